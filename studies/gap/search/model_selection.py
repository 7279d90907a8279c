"""The models that may explain the gap, fitted and ranked by penalised cost."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import combinations
from math import log
from typing import Any, NamedTuple

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.estimation.residuals import unless_ended
from apesim.studies.gap.search.refit import probe_large_sizes, refit, refit_one
from apesim.studies.gap.search.score_test import Score, Sensitivity, find_scores, find_sensitivities, project_for_model
from apesim.studies.gap.stage_work import Work
from apesim.studies.gap.thresholds import AMBIGUOUS_COST, TERM_CHANCE

MAX_SINGLES = 12
"""Candidates that are fitted alone for their score."""
MAX_FAULTS = 6
"""Faults of single files that are fitted alone for their score."""
MAX_LARGE = 4
"""Candidates that are fitted alone for what they leave when switched on by much."""
MAX_SCREENED_PAIRS = 3
"""Pairs of a screen of all that are fitted."""
MAX_EXTENDED_PAIRS = 3
"""Pairs to which a third effect is added."""
MAX_SWAPS = 3
"""Effects that are tried in place of either of the best pair."""
LEADERS = 4
"""Models of a kind that are fitted first: how near the best of them comes says which others are worth sharpening."""
NEGLIGIBLE = 60.0
"""Sum of squares above the best model's from which a model counts for nothing: odds of 1e13 to 1."""
NEGLIGIBLE_SHARE = 0.1
"""Share of what the best model takes off the calibrated machine's sum of squares that a model has to be behind, too."""
Pair = tuple[tuple[Any, ...], tuple[Any, ...]]
"""Candidates with the values x from which each starts."""


class PricedModel(NamedTuple):
    """A model with its penalised cost: one explanation of the gap."""

    model: Model
    cost: float
    """Sum of squares, priors included, and the penalty for what the model adds, see `find_penalty`."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of what it adds; where it adds nothing, the keys of the numbers that it corrects."""
        return self.model.names or self.model.corrected


def find_term_penalty(library: int) -> float:
    """The penalty of one effect of the library of n, ``2 ln(n / p)``, in units of the sum of squares.

    It is the price of one term among n, with the chance p = `TERM_CHANCE` of a term that is not there (PASTIS; Gerardos
    and Ronceray 2025, arXiv:2501.10339).

    >>> round(find_term_penalty(35), 2)
    16.32
    """
    return 2.0 * log(max(library, 1) / TERM_CHANCE)


def find_penalty(model: Model, library: int) -> float:
    """The penalty of a model: that of a term for each effect, and 2 for each parameter beyond one an effect.

    It is in units of the sum of squares; `library` is the number of candidates. The price of a term is that of PASTIS
    (Gerardos and Ronceray 2025, arXiv:2501.10339), see `find_term_penalty`, that of a further parameter Akaike's (1974,
    doi 10.1109/TAC.1974.1100705); a number that is off costs what its prior says, see `find_pull`.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> round(find_penalty(explain_example().best, library=35), 2)  # one effect of one parameter
    16.32
    """
    terms = len(model.candidates)
    return terms * find_term_penalty(library) + 2.0 * max(0, model.added - terms)


def price_model(model: Model, library: int) -> PricedModel:
    """A model as a choice: with its sum of squares and its `find_penalty` added up; `library` counts the candidates."""
    return PricedModel(model, model.cost + find_penalty(model, library))


def fit_singles(base: Model, ranked: Sequence[Score], library: int, work: Work) -> list[PricedModel]:
    """Fit the most promising candidates, each alone; the best fit first.

    They are the `MAX_SINGLES` best by score (`ranked`, the largest first), and of the others the `MAX_LARGE` that leave
    least when switched on by much; `library` is the number of candidates.
    """
    wanted = {score.name: score for score in ranked[:MAX_SINGLES] if score.n_sigma > 0.0}
    tasks = _guess_singles(base, wanted.values())
    others = [score.sensitivity.probe.candidate for score in ranked if score.name not in wanted]
    large = work.each("scoring", probe_large_sizes, [(base, candidate) for candidate in others])
    work.simulations.add(sum(simulations for *_, simulations in large))
    near = sorted(zip(large, others, strict=True), key=lambda pair: pair[0][0])
    tasks += [(base, (candidate,), (x,)) for (cost, x, _), candidate in near[:MAX_LARGE] if cost < base.fitted.cost]
    return _fit_all(base, refit, tasks, (), library, work, "fitting effects")


def fit_faults(
    base: Model, ranked: Sequence[Score], fits: Iterable[PricedModel], library: int, work: Work
) -> list[PricedModel]:
    """Fit the most promising faults of single files, each alone, beside the models `fits` that were fitted; best first.

    `base` is the calibrated machine, `ranked` the scores of the faults, the largest first, `library` the number of
    candidates.
    """
    wanted = [score for score in ranked[:MAX_FAULTS] if score.n_sigma > 0.0]
    return _fit_all(base, refit, _guess_singles(base, wanted), fits, library, work, "fitting files")


def fit_triples(
    base: Model,
    sensitivities: Sequence[Sensitivity],
    pairs: Sequence[PricedModel],
    library: int,
    work: Work,
) -> list[PricedModel]:
    """Fit the most promising sets of three: each of the best pairs with the two that score best on what it leaves.

    `sensitivities` are those at the calibrated machine `base`, `pairs` and the result have the best first; `library` is
    the number of candidates.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> pairs = [choice for choice in explanation.fits if len(choice.names) == 2]
    >>> triples = fit_triples(explanation.calibrated, explanation.sensitivities, pairs[:1], 3, Work())
    >>> all(len(triple.names) == 3 and triple.model.cost <= pairs[0].model.cost for triple in triples)
    True
    """
    wanted: dict[frozenset[str], Any] = {}
    for pair in pairs[:MAX_EXTENDED_PAIRS]:
        model = pair.model
        beside = find_scores(project_beside(sensitivities, model), model.fitted.residuals)
        for score in [score for score in beside if score.n_sigma > 0.0][:2]:
            third = score.sensitivity.probe.candidate
            guesses = (*(tuple(model.own(number)) for number in range(len(model.candidates))), score.guess)
            names = frozenset((*model.names, third.name))
            within = [other.model for other in pairs if set(other.names) < names]
            wanted.setdefault(names, (base, (*model.candidates, third), guesses, within))
    return _fit_all(base, refit, wanted.values(), pairs, library, work, "fitting sets of three")


def fit_remaining(
    base: Model, ranked: Sequence[Score], fits: Iterable[PricedModel], library: int, work: Work
) -> list[PricedModel]:
    """Fit the candidates that were not fitted alone yet; the best fit first.

    Where a calibration was led astray, scores and probes say little of what a fit gives. `ranked` has the largest score
    first; `library` is the number of candidates.
    """
    fitted = list(fits)
    names = {choice.names for choice in fitted}
    rest = [score for score in ranked if (score.name,) not in names]
    return _fit_all(base, refit, _guess_singles(base, rest), fitted, library, work, "fitting effects")


def fit_pairs(
    base: Model,
    sensitivities: Sequence[Sensitivity],
    ranked: Sequence[Score],
    alone: Sequence[PricedModel],
    library: int,
    work: Work,
) -> list[PricedModel]:
    """Fit the most promising pairs of effects; the best fit first.

    They are each of the three best singles with the two effects that score best on what it leaves; of all pairs those
    that take most of the gap in a linear model, by their sensitivities and by what each effect takes alone; and then
    the best of these pairs with either effect replaced by others. `sensitivities` are at the calibrated machine `base`,
    `ranked` and `alone` have the best first; `library` is the number of candidates.
    """
    wanted: dict[frozenset[str], Pair] = {}
    screened = [*_screen_pairs(ranked, base.fitted.residuals), *_add_up_singles(alone, base.fitted.data_residuals)]
    for (first, second), guesses in [*_find_partners(alone[:3], sensitivities, work), *screened]:
        wanted.setdefault(frozenset((first.name, second.name)), ((first, second), guesses))

    def fitted(pairs: Iterable[Pair], fits: Sequence[PricedModel]) -> list[PricedModel]:
        tasks = [(base, *pair, [c.model for c in alone if c.names[0] in _name_candidates(pair)]) for pair in pairs]
        return _fit_all(base, refit, tasks, fits, library, work, "fitting pairs")

    fits = fitted(wanted.values(), alone)
    if fits:
        others = {frozenset(_name_candidates(pair)): pair for pair in _swap_effects(fits[0], alone, sensitivities)}
        tried = {frozenset(choice.names) for choice in fits}
        untried = [pair for names, pair in others.items() if names not in tried]
        fits += fitted(untried, fits)
    return sorted(fits, key=lambda choice: choice.cost)


def refit_each_alone(base: Model, pair: PricedModel, library: int, work: Work) -> list[PricedModel]:
    """Fit each effect of a pair alone, from where the pair stands: its own fit may have ended in another minimum.

    The best comes first; `library` is the number of candidates.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> pair = next(choice for choice in explanation.fits if len(choice.names) == 2)
    >>> [choice.names for choice in refit_each_alone(explanation.calibrated, pair, 3, Work())]
    [('side_force',), ('coulomb_friction',)]
    """
    wanted = [(base, pair.model, number) for number in range(len(pair.model.candidates))]
    return _fit_all(base, refit_one, wanted, (), library, work, "fitting pairs")


def project_beside(sensitivities: Iterable[Sensitivity], model: Model) -> list[Sensitivity]:
    """Sensitivities of the other effects beside a model with effects: what that can imitate is taken off, too.

    `sensitivities` are those at the calibrated machine.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> others = project_beside(explanation.sensitivities, explanation.best)
    >>> sorted({sensitivity.probe.candidate.name for sensitivity in others})
    ['coulomb_friction', 'spring_rate_error']
    """
    others = [sensitivity for sensitivity in sensitivities if sensitivity.probe.candidate.name not in model.names]
    return project_for_model(others, model.fitted, model.added)


def _guess_singles(base: Model, scores: Iterable[Score]) -> list[tuple[Any, ...]]:
    """Candidates alone with the sizes that their scores suggest, as `refit` wants them."""
    return [(base, (score.sensitivity.probe.candidate,), (score.guess,)) for score in scores]


def _fit_all(
    base: Model,
    fit: Callable[..., Model],
    wanted: Iterable[Any],
    known: Iterable[PricedModel],
    library: int,
    work: Work,
    stage: str,
) -> list[PricedModel]:
    """The calibrated model fitted anew in several ways, the best first; without those that do not come to their end.

    Models that are far behind the best of those known, and of those first in order, are not sharpened.
    """
    tasks = list(wanted)
    least = min((choice.model.cost for choice in known), default=np.inf)
    models: list[Model] = []
    for part in (tasks[:LEADERS], tasks[LEADERS:]):
        limit = find_limit(base, least)
        found = work.each(stage, unless_ended, [(partial(fit, limit=limit), *how) for how in part])
        models += [model for model in found if model]
        least = min([least, *(model.cost for model in models)])
    work.simulations.add(sum(model.residuals.simulations for model in models))
    return sorted((price_model(model, library) for model in models), key=lambda choice: choice.cost)


def find_limit(base: Model, least: float) -> float:
    """Find the sum of squares above which a model is so far behind the best one that its fit is not sharpened.

    It is above `least`, that of the best model, by `NEGLIGIBLE`, or by `NEGLIGIBLE_SHARE` of what that model takes away
    from the calibrated machine `base`, if this is more.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> calibrated = explain_example().calibrated
    >>> find_limit(calibrated, calibrated.cost - 1000.0) - calibrated.cost
    -900.0
    """
    return least + max(NEGLIGIBLE, NEGLIGIBLE_SHARE * (base.cost - least))


def _name_candidates(pair: Pair) -> list[str]:
    """Names of the candidates of a pair with its guesses."""
    return [candidate.name for candidate in pair[0]]


def _swap_effects(
    pair: PricedModel, alone: Sequence[PricedModel], sensitivities: Sequence[Sensitivity]
) -> Iterator[Pair]:
    """The pair with either effect replaced by what explains as much of what the other leaves."""
    for number, retained in enumerate(pair.model.candidates):
        single = next((choice.model for choice in alone if choice.names == (retained.name,)), None)
        if single is None:
            continue
        ranked = find_scores(project_beside(sensitivities, single), single.fitted.residuals)
        near = [score for score in ranked if score.n_sigma**2 > ranked[0].n_sigma ** 2 - 2.0 * AMBIGUOUS_COST]
        x = tuple(pair.model.own(number))
        for score in near[:MAX_SWAPS]:
            yield (retained, score.sensitivity.probe.candidate), (x, score.guess)


def _find_partners(alone: Sequence[PricedModel], sensitivities: Sequence[Sensitivity], work: Work) -> Iterator[Pair]:
    """For each single the two candidates that score best on what it leaves."""
    by_candidate = list(
        {sensitivity.probe.candidate.name: sensitivity.probe.candidate for sensitivity in sensitivities}.values()
    )
    for rank, choice in enumerate(alone):
        model = choice.model
        first = model.candidates[0]
        if rank == 0:
            # A fault of a file changes the same records in the same way, whatever the machine does.
            others = [each for each in by_candidate if each.name != first.name and not each.file]
            of_faults = [each for each in sensitivities if each.probe.candidate.file]
            others_beside = find_sensitivities(model.residuals, model.fitted, others, work, "fitting pairs")
            others_beside += project_beside(of_faults, model)
        else:
            others_beside = project_beside(sensitivities, model)
        for score in find_scores(others_beside, model.fitted.residuals)[:2]:
            if score.n_sigma > 0.0:
                x = tuple(model.own(0))
                yield (first, score.sensitivity.probe.candidate), (x, score.guess)


def _screen_pairs(ranked: Sequence[Score], errors: np.ndarray) -> Iterator[Pair]:
    """The pairs that explain most of the gap if all is straight."""
    probes = [score.sensitivity.probe for score in ranked]
    for numbers, weights in _select_largest([-score.sensitivity.projected for score in ranked], errors):
        pair = [probes[number] for number in numbers]
        guesses = (probe.scale(weight) for probe, weight in zip(pair, weights, strict=True))
        yield tuple(probe.candidate for probe in pair), tuple(guesses)


def _add_up_singles(alone: Sequence[PricedModel], gap: np.ndarray) -> Iterator[Pair]:
    """The pairs that explain most of the gap if what each takes of it alone adds up.

    Where an effect is large and bends the data, its sensitivity at the calibrated machine foretells little of it.
    """
    models = [choice.model for choice in alone]
    for numbers, _ in _select_largest([gap - model.fitted.data_residuals for model in models], gap):
        pair = [models[number] for number in numbers]
        yield tuple(model.candidates[0] for model in pair), tuple(tuple(model.own(0)) for model in pair)


def _select_largest(taken: Sequence[np.ndarray], gap: np.ndarray) -> list[tuple[tuple[int, ...], np.ndarray]]:
    """The pairs, by number, that take most of a gap together, with their weights; the largest first."""
    ranked = []
    for pair in combinations(range(len(taken)), 2):
        both = np.column_stack([taken[number] for number in pair])
        weights, *_ = np.linalg.lstsq(both, gap, rcond=None)
        ranked.append((float(gap @ (both @ weights)), pair, weights))
    ranked.sort(key=lambda row: -row[0])
    return [(pair, weights) for _, pair, weights in ranked[:MAX_SCREENED_PAIRS]]
