"""The models that explain the gap, by penalised cost: the best, and all that these data cannot tell from it."""

from itertools import combinations
from math import log
from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.estimation.residuals import unless_ended
from apesim.studies.gap.search.refit import at_large, reduced, refit, release
from apesim.studies.gap.search.score_test import find_sensitivities, freed, scores
from apesim.studies.gap.thresholds import AMBIGUOUS_COST, TERM_CHANCE

SINGLES = 12
"""Candidates that are fitted alone for their score."""
LARGE = 4
"""Candidates that are fitted alone for what they leave when switched on by much."""
SCREENED = 3
"""Pairs of a screen of all that are fitted."""
SWAPS = 3
"""Effects that are tried in place of either of the best pair."""
PULLED = 2.5
"""Prior deviations from which a wrong nuisance is one of the explanations."""
MATERIAL = ("air.heat_capacity_ratio",)
"""Nuisances that are no number of a machine: not tried as the explanation in place of an effect."""


class Choice(NamedTuple):
    """A model with its penalised cost."""

    model: Model
    cost: float

    @property
    def names(self):
        """Names of the effects it adds."""
        return self.model.names


def term(library):
    """What one effect of a library has to earn, or a number of the machine: 2 ln(n/p)."""
    return 2.0 * log(max(library, 1) / TERM_CHANCE)


def penalty(model, library):
    """What the effects of a model have to earn, and 2 for each further parameter."""
    terms = len(model.names)
    return terms * term(library) + 2.0 * max(0, model.added - terms)


def priced(model, library):
    """A model as a choice."""
    return Choice(model, model.cost + penalty(model, library))


def singles(base, ranked, library, work):
    """The best candidates by score, and by what they leave when switched on by much, each fitted alone.

    Parameters
    ----------
    base : Model
    ranked : list of Score
    library : int
        Number of candidates.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    list of Choice
        The best first.
    """
    wanted = {score.name: score for score in ranked[:SINGLES] if score.deviations > 0.0}
    tasks = _scored(wanted.values())
    others = [score.column.probe.candidate for score in ranked if score.name not in wanted]
    large = work.each("scoring", at_large, [(base, candidate) for candidate in others])
    base.problem.simulations += sum(simulations for *_, simulations in large)
    near = sorted(zip(large, others, strict=True), key=lambda one: one[0][0])
    tasks += [((candidate,), (x,)) for (cost, x, _), candidate in near[:LARGE] if cost < base.cost]
    return _fitted(base, refit, tasks, library, work, "fitting effects")


def remaining(base, ranked, found, library, work):
    """The candidates that were not fitted alone: where a calibration was led astray, scores and probes foretell little.

    Parameters
    ----------
    base : Model
    ranked : list of Score
    found : list of Choice
        What was fitted.
    library : int
    work : apesim.studies.gap.work.Work

    Returns
    -------
    list of Choice
        The best first.
    """
    fitted = {choice.names for choice in found}
    rest = [score for score in ranked if (score.name,) not in fitted]
    return _fitted(base, refit, _scored(rest), library, work, "fitting effects")


def released(base, library, work):
    """The calibrated model without one prior, for each nuisance that is pulled by more than `PULLED`.

    Returns
    -------
    list of Choice
    """
    pulled = np.flatnonzero(base.problem.known & (np.abs(base.fitted.x) > PULLED))
    wanted = [(int(j),) for j in pulled if base.problem.parameters[j].key not in MATERIAL]
    return _fitted(base, release, wanted, library, work, "fitting effects")


def pairs(base, columns, ranked, alone, library, work):
    """The best pairs: partners of the best singles and those of both screens of all, each fitted; and the best with
    either effect replaced by others.

    Parameters
    ----------
    base : Model
    columns : list of Sensitivity
        Of the bank at the calibrated machine.
    ranked : list of Score
    alone : list of Choice
        Singles, the best first.
    library : int
    work : apesim.studies.gap.work.Work

    Returns
    -------
    list of Choice
        The best first.
    """
    wanted = {}
    screened = [*_screened(ranked, base.fitted.errors), *_added_up(alone, base.fitted.left)]
    for (first, second), guesses in [*_partners(alone[:3], columns, work), *screened]:
        wanted.setdefault(frozenset((first.name, second.name)), ((first, second), guesses))

    def fitted(pairs):
        tasks = [(*pair, [c.model for c in alone if c.names[0] in _names(pair)]) for pair in pairs]
        return _fitted(base, refit, tasks, library, work, "fitting pairs")

    found = fitted(wanted.values())
    if found:
        others = {frozenset(_names(pair)): pair for pair in _swapped(found[0], alone, columns)}
        tried = {frozenset(choice.names) for choice in found}
        untried = [pair for names, pair in others.items() if names not in tried]
        found += fitted(untried)
    return sorted(found, key=lambda choice: choice.cost)


def alone_again(base, pair, library, work):
    """The effects of a pair, each alone, from where the pair stands: a single fit may have ended elsewhere.

    Parameters
    ----------
    base : Model
    pair : Choice
    library : int
    work : apesim.studies.gap.work.Work

    Returns
    -------
    list of Choice
    """
    wanted = [(pair.model, number) for number in range(len(pair.model.candidates))]
    return _fitted(base, reduced, wanted, library, work, "fitting pairs")


def beside(columns, model):
    """Columns of a bank for what a model with effects leaves, without those of its effects."""
    others = [column for column in columns if column.probe.candidate.name not in model.names]
    return freed(others, model.fitted, model.added)


def _scored(scores):
    """Candidates alone with the sizes that their scores suggest, as `refit` wants them."""
    return [((score.column.probe.candidate,), (score.guess,)) for score in scores]


def _fitted(base, fit, wanted, library, work, stage):
    """The calibrated model fitted anew in several ways, the best first; without those that do not come to their end."""
    models = work.each(stage, unless_ended, [(fit, base, *how) for how in wanted])
    models = [model for model in models if model]
    base.problem.simulations += sum(model.problem.simulations for model in models)
    return sorted((priced(model, library) for model in models), key=lambda choice: choice.cost)


def _names(pair):
    """Names of the candidates of a pair with its guesses."""
    return [candidate.name for candidate in pair[0]]


def _swapped(pair, alone, columns):
    """The pair with either effect replaced by what explains as much of what the other leaves."""
    for number, kept in enumerate(pair.model.candidates):
        single = next((choice.model for choice in alone if choice.names == (kept.name,)), None)
        if single is None:
            continue
        ranked = scores(beside(columns, single), single.fitted.errors)
        near = [one for one in ranked if one.deviations**2 > ranked[0].deviations ** 2 - 2.0 * AMBIGUOUS_COST]
        x = tuple(pair.model.own(number))
        for score in near[:SWAPS]:
            yield (kept, score.column.probe.candidate), (x, score.guess)


def _partners(alone, columns, work):
    """For each single the two candidates that score best on what it leaves."""
    by_candidate = list({column.probe.candidate.name: column.probe.candidate for column in columns}.values())
    for rank, choice in enumerate(alone):
        model = choice.model
        first = model.candidates[0]
        if rank == 0:
            others = [candidate for candidate in by_candidate if candidate.name != first.name]
            own = find_sensitivities(model.problem, model.fitted, others, work, "fitting pairs")
        else:
            own = beside(columns, model)
        for score in scores(own, model.fitted.errors)[:2]:
            if score.deviations > 0.0:
                x = tuple(model.own(0))
                yield (first, score.column.probe.candidate), (x, score.guess)


def _screened(ranked, errors):
    """The pairs that explain most of the gap if all is straight."""
    probes = [score.column.probe for score in ranked]
    for numbers, weights in _largest([-score.column.projected for score in ranked], errors):
        pair = [probes[number] for number in numbers]
        guesses = (probe.scaled(weight) for probe, weight in zip(pair, weights, strict=True))
        yield tuple(probe.candidate for probe in pair), tuple(guesses)


def _added_up(alone, left):
    """The pairs that explain most of the gap if what each takes of it alone adds up.

    Where an effect is large and bends the data, its sensitivity at the calibrated machine foretells little of it.
    """
    models = [choice.model for choice in alone]
    for numbers, _ in _largest([left - model.fitted.left for model in models], left):
        pair = [models[number] for number in numbers]
        yield tuple(model.candidates[0] for model in pair), tuple(tuple(model.own(0)) for model in pair)


def _largest(taken, gap):
    """The pairs, by number, that take most of a gap together, with their weights; the largest first."""
    found = []
    for pair in combinations(range(len(taken)), 2):
        both = np.column_stack([taken[number] for number in pair])
        weights, *_ = np.linalg.lstsq(both, gap, rcond=None)
        found.append((float(gap @ (both @ weights)), pair, weights))
    found.sort(key=lambda one: -one[0])
    return [(pair, weights) for _, pair, weights in found[:SCREENED]]
