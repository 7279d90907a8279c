"""How far the data speak for each effect, over all models.

A laboratory asks whether an effect is there, and not which model is the best of many. The weight of a model is
``exp(-cost / 2)`` with its penalised cost; the odds of an effect are the weights of all models that contain it, over
those of all others, the calibrated machine among these. Sets that were not fitted count by what a linear model foresees
of them: else an effect that all fitted models share would look surer than it is. Effects that do the same to these data
are one.
"""

from collections.abc import Iterable, Sequence
from math import log
from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.gap.search.model_selection import Foreseen, PricedModel
from apesim.studies.gap.search.run_faults import find_files
from apesim.studies.gap.search.score_test import find_cosine
from apesim.studies.gap.thresholds import ALIKE, AMBIGUOUS_COST, MIN_SURE_ODDS

MAX_LOG_ODDS = 700.0
"""Odds beyond which a number of 64 bits says zero or infinity."""
MIN_LISTED = -4.6
"""Log odds from which an effect is worth a mention: one in a hundred."""


class Inclusion(NamedTuple):
    """How far the data speak for an effect, or for one of several that do the same to them."""

    names: tuple[str, ...]
    """The effect, and behind it those that these data do not distinguish from it."""
    log_odds: float
    """Natural logarithm of the weight of all models that contain one of them over that of all others."""


def find_inclusions(base: Model, choices: Sequence[PricedModel], foreseen: Sequence[Foreseen] = ()) -> list[Inclusion]:
    """Find how far the data speak for each effect, averaged over models.

    It is Bayesian model averaging (Hoeting et al. 1999, doi 10.1214/ss/1009212519, Eq. 1). `base` is the calibrated
    machine; `choices` are the models that were fitted, the least penalised cost first; `foreseen` are sets that were
    not. Effects of the best choice come first, then those of the next ones.
    """
    if not choices:
        return []
    twins = find_twins(base, choices)
    groups: list[tuple[str, ...]] = []
    for name in (name for names in _list_sets(choices, foreseen) for name in names):
        if not any(name in group for group in groups):
            groups.append((name, *twins.get(name, ())))
    return [Inclusion(group, find_log_odds(base, choices, group, foreseen)) for group in groups]


def find_sure(
    base: Model,
    choices: Sequence[PricedModel],
    explanations: Sequence[PricedModel],
    foreseen: Sequence[Foreseen] = (),
) -> tuple[tuple[str, ...], ...]:
    """Find what is sure though several explanations are open: each effect with its twins behind it, the best's first.

    All of `explanations`, which are the best choice and its rivals, have to contain it or a twin, and over all models
    its odds have to be `MIN_SURE_ODDS`. A fault of a file is never sure in this way. `base`, `choices` and
    `foreseen` are those of `find_inclusions`.
    """
    files = {each.name for choice in choices for each in choice.model.candidates if find_files([each])}
    return tuple(
        each.names
        for each in find_inclusions(base, choices, foreseen)
        if each.log_odds >= log(MIN_SURE_ODDS)
        and not files & set(each.names)
        and all(set(each.names) & set(explanation.names) for explanation in explanations)
    )


def find_log_odds(
    base: Model, choices: Sequence[PricedModel], names: Sequence[str], foreseen: Sequence[Foreseen] = ()
) -> float:
    """Find the log odds that one of some effects is there: weights of the models that have one over all others'.

    The logarithm is natural, and lies within `MAX_LOG_ODDS` to both sides; `base`, the calibrated machine, has none of
    the effects. What was not fitted counts from the best choice on: of runs held out it is taken to leave as much.
    """
    costs = [base.cost, *(choice.cost for choice in choices), *(choices[0].cost + each.excess for each in foreseen)]
    log_weights = -0.5 * np.array(costs)
    has_it = np.array([False, *(not set(names).isdisjoint(each) for each in _list_sets(choices, foreseen))])
    with_it, without_it = (np.logaddexp.reduce(log_weights[each], initial=-np.inf) for each in (has_it, ~has_it))
    return float(np.clip(with_it - without_it, -MAX_LOG_ODDS, MAX_LOG_ODDS))


def _list_sets(choices: Iterable[PricedModel], foreseen: Iterable[Foreseen]) -> list[tuple[str, ...]]:
    """Names of what each model adds, those that were fitted before those that were not."""
    return [*(choice.names for choice in choices), *(each.names for each in foreseen)]


def find_twins(base: Model, choices: Sequence[PricedModel]) -> dict[str, tuple[str, ...]]:
    """Find what these data do not distinguish from each effect of the best choice, by effect.

    An effect is a twin of another where putting it in the other's place costs less than `AMBIGUOUS_COST`, and where
    both take the same part of the gap: a cosine above `ALIKE` between what either of them takes of what the rest of the
    model leaves. `base` is the calibrated machine; `choices`, at least one, come with the least penalised cost first.
    """
    best = choices[0]
    near = [choice for choice in choices[1:] if choice.cost - best.cost < AMBIGUOUS_COST]
    effects = best.names
    return {effect: tuple(dict.fromkeys(_find_twins_of(effect, base, best, near, choices))) for effect in effects}


def _find_twins_of(
    effect: str, base: Model, best: PricedModel, near: Iterable[PricedModel], choices: Sequence[PricedModel]
) -> Iterable[str]:
    """Names of what may stand in the place of one effect of the best choice."""
    others = set(best.names) - {effect}
    without = next((choice.model for choice in choices if set(choice.names) == others), base)
    taken = without.fitted.data_residuals - best.model.fitted.data_residuals
    for choice in near:
        rest = set(choice.names) - others
        if len(rest) != 1 or effect in rest or len(choice.names) != len(best.names):
            continue
        if find_cosine(taken, without.fitted.data_residuals - choice.model.fitted.data_residuals) > ALIKE:
            yield rest.pop()
