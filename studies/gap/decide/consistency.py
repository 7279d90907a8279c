"""Whether each operating point alone leads to the same numbers as all runs together."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from apesim.studies.estimation.model import Model
from apesim.studies.estimation.parameters import Parameter
from apesim.studies.gap.decide.operating_points import is_at, points_of
from apesim.studies.gap.thresholds import ALARM
from apesim.studies.measured import MeasuredRun

LEAST = 0.01
"""Share by which the variance of a parameter from one operating point alone has to be above that from all: below it,
that point alone determines the parameter, and its difference from all is rounding."""


class Inconsistency(NamedTuple):
    """The estimate of a parameter from one operating point alone, against the estimate from all points together."""

    parameter: Parameter
    run: MeasuredRun
    """First run at the operating point."""
    x: float
    """Scaled value of the parameter to which that point alone leads, in a model that is linear in the parameters."""
    deviations: float
    """Difference from the estimate of all points, in standard deviations that noise alone gives it."""


def compare_points(model: Model) -> list[Inconsistency]:
    """Compare the parameters that each operating point alone gives with those of all points together.

    The shift of parameter j at an operating point P, in a model that is linear in the parameters, over the standard
    deviation that noise alone gives it (Hausman [1]_)::

        d_j = shift_j / sqrt(C_P[j, j] - C[j, j]),    shift = -C_P J_P' e_P,    C_P = pinv(J_P' J_P)

    ``J_P`` and ``e_P`` are the sensitivities and the whitened residuals of the runs at P with the pulls of all priors,
    and ``C`` is the covariance from all runs. Parameters that the data do not depend on are left out, and so are those
    of which P alone knows as much as all points together.

    Parameters
    ----------
    model : apesim.studies.estimation.model.Model
        A model at its fit.

    Returns
    -------
    list of Inconsistency
        For each parameter the operating point with the largest ``abs(d_j)``, the largest first; empty where there is
        one operating point alone.

    References
    ----------
    .. [1] J. A. Hausman, "Specification tests in econometrics", Econometrica 46, 1978, pp. 1251-1271,
       doi 10.2307/1913827.
    """
    residuals, (x, errors, jacobian, *_) = model.residuals, model.fitted
    points = points_of(residuals.runs)
    if len(points) < 2:
        return []
    samples = len(errors) - len(x)
    at = np.concatenate([np.full(len(b.values), _place(points, b.run)) for b in residuals.blocks])
    all_of_them, told, found = np.diag(model.fitted.covariance), model.identifiable, []
    for number, point in enumerate(points):
        rows = np.append(np.flatnonzero(at == number), np.arange(samples, len(errors)))
        covariance = np.linalg.pinv(jacobian[rows].T @ jacobian[rows])
        shift = -covariance @ (jacobian[rows].T @ errors[rows])
        more = np.diag(covariance) - all_of_them
        for j, parameter in enumerate(residuals.parameters):
            if more[j] > LEAST * all_of_them[j] and told[j]:
                found.append(Inconsistency(parameter, point, x[j] + shift[j], shift[j] / np.sqrt(more[j])))
    found.sort(key=lambda one: -abs(one.deviations))
    first: dict[str, Inconsistency] = {}
    for one in found:
        first.setdefault(one.parameter.key, one)
    return list(first.values())


def too_far(found: Sequence[Inconsistency], points: int) -> list[Inconsistency]:
    """The inconsistencies that are larger than noise alone would make them.

    The limit is Bonferroni's [1]_, for ``m = points len(found)`` looks in both directions: noise alone puts one of them
    beyond ``isf(ALARM / (2 m))`` of a standard normal number with a chance of at most `ALARM`.

    Parameters
    ----------
    found : sequence of Inconsistency
        See `compare_points`.
    points : int
        Number of operating points.

    Returns
    -------
    list of Inconsistency

    References
    ----------
    .. [1] O. J. Dunn, "Multiple comparisons among means", J. Am. Statist. Assoc. 56, 1961, pp. 52-64,
       doi 10.1080/01621459.1961.10482090.
    """
    limit = norm.isf(0.5 * ALARM / max(1, points * len(found)))
    return [one for one in found if abs(one.deviations) > limit]


def _place(points: Sequence[MeasuredRun], run: MeasuredRun) -> int:
    """Number of the operating point that a run is at."""
    return next(number for number, point in enumerate(points) if is_at(run, point))
