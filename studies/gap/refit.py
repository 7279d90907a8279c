"""Candidates fitted through the simulator, together with the nuisances."""

from itertools import product
from typing import NamedTuple

import numpy as np

from apesim.studies.gap.candidates import probes_of
from apesim.studies.gap.descent import Fitted, descend
from apesim.studies.gap.parameters import corrections
from apesim.studies.gap.problem import EndedEarly, Problem
from apesim.studies.gap.score import imitated
from apesim.studies.measured.prediction import with_value

STARTS = (0.25, 0.5, 1.0)
"""Of a strength, over its range, beside the size that the score suggests and the probes."""
SHAPE = 0.3
"""Of further parameters over their range, where a strength is tried at large."""
UNTOLD = 1e-6
"""Standard deviations over a parameter's range, below which the data do not depend on it."""
DESCENTS = 2
"""Starts that are followed to their end: those that leave least once the nuisances have moved."""


class Model(NamedTuple):
    """The calibrated machine with candidates added."""

    candidates: tuple
    """None, one or two."""
    problem: Problem
    fitted: Fitted
    released: str = ""
    """Key of a nuisance whose prior was taken away."""
    profiles: dict | None = None
    """Both ends of the intervals of effects that have a shape, `apesim.studies.profile_likelihood.End` in x, by key;
    None: not sought, see `apesim.studies.gap.intervals`."""

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

    @property
    def beyond(self):
        """Keys of what is fitted beyond what a machine file takes."""
        return [
            p.key
            for p, x in zip(self.problem.parameters, self.fitted.x, strict=True)
            if not p.prior and not p.ends[0] <= x <= p.ends[1]
        ]

    def own(self, number):
        """Where the parameters of one of its candidates are, x."""
        first = len(self.fitted.x) - self.added
        first += sum(len(candidate.parameters) for candidate in self.candidates[:number])
        return self.fitted.x[first : first + len(self.candidates[number].parameters)]

    def machine(self):
        """The machine with the effects, within what a machine file allows; its nuisances as they were."""
        machine, runs = self.problem.machine, self.problem.runs
        for p, x, told in zip(self.problem.parameters, self.fitted.x, self.told, strict=True):
            if told and not p.prior:
                for key, value in corrections(self.problem.machine, p, np.clip(x, *p.ends), runs).items():
                    machine = with_value(machine, key, value)
        return machine

    @property
    def told(self):
        """Whether the data depend on each parameter at all, (p,) bool array."""
        return np.linalg.norm(self.fitted.jacobian, axis=0) > UNTOLD


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
    """Where a model with some of the candidates stands, with values for the others."""
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
    space, found = imitated(jacobian), []
    for x in starts:
        try:
            errors = problem.errors(x)
        except EndedEarly:
            continue
        found.append((float(np.linalg.norm(space.removed(errors))), x, errors))
    return sorted(found, key=lambda one: one[0])


def _padded(jacobian, more):
    """Rows for parameters that have no prior."""
    return np.vstack([jacobian, np.zeros((more, jacobian.shape[1]))])
