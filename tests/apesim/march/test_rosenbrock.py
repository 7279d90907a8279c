from math import cos, sin
from typing import NamedTuple

import numpy as np
import pytest

from apesim.air import Air, Gas, GasState, gas_of, internal_energy, temperature_of
from apesim.kernel import kernel
from apesim.march.adaptive import EVALUATIONS_IN_A_STEP, MAX_EVALUATIONS, Status
from apesim.march.dormand_prince import dense
from apesim.march.hybrid_system import MAX_SHORT_STEPS, rates
from apesim.march.rosenbrock import implicit_error, implicit_interpolant, implicit_stages, slopes_of_rates
from apesim.restriction import NEAR, Sides, flow_in
from tests.apesim.march.test_adaptive import cached_apart, compiled_only, run


@pytest.fixture(scope="module", autouse=True)
def own_cache():
    yield from cached_apart(__file__)


class Follower(NamedTuple):
    """What follows sin(t) at a rate, and a vessel that it drains; the ledger counts what has been drained."""

    rate: float
    bend: float = 1.0
    """Weight of a quadratic term, without which the solution would hide errors of the Jacobian."""


@rates.for_type(Follower)
@kernel
def follower_rates(p, t, y, mode, dy):
    apart = y[0] - sin(t)
    dy[0] = cos(t) - p.rate * apart - p.bend * apart * (y[0] + sin(t))
    dy[1] = -y[0] * y[1]
    dy[2] = y[0] * y[1]
    return True


def drained(t):
    return np.exp(cos(t) - 1.0)


def steps_of(p, count, end=1.0):
    """States at the end of equal steps from 0, and the largest error of the dense output in the middle of one."""
    h, y, scale, mode = end / count, np.array([0.0, 1.0, 0.0]), np.ones(2), np.zeros(1)
    k, u, c, trial, middle = np.zeros((7, 3)), np.zeros((6, 3)), np.zeros((5, 2)), y.copy(), np.empty(2)
    jacobian, room, apart = np.empty((3, 3)), np.empty((2, 4)), 0.0
    for i in range(count):
        t = i * h
        rates(p, t, y, mode, k[0])
        assert slopes_of_rates(p, t, h, y, mode, scale, k, trial, jacobian, room)
        assert implicit_stages(p, t, h, y, mode, scale, jacobian, k, trial, u, room)
        implicit_interpolant(y, trial, u, c)
        dense(c, 0.5, middle)
        true = np.array([sin(t + 0.5 * h), drained(t + 0.5 * h)])
        apart = max(apart, np.abs(middle - true).max())
        y = trial.copy()
    return y, apart, implicit_error(y, y, u, 1.0, scale)


def test_a_step_is_of_order_four_and_its_dense_output_and_error_estimate_of_order_three():
    true = np.array([sin(1.0), drained(1.0)])
    (coarse, dense_coarse, estimate_coarse), (fine, dense_fine, estimate_fine) = (
        steps_of(Follower(1.0), count) for count in (16, 32)
    )
    assert np.abs(coarse[:2] - true).max() / np.abs(fine[:2] - true).max() == pytest.approx(16.0, rel=0.3)
    assert dense_coarse / dense_fine > 8.0
    assert estimate_coarse / estimate_fine == pytest.approx(16.0, rel=0.3)


@pytest.mark.parametrize("rate", [1.0, 1e4, 1e8])
def test_the_ledger_closes_however_stiff_the_states_are(rate):
    y, *_ = steps_of(Follower(rate), 20)
    assert y[1] + y[2] == pytest.approx(1.0, abs=1e-14)
    assert y[0] == pytest.approx(sin(1.0), abs=1e-6)


def jacobians_of(outcome, states=2):
    """How many times slopes were taken; a step of either method has evaluations of its own."""
    return (outcome.evaluations - EVALUATIONS_IN_A_STEP * (outcome.steps + outcome.rejected)) / (2 * states + 1)


class Chain(NamedTuple):
    """A state that moves, three at rest that follow from it or from one another, and two that nothing moves."""

    follow: float = 3.0


@rates.for_type(Chain)
@kernel
def chain_rates(p, t, y, mode, dy):
    dy[0] = -2.0 * y[0]
    dy[1] = p.follow * (y[0] - 1.0)
    dy[2] = (y[0] - 1.0) ** 2
    dy[3] = y[1] - 5.0
    dy[4] = -1e3 * (y[4] - 7.0)
    dy[5] = y[0] * (y[5] - 8.0) * y[4]
    dy[6] = t
    return True


def test_slopes_are_taken_over_what_moves_or_is_moved_and_over_nothing_else():
    p, y, mode, k = Chain(), np.array([1.0, 5.0, 6.0, 9.0, 7.0, 8.0, 0.0]), np.zeros(1), np.zeros((7, 7))
    jacobian, room = np.empty((7, 8)), np.empty((7, 9))
    rates(p, 0.0, y, mode, k[0])
    assert slopes_of_rates(p, 0.0, 0.1, y, mode, np.full(7, 1e-9), k, np.empty(7), jacobian, room) == 1 + 2 * 5
    true = np.zeros((7, 8))
    true[0, 0], true[1, 0], true[3, 1], true[6, 7] = -2.0, 3.0, 1.0, 1.0
    assert jacobian == pytest.approx(true, abs=1e-5)


class Kicked(NamedTuple):
    """A follower of what is kicked a hundred times a second: its steps grow between kicks, and are rejected there."""

    rate: float


@rates.for_type(Kicked)
@kernel
def kicked_rates(p, t, y, mode, dy):
    dy[0] = -p.rate * (y[0] - np.exp(30.0 * (np.cos(2.0 * np.pi * 100.0 * t) - 1.0)))
    return True


@compiled_only
def test_a_step_that_is_rejected_is_made_again_with_the_same_slopes_and_the_next_one_does_not_grow():
    outcome, *_ = run(Kicked(2e7), [1.0], [1.0], tolerance=1e-6, max_step=0.01, states=1, log_rows=0)
    assert outcome.status == Status.DONE
    assert outcome.rejected > 50
    assert jacobians_of(outcome, states=1) <= outcome.steps - MAX_SHORT_STEPS
    assert outcome.rejected / outcome.steps < 0.2


class Confined(NamedTuple):
    """A follower whose laws hold near what it follows alone: a step may fail there, and no error foretells it."""

    rate: float
    room: float


@rates.for_type(Confined)
@kernel
def confined_rates(p, t, y, mode, dy):
    apart = y[0] - sin(100.0 * t) ** 8
    dy[0] = -p.rate * apart
    return abs(apart) < p.room


@compiled_only
def test_a_step_does_not_grow_after_one_that_left_the_domain():
    outcome, *_ = run(Confined(2e5, 3e-3), [0.0], [1.0], tolerance=1e-3, max_step=0.01, states=1, log_rows=0)
    assert outcome.status == Status.DONE
    assert outcome.rejected > 500
    assert outcome.rejected / outcome.steps < 0.7, "else a step that fails would follow upon each that holds"


@compiled_only
def test_a_march_that_stability_would_hold_to_tiny_steps_comes_to_its_end():
    p = Follower(rate=2e7)
    assert 6 * p.rate / 4.0 > MAX_EVALUATIONS, "an explicit method needs a step per 4 time constants"
    outcome, y, *_ = run(p, [0.0, 1.0, 0.0], [1.0], tolerance=1e-8, max_step=0.01, states=2, log_rows=0)
    assert outcome.status == Status.DONE
    assert outcome.steps < MAX_SHORT_STEPS + 1000
    assert jacobians_of(outcome) in range(1, outcome.steps - MAX_SHORT_STEPS)
    assert y == pytest.approx([sin(1.0), drained(1.0), 1.0 - drained(1.0)], abs=1e-7)


class Vessel(NamedTuple):
    """A cylinder of 100 cm3, heated by 10 W, that halves its volume in a second and empties through a large area."""

    gas: Gas
    area: float


AMBIENT = GasState(1e5, 300.0)
GAS = gas_of(Air())


@rates.for_type(Vessel)
@kernel
def vessel_rates(p, t, y, mode, dy):
    temperature = temperature_of(p.gas, y[1] / y[0])
    pressure = y[0] * p.gas.gas_constant * temperature / (1e-4 * (1.0 - 0.5 * t))
    flow = flow_in(p.gas, NEAR, p.area, Sides(GasState(pressure, temperature), AMBIENT))
    dy[0] = -flow.mass
    dy[1] = -flow.enthalpy + 0.5e-4 * pressure + 10.0
    return True


@compiled_only
@pytest.mark.parametrize("area", [1e-5, 1e-3, 1e-1])
def test_a_march_takes_no_more_steps_where_an_area_is_larger_for_its_volume(area):
    """What flows out takes the enthalpy of the heat and 1.4/0.4 of the work, and halves that of what stays."""
    mass = 1e5 * 1e-4 / (GAS.gas_constant * 300.0)
    left = mass * 0.5 ** (1.0 + 2.0 * 10.0 * 0.4 / 1.4 / 10.0), 0.5 * 10.0 / 0.4
    start = [mass, mass * internal_energy(GAS, 300.0)]
    outcome, y, *_ = run(Vessel(GAS, area), start, [1.0], tolerance=1e-7, max_step=0.1, states=2, scale=1e-30)
    assert outcome.status == Status.DONE
    assert outcome.steps < MAX_SHORT_STEPS + 200
    assert y == pytest.approx(left, rel=1e-3)


class Bounce(NamedTuple):
    """A piston that floats on a film of gas before its stop, far thinner than the scale of its position."""

    film: float


@rates.for_type(Bounce)
@kernel
def bounce_rates(p, t, y, mode, dy):
    dy[0] = y[1]
    dy[1] = 1e6 * ((p.film / y[0]) ** 2 - 1.0 - 0.5 * sin(t)) - 1e9 * y[1]
    return True


@compiled_only
def test_a_film_far_thinner_than_the_scale_of_the_position_leaves_long_steps():
    film = 1e-7
    outcome, y, *_ = run(Bounce(film), [film, 0.0], [1.0], tolerance=1e-7, max_step=0.1, states=2, scale=1.0)
    assert outcome.status == Status.DONE
    assert outcome.steps < MAX_SHORT_STEPS + 100
    assert y[0] == pytest.approx(film / (1.0 + 0.5 * sin(1.0)) ** 0.5, rel=1e-3)


@compiled_only
def test_a_march_of_many_short_stretches_is_not_taken_for_a_stiff_one():
    stretch, count = 0.01, MAX_SHORT_STEPS + 5000
    breakpoints, y = stretch * np.arange(1, count + 1), [0.0, 1.0, 0.0]
    outcome, *_ = run(Follower(rate=1.0), y, breakpoints, tolerance=1e-11, max_step=1.0, states=2, log_rows=0)
    assert outcome.steps == count, "a step of order 4 would not do for a stretch at this tolerance"
