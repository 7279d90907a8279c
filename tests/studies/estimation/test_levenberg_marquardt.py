"""Least squares with few simulations."""

from itertools import product

import numpy as np
import pytest

from apesim.studies.estimation import levenberg_marquardt
from apesim.studies.estimation.calibration import elsewhere
from apesim.studies.estimation.levenberg_marquardt import FRESH, SAME, descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.residuals import EndedEarly
from apesim.studies.gap.stage_work import Work


class Curved:
    """Rosenbrock's valley as two errors, counted."""

    low, high = np.array([-5.0, -5.0]), np.array([5.0, 5.0])

    def __init__(self, fails_beyond=np.inf):
        self.evaluations, self.fails_beyond = 0, fails_beyond

    def at(self, x):
        self.evaluations += 1
        if x[0] > self.fails_beyond:
            raise EndedEarly("too far")
        return np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]])

    def jacobian(self, x, residuals, steps):
        return np.column_stack([(self.at(x + 1e-6 * one) - residuals) / 1e-6 for one in np.eye(2)]), steps


def test_it_finds_the_end_of_a_curved_valley():
    found = descend(Curved(), [-1.2, 1.0])
    assert found.converged
    assert found.cost < 0.02
    assert found.x == pytest.approx([1.0, 1.0], abs=0.3)


def test_it_stays_within_the_bounds():
    residuals = Curved()
    residuals.high = np.array([0.5, 5.0])
    found = descend(residuals, [-1.2, 1.0])
    assert found.converged
    assert found.x == pytest.approx([0.5, 0.25], abs=0.01)


def test_a_simulation_that_fails_on_the_way_only_shortens_the_step():
    found = descend(Curved(fails_beyond=1.05), [-1.2, 1.0])
    assert found.converged
    assert found.cost < 0.02


def test_one_that_fails_at_the_start_is_told():
    with pytest.raises(EndedEarly):
        descend(Curved(fails_beyond=-2.0), [-1.2, 1.0])


def test_sensitivities_from_nearby_save_simulations():
    class Straight(Curved):
        def at(self, x):
            self.evaluations += 1
            return np.array([[2.0, 1.0], [0.5, 3.0], [1.0, 1.0]]) @ x - [4.0, 3.5, 2.0]

    cold, warm = Straight(), Straight()
    slopes, _ = cold.jacobian(np.zeros(2), cold.at(np.zeros(2)), np.zeros(2))
    first = descend(warm, [0.0, 0.0], slopes)
    assert first.x == pytest.approx([1.5, 1.0], abs=0.2)
    assert warm.evaluations <= 6
    with_own = Straight()
    assert descend(with_own, [0.0, 0.0]).x == pytest.approx(first.x, abs=1e-6)


def test_sensitivities_at_the_start_are_not_taken_again():
    """At the minimum nothing is left to do; with sensitivities from nearby it has to be made sure of."""
    counts = {}
    for is_exact in (True, False):
        residuals = Curved()
        errors = residuals.at(np.ones(2))
        slopes, _ = residuals.jacobian(np.ones(2), errors, np.zeros(2))
        found = descend(residuals, [1.0, 1.0], slopes, errors=errors, is_exact=is_exact)
        assert found.converged
        counts[is_exact] = residuals.evaluations
    assert counts == {True: 3, False: 5}


def test_a_minimum_above_the_limit_is_not_sharpened():
    """What is left is 4 at least: with a limit below that the last sensitivities are saved."""

    class Raised(Curved):
        jacobians = 0

        def at(self, x):
            return np.append(super().at(x), 2.0)

        def jacobian(self, x, residuals, steps):
            self.jacobians += 1
            return super().jacobian(x, residuals, steps)

    counts = {}
    for limit in (3.0, 5.0):
        residuals = Raised()
        nearby, _ = residuals.jacobian(np.ones(2), residuals.at(np.ones(2)), np.zeros(2))
        residuals.jacobians = 0
        found = descend(residuals, [0.9, 0.8], nearby, limit=limit, least_promise=0.0)
        assert found.cost == pytest.approx(4.0, abs=0.1)
        assert found.converged == (limit == 5.0)
        counts[limit] = residuals.jacobians
    assert counts[3.0] == counts[5.0] - 1


def test_a_descent_that_does_not_lead_down_to_the_limit_is_given_up_after_a_step():
    counts = {}
    for limit in (-1e4, 0.5):
        residuals = Curved()
        found = descend(residuals, [-1.2, 1.0], limit=limit)
        assert found.converged == (limit == 0.5)
        counts[limit] = residuals.evaluations
    assert counts[-1e4] == 4  # at the start, with a difference for each parameter, and at the step
    assert counts[0.5] > 20


class Fronts:
    """Steep fronts whose places parameters shift, as the contacts of a stroke; a fall is far more than promised."""

    low, high = np.full(8, -20.0), np.full(8, 20.0)

    def __init__(self):
        rng = np.random.default_rng(3)
        self.places, self.shifts = rng.uniform(0.2, 0.8, 4), 0.01 * rng.normal(size=(4, 8))
        self.seen = self.trace(rng.normal(size=8))

    def trace(self, x):
        times = np.linspace(0.0, 1.0, 200)
        return 50.0 * sum(np.tanh(60.0 * (times - place)) for place in self.places + self.shifts @ x)

    def at(self, x):
        return np.append(self.trace(x) - self.seen, x)

    def jacobian(self, x, residuals, steps):
        return np.column_stack([(self.at(x + 1e-4 * one) - residuals) / 1e-4 for one in np.eye(len(x))]), steps


def test_sensitivities_are_renewed_where_a_step_brings_more_than_they_promise():
    found = descend(Fronts(), np.full(8, -4.0))
    assert found.converged
    assert found.cost < 10.0


class Strokes(Fronts):
    """Strokes with fronts whose heights change, too, further apart from what is seen."""

    low, high = np.full(12, -20.0), np.full(12, 20.0)

    def __init__(self, seed):
        rng = np.random.default_rng(seed)
        self.places, self.shifts = rng.uniform(0.2, 0.8, 6), 0.02 * rng.normal(size=(6, 12))
        self.heights, self.evaluations = 0.05 * rng.normal(size=(6, 12)), 0
        self.seen = self.trace(rng.normal(size=12))

    def trace(self, x):
        self.evaluations += 1
        times, places = np.linspace(0.0, 1.0, 200), self.places + self.shifts @ x
        fronts = [np.tanh(60.0 * (times - place)) for place in places]
        return 50.0 * (1.0 + self.heights @ x) @ fronts


def test_sensitivities_are_renewed_where_steps_keep_promising_as_little():
    residuals = Strokes(22)
    found = descend(residuals, np.zeros(12))
    assert found.converged
    assert residuals.evaluations < 150


@pytest.mark.parametrize("rest", [0.0, 2.0], ids=["known", "unknown"])
def test_a_descent_to_a_known_minimum_takes_no_sensitivities_anew(rest):
    """It is known by its sum of squares, whatever sensitivities were there."""
    first, again = Curved(), Curved()
    found = descend(first, [0.0, 0.0])
    known = found._replace(residuals=found.residuals + rest, jacobian=np.zeros((2, 2)))
    ended = descend(again, [0.5, 1.5], found.jacobian, found.steps, known=known)
    assert ended.cost == pytest.approx(found.cost, abs=SAME)
    assert ended.converged == (rest > 0.0)


def test_a_start_in_the_basin_of_a_known_minimum_is_not_followed():
    """There the sensitivities of the minimum foretell the residuals, which a second minimum beyond them would not."""
    first, again = Curved(), Curved()
    found = descend(first, [0.0, 0.0])
    ended = descend(again, [1.02, 1.05], found.jacobian, found.steps, known=found)
    assert not ended.converged
    assert again.evaluations == 1
    assert not found.leads_here(np.array([-1.2, 1.0]), again.at(np.array([-1.2, 1.0])))


def test_sensitivities_prove_a_minimum_that_is_near_where_they_were_taken(monkeypatch):
    """A curve of so small a scale is straight within half a standard deviation; a larger one is not taken on trust."""

    class Scaled(Curved):
        def __init__(self, scale):
            super().__init__()
            self.scale, self.taken = scale, []

        def at(self, x):
            return self.scale * super().at(x)

        def jacobian(self, x, residuals, steps):
            self.taken.append(np.array(x))
            return super().jacobian(x, residuals, steps)

    counts = {}
    for fresh, scale in product((FRESH, 1e-12), (3.0, 100.0)):
        monkeypatch.setattr(levenberg_marquardt, "FRESH", fresh)
        residuals = Scaled(scale)
        found = descend(residuals, [0.9, 0.8])
        moved = residuals.at(found.x) - residuals.at(residuals.taken[-1])
        assert found.converged
        assert np.linalg.norm(moved) < fresh
        assert found.cost < 0.05
        counts[fresh, scale] = len(residuals.taken)
    assert counts == {(FRESH, 3.0): 1, (FRESH, 100.0): 2, (1e-12, 3.0): 2, (1e-12, 100.0): 2}


def test_a_scout_takes_no_sensitivities_of_its_own():
    residuals, start = Curved(), np.array([-1.2, 1.0])
    slopes, _ = residuals.jacobian(np.ones(2), residuals.at(np.ones(2)), np.zeros(2))
    residuals.evaluations = 0
    ended = descend(residuals, start, slopes, is_scout=True)
    assert not ended.converged
    assert residuals.evaluations < 5  # one where it starts and one a step; the end of the valley takes over 20


def test_residuals_of_the_start_that_are_known_are_not_asked_for():
    plain, told = Curved(), Curved()
    start = np.zeros(2)
    errors = told.at(start)
    assert told.evaluations == 1
    ends = descend(plain, start), descend(told, start, errors=errors)
    assert told.evaluations == plain.evaluations
    assert ends[0].x.tolist() == ends[1].x.tolist()


class Torn(Curved):
    """Two valleys with a range between them that cannot be simulated; the one above it has its bottom at a depth."""

    known, simulations, parameters = np.array([True, False]), 0, ()

    def __init__(self, depth):
        super().__init__()
        self.depth = depth

    def find_relief(self, errors):
        return 0.0

    def at(self, x):
        if 0.4 < x[0] < 0.6:
            raise EndedEarly("no steady state")
        middle, level = (1.2, self.depth) if x[0] > 0.5 else (0.2, 3.0)
        return np.array([4.0 * (x[0] - middle), x[1] - 2.0, level])

    def with_parameters(self, parameters):
        return Torn(self.depth)

    def restarted_at(self, x):
        return self


def test_a_calibration_is_the_deepest_of_several_minima():
    """So it is where an engine's valve runs out of breath, and there is no steady state on the way."""
    residuals = Torn(depth=1.0)
    near = Model((), residuals, descend(residuals, [0.0, 0.0]))
    found = elsewhere(near, Work())
    assert near.fitted.x == pytest.approx([0.2, 2.0], abs=0.01)
    assert found.fitted.x == pytest.approx([1.2, 2.0], abs=0.03)
    assert found.cost == pytest.approx(1.0, abs=0.02)


def test_a_minimum_that_is_hardly_deeper_changes_nothing():
    residuals = Torn(depth=2.9)
    near = Model((), residuals, descend(residuals, [0.0, 0.0]))
    assert elsewhere(near, Work()) is near
