"""The models that may explain the gap, fitted and ranked by penalised cost."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import combinations
from math import log
from typing import Any, NamedTuple

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.estimation.residuals import unless_ended
from apesim.studies.gap.search.refit import at_large, reduced, refit, release
from apesim.studies.gap.search.score_test import Score, Sensitivity, find_sensitivities, freed, scores
from apesim.studies.gap.thresholds import AMBIGUOUS_COST, TERM_CHANCE
from apesim.studies.gap.work import Work

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
Pair = tuple[tuple[Any, ...], tuple[Any, ...]]
"""Candidates with the values x from which each starts."""


class Choice(NamedTuple):
    """A model with its penalised cost: one explanation of the gap."""

    model: Model
    cost: float
    """Sum of squares, priors included, and the penalty for what the model adds, see `penalty`."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects that it adds, or the key of the nuisance whose prior it takes away."""
        return self.model.names


def term(library: int) -> float:
    """The penalty of one effect, or of one nuisance without its prior: ``2 ln(n / p)``.

    It is the price of one term among n, with the chance p = `TERM_CHANCE` of a term that is not there (PASTIS [1]_).

    Parameters
    ----------
    library : int
        Number n of candidates.

    Returns
    -------
    float
        In units of the sum of squares.

    References
    ----------
    .. [1] A. Gerardos and P. Ronceray, 2025, arXiv:2501.10339 (PASTIS).

    Examples
    --------
    >>> round(term(35), 2)
    16.32
    """
    return 2.0 * log(max(library, 1) / TERM_CHANCE)


def penalty(model: Model, library: int) -> float:
    """The penalty of a model: that of one `term` for each effect, and 2 for each parameter beyond one an effect.

    The price of a term is that of PASTIS [1]_, that of a further parameter is Akaike's [2]_.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model
    library : int
        Number of candidates.

    Returns
    -------
    float
        In units of the sum of squares.

    References
    ----------
    .. [1] A. Gerardos and P. Ronceray, 2025, arXiv:2501.10339 (PASTIS).
    .. [2] H. Akaike, "A new look at the statistical model identification", IEEE Trans. Automat. Contr. 19, 1974,
       pp. 716-723, doi 10.1109/TAC.1974.1100705.
    """
    terms = len(model.names)
    return terms * term(library) + 2.0 * max(0, model.added - terms)


def priced(model: Model, library: int) -> Choice:
    """A model as a choice: with its sum of squares and its `penalty` added up.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model
    library : int
        Number of candidates.

    Returns
    -------
    Choice
    """
    return Choice(model, model.cost + penalty(model, library))


def singles(base: Model, ranked: Sequence[Score], library: int, work: Work) -> list[Choice]:
    """Fit the most promising candidates, each alone.

    They are the `SINGLES` best by score, and of the others the `LARGE` that leave least when switched on by much.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    ranked : sequence of apesim.studies.gap.search.score_test.Score
        Scores of the candidates, the largest first.
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
    work.simulations.add(sum(simulations for *_, simulations in large))
    near = sorted(zip(large, others, strict=True), key=lambda one: one[0][0])
    tasks += [((candidate,), (x,)) for (cost, x, _), candidate in near[:LARGE] if cost < base.cost]
    return _fitted(base, refit, tasks, library, work, "fitting effects")


def remaining(base: Model, ranked: Sequence[Score], found: Iterable[Choice], library: int, work: Work) -> list[Choice]:
    """Fit the candidates that were not fitted alone yet.

    Where a calibration was led astray, scores and probes say little of what a fit gives.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    ranked : sequence of apesim.studies.gap.search.score_test.Score
        Scores of the candidates, the largest first.
    found : iterable of Choice
        Models that were fitted.
    library : int
        Number of candidates.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    list of Choice
        The best first.
    """
    fitted = {choice.names for choice in found}
    rest = [score for score in ranked if (score.name,) not in fitted]
    return _fitted(base, refit, _scored(rest), library, work, "fitting effects")


def released(base: Model, library: int, work: Work) -> list[Choice]:
    """Fit the calibrated machine without one prior, for each nuisance that is pulled by more than `PULLED`.

    Nuisances that are no number of the machine (`MATERIAL`) are left out.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    library : int
        Number of candidates.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    list of Choice
        The best first.
    """
    pulled = np.flatnonzero(base.residuals.known & (np.abs(base.fitted.x) > PULLED))
    wanted = [(int(j),) for j in pulled if base.residuals.parameters[j].key not in MATERIAL]
    return _fitted(base, release, wanted, library, work, "fitting effects")


def pairs(
    base: Model,
    columns: Sequence[Sensitivity],
    ranked: Sequence[Score],
    alone: Sequence[Choice],
    library: int,
    work: Work,
) -> list[Choice]:
    """Fit the most promising pairs of effects.

    They are each of the three best singles with the two effects that score best on what it leaves; of all pairs those
    that take most of the gap in a linear model, by their sensitivities and by what each effect takes alone; and then
    the best of these pairs with either effect replaced by others.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    columns : sequence of apesim.studies.gap.search.score_test.Sensitivity
        What each candidate would do to the data at the calibrated machine.
    ranked : sequence of apesim.studies.gap.search.score_test.Score
        Scores of the candidates, the largest first.
    alone : sequence of Choice
        Single effects, the best first.
    library : int
        Number of candidates.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    list of Choice
        The best first.
    """
    wanted: dict[frozenset[str], Pair] = {}
    screened = [*_screened(ranked, base.fitted.residuals), *_added_up(alone, base.fitted.data_residuals)]
    for (first, second), guesses in [*_partners(alone[:3], columns, work), *screened]:
        wanted.setdefault(frozenset((first.name, second.name)), ((first, second), guesses))

    def fitted(pairs: Iterable[Pair]) -> list[Choice]:
        tasks = [(*pair, [c.model for c in alone if c.names[0] in _names(pair)]) for pair in pairs]
        return _fitted(base, refit, tasks, library, work, "fitting pairs")

    found = fitted(wanted.values())
    if found:
        others = {frozenset(_names(pair)): pair for pair in _swapped(found[0], alone, columns)}
        tried = {frozenset(choice.names) for choice in found}
        untried = [pair for names, pair in others.items() if names not in tried]
        found += fitted(untried)
    return sorted(found, key=lambda choice: choice.cost)


def alone_again(base: Model, pair: Choice, library: int, work: Work) -> list[Choice]:
    """Fit each effect of a pair alone, from where the pair stands: its own fit may have ended in another minimum.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    pair : Choice
    library : int
        Number of candidates.
    work : apesim.studies.gap.work.Work

    Returns
    -------
    list of Choice
        The best first.
    """
    wanted = [(pair.model, number) for number in range(len(pair.model.candidates))]
    return _fitted(base, reduced, wanted, library, work, "fitting pairs")


def beside(columns: Iterable[Sensitivity], model: Model) -> list[Sensitivity]:
    """Sensitivities of the other effects beside a model with effects: what that can imitate is taken off, too.

    Parameters
    ----------
    columns : iterable of apesim.studies.gap.search.score_test.Sensitivity
        Sensitivities at the calibrated machine.
    model : apesim.studies.estimation.model.Model
        A model with effects.

    Returns
    -------
    list of apesim.studies.gap.search.score_test.Sensitivity
        Without those of the effects of the model.
    """
    others = [column for column in columns if column.probe.candidate.name not in model.names]
    return freed(others, model.fitted, model.added)


def _scored(scores: Iterable[Score]) -> list[Pair]:
    """Candidates alone with the sizes that their scores suggest, as `refit` wants them."""
    return [((score.column.probe.candidate,), (score.guess,)) for score in scores]


def _fitted(
    base: Model, fit: Callable[..., Model], wanted: Iterable[Any], library: int, work: Work, stage: str
) -> list[Choice]:
    """The calibrated model fitted anew in several ways, the best first; without those that do not come to their end."""
    models = work.each(stage, unless_ended, [(fit, base, *how) for how in wanted])
    models = [model for model in models if model]
    work.simulations.add(sum(model.residuals.simulations for model in models))
    return sorted((priced(model, library) for model in models), key=lambda choice: choice.cost)


def _names(pair: Pair) -> list[str]:
    """Names of the candidates of a pair with its guesses."""
    return [candidate.name for candidate in pair[0]]


def _swapped(pair: Choice, alone: Sequence[Choice], columns: Sequence[Sensitivity]) -> Iterator[Pair]:
    """The pair with either effect replaced by what explains as much of what the other leaves."""
    for number, kept in enumerate(pair.model.candidates):
        single = next((choice.model for choice in alone if choice.names == (kept.name,)), None)
        if single is None:
            continue
        ranked = scores(beside(columns, single), single.fitted.residuals)
        near = [one for one in ranked if one.deviations**2 > ranked[0].deviations ** 2 - 2.0 * AMBIGUOUS_COST]
        x = tuple(pair.model.own(number))
        for score in near[:SWAPS]:
            yield (kept, score.column.probe.candidate), (x, score.guess)


def _partners(alone: Sequence[Choice], columns: Sequence[Sensitivity], work: Work) -> Iterator[Pair]:
    """For each single the two candidates that score best on what it leaves."""
    by_candidate = list({column.probe.candidate.name: column.probe.candidate for column in columns}.values())
    for rank, choice in enumerate(alone):
        model = choice.model
        first = model.candidates[0]
        if rank == 0:
            others = [candidate for candidate in by_candidate if candidate.name != first.name]
            own = find_sensitivities(model.residuals, model.fitted, others, work, "fitting pairs")
        else:
            own = beside(columns, model)
        for score in scores(own, model.fitted.residuals)[:2]:
            if score.deviations > 0.0:
                x = tuple(model.own(0))
                yield (first, score.column.probe.candidate), (x, score.guess)


def _screened(ranked: Sequence[Score], errors: np.ndarray) -> Iterator[Pair]:
    """The pairs that explain most of the gap if all is straight."""
    probes = [score.column.probe for score in ranked]
    for numbers, weights in _largest([-score.column.projected for score in ranked], errors):
        pair = [probes[number] for number in numbers]
        guesses = (probe.scaled(weight) for probe, weight in zip(pair, weights, strict=True))
        yield tuple(probe.candidate for probe in pair), tuple(guesses)


def _added_up(alone: Sequence[Choice], left: np.ndarray) -> Iterator[Pair]:
    """The pairs that explain most of the gap if what each takes of it alone adds up.

    Where an effect is large and bends the data, its sensitivity at the calibrated machine foretells little of it.
    """
    models = [choice.model for choice in alone]
    for numbers, _ in _largest([left - model.fitted.data_residuals for model in models], left):
        pair = [models[number] for number in numbers]
        yield tuple(model.candidates[0] for model in pair), tuple(tuple(model.own(0)) for model in pair)


def _largest(taken: Sequence[np.ndarray], gap: np.ndarray) -> list[tuple[tuple[int, ...], np.ndarray]]:
    """The pairs, by number, that take most of a gap together, with their weights; the largest first."""
    found = []
    for pair in combinations(range(len(taken)), 2):
        both = np.column_stack([taken[number] for number in pair])
        weights, *_ = np.linalg.lstsq(both, gap, rcond=None)
        found.append((float(gap @ (both @ weights)), pair, weights))
    found.sort(key=lambda one: -one[0])
    return [(pair, weights) for _, pair, weights in found[:SCREENED]]
