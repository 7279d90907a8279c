"""Candidates fitted through the simulator, together with the nuisances."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import product

import numpy as np

from apesim.studies.estimation.levenberg_marquardt import Fitted, descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.estimation.residuals import EndedEarly, WhitenedResiduals, first_steps
from apesim.studies.gap.search.candidates import Candidate, probes_of

STARTS = (0.25, 0.5, 1.0)
"""Starts of a strength, over its range, beside the size that the score suggests and the probes."""
SHAPE = 0.3
"""Place of further parameters in their range, where a strength is tried at large."""
DESCENTS = 2
"""Starts that are followed to their end: those that leave least once the nuisances have moved."""


def refit(
    base: Model,
    candidates: Sequence[Candidate],
    guesses: Iterable[Sequence[float]],
    within: Sequence[Model] = (),
) -> Model:
    """Add candidates to a calibrated model and fit everything anew, from several starts.

    The starts are ranked by what they leave once the nuisances have moved in a linear model; the best `DESCENTS` of
    them are followed to their minimum.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        Model whose nuisances, and effects that it has already, start where they are.
    candidates : sequence of apesim.studies.gap.search.candidates.Candidate
        Effects to be added.
    guesses : iterable of sequence of float
        For each candidate the values x that its score suggests.
    within : sequence of apesim.studies.estimation.model.Model
        Fits of the base with some of the candidates: further starts, with the other candidates as guessed.

    Returns
    -------
    apesim.studies.estimation.model.Model
        The best of all fits. Its cost is never above that of the base or of a model within, which it contains: where no
        start leads below them, it is the best of these with the other candidates off, marked as not converged.
    """
    freed = [parameter for candidate in candidates for parameter in candidate.parameters]
    residuals = base.residuals.with_parameters([*base.residuals.parameters, *freed])
    jacobian, best = _padded(base.fitted.jacobian, len(freed)), None
    steps = np.append(base.fitted.steps, first_steps(len(freed)))
    for _, x, errors in _ranked(residuals, jacobian, _starts(base, candidates, guesses, within))[:DESCENTS]:
        try:
            own, adapted = residuals.jacobian(x, errors, steps, range(len(base.fitted.x), len(x)))
            found = descend(residuals, x, np.column_stack([jacobian, own]), adapted)
        except EndedEarly:
            continue
        if best is None or found.cost < best.cost:
            best = found
    smaller = min((base, *within), key=lambda model: model.cost)
    if best is None or best.cost > smaller.cost:
        off = _from(base, smaller, candidates, [np.zeros(len(candidate.parameters)) for candidate in candidates])
        errors = residuals.at(off)
        jacobian, steps = residuals.jacobian(off, errors, steps)
        best = Fitted(off, errors, jacobian, False, steps)
    return Model((*base.candidates, *candidates), residuals, best)


def at_large(base: Model, candidate: Candidate) -> tuple[float, tuple[float, ...], int]:
    """Switch a candidate on by a quarter, half and all of its range, and find which size leaves least of the gap.

    Nothing is fitted but the nuisances, in a linear model. An effect to which the data do not respond in proportion is
    seen so, where its sensitivity at the base says little.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
    candidate : apesim.studies.gap.search.candidates.Candidate

    Returns
    -------
    cost : float
        Least sum of squares that is left [standard deviations squared]; inf: no simulation comes to its end.
    x : tuple of float
        Values of the candidate's parameters there; () where no simulation comes to its end.
    simulations : int
        Number of simulations that it took.
    """
    residuals = base.residuals.with_parameters([*base.residuals.parameters, *candidate.parameters])
    jacobian = _padded(base.fitted.jacobian, len(candidate.parameters))
    shapes = [SHAPE] * len(candidate.shapes)
    starts = [
        np.append(base.fitted.x, candidate.switched_on(number, size, shapes))
        for number, strength in enumerate(candidate.strengths)
        for size in (*STARTS, *(-share for share in STARTS))
        if strength.low <= size <= strength.high
    ]
    found = _ranked(residuals, jacobian, starts)
    if not found:
        return np.inf, (), residuals.simulations
    left, x, _ = found[0]
    return left**2, tuple(x[len(base.fitted.x) :]), residuals.simulations


def reduced(base: Model, model: Model, number: int) -> Model:
    """Keep one effect of a larger model, and fit it anew from where it stands there.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    model : apesim.studies.estimation.model.Model
        The calibrated machine with effects added.
    number : int
        Place of the candidate that stays among those of the model.

    Returns
    -------
    apesim.studies.estimation.model.Model

    Raises
    ------
    apesim.studies.estimation.residuals.EndedEarly
        The simulation does not come to its end at the start.
    """
    kept = model.candidates[number]
    residuals = base.residuals.with_parameters([*base.residuals.parameters, *kept.parameters])
    x = np.append(model.fitted.x[: len(base.fitted.x)], model.own(number))
    found = descend(residuals, x, steps=np.append(base.fitted.steps, first_steps(len(kept.parameters))))
    return Model((kept,), residuals, found)


def release(base: Model, number: int) -> Model:
    """Fit the calibrated machine anew without the prior of one nuisance.

    Parameters
    ----------
    base : apesim.studies.estimation.model.Model
        The calibrated machine.
    number : int
        Place of the nuisance among the parameters.

    Returns
    -------
    apesim.studies.estimation.model.Model
        A model without candidates, ``released`` being the key of the nuisance.

    Raises
    ------
    apesim.studies.estimation.residuals.EndedEarly
        The simulation does not come to its end at the start.
    """
    parameters = list(base.residuals.parameters)
    parameters[number] = parameters[number]._replace(prior=False)
    residuals = base.residuals.with_parameters(parameters)
    found = descend(residuals, base.fitted.x, steps=base.fitted.steps)
    return Model((), residuals, found, parameters[number].key)


def _from(
    base: Model, smaller: Model, candidates: Sequence[Candidate], others: Iterable[Sequence[float] | np.ndarray]
) -> np.ndarray:
    """State of a model with some of the candidates, with values for the others."""
    known = {candidate.name: smaller.own(number) for number, candidate in enumerate(smaller.candidates)}
    own = [known.get(candidate.name, other) for candidate, other in zip(candidates, others, strict=True)]
    return np.concatenate([smaller.fitted.x[: len(base.fitted.x)], *own])


def _starts(
    base: Model, candidates: Sequence[Candidate], guesses: Iterable[Sequence[float]], within: Sequence[Model]
) -> Iterator[np.ndarray]:
    """Points to start from: those that the scores suggest; of one candidate alone all its probes, too."""
    each = []
    for candidate, guess in zip(candidates, guesses, strict=True):
        own = [guess]
        if len(candidates) == 1:
            main = int(np.argmax(np.abs(guess[: len(candidate.strengths)])))
            sign = 1.0 if guess[main] >= 0.0 else -1.0
            shapes = guess[len(candidate.strengths) :]
            own += [candidate.switched_on(main, sign * share, shapes) for share in STARTS]
            own += [probe.x for probe in probes_of(candidate)]
        each.append(own)
    for chosen in product(*each):
        yield np.concatenate([base.fitted.x, *chosen])
    for smaller in within:
        yield _from(base, smaller, candidates, guesses)


def _ranked(
    residuals: WhitenedResiduals, jacobian: np.ndarray, starts: Iterable[np.ndarray]
) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """What starts leave once the nuisances have moved, with the starts and their errors; the least first."""
    space, found = find_nuisance_space(jacobian), []
    for x in starts:
        try:
            errors = residuals.at(x)
        except EndedEarly:
            continue
        found.append((float(np.linalg.norm(space.project_out(errors))), x, errors))
    return sorted(found, key=lambda one: one[0])


def _padded(jacobian: np.ndarray, more: int) -> np.ndarray:
    """Sensitivities with rows of zeros below, for so many further parameters that have no prior."""
    return np.vstack([jacobian, np.zeros((more, jacobian.shape[1]))])
