"""Whether each operating point alone leads to the same numbers as all runs together."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from apesim.studies.estimation.model import Model
from apesim.studies.estimation.parameters import Parameter
from apesim.studies.gap.decide.operating_points import find_points, list_point_rows
from apesim.studies.gap.thresholds import ALARM
from apesim.studies.measured import MeasuredRun

MIN_EXTRA_VARIANCE = 0.01
"""Share by which the variance of a parameter from one operating point alone has to be above that from all: below it,
that point alone determines the parameter, and its difference from all is rounding."""


class Inconsistency(NamedTuple):
    """The estimate of a parameter from one operating point alone, against the estimate from all points together."""

    parameter: Parameter
    run: MeasuredRun
    """First run at the operating point."""
    x: float
    """Scaled value of the parameter to which that point alone leads, in a model that is linear in the parameters."""
    n_sigma: float
    """Difference from the estimate of all points, in standard deviations that noise alone gives it."""


def compare_points(model: Model) -> list[Inconsistency]:
    """Compare the parameters that each operating point alone gives with those of all points together.

    In a model linear in the parameters, the shift of parameter j at an operating point P, over the standard deviation
    that noise alone gives it, is ``d_j = shift_j / sqrt(C_P[j, j] - C[j, j])`` with ``shift = -C_P J_P' e_P`` and ``C_P
    = pinv(J_P' J_P)`` (Hausman 1978, doi 10.2307/1913827). ``J_P`` and ``e_P`` are the sensitivities and the whitened
    residuals of the runs at P with the pulls of all priors, and ``C`` is the covariance from all runs. Parameters that
    the data do not depend on are left out, and so are those of which P alone knows as much as all points together. For
    each parameter the point with the largest ``abs(d_j)`` is returned, the largest first; nothing where there is one
    operating point alone.
    """
    residuals, (x, errors, jacobian, *_) = model.residuals, model.fitted
    points = find_points(residuals.runs)
    if len(points) < 2:
        return []
    priors = np.arange(len(errors) - len(x), len(errors))
    variances, identifiable, shifts = np.diag(model.fitted.covariance), model.identifiable, []
    for own, point in zip(list_point_rows(residuals), points, strict=True):
        rows = np.append(own, priors)
        covariance = np.linalg.pinv(jacobian[rows].T @ jacobian[rows])
        shift = -covariance @ (jacobian[rows].T @ errors[rows])
        extra = np.diag(covariance) - variances
        for j, parameter in enumerate(residuals.parameters):
            if extra[j] > MIN_EXTRA_VARIANCE * variances[j] and identifiable[j]:
                shifts.append(Inconsistency(parameter, point, x[j] + shift[j], shift[j] / np.sqrt(extra[j])))
    shifts.sort(key=lambda each: -abs(each.n_sigma))
    largest: dict[str, Inconsistency] = {}
    for each in shifts:
        largest.setdefault(each.parameter.key, each)
    return list(largest.values())


def select_significant(inconsistencies: Sequence[Inconsistency], points: int) -> list[Inconsistency]:
    """The inconsistencies, as `compare_points` finds them, that are larger than noise alone would make them.

    With `points` operating points there are ``m = points len(inconsistencies)`` looks in both directions: noise alone
    puts one of them beyond the limit ``isf(ALARM / (2 m))`` of a standard normal number with a chance of at most
    `ALARM` (Bonferroni's limit; Dunn 1961, doi 10.1080/01621459.1961.10482090).
    """
    limit = norm.isf(0.5 * ALARM / max(1, points * len(inconsistencies)))
    return [each for each in inconsistencies if abs(each.n_sigma) > limit]
