"""Candidates fitted through the simulator, together with the nuisances."""

from itertools import product

import numpy as np

from apesim.studies.estimation.levenberg_marquardt import Fitted, descend
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.estimation.residuals import EndedEarly
from apesim.studies.gap.search.candidates import probes_of

STARTS = (0.25, 0.5, 1.0)
"""Starts of a strength, over its range, beside the size that the score suggests and the probes."""
SHAPE = 0.3
"""Place of further parameters in their range, where a strength is tried at large."""
DESCENTS = 2
"""Starts that are followed to their end: those that leave least once the nuisances have moved."""


def refit(base, candidates, guesses, within=()):
    """Add candidates to a calibrated model and fit everything anew, from several starts.

    Parameters
    ----------
    base : Model
        Its nuisances, and effects that it has already, start where they are.
    candidates : tuple of Candidate
        To be added.
    guesses : tuple of tuple of float
        For each candidate the x that the score suggests.
    within : sequence of Model
        Fits of the base with some of the candidates; from where they stand the others start, too.

    Returns
    -------
    Model
        The best of all starts; never worse than the base or a model within, which it contains.
    """
    freed = [parameter for candidate in candidates for parameter in candidate.parameters]
    problem = base.problem.with_parameters([*base.problem.parameters, *freed])
    jacobian, best = _padded(base.fitted.jacobian, len(freed)), None
    for _, x, errors in _ranked(problem, jacobian, _starts(base, candidates, guesses, within))[:DESCENTS]:
        try:
            own = problem.jacobian(x, errors, range(len(base.fitted.x), len(x)))
            found = descend(problem, x, np.column_stack([jacobian, own]))
        except EndedEarly:
            continue
        if best is None or found.cost < best.cost:
            best = found
    smaller = min((base, *within), key=lambda model: model.cost)
    if best is None or best.cost > smaller.cost:
        off = _from(base, smaller, candidates, [np.zeros(len(candidate.parameters)) for candidate in candidates])
        errors = problem.errors(off)
        best = Fitted(off, errors, problem.jacobian(off, errors), False)
    return Model((*base.candidates, *candidates), problem, best)


def at_large(base, candidate):
    """A candidate switched on by a quarter, half and all of its range, and nothing fitted.

    Where it bends the data, its sensitivity at the base foretells little of that.

    Parameters
    ----------
    base : Model
    candidate : Candidate

    Returns
    -------
    cost : float
        Of what is left at best if the nuisances move straight; inf: no simulation comes to its end.
    x : tuple of float
        Of the candidate's parameters there.
    simulations : int
    """
    problem = base.problem.with_parameters([*base.problem.parameters, *candidate.parameters])
    jacobian = _padded(base.fitted.jacobian, len(candidate.parameters))
    shapes = [SHAPE] * len(candidate.shapes)
    starts = [
        np.append(base.fitted.x, candidate.switched_on(number, size, shapes))
        for number, strength in enumerate(candidate.strengths)
        for size in (*STARTS, *(-share for share in STARTS))
        if strength.low <= size <= strength.high
    ]
    found = _ranked(problem, jacobian, starts)
    if not found:
        return np.inf, (), problem.simulations
    left, x, _ = found[0]
    return left**2, tuple(x[len(base.fitted.x) :]), problem.simulations


def reduced(base, model, number):
    """One effect of a larger model alone, fitted anew from where it stands there.

    Parameters
    ----------
    base : Model
        The calibrated machine.
    model : Model
        That with effects added.
    number : int
        Of the candidate that stays.

    Returns
    -------
    Model
    """
    kept = model.candidates[number]
    problem = base.problem.with_parameters([*base.problem.parameters, *kept.parameters])
    found = descend(problem, np.append(model.fitted.x[: len(base.fitted.x)], model.own(number)))
    return Model((kept,), problem, found)


def release(base, number):
    """The calibrated model fitted anew without the prior of one nuisance.

    Parameters
    ----------
    base : Model
    number : int
        Of the parameter.

    Returns
    -------
    Model
    """
    parameters = list(base.problem.parameters)
    parameters[number] = parameters[number]._replace(prior=False)
    problem = base.problem.with_parameters(parameters)
    found = descend(problem, base.fitted.x)
    return Model((), problem, found, parameters[number].key)


def _from(base, smaller, candidates, others):
    """State of a model with some of the candidates, with values for the others."""
    known = {candidate.name: smaller.own(number) for number, candidate in enumerate(smaller.candidates)}
    own = [known.get(candidate.name, other) for candidate, other in zip(candidates, others, strict=True)]
    return np.concatenate([smaller.fitted.x[: len(base.fitted.x)], *own])


def _starts(base, candidates, guesses, within):
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


def _ranked(problem, jacobian, starts):
    """What starts leave once the nuisances have moved, with the starts and their errors; the least first."""
    space, found = find_nuisance_space(jacobian), []
    for x in starts:
        try:
            errors = problem.errors(x)
        except EndedEarly:
            continue
        found.append((float(np.linalg.norm(space.project_out(errors))), x, errors))
    return sorted(found, key=lambda one: one[0])


def _padded(jacobian, more):
    """Rows for parameters that have no prior."""
    return np.vstack([jacobian, np.zeros((more, jacobian.shape[1]))])
