"""Anderson's method on maps whose fixed points and multipliers are known."""

import numpy as np
import pytest

from apesim.march.acceleration import DEPTH, Secants

ONE = np.ones(4)


def steps_to(end, matrix, secants, y, most):
    """States that accelerated images of ``end + matrix (y - end)`` come to, and how far each step says it is."""
    for number in range(most):
        image = end + matrix @ (y - end)
        secants.add(y, image, ONE)
        step, left = secants.step(image - y, ONE)
        y = y + step
        yield number, y, left


@pytest.mark.parametrize("seed", range(5))
def test_a_linear_map_is_solved_by_as_many_secants_as_it_has_directions(seed):
    random = np.random.default_rng(seed)
    basis = random.normal(size=(4, 4))
    matrix = basis @ np.diag([0.9, 0.5, -0.3, 0.99]) @ np.linalg.inv(basis)
    end = random.uniform(1.0, 2.0, 4)
    apart = [np.abs(y - end).max() for _, y, _ in steps_to(end, matrix, Secants(), end + 0.05, DEPTH + 1)]
    assert apart[-1] < 1e-6 < apart[-3], "plain cycles would need a thousand"


def test_the_correction_gives_the_step_in_all_directions_and_keeps_what_never_moved():
    random = np.random.default_rng(1)
    slopes = np.zeros((4, 4))
    slopes[:3, :3] = 0.3 * random.normal(size=(3, 3))
    slopes[3, 3] = 1.0
    secants, y = Secants(), np.array([0.05, 0.04, -0.03, 0.0])
    for _ in range(4):
        secants.add(y, slopes @ y, ONE)
        gain = slopes @ y - y
        y = slopes @ y
    correction = secants.correction(ONE)
    assert correction[:3, :3] == pytest.approx(np.linalg.inv(np.eye(3) - slopes[:3, :3]), rel=1e-6)
    assert correction @ gain == pytest.approx(secants.step(gain, ONE)[0])
    assert not correction[3].any()


def test_what_no_secant_shows_counts_as_far_as_it_may_lead():
    """The second direction gains 1e-9 a cycle, and falls by a thousandth: 1e-6 is left, though the step is 1e-9."""
    end, matrix = np.zeros(4), np.diag([0.5, 0.999, 0.0, 0.0])
    *_, (_, y, left) = steps_to(end, matrix, Secants(), np.array([0.1, 1e-6, 0.0, 0.0]), 4)
    assert abs(y[1]) > 0.9e-6
    assert left > 0.9e-6


@pytest.mark.parametrize("multiplier", [-1.2, -0.6, 0.4, 0.97, 1.05])
def test_the_multiplier_of_the_slowest_direction_is_seen(multiplier):
    matrix = np.diag([multiplier, 0.2, 0.1, 0.0])
    secants, y = Secants(), np.array([0.02, 0.02, 0.0, 0.0])
    for _ in range(4):
        secants.add(y, matrix @ y, ONE)
        y = matrix @ y
    assert np.abs(secants.multipliers() - multiplier).min() < 1e-6


def test_secants_from_before_a_change_of_phase_are_forgotten():
    secants = Secants()
    for y in (0.1, 0.2):
        secants.add(np.array([y]), np.array([3.0 * y]), np.ones(1))
    secants.forget()
    assert not secants.are_shown
    secants.add(np.array([1.0]), np.array([1.5]), np.ones(1))
    assert not secants.are_shown
    assert secants.step(np.array([0.5]), np.ones(1))[0] == 0.5
