"""Intervals of free parameters by profile likelihood."""

from collections.abc import Callable

import numpy as np

from apesim.studies.estimation.fixed_parameter import fit_held
from apesim.studies.estimation.levenberg_marquardt import Fitted
from apesim.studies.estimation.profile_likelihood import End, Likelihood, find_end, first_better
from apesim.studies.estimation.residuals import WhitenedResiduals

FINE = 1e-3
"""Fall of the sum of squares that a step would still promise at the end of a fit: 0.03 standard deviations, a hundredth
of a 95 % interval."""


def invert_curvature(jacobian: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the curvature ``J'J`` (p, p) at an optimum and its inverse, the covariance of the parameters.

    `jacobian` (n, p) holds the sensitivities of the whitened residuals. A little is added to the diagonal, so that a
    parameter that hardly changes the data leaves it invertible.
    """
    curvature = jacobian.T @ jacobian
    curvature += np.diag(1e-10 * np.diag(curvature) + 1e-12)
    return curvature, np.linalg.inv(curvature)


def find_intervals(
    residuals: WhitenedResiduals, fitted: Fitted, covariance: np.ndarray, is_spent: Callable[[], bool]
) -> tuple[list[list[End]], np.ndarray | None]:
    """Find both ends of every parameter's interval; or a better point (p,), if one is met, else None.

    `fitted` is the optimum, `covariance` (p, p) that of the parameters by the curvature there; `is_spent` tells whether
    there are to be no further simulations.

    One parameter, measured as 1.0 with a standard deviation of 0.5:

    >>> from types import SimpleNamespace
    >>> slope = np.array([[2.0]])
    >>> line = SimpleNamespace(low=np.zeros(1), high=np.full(1, 9.0), at=lambda x: 2.0 * (x - 1.0))
    >>> fitted = Fitted(np.ones(1), np.zeros(1), slope, True, np.full(1, 0.01))
    >>> [[low, high]], better = find_intervals(line, fitted, fitted.covariance, lambda: False)
    >>> round(float(low.at), 2), round(float(high.at), 2), better
    (0.02, 1.98, None)
    """

    def hold(guess: np.ndarray, j: int) -> tuple[np.ndarray, float, bool]:
        return fit_held(residuals, fitted, guess, j, FINE)

    bounds = np.array([residuals.low, residuals.high])
    likelihood = Likelihood(fitted.x, fitted.cost, covariance, bounds, hold, is_spent)
    intervals: list[list[End]] = []
    for j in range(len(fitted.x)):
        intervals.append([find_end(likelihood, j, side) for side in (-1, 1)])
        better = first_better(intervals[-1])
        if better is not None:
            return intervals, better
    return intervals, None
