"""Least squares with one parameter held, as a profile likelihood wants them."""

import numpy as np

from apesim.studies.estimation.levenberg_marquardt import CONVERGED, Fitted, descend
from apesim.studies.estimation.residuals import EndedEarly, WhitenedResiduals


class HeldParameter:
    """Residuals with one parameter held at a value x, as a function of the others; `number` is its place among all."""

    def __init__(self, residuals: WhitenedResiduals, number: int, value: float) -> None:
        self.residuals, self.number, self.value = residuals, number, value
        self.others = [j for j in range(len(residuals.low)) if j != number]
        self.low, self.high = residuals.low[self.others], residuals.high[self.others]

    def insert_held(self, x: np.ndarray) -> np.ndarray:
        """Return all parameters, (p,): the free ones, (p - 1,), with the one held among them."""
        return np.insert(x, self.number, self.value)

    def at(self, x: np.ndarray) -> np.ndarray:
        """Whitened residuals and pulls [standard deviations], (n + p,), at the free parameters, (p - 1,).

        See `WhitenedResiduals.at`.
        """
        return self.residuals.at(self.insert_held(x))

    def jacobian(self, x: np.ndarray, residuals: np.ndarray, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Find the sensitivities to the free parameters, (n + p, p - 1), and the steps for the next differences.

        Parameters and the steps of their differences, in units of x, are (p - 1,), the residuals at x (n + p,); see
        `WhitenedResiduals.jacobian`.
        """
        all_steps = np.insert(steps, self.number, np.nan)  # the parameter that is held takes none
        jacobian, all_steps = self.residuals.jacobian(self.insert_held(x), residuals, all_steps, self.others)
        return jacobian, all_steps[self.others]


def fit_held(
    residuals: WhitenedResiduals, fitted: Fitted, start: np.ndarray, j: int, converged: float = CONVERGED
) -> tuple[np.ndarray, float, bool]:
    """Find the least squares from a start with parameter j held.

    `fitted` is the fit without anything held, whose sensitivities and steps are taken to begin with; for `converged`
    see `descend`. Returns all parameters, (p,), their sum of squares (inf where the simulation does not come to its end
    at the start), and whether the minimum is reached.

    Two parameters with a correlated sum of squares; with the second one held at 1, the first is best at -0.5:

    >>> slopes = np.array([[1.0, 0.5], [0.0, 1.0]])
    >>> class Plane:
    ...     low, high = np.full(2, -9.0), np.full(2, 9.0)
    ...     def at(self, x):
    ...         return slopes @ x
    ...     def jacobian(self, x, residuals, steps, only=(0, 1)):
    ...         return slopes[:, list(only)], steps
    >>> best = Fitted(np.zeros(2), np.zeros(2), slopes, True, np.full(2, 0.01))
    >>> x, cost, is_reached = fit_held(Plane(), best, np.array([0.0, 1.0]), 1)
    >>> x.round(3).tolist(), round(cost, 3), is_reached
    ([-0.5, 1.0], 1.0, True)
    """
    held = HeldParameter(residuals, j, start[j])
    if not held.others:
        try:
            values = residuals.at(start)
        except EndedEarly:
            return start, np.inf, False
        return start, float(values @ values), True
    try:
        optimum = descend(
            held, start[held.others], fitted.jacobian[:, held.others], fitted.steps[held.others], converged
        )
    except EndedEarly:
        return start, np.inf, False
    return held.insert_held(optimum.x), optimum.cost, optimum.converged
