"""Candidates fitted together with the nuisances, from several starts."""

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from apesim.studies.estimation.levenberg_marquardt import descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.parameters import Parameter
from apesim.studies.estimation.residuals import Counter, EndedEarly
from apesim.studies.gap.search.calibrated_gap import CalibratedGap
from apesim.studies.gap.search.candidate_fits import fit_candidates
from apesim.studies.gap.search.candidates import Candidate, Probe
from apesim.studies.gap.search.model_selection import MAX_SINGLES, MIN_FORESEEN, fit_large, fit_singles
from apesim.studies.gap.search.refit import Start, _place_columns, probe_large_sizes, refit
from apesim.studies.gap.search.score_test import Score, Sensitivity, find_scores, find_sensitivities
from apesim.studies.gap.stage_work import Work

NUISANCE = Parameter("effects.time_zero.time", 1.0, -5.0, 5.0, prior=True)
BENT, PLAIN = (
    Candidate(name, (Parameter(f"effects.{name}.share", 1.0, -5.0, 5.0),), ())
    for name in ("spring_rate_error", "moving_mass_error")
)

HEAT = Candidate("cylinder_wall_heat", (Parameter("effects.cylinder_wall_heat.h", 1.0, 0.0, 1.3),), ())


class Basins:
    """The first effect has a basin at -1, where much is left, and one at 2; the second takes 3 more.

    Parameters
    ----------
    fails_beyond : float
        Size of the second effect from which simulations do not come to their end.
    """

    def __init__(self, parameters, fails_beyond=np.inf):
        self.parameters, self.fails_beyond = list(parameters), fails_beyond
        self.low, self.high = (np.array([getattr(p, end) for p in parameters]) for end in ("low", "high"))
        self.known = np.array([p.prior for p in parameters])
        self.counter = Counter()

    def with_parameters(self, parameters):
        return Basins(parameters, self.fails_beyond)

    def find_relief(self, errors):
        return 0.0

    def at(self, x):
        size = dict(zip((p.key.split(".")[1] for p in self.parameters), x, strict=True))
        bent, plain = size.get(BENT.name, 0.0), size.get(PLAIN.name, 0.0)
        if abs(plain) > self.fails_beyond:
            raise EndedEarly("too much")
        left = 2.0 * (bent - 2.0) * ((bent + 1.0) ** 2 + 0.5)
        return np.array([left, 3.0 - plain, x[0], x[0], *np.zeros(len(x) - 1)])

    @property
    def simulations(self):
        return self.counter.number

    def jacobian(self, x, residuals, steps=None, only=None):
        moves = 1e-6 * np.eye(len(x))[range(len(x)) if only is None else only]
        return np.column_stack([(self.at(x + move) - residuals) / 1e-6 for move in moves]), steps


class Hump(Basins):
    """An effect leaves more by a quarter and by all of its range than by none, and nearly nothing between."""

    LEFT = PchipInterpolator([0.0, 0.25, 0.5, 0.6, 1.0, 1.3], [3.0, 3.5, 1.5, 0.2, 3.6, 5.0])

    def with_parameters(self, parameters):
        return Hump(parameters)

    def at(self, x):
        size = x[-1] if len(x) > 1 else 0.0
        return np.array([float(self.LEFT(size)), x[0], x[0], *np.zeros(len(x) - 1)])


def calibrated(**options):
    residuals = Basins([NUISANCE], **options)
    return Model((), residuals, descend(residuals, np.zeros(1)))


def fitted_alone(base):
    """The first effect alone, in its better basin."""
    residuals = base.residuals.with_parameters([NUISANCE, *BENT.parameters])
    return Model((BENT,), residuals, descend(residuals, [0.0, 2.5]))


def test_an_effect_is_found_beyond_the_hump_that_hides_it():
    """The cause of a wall's heat of 30 deviations that was never found: a quarter and all of it left more than none."""
    residuals = Hump([NUISANCE])
    base = Model((), residuals, descend(residuals, np.zeros(1)))
    assert probe_large_sizes(base, HEAT)[:2] == (pytest.approx(1.5**2), (0.5,))
    found = refit(base, (HEAT,), ((0.0,),))
    assert found.own(0) == pytest.approx([0.6], abs=0.05)
    assert found.cost < 0.1 < base.cost


def test_a_pair_starts_from_where_its_single_stands_too():
    base = calibrated()
    single = fitted_alone(base)
    guesses = (-1.5,), (1.0,)
    astray = refit(base, (BENT, PLAIN), guesses)
    found = refit(base, (BENT, PLAIN), guesses, [single])
    assert found.cost < 0.1 < 4.0 < astray.cost
    assert found.own(0) == pytest.approx([2.0], abs=0.2)
    assert found.own(1) == pytest.approx([3.0], abs=0.2)


@pytest.mark.parametrize("candidates", [(BENT, PLAIN), (PLAIN, BENT)])
def test_a_pair_is_never_worse_than_a_single_in_it(candidates):
    base = calibrated(fails_beyond=0.5)
    single = fitted_alone(base)
    found = refit(base, candidates, ((1.0,), (1.0,)), [single])
    assert found.cost <= single.cost
    assert found.own(candidates.index(BENT)) == pytest.approx(single.own(0))


def test_sensitivities_of_a_model_within_go_to_the_places_of_its_candidates():
    base = calibrated()
    shaped = Candidate("bounce", tuple(Parameter(f"effects.bounce.{j}", 1.0, -5.0, 5.0) for j in range(2)), ())
    own = base.residuals.with_parameters([NUISANCE, *PLAIN.parameters, *BENT.parameters])
    x = np.array([0.3, 1.0, 2.5])
    fitted = descend(own, x)._replace(x=x, residuals=own.at(x), jacobian=own.jacobian(x, own.at(x))[0])
    whole = own.with_parameters([NUISANCE, *BENT.parameters, *shaped.parameters, *PLAIN.parameters])
    there = np.array([0.3, 2.5, 0.0, 0.0, 1.0])
    start = Start(there, Model((PLAIN, BENT), own, fitted), whole.at(there))
    columns, missing = _place_columns(base, (BENT, shaped, PLAIN), start)
    known = [0, 1, 4]
    assert missing == [2, 3]
    assert columns[:, known] == pytest.approx(whole.jacobian(there, start.errors)[0][:, known], rel=1e-6)
    assert len({*map(tuple, columns[:, known].T)}) == len(known)


def test_a_model_that_never_comes_to_its_end_is_what_it_adds_to():
    base = calibrated(fails_beyond=1e-3)
    found = refit(base, (PLAIN,), ((1.0,),))
    assert found.cost == pytest.approx(base.cost)
    assert found.own(0) == [0.0]


def test_an_effect_is_tried_at_large_too():
    base = calibrated()
    cost, x, _ = probe_large_sizes(base, PLAIN)
    assert x == (1.0,)
    assert cost == pytest.approx(base.cost - 3.0**2 + (3.0 - 1.0) ** 2)
    assert probe_large_sizes(calibrated(fails_beyond=1e-3), PLAIN)[0] == np.inf


def scored(candidate, deviations):
    probe = Probe(candidate, (0.01,), 0)
    return Score(Sensitivity(probe, np.ones(5), np.ones(5), 1.0), deviations, 10.0)


def test_an_effect_without_a_score_is_fitted_where_much_of_it_leaves_little():
    assert fit_singles(calibrated(), [scored(PLAIN, 0.0)], 40, Work()) == []
    (found,) = fit_large(calibrated(), [scored(PLAIN, 0.0)], [], 40, Work())
    assert found.names == (PLAIN.name,)
    assert found.model.own(0) == pytest.approx([3.0], abs=0.1)
    assert fit_large(calibrated(), [scored(PLAIN, 0.0)], [found], 40, Work()) == []


def others(number):
    """Candidates that do nothing."""
    idle = Parameter("effects.bounce.restitution", 1.0, -5.0, 5.0)
    return [Candidate(f"other_{each}", (idle,), ()) for each in range(number)]


def test_only_the_best_are_fitted_alone():
    ranked = [scored(candidate, 5.0) for candidate in (*others(40), PLAIN)]
    found = [choice.names[0] for choice in fit_singles(calibrated(), ranked, 40, Work())]
    assert sorted(found) == sorted(other.name for other in others(MAX_SINGLES))


def test_what_is_foreseen_to_stay_far_behind_the_first_is_not_fitted():
    base = calibrated()
    gained = base.cost - fit_singles(base, [scored(PLAIN, 3.0)], 40, Work())[0].model.cost
    near, far = (np.sqrt(factor * MIN_FORESEEN * gained) for factor in (1.1, 0.9))
    one, other = others(2)
    ranked = [scored(PLAIN, 3.0), scored(one, near), scored(other, far)]
    assert {choice.names for choice in fit_singles(base, ranked, 40, Work())} == {(PLAIN.name,), (one.name,)}


class TooFar(Basins):
    """What is missing is the second effect alone, by more than it can be."""

    blocks = ()
    """Its noise is known."""
    scatter = None

    def block_slices(self):
        return []

    def list_spreads(self):
        return []

    def with_parameters(self, parameters):
        return TooFar(parameters)

    def at(self, x):
        size = dict(zip((p.key.split(".")[1] for p in self.parameters), x, strict=True))
        gap = 10.0 * (3.0 - size.get(PLAIN.name, 0.0))
        return np.array([100.0 * size.get(BENT.name, 0.0) + 1.0, gap, x[0], x[0], *np.zeros(len(x) - 1)])


@pytest.mark.parametrize(("end", "tried"), [(5.0, {1}), (2.5, {1, 2})])
def test_pairs_are_tried_where_the_best_explanation_is_beyond_its_range(end, tried):
    far = PLAIN.strengths[0]._replace(low=-2.0 * end, high=2.0 * end, reach=2.0)
    candidates = [BENT, PLAIN._replace(strengths=(far,))]
    residuals = TooFar([NUISANCE])
    base = Model((), residuals, descend(residuals, np.zeros(1)))
    columns = find_sensitivities(residuals, base.fitted, candidates, Work())
    ranked = find_scores(columns, base.fitted.residuals)
    gap = CalibratedGap(base, columns, [], [], ranked, np.zeros((len(base.fitted.residuals), 0)), None)
    _, found, _ = fit_candidates(gap, 2, Work())
    assert found[0].names == (PLAIN.name,)
    assert {len(choice.names) for choice in found} == tried
