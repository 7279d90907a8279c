"""The models that may explain the gap, fitted and ranked by penalised cost."""

from collections.abc import Callable, Container, Iterable, Sequence
from functools import partial
from itertools import takewhile
from math import log
from typing import Any, NamedTuple

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.estimation.residuals import unless_ended
from apesim.studies.gap.search.candidates import Candidate
from apesim.studies.gap.search.linear_sets import (
    LARGEST_SET,
    LinearModel,
    LinearSet,
    linearise_base,
    linearise_best,
    rank_sets,
)
from apesim.studies.gap.search.refit import probe_large_sizes, refit, refit_one
from apesim.studies.gap.search.score_test import Score, Sensitivity, find_sensitivities, project_for_model
from apesim.studies.gap.stage_work import Work
from apesim.studies.gap.thresholds import AMBIGUOUS_COST, TERM_CHANCE

MAX_SINGLES = 12
"""Candidates that are fitted alone for their score."""
MAX_FAULTS = 6
"""Faults of single files that are fitted alone for their score."""
MAX_LARGE = 4
"""Candidates that are fitted alone for what they leave when switched on by much."""
MIN_SETS, MAX_SETS = 3, 8
"""Sets of candidates that are fitted in a round: the best by a linear model, and those foreseen to come near them."""
NEAR = 2.0 * AMBIGUOUS_COST
"""Penalised cost above that of the best set, by a linear model, from which a set is no rival: linear models err."""
MAX_ROUNDS = 3
"""Rounds of linear models, each at the best model so far; two mostly agree."""
LEADERS = 4
"""Models of a kind that are fitted first: how near the best of them comes says which others are worth sharpening."""
NEGLIGIBLE = 60.0
"""Sum of squares above the best model's from which a model counts for nothing: odds of 1e13 to 1."""
NEGLIGIBLE_SHARE = 0.1
"""Share of what the best model takes off the calibrated machine's sum of squares that a model has to be behind, too."""
MIN_FORESEEN = 0.3
"""Share of what the best model takes off the calibrated machine's sum of squares that a linear model has to foresee of
another, so that it is fitted. Of a hundred fits that came near the best, the least was foreseen to take half."""
REACH = 2.0 * log(1e6)
"""Penalised cost above that of the best model from which a set that was not fitted counts for nothing: a millionth of
the best model's weight."""
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


class Foreseen(NamedTuple):
    """A set of candidates that was not fitted, and what a linear model foresees of it."""

    candidates: tuple[Candidate, ...]
    excess: float
    """Penalised cost above that of the best model that was fitted. It is 0 where the linear model foresees less: such
    sets are fitted first, so that one that was not is at most as good."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the candidates."""
        return tuple(candidate.name for candidate in self.candidates)


def find_term_penalty(library: int) -> float:
    """The penalty of one effect of the library of n, ``2 ln(n / p)``, in units of the sum of squares.

    It is the price of one term among n, with the chance p = `TERM_CHANCE` of a term that is not there (PASTIS; Gerardos
    and Ronceray 2025, arXiv:2501.10339).

    >>> round(find_term_penalty(35), 2)
    16.32
    """
    return 2.0 * log(max(library, 1) / TERM_CHANCE)


def find_penalty(model: Model | LinearSet, library: int) -> float:
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

    They are the `MAX_SINGLES` best by score (`ranked`, the largest first), but for those that are foreseen to stay far
    behind the first; `library` is the number of candidates.
    """
    wanted = [score for score in ranked[:MAX_SINGLES] if score.n_sigma > 0.0]
    return _fit_scored(base, wanted, (), library, work, "fitting effects")


def fit_large(
    base: Model, ranked: Sequence[Score], fits: Iterable[PricedModel], library: int, work: Work
) -> list[PricedModel]:
    """Fit the `MAX_LARGE` candidates that leave least when switched on by much, of those that were not fitted yet.

    An effect to which the data do not respond in proportion has a small score. `fits` are the models that were fitted;
    the best fit comes first.
    """
    names = {choice.names for choice in fits}
    others = [score.sensitivity.probe.candidate for score in ranked if (score.name,) not in names]
    large = work.each("scoring", probe_large_sizes, [(base, candidate) for candidate in others])
    work.simulations.add(sum(simulations for *_, simulations in large))
    near = sorted(zip(large, others, strict=True), key=lambda pair: pair[0][0])
    tasks = [(base, (candidate,), (x,)) for (cost, x, _), candidate in near[:MAX_LARGE] if cost < base.fitted.cost]
    return _fit_all(base, refit, tasks, fits, library, work, "fitting effects")


def fit_faults(
    base: Model, ranked: Sequence[Score], fits: Iterable[PricedModel], library: int, work: Work
) -> list[PricedModel]:
    """Fit the most promising faults of single files, each alone, beside the models `fits` that were fitted; best first.

    `base` is the calibrated machine, `ranked` the scores of the faults, the largest first, `library` the number of
    candidates.
    """
    wanted = [score for score in ranked[:MAX_FAULTS] if score.n_sigma > 0.0]
    return _fit_scored(base, wanted, fits, library, work, "fitting files")


def fit_sets(
    base: Model, sensitivities: Sequence[Sensitivity], alone: Sequence[PricedModel], library: int, work: Work
) -> tuple[list[PricedModel], list[Foreseen]]:
    """Fit the most promising singles, pairs and sets of three, by linear models of all of them; the best fit first.

    The second value is what the last linear model foresees of the sets that were not fitted.

    The first linear model is that at the calibrated machine `base`, with the `sensitivities` there. Each further one is
    taken at the best model so far, until that is the same once more: about it the others are foreseen best. `alone` are
    the single candidates that were fitted, `library` is the number of candidates.
    """
    fits = list(alone)
    singles = [choice.model for choice in alone if len(choice.model.candidates) == 1]
    _, tried = _fit_ranked(base, linearise_base(base, sensitivities, singles), fits, library, work)
    about: PricedModel | None = None
    ranked: list[LinearSet] = []
    linearised: set[frozenset[str]] = set()
    for _ in range(MAX_ROUNDS):
        best = min((choice for choice in fits if choice.model.candidates), key=lambda choice: choice.cost, default=None)
        if best is None or frozenset(best.names) in linearised:
            break
        linearised.add(frozenset(best.names))
        others = _find_sensitivities_beside(best.model, sensitivities, work)
        ranked, now_tried = _fit_ranked(base, linearise_best(best.model, others), fits, library, work)
        about, tried = best, tried | now_tried
    foreseen = foresee_others(ranked, tried, about, fits, library) if about else []
    return sorted(fits[len(alone) :], key=lambda choice: choice.cost), foreseen


def foresee_others(
    ranked: Sequence[LinearSet],
    tried: Container[frozenset[str]],
    about: PricedModel,
    fits: Sequence[PricedModel],
    library: int,
) -> list[Foreseen]:
    """Foresee what the sets that were not tried would cost, by a linear model about a fit; those within `REACH` alone.

    `ranked` are all sets by that linear model, the one that leaves least first, and `about` is the fit: the others cost
    more than it by as much as the linear model says. Of an effect that bends the data it may promise much that no fit
    keeps: a set falls as short of its promise as the worst of its candidates, each by what its best fit fell short.
    `fits` are all models that were fitted, `library` is the number of candidates.
    """
    least = min(choice.cost for choice in fits)
    own = next((each.cost for each in ranked if each.names == frozenset(about.names)), about.model.fitted.cost)
    start, term = about.model.cost - least - own, find_term_penalty(library)

    def foresee(each: LinearSet) -> float:
        return start + each.cost + find_penalty(each, library)

    # Of each candidate the fit that keeps most of what was foreseen of it tells how far the others may be off: one that
    # is a change of one candidate from where the linear model stands, as farther ones tell of something else.
    costs = {frozenset(choice.names): choice.cost - least for choice in fits}
    short: dict[str, float] = {}
    for each in ranked:
        if each.names in costs and len(each.names ^ set(about.names)) <= 2:
            error = costs[each.names] - foresee(each)
            short |= {name: min(error, short.get(name, error)) for name in each.names}
    # What a set promises beyond the best fit is not believed either, nor in the larger sets that contain it.
    others: list[Foreseen] = []
    beyond: dict[frozenset[str], float] = {}
    for each in takewhile(lambda each: start + each.price(term) < REACH, ranked):
        names = each.names
        if names in tried:
            continue
        off = max((promise for smaller, promise in beyond.items() if smaller < names), default=0.0)
        excess = foresee(each) + max(off, *(short.get(name, 0.0) for name in names))
        if excess < 0.0:
            beyond[names] = off - excess
        others.append(Foreseen(each.candidates, max(0.0, excess)))
    return [each for each in others if each.excess < REACH]


def _fit_ranked(
    base: Model, linear: LinearModel, fits: list[PricedModel], library: int, work: Work
) -> tuple[list[LinearSet], set[frozenset[str]]]:
    """Fit the sets that leave least by a linear model and were not fitted yet, see `MIN_SETS`; add them to the fits.

    All sets come back as the linear model ranks them, and the names of those that were fitted, or that did not come to
    their end.
    """
    penalty = find_term_penalty(library)
    ranked, tried = rank_sets(linear, penalty), {frozenset(choice.names) for choice in fits}
    untried = [each for each in ranked[: len(tried) + MAX_SETS] if each.names not in tried]
    limit = ranked[0].price(penalty) + NEAR if ranked else 0.0
    wanted = untried[:MIN_SETS] + [each for each in untried[MIN_SETS:MAX_SETS] if each.price(penalty) < limit]
    # The smaller sets first, as a larger one starts from those that it contains, and is never worse.
    for size in range(1, LARGEST_SET + 1):
        tasks = [
            (base, each.candidates, each.guesses, [c.model for c in fits if frozenset(c.names) < each.names])
            for each in wanted
            if len(each.candidates) == size
        ]
        fits += _fit_all(base, refit, tasks, fits, library, work, "fitting sets")
    return ranked, tried | {each.names for each in wanted}


def _find_sensitivities_beside(model: Model, sensitivities: Sequence[Sensitivity], work: Work) -> list[Sensitivity]:
    """What the candidates that a model does not have would do to the data there; `sensitivities` are elsewhere.

    A fault of a file changes the same records in the same way, whatever the machine does.
    """
    others = [each for each in sensitivities if each.probe.candidate.name not in model.names]
    of_rig = {each.probe.candidate.name: each.probe.candidate for each in others if not each.probe.candidate.file}
    of_files = [each for each in others if each.probe.candidate.file]
    return find_sensitivities(model.residuals, model.fitted, list(of_rig.values()), work, "scoring") + of_files


def refit_each_alone(base: Model, best: PricedModel, library: int, work: Work) -> list[PricedModel]:
    """Fit each effect of a set alone, from where the set stands: its own fit may have ended in another minimum.

    The best comes first; `library` is the number of candidates.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> pair = next(choice for choice in explanation.fits if len(choice.names) == 2)
    >>> [choice.names for choice in refit_each_alone(explanation.calibrated, pair, 3, Work())]
    [('side_force',), ('coulomb_friction',)]
    """
    wanted = [(base, best.model, number) for number in range(len(best.model.candidates))]
    return _fit_all(base, refit_one, wanted, (), library, work, "fitting sets")


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


def _fit_scored(
    base: Model, scores: Sequence[Score], fits: Iterable[PricedModel], library: int, work: Work, stage: str
) -> list[PricedModel]:
    """Fit candidates alone: that with the largest score, then those that are foreseen to come near it; best first."""
    known = list(fits)
    found = _fit_all(base, refit, _guess_singles(base, scores[:1]), known, library, work, stage)
    least = min((choice.model.cost for choice in (*known, *found)), default=np.inf)
    others = [score for score in scores[1:] if score.n_sigma**2 > MIN_FORESEEN * (base.cost - least)]
    found += _fit_all(base, refit, _guess_singles(base, others), [*known, *found], library, work, stage)
    return sorted(found, key=lambda choice: choice.cost)


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
