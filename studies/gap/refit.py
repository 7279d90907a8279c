"""Candidates fitted through the simulator, together with the nuisances."""

from itertools import product
from typing import NamedTuple

import numpy as np

from studies.gap.descent import Fitted, descend
from studies.gap.parameters import put
from studies.gap.problem import EndedEarly, Problem

STARTS = (0.25, 1.0)
"""Of a strength, over its range, beside the size that the score suggests."""
NEAR = 4.0
"""A start is fitted to its end only if its cost is within this many times the fall so far of the best start."""


class Model(NamedTuple):
    """The calibrated machine with candidates added."""

    candidates: tuple
    """None, one or two."""
    problem: Problem
    fitted: Fitted
    released: str = ""
    """Key of a nuisance whose prior was taken away."""

    @property
    def names(self):
        """Of the candidates, or of the nuisance released."""
        return (self.released,) if self.released else tuple(candidate.name for candidate in self.candidates)

    @property
    def cost(self):
        """Sum of squares, priors included."""
        return self.fitted.cost

    @property
    def added(self):
        """How many parameters were freed."""
        return sum(len(candidate.parameters) for candidate in self.candidates)

    def machine(self):
        """The machine with the effects, within what a machine file allows; its nuisances as they were."""
        parameters = self.problem.parameters
        x = [
            0.0 if p.prior else np.clip(x, p.low / p.reach, p.high / p.reach)
            for p, x in zip(parameters, self.fitted.x, strict=True)
        ]
        return put(self.problem.machine, parameters, x)


def refit(base, candidates, guesses):
    """Add candidates to a calibrated model and fit everything anew, from several starts.

    Parameters
    ----------
    base : Model
        Its nuisances, and effects that it has already, start where they are.
    candidates : tuple of Candidate
        To be added.
    guesses : tuple of tuple of float
        For each candidate the x that the score suggests.

    Returns
    -------
    Model
        The best of all starts; never worse than the base, which it contains.
    """
    freed = [parameter for candidate in candidates for parameter in candidate.parameters]
    problem = base.problem.with_parameters([*base.problem.parameters, *freed])
    best = None
    for x in _starts(base, candidates, guesses):
        try:
            errors = problem.errors(x)
            if best is not None and errors @ errors > base.cost + NEAR * (base.cost - best.cost):
                continue
            own = problem.jacobian(x, errors, range(len(base.fitted.x), len(x)))
            found = descend(problem, x, np.column_stack([_padded(base.fitted.jacobian, len(freed)), own]))
        except EndedEarly:
            continue
        if best is None or found.cost < best.cost:
            best = found
    if best is None or best.cost > base.cost:
        off = np.append(base.fitted.x, np.zeros(len(freed)))
        errors = problem.errors(off)
        best = Fitted(off, errors, problem.jacobian(off, errors), False)
    base.problem.simulations += problem.simulations
    return Model((*base.candidates, *candidates), problem, best)


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
    base.problem.simulations += problem.simulations
    return Model((), problem, found, parameters[number].key)


def _starts(base, candidates, guesses):
    each = []
    for candidate, guess in zip(candidates, guesses, strict=True):
        own = [guess]
        if len(candidates) == 1:
            for share in STARTS:
                at = [0.0] * len(candidate.strengths)
                main = int(np.argmax(np.abs(guess[: len(candidate.strengths)])))
                at[main] = share if guess[main] >= 0.0 else -share
                own.append((*at, *guess[len(candidate.strengths) :]))
        each.append(own)
    for chosen in product(*each):
        yield np.concatenate([base.fitted.x, *chosen])


def _padded(jacobian, more):
    """Rows for parameters that have no prior."""
    return np.vstack([jacobian, np.zeros((more, jacobian.shape[1]))])


def guess_of(score):
    """The x that a score suggests for its candidate, within its range.

    Returns
    -------
    tuple of float
    """
    candidate, probe = score.column.probe.candidate, score.column.probe
    x = list(probe.x)
    strength = candidate.strengths[probe.strength]
    x[probe.strength] = float(np.clip(x[probe.strength] * score.size, strength.low, strength.high))
    return tuple(x)
