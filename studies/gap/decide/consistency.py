"""Whether each operating point alone leads to the same numbers as all runs together."""

from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from apesim.studies.gap.decide.operating_points import is_at, points_of
from apesim.studies.gap.thresholds import ALARM

LEAST = 0.01
"""Share of a parameter's variance that it has to be less sure by, where one operating point alone tells it."""


class Inconsistency(NamedTuple):
    """What one operating point alone says of a parameter, against all together."""

    parameter: object
    """`apesim.studies.estimation.parameters.Parameter`"""
    run: object
    """The first of the operating point."""
    x: float
    """At which that point alone has it, if all is straight."""
    deviations: float
    """Difference in standard deviations of what noise makes of it."""


def compare_points(model):
    """Find where each operating point alone leads, if all is straight, the farthest for each parameter.

    A subset of the data has its own estimate, whose difference from that of all varies by the difference of their
    covariances (Hausman 1978, doi 10.2307/1913827).

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model

    Returns
    -------
    list of Inconsistency
        The farthest first; none of a single operating point.
    """
    problem, (x, errors, jacobian, _) = model.problem, model.fitted
    points = points_of(problem.runs)
    if len(points) < 2:
        return []
    samples = len(errors) - len(x)
    at = np.concatenate([np.full(len(b.values), _place(points, b.run)) for b in problem.blocks])
    all_of_them, told, found = np.diag(model.fitted.covariance), model.identifiable, []
    for number, point in enumerate(points):
        rows = np.append(np.flatnonzero(at == number), np.arange(samples, len(errors)))
        covariance = np.linalg.pinv(jacobian[rows].T @ jacobian[rows])
        shift = -covariance @ (jacobian[rows].T @ errors[rows])
        more = np.diag(covariance) - all_of_them
        for j, parameter in enumerate(problem.parameters):
            if more[j] > LEAST * all_of_them[j] and told[j]:
                found.append(Inconsistency(parameter, point, x[j] + shift[j], shift[j] / np.sqrt(more[j])))
    found.sort(key=lambda one: -abs(one.deviations))
    first: dict = {}
    for one in found:
        first.setdefault(one.parameter.key, one)
    return list(first.values())


def too_far(found, points):
    """Those of `compare_points` that noise alone would put so far with a chance of less than `ALARM` over all."""
    limit = norm.isf(0.5 * ALARM / max(1, points * len(found)))
    return [one for one in found if abs(one.deviations) > limit]


def _place(points, run):
    return next(number for number, point in enumerate(points) if is_at(run, point))
