"""Candidates fitted through the simulator, together with the nuisances."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.levenberg_marquardt import SAME, Fitted, descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.estimation.residuals import EndedEarly, WhitenedResiduals, first_steps
from apesim.studies.gap.search.candidates import Candidate, list_probes

START_SIZES = (0.25, 0.5, 1.0)
"""Starts of a strength, over its range, beside the size that the score suggests and the probes."""
START_SHAPE = 0.3
"""Place of further parameters in their range, where a strength is tried at large."""
MAX_DESCENTS = 2
"""Starts that are followed to their end: those that leave least once the nuisances have moved."""


class Start(NamedTuple):
    """A point to start a fit from."""

    x: np.ndarray
    """Values of all parameters, (p,)."""
    near: Model
    """Fitted model whose sensitivities hold there, too."""
    errors: np.ndarray = np.zeros(0)
    """Residuals there, (n + p,) [standard deviations]."""
    left: float = np.inf
    """Length of the residuals once the nuisances have moved in a linear model [standard deviations]."""


def refit(
    base: Model,
    candidates: Sequence[Candidate],
    guesses: Iterable[Sequence[float]],
    within: Sequence[Model] = (),
    *,
    limit: float = np.inf,
) -> Model:
    """Add candidates to a calibrated model and fit everything anew, from several starts; the best of all fits.

    The starts, from `guesses` (for each candidate the values x that its score suggests) and from `within` (fits of the
    base with some of the candidates, the others as guessed), are ranked by what they leave once the nuisances have
    moved in a linear model; the best `MAX_DESCENTS` are followed to their minimum, up to the sum of squares `limit`,
    see `descend`. The cost is never above that of the base or of a model within: where no start leads below them, it is
    the best of these with the other candidates off, marked as not converged.
    """
    freed = [parameter for candidate in candidates for parameter in candidate.parameters]
    residuals = base.residuals.with_parameters([*base.residuals.parameters, *freed])
    jacobian, best = _pad(base.fitted.jacobian, len(freed)), None
    old, steps = len(base.fitted.x), np.append(base.fitted.steps, first_steps(len(freed)))
    starts = _list_starts(base, candidates, guesses, within)
    for start in _rank_starts(residuals, jacobian, starts)[:MAX_DESCENTS]:
        # The nuisances' sensitivities are those of the first descent's end, as soon as there is one.
        near, missing = _place_columns(base, candidates, start)
        if best is not None:
            near[:, :old] = best.jacobian[:, :old]
        try:
            near[:, missing], adapted = residuals.jacobian(start.x, start.errors, steps, missing)
            fitted = descend(residuals, start.x, near, adapted, errors=start.errors, known=best, limit=limit)
        except EndedEarly:
            continue
        if best is None or fitted.cost < best.cost - SAME:
            best = fitted
    smaller = min((base, *within), key=lambda model: model.fitted.cost)
    if best is None or best.cost > smaller.fitted.cost:
        off = _start_from(base, smaller, candidates, [np.zeros(len(candidate.parameters)) for candidate in candidates])
        errors = residuals.at(off)
        columns, steps = residuals.jacobian(off, errors, steps, range(old, len(off)))
        near = _pad(smaller.fitted.jacobian, len(off) - len(smaller.fitted.x))[:, :old]
        best = Fitted(off, errors, np.column_stack([near, columns]), False, steps)
    return Model((*base.candidates, *candidates), residuals, best)


def probe_large_sizes(base: Model, candidate: Candidate) -> tuple[float, tuple[float, ...], int]:
    """Switch a candidate on by a quarter, half and all of its scale, and find which size leaves least of the gap.

    Gives the least sum of squares [standard deviations squared], the values x there, and the number of simulations; inf
    and () where none comes to its end. Nothing is fitted but the nuisances, in a linear model, so an effect is seen to
    which the data do not respond in proportion, where its sensitivity at the base says little.
    """
    residuals = base.residuals.with_parameters([*base.residuals.parameters, *candidate.parameters])
    jacobian = _pad(base.fitted.jacobian, len(candidate.parameters))
    shapes = [START_SHAPE] * len(candidate.shapes)
    starts = [
        Start(np.append(base.fitted.x, candidate.switch_on(number, size, shapes)), base)
        for number, strength in enumerate(candidate.strengths)
        for size in (*START_SIZES, *(-share for share in START_SIZES))
        if strength.low <= size <= strength.high
    ]
    ranked = _rank_starts(residuals, jacobian, starts)
    if not ranked:
        return np.inf, (), residuals.simulations
    best = ranked[0]
    return best.left**2, tuple(best.x[len(base.fitted.x) :]), residuals.simulations


def refit_one(base: Model, model: Model, number: int, *, limit: float = np.inf) -> Model:
    """Keep one effect of a larger model, and fit it anew from where it stands there.

    `number` is the place of the candidate that stays among those of the model; above the sum of squares `limit` a fit
    is of no interest, see `descend`. Raises EndedEarly where the simulation does not come to its end at the start.
    """
    retained = model.candidates[number]
    residuals = base.residuals.with_parameters([*base.residuals.parameters, *retained.parameters])
    kept = [*range(len(base.fitted.x)), *model.places(number)]
    rows = [*range(len(model.fitted.data_residuals)), *(len(model.fitted.data_residuals) + place for place in kept)]
    jacobian, steps = model.fitted.jacobian[np.ix_(rows, kept)], model.fitted.steps[kept]
    return Model((retained,), residuals, descend(residuals, model.fitted.x[kept], jacobian, steps, limit=limit))


def _start_from(
    base: Model, smaller: Model, candidates: Sequence[Candidate], others: Iterable[Sequence[float] | np.ndarray]
) -> np.ndarray:
    """State of a model with some of the candidates, with values for the others."""
    known = {candidate.name: smaller.own(number) for number, candidate in enumerate(smaller.candidates)}
    values = [known.get(candidate.name, other) for candidate, other in zip(candidates, others, strict=True)]
    return np.concatenate([smaller.fitted.x[: len(base.fitted.x)], *values])


def _list_starts(
    base: Model, candidates: Sequence[Candidate], guesses: Iterable[Sequence[float]], within: Sequence[Model]
) -> Iterator[Start]:
    """Points to start from: those that the scores suggest; of one candidate alone all its probes, too."""
    each = []
    for candidate, guess in zip(candidates, guesses, strict=True):
        points = [guess]
        if len(candidates) == 1:
            main = int(np.argmax(np.abs(guess[: len(candidate.strengths)])))
            sign = 1.0 if guess[main] >= 0.0 else -1.0
            shapes = guess[len(candidate.strengths) :]
            points += [candidate.switch_on(main, sign * share, shapes) for share in START_SIZES]
            points += [probe.x for probe in list_probes(candidate)]
        each.append(points)
    for chosen in product(*each):
        yield Start(np.concatenate([base.fitted.x, *chosen]), base)
    for smaller in within:
        yield Start(_start_from(base, smaller, candidates, guesses), smaller)


def _rank_starts(residuals: WhitenedResiduals, jacobian: np.ndarray, starts: Iterable[Start]) -> list[Start]:
    """Starts whose simulations come to their end, with what they leave; the least first."""
    space, ranked = find_nuisance_space(jacobian), []
    for start in starts:
        try:
            errors = residuals.at(start.x)
        except EndedEarly:
            continue
        left = float(np.linalg.norm(space.project_out(errors)))
        ranked.append(start._replace(errors=errors, left=left))
    return sorted(ranked, key=lambda start: start.left)


def _place_columns(base: Model, candidates: Sequence[Candidate], start: Start) -> tuple[np.ndarray, list[int]]:
    """Sensitivities at a start, (n + p, p), as far as the model near it has them, and the places of the others."""
    near, old = start.near, len(base.fitted.x)
    known = {candidate.name: near.places(number) for number, candidate in enumerate(near.candidates)}
    rows = len(base.fitted.residuals)  # pulls of effects, behind these, are zero
    columns, missing = np.zeros((len(start.errors), len(start.x))), []
    columns[:rows, :old] = near.fitted.jacobian[:rows, :old]
    first = old
    for candidate in candidates:
        places = list(range(first, first + len(candidate.parameters)))
        first += len(places)
        if candidate.name in known:
            columns[:rows, places] = near.fitted.jacobian[:rows, known[candidate.name]]
        else:
            missing += places
    return columns, missing


def _pad(jacobian: np.ndarray, more: int) -> np.ndarray:
    """Sensitivities with rows of zeros below, for so many further parameters that have no prior."""
    return np.vstack([jacobian, np.zeros((more, jacobian.shape[1]))])
