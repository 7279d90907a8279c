"""The noise of measured data, and the machine with its uncertain numbers fitted to them."""

from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from studies.gap.descent import descend
from studies.gap.detect import ALARM
from studies.gap.heldout import is_at, points_of
from studies.gap.noise_source import noise_of
from studies.gap.nuisances import nuisances_of
from studies.gap.problem import Problem
from studies.gap.refit import Model
from studies.measured import FIT, GATE

LEAST = 0.01
"""Share of a parameter's variance that it has to be less sure by, where one operating point alone tells it."""


def uncalibrated(machine, measured):
    """The runs to be fitted with the noise of the data, and the nuisances of the machine.

    Returns
    -------
    studies.gap.problem.Problem
    warnings : list of str
    """
    nuisances = nuisances_of(machine, measured)
    known = Problem(machine, measured.of(FIT) + measured.of(GATE), nuisances)
    noise, warnings = noise_of(known.blocks, known.predicted(np.zeros(len(nuisances))), measured.noise)
    return Problem(machine, measured.of(FIT), nuisances, noise), warnings


def calibrate(machine, measured):
    """The noise of the data, and the machine with its nuisances fitted under their priors.

    Parameters
    ----------
    machine : engine.machine.Machine
    measured : studies.measured.Measured

    Returns
    -------
    Model
    warnings : list of str
    """
    problem, warnings = uncalibrated(machine, measured)
    fitted = descend(problem, np.zeros(len(problem.parameters)))
    problem.start_at(fitted.x)
    if not fitted.converged:
        warnings.append("the calibration did not converge")
    return Model((), problem, fitted), warnings


class Apart(NamedTuple):
    """What one operating point alone says of a parameter, against all together."""

    parameter: object
    """`studies.gap.parameters.Parameter`"""
    run: object
    """The first of the operating point."""
    x: float
    """At which that point alone has it, if all is straight."""
    deviations: float
    """Of what noise makes of the difference."""


def apart(model):
    """Where each operating point alone leads, if all is straight, the farthest for each parameter.

    A subset of the data has its own estimate, whose difference from that of all varies by the difference of their
    covariances (Hausman 1978, doi 10.2307/1913827).

    Parameters
    ----------
    model : studies.gap.refit.Model

    Returns
    -------
    list of Apart
        The farthest first; none of a single operating point.
    """
    problem, (x, errors, jacobian, _) = model.problem, model.fitted
    points = points_of(problem.runs)
    if len(points) < 2:
        return []
    samples = len(errors) - len(x)
    at = np.concatenate([np.full(len(b.values), _place(points, b.run)) for b in problem.blocks])
    all_of_them, told, found = np.diag(model.fitted.covariance), model.told, []
    for number, point in enumerate(points):
        rows = np.append(np.flatnonzero(at == number), np.arange(samples, len(errors)))
        covariance = np.linalg.pinv(jacobian[rows].T @ jacobian[rows])
        shift = -covariance @ (jacobian[rows].T @ errors[rows])
        more = np.diag(covariance) - all_of_them
        for j, parameter in enumerate(problem.parameters):
            if more[j] > LEAST * all_of_them[j] and told[j]:
                found.append(Apart(parameter, point, x[j] + shift[j], shift[j] / np.sqrt(more[j])))
    found.sort(key=lambda one: -abs(one.deviations))
    first: dict = {}
    for one in found:
        first.setdefault(one.parameter.key, one)
    return list(first.values())


def too_far(found, points):
    """Those of `apart` that noise alone would put so far with a chance of less than `ALARM` over all."""
    limit = norm.isf(0.5 * ALARM / max(1, points * len(found)))
    return [one for one in found if abs(one.deviations) > limit]


def _place(points, run):
    return next(number for number, point in enumerate(points) if is_at(run, point))
