"""How far the parameters of an explanation may be off, beyond what the curvature of its sum of squares says.

The curvature believes that the model is right. A rig has more in it: what drags a little more at one pressure than at
another, and effects too small to be named, which move the strength of one that is named. Neither needs a simulation:
the operating points of a fit lead to different values, and the models that were tried beside it do, too.
"""

from collections.abc import Iterator, Sequence
from math import log
from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.cluster_robust import compare_groups
from apesim.studies.estimation.model import Model
from apesim.studies.gap.decide.operating_points import list_point_rows
from apesim.studies.gap.search.model_selection import PricedModel, find_term_penalty
from apesim.studies.gap.search.score_test import Sensitivity, project_for_model
from apesim.studies.gap.thresholds import AMBIGUOUS_COST, TERM_CHANCE

WIDENING = 1.33
"""Factor of all standard deviations of strengths, so that 95 % of the intervals of sealed cases hold the truth, by
``python -m tests.truth widen``: 28 of 33 strengths of development held it without, where nothing was hidden beside what
was said. The factor itself is known to 0.84 to 1.34 by these. Where more was hidden, two of seven held it, and no
factor would do: what is missing beside a named effect moves its strength as far as the two are alike."""
FURTHER_CHANCE = 0.1
"""Chance of an effect of the library beside those of a model, where it is asked how far strengths may be off: ten times
`TERM_CHANCE`, by which names are given, as an effect that is too small for a name moves the strengths of others all the
same. In 436 draws on linear models of 14 benches another effect of 1 to 5 standard deviations is hidden beside the one
that is fitted: 78 % of the intervals by the curvature hold the strength, with operating points and other models 88 % by
`TERM_CHANCE` and 90 % by this. With noise alone it is 95 % by the curvature and 96 % by this, half of them no wider."""


class Other(NamedTuple):
    """Another model, as far as it tells of the parameters of the best one."""

    excess: float
    """Penalised cost above that of the best model, each effect priced by `FURTHER_CHANCE`."""
    shifts: np.ndarray
    """Parameters less those of the best model, in x, (p,); NaN where it has no such parameter."""
    variances: np.ndarray
    """Variances of the parameters by the curvature, in x, (p,)."""


def find_standard_errors(model: Model) -> np.ndarray:
    """Find the standard deviations of a model's parameters, in x, (p,).

    The variance by the curvature, ``pinv(J'J)``, is multiplied by what the operating points tell, see `compare_groups`,
    and what the models within reach add comes to it, see `find_variances_between`; of the root `WIDENING` is taken.
    Where all runs are at one operating point, that tells nothing.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> model = explain_example().best
    >>> bool(np.all(find_standard_errors(model) ** 2 >= np.diag(model.fitted.covariance)))
    True
    """
    variances, groups = np.diag(model.fitted.covariance), list_point_rows(model.residuals)
    if len(groups) > 1:
        variances = variances * compare_groups(model.fitted.jacobian, model.fitted.residuals, groups).factors
    if model.between is not None:
        variances = variances + model.between
    return WIDENING * np.sqrt(variances)


def find_variances_between(
    best: PricedModel, choices: Sequence[PricedModel], sensitivities: Sequence[Sensitivity], library: int
) -> np.ndarray:
    """Find the variances of the best model's parameters that other models within reach add, in x, (p,).

    With the weights ``w_k = exp(-excess_k / 2)`` over the sum of all, that of the best model among them, the variance
    about the best value is ``sum_k w_k (sigma_k^2 + (x_k - x)^2)`` (Kass and Raftery 1995, doi
    10.1080/01621459.1995.10476572, with the best value in place of the mean; Buckland, Burnham and Augustin 1997, doi
    10.2307/2533961). What it is above the best model's own is given, 0 or more. Models are those of the `choices`,
    which were fitted, and the best one with one effect more, linear in its size, by `sensitivities` at the calibrated
    machine. They count within `AMBIGUOUS_COST`, and for each parameter those that have it. `library` is the number of
    candidates.
    """
    own = np.diag(best.model.fitted.covariance)
    others = [*_list_fitted(best, choices), *_list_larger(best, choices, sensitivities, library)]
    near = [other for other in others if other.excess < AMBIGUOUS_COST]
    if not near:
        return np.zeros(len(own))
    shifts, variances = (np.array([getattr(other, name) for other in near]) for name in ("shifts", "variances"))
    # No other one counts for more than the best: where its effects are priced higher, it was not preferred.
    weights = np.exp(-0.5 * np.maximum([other.excess for other in near], 0.0))[:, None] * np.isfinite(shifts)
    added = np.nansum(weights * (variances - own + shifts**2), axis=0) / (1.0 + weights.sum(axis=0))
    return np.maximum(added, 0.0)


def _list_fitted(best: PricedModel, choices: Sequence[PricedModel]) -> Iterator[Other]:
    """Other models that were fitted."""
    keys = [(p.key, p.file) for p in best.model.residuals.parameters]
    for choice in choices:
        if set(choice.names) == set(best.names):
            continue
        places = {(p.key, p.file): j for j, p in enumerate(choice.model.residuals.parameters)}
        shared = np.array([places.get(key, -1) for key in keys])
        fitted, terms = choice.model.fitted, len(choice.model.candidates) - len(best.model.candidates)
        shifts = np.where(shared < 0, np.nan, fitted.x[shared] - best.model.fitted.x)
        variances = np.diag(fitted.covariance)[shared]
        yield Other(choice.cost - best.cost - terms * _find_rebate(), shifts, variances)


def _list_larger(
    best: PricedModel, choices: Sequence[PricedModel], sensitivities: Sequence[Sensitivity], library: int
) -> Iterator[Other]:
    """The best model with one effect more that was not fitted beside it, each by its likeliest probe.

    The size of the effect has a normal prior, the end of its range as its standard deviation: an effect that does much
    the same as others may not be larger than it can be.
    """
    fitted, known = best.model.fitted, {frozenset(choice.names) for choice in (best, *choices)}
    larger = [each for each in sensitivities if frozenset((*best.names, each.probe.candidate.name)) not in known]
    covariance, samples = fitted.covariance, len(fitted.data_residuals)
    found: dict[str, Other] = {}
    for each in project_for_model(larger, fitted, best.model.added):
        probe, name = each.probe, each.probe.candidate.name
        if not each.is_visible:
            continue
        prior = (probe.x[probe.strength] / max(map(abs, probe.parameter.ends))) ** 2
        precision = each.length**2 + prior
        size = -float(each.projected @ fitted.residuals) / precision
        if probe.one_sided and size <= 0.0:
            continue
        moved = covariance @ (fitted.jacobian[:samples].T @ each.effect[:samples])
        excess = find_term_penalty(library) - _find_rebate() - size**2 * precision
        if name not in found or excess < found[name].excess:
            found[name] = Other(excess, -size * moved, np.diag(covariance) + moved**2 / precision)
    yield from found.values()


def _find_rebate() -> float:
    """Penalised cost by which an effect is cheaper here than where names are given."""
    return 2.0 * log(FURTHER_CHANCE / TERM_CHANCE)
