"""All models that may explain a gap: effects, faults of files and sets of them, fitted through the simulator."""

from collections.abc import Iterable, Sequence

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.estimation.noise.sampling import parts_of
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.gap.search.calibrated_gap import CalibratedGap
from apesim.studies.gap.search.gap_test import GapTest, compare_with_noise
from apesim.studies.gap.search.model_selection import (
    Foreseen,
    PricedModel,
    fit_faults,
    fit_large,
    fit_sets,
    fit_singles,
    project_beside,
    refit_each_alone,
)
from apesim.studies.gap.search.plausibility import find_implausible
from apesim.studies.gap.search.scatter_beside import take_scatter_at_best
from apesim.studies.gap.search.score_test import Score, Sensitivity, find_scores
from apesim.studies.gap.stage_work import Work
from apesim.studies.gap.thresholds import DOUBTFUL
from apesim.studies.measured import MeasuredRun

MAX_PAIRED_FAULTS = 10
"""Faults of single files that are tried beside effects."""


def fit_candidates(
    gap: CalibratedGap, library_size: int, work: Work, others: Sequence[MeasuredRun] = ()
) -> tuple[CalibratedGap, list[PricedModel], list[Foreseen]]:
    """Fit all models that may explain a gap; give the gap, its scatter taken anew where runs scatter, and the fits.

    The third value is what is foreseen of the sets that were not fitted; none where sets were not looked at.

    The best single effects and faults of single files by score come first. Where the best of these is doubtful, effects
    that show when they are large follow, and then sets of one to three by linear models. Scatter is taken at the best
    single effect, and again at the best set, see `take_scatter_at_best`, with the held-out runs `others`;
    `library_size` is the number of candidates. The fits are penalised, the best of each set of effects, the best first.
    """
    fits = fit_singles(gap.calibrated, gap.scores, library_size, work)
    gap, fits = take_scatter_at_best(gap, fits, others, work)
    base, ranked, fault_scores = gap.calibrated, gap.scores, _score_faults(gap)
    fits += fit_faults(base, fault_scores, fits, library_size, work)
    if not is_doubtful(fits, gap):
        return gap, _select_best_of_sets(fits), []
    large = fit_large(base, ranked, fits, library_size, work)
    is_better = bool(large) and large[0].cost < min(choice.cost for choice in fits)
    fits += large
    foreseen: list[Foreseen] = []
    if not is_better or is_doubtful(fits, gap):
        sets, foreseen = fit_sets(base, _list_paired(gap), fits, library_size, work)
        fits += sets
        if sets and sets[0] is min(fits, key=lambda choice: choice.cost):
            fits += refit_each_alone(base, sets[0], library_size, work)
            gap, fits = take_scatter_at_best(gap, fits, others, work)
            foreseen = count_from_best(foreseen, sets[0].names, fits)
    return gap, _select_best_of_sets(fits), foreseen


def count_from_best(
    foreseen: Iterable[Foreseen], best_names: Sequence[str], fits: Sequence[PricedModel]
) -> list[Foreseen]:
    """Count what was foreseen from the best of all fits, where their costs have changed since.

    `best_names` are those of the fit that was the best. Where it is not among `fits` any more, nothing is foreseen.
    """
    costs = [choice.cost for choice in fits if choice.names == tuple(best_names)]
    if not costs:
        return []
    behind = min(costs) - min(choice.cost for choice in fits)
    return [each._replace(excess=each.excess + behind) for each in foreseen]


def _select_best_of_sets(fits: list[PricedModel]) -> list[PricedModel]:
    """The best fit of each set of candidates, the best first."""
    best: dict[frozenset[str], PricedModel] = {}
    for choice in sorted(fits, key=lambda choice: choice.cost):
        best.setdefault(frozenset(choice.names), choice)
    return list(best.values())


def _score_faults(gap: CalibratedGap) -> list[Score]:
    """Scores of the faults of single files that are tried, the largest first."""
    return find_scores(gap.faults, gap.calibrated.fitted.residuals)[:MAX_PAIRED_FAULTS]


def _list_paired(gap: CalibratedGap) -> list[Sensitivity]:
    """Sensitivities of what is tried in sets: all effects, and the faults of single files with the largest scores."""
    return [*gap.sensitivities, *(score.sensitivity for score in _score_faults(gap))]


def is_doubtful(fits: list[PricedModel], gap: CalibratedGap) -> bool:
    """Whether the best model is implausible, pulls a number far, or leaves what noise alone hardly leaves.

    The last is meant where noise alone leaves as much with a chance below `DOUBTFUL`. False where no model was fitted.

    >>> from apesim.studies.gap.example_bench import explain_example, find_example_gap
    >>> fits = explain_example().fits
    >>> is_doubtful([choice for choice in fits if choice.names == ("coulomb_friction",)], find_example_gap())
    True
    """
    if not fits:
        return False
    best = min(fits, key=lambda choice: choice.cost).model
    return bool(best.pulled or find_implausible(best)) or compare_model_with_noise(best, gap).p_value < DOUBTFUL


def compare_model_with_noise(model: Model, gap: CalibratedGap) -> GapTest:
    """Compare what a model with effects leaves with what noise alone would leave.

    The scores are those of the candidates that the model does not have, and of local shapes, see `compare_with_noise`.

    >>> from apesim.studies.gap.example_bench import explain_example, find_example_gap
    >>> compare_model_with_noise(explain_example().best, find_example_gap()).alarm
    False
    """
    again, local = project_beside([*gap.sensitivities, *gap.faults], model), gap.local_shapes
    wider = find_nuisance_space(model.fitted.jacobian).project_out(
        np.vstack([local, np.zeros((model.added, local.shape[1]))])
    )
    left = model.residuals
    return compare_with_noise(again, wider, model.fitted.residuals, parts_of(left), left.list_spreads())
