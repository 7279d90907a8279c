"""Least squares with one parameter held, as a profile likelihood wants them."""

import numpy as np

from apesim.studies.estimation.levenberg_marquardt import CONVERGED, Fitted, descend
from apesim.studies.estimation.residuals import EndedEarly, WhitenedResiduals


class HeldParameter:
    """Residuals with one parameter held, as a function of the others.

    Parameters
    ----------
    residuals : apesim.studies.estimation.residuals.WhitenedResiduals
    number : int
        Place of the parameter that is held.
    value : float
        Value x at which it is held.
    """

    def __init__(self, residuals: WhitenedResiduals, number: int, value: float) -> None:
        self.residuals, self.number, self.value = residuals, number, value
        self.others = [j for j in range(len(residuals.low)) if j != number]
        self.low, self.high = residuals.low[self.others], residuals.high[self.others]

    def insert_held(self, x: np.ndarray) -> np.ndarray:
        """All parameters: the free ones with the one held among them.

        Parameters
        ----------
        x : (p - 1,) float array

        Returns
        -------
        (p,) float array

        Examples
        --------
        >>> from types import SimpleNamespace
        >>> bounds = SimpleNamespace(low=np.full(3, -1.0), high=np.full(3, 1.0))
        >>> HeldParameter(bounds, 1, 0.5).insert_held(np.array([0.1, 0.9])).tolist()
        [0.1, 0.5, 0.9]
        """
        return np.insert(x, self.number, self.value)

    def at(self, x: np.ndarray) -> np.ndarray:
        """Whitened residuals and pulls, see `apesim.studies.estimation.residuals.WhitenedResiduals.at`.

        Parameters
        ----------
        x : (p - 1,) float array

        Returns
        -------
        (n + p,) float array
            [standard deviations]

        Examples
        --------
        >>> from types import SimpleNamespace
        >>> bounds = {"low": np.full(2, -9.0), "high": np.full(2, 9.0)}
        >>> plane = SimpleNamespace(**bounds, at=lambda x: np.array([x[0] + 10.0 * x[1]]))
        >>> HeldParameter(plane, 1, 0.5).at(np.array([2.0])).tolist()
        [7.0]
        """
        return self.residuals.at(self.insert_held(x))

    def jacobian(self, x: np.ndarray, residuals: np.ndarray, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sensitivities to the free parameters.

        Parameters
        ----------
        x : (p - 1,) float array
        residuals : (n + p,) float array
            Residuals at x.
        steps : (p - 1,) float array
            Step of each difference, in units of x.

        Returns
        -------
        jacobian : (n + p, p - 1) float array
        steps : (p - 1,) float array
            Steps for the next differences, see `apesim.studies.estimation.residuals.WhitenedResiduals.jacobian`.

        Examples
        --------
        >>> from types import SimpleNamespace
        >>> slopes = np.array([[1.0, 10.0]])
        >>> bounds = {"low": np.full(2, -9.0), "high": np.full(2, 9.0)}
        >>> plane = SimpleNamespace(**bounds, jacobian=lambda x, residuals, steps, only: (slopes[:, only], steps))
        >>> jacobian, steps = HeldParameter(plane, 1, 0.5).jacobian(np.array([2.0]), np.array([7.0]), np.array([0.01]))
        >>> jacobian.tolist(), steps.tolist()
        ([[1.0]], [0.01])
        """
        all_steps = np.insert(steps, self.number, np.nan)  # the parameter that is held takes none
        jacobian, all_steps = self.residuals.jacobian(self.insert_held(x), residuals, all_steps, self.others)
        return jacobian, all_steps[self.others]


def fit_held(
    residuals: WhitenedResiduals, fitted: Fitted, start: np.ndarray, j: int, converged: float = CONVERGED
) -> tuple[np.ndarray, float, bool]:
    """Find the least squares from a start with parameter j held.

    Parameters
    ----------
    residuals : apesim.studies.estimation.residuals.WhitenedResiduals
    fitted : apesim.studies.estimation.levenberg_marquardt.Fitted
        Fit without anything held, whose sensitivities and steps are taken to begin with.
    start : (p,) float array
    j : int
        Place of the parameter that stays where it is.
    converged : float
        See `apesim.studies.estimation.levenberg_marquardt.descend`.

    Returns
    -------
    x : (p,) float array
    cost : float
        Sum of squares; inf where the simulation does not come to its end at the start.
    is_reached : bool

    Examples
    --------
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
