"""All models that may explain a gap: single effects and pairs, fitted through the simulator."""

from collections.abc import Iterable

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.estimation.noise.sampling import parts_of
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.gap.search.calibrated_gap import CalibratedGap
from apesim.studies.gap.search.gap_test import GapTest, compare_with_noise
from apesim.studies.gap.search.model_selection import Choice, alone_again, beside, pairs, released, remaining, singles
from apesim.studies.gap.search.plausibility import implausible
from apesim.studies.gap.thresholds import DOUBTFUL
from apesim.studies.gap.work import Work


def fit_candidates(gap: CalibratedGap, library_size: int, work: Work) -> list[Choice]:
    """Fit all models that may explain a gap.

    The best single effects by their score and the numbers of the machine that were pulled far come first; the other
    effects and pairs follow where the best of these is doubtful.

    Parameters
    ----------
    gap : apesim.studies.gap.search.calibrated_gap.CalibratedGap
    library_size : int
        Number of candidates.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    list of Choice
        Penalised, the best first; the best of each set of effects.
    """
    base, ranked = gap.calibrated, gap.scores
    found = singles(base, ranked, library_size, work) + released(base, library_size, work)
    if is_doubtful(found, gap):
        found += remaining(base, ranked, found, library_size, work)
        if is_doubtful(found, gap):
            alone = with_effects(found)
            couples = pairs(base, gap.sensitivities, ranked, alone, library_size, work)
            found += couples
            if couples and couples[0].cost < alone[0].cost:
                found += alone_again(base, couples[0], library_size, work)
    best: dict[frozenset[str], Choice] = {}
    for choice in sorted(found, key=lambda choice: choice.cost):
        best.setdefault(frozenset(choice.names), choice)
    return list(best.values())


def is_doubtful(found: list[Choice], gap: CalibratedGap) -> bool:
    """Whether the best model is implausible, or the best one with an effect leaves more than noise may well leave.

    The second holds where noise alone leaves as much with a chance below `DOUBTFUL`.

    Parameters
    ----------
    found : list of Choice
        Models that were fitted so far.
    gap : apesim.studies.gap.search.calibrated_gap.CalibratedGap

    Returns
    -------
    bool
        False where no model adds an effect.
    """
    alone = with_effects(found)
    if not alone:
        return False
    best = min(found, key=lambda choice: choice.cost)
    return bool(implausible(best.model)) or compare_left_over(alone[0].model, gap).p_value < DOUBTFUL


def with_effects(found: Iterable[Choice]) -> list[Choice]:
    """The choices that add effects, without those that only take the prior of a nuisance away.

    Parameters
    ----------
    found : iterable of Choice

    Returns
    -------
    list of Choice
        The least penalised cost first.
    """
    return sorted((choice for choice in found if choice.model.candidates), key=lambda choice: choice.cost)


def compare_left_over(model: Model, gap: CalibratedGap) -> GapTest:
    """Compare what a model with effects leaves with what noise alone would leave.

    The scores are those of the candidates that the model does not have, and of local shapes, see `compare_with_noise`.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model
    gap : apesim.studies.gap.search.calibrated_gap.CalibratedGap

    Returns
    -------
    apesim.studies.gap.search.gap_test.GapTest
    """
    again, local = beside(gap.sensitivities, model), gap.local_shapes
    wider = find_nuisance_space(model.fitted.jacobian).project_out(
        np.vstack([local, np.zeros((model.added, local.shape[1]))])
    )
    return compare_with_noise(again, wider, model.fitted.residuals, parts_of(model.residuals))
