"""Least squares with few simulations: Levenberg and Marquardt's steps, sensitivities kept up by Broyden's rule.

`scipy.optimize.least_squares` has no such rule and takes a Jacobian anew at each step. Measured on six fits of three
benches, calibrations and fits of one or two effects: 208 evaluations of all runs here, 399 there with the same finite
differences ("trf", tolerances of 1e-5), to sums of squares within 0.005 of each other.
"""

from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.residuals import EndedEarly

MAX_STEPS = 40
CONVERGED = 0.02
"""Fall of the sum of squares that a fresh step would still promise."""
FORESEEN = 0.5, 1.5
"""Fall over that promised, beyond which sensitivities are taken anew."""
CREEPING = 0.25
"""Share of a promise over that of the step before: sensitivities gone stale keep small promises, and hide large
ones."""
UNDAMPED = 1e-5
"""Damping below which a promise is not one that damping shortens."""
DAMPING_FELT = 1e-2
"""Share of a sensitivity's square from which damping shortens a step."""
BENT = 0.3
"""Share of a promise that counts as kept where no damped step keeps its promise, as a contact bends the data."""


class Fitted(NamedTuple):
    """Result of a fit."""

    x: np.ndarray
    """(p,)"""
    errors: np.ndarray
    """(n + p,), see `apesim.studies.estimation.residuals.Problem.errors`."""
    jacobian: np.ndarray
    """(n + p, p), at x or close to it."""
    converged: bool
    """Whether no sensitivity taken at x promises more."""

    @property
    def cost(self):
        """Sum of squares, priors included."""
        return float(self.errors @ self.errors)

    @property
    def left(self):
        """Errors without the pulls of the priors, (n,)."""
        return self.errors[: len(self.errors) - len(self.x)]

    @property
    def covariance(self):
        """Covariance of the parameters, (p, p)."""
        return np.linalg.pinv(self.jacobian.T @ self.jacobian)


def descend(problem, x, jacobian=None):
    """The nearest minimum of the sum of squares within the bounds.

    Parameters
    ----------
    problem : apesim.studies.estimation.residuals.Problem
    x : (p,) float array
        Where to start.
    jacobian : (n + p, p) float array, optional
        From nearby.

    Returns
    -------
    Fitted

    Raises
    ------
    EndedEarly
        The simulation fails at the start.
    """
    x = np.clip(np.asarray(x, dtype=float), problem.low, problem.high)
    errors = problem.errors(x)
    fresh = jacobian is None
    jacobian = problem.jacobian(x, errors) if fresh else jacobian.copy()
    damping, before = 1e-3, np.inf
    for _ in range(MAX_STEPS):
        step, promise = _step(problem, x, errors, jacobian, damping)
        if promise < CONVERGED and fresh:
            return Fitted(x, errors, jacobian, True)
        if not fresh and (promise < CONVERGED or (promise > CREEPING * before and damping < UNDAMPED)):
            jacobian, fresh = problem.jacobian(x, errors), True
            continue
        before = promise
        try:
            tried = problem.errors(x + step)
            fall = errors @ errors - tried @ tried
        except EndedEarly:
            fall = -np.inf
        if fall > 0.1 * promise:
            jacobian = jacobian + np.outer(tried - errors - jacobian @ step, step) / (step @ step)
            x, errors, fresh = x + step, tried, False
            damping = max(damping / 5.0, 1e-9)
            if not FORESEEN[0] < fall / promise < FORESEEN[1]:
                jacobian, fresh = problem.jacobian(x, errors), True
        elif fresh:
            if promise < BENT and damping > 1.0:
                return Fitted(x, errors, jacobian, True)
            if fall > 0.0:
                x, errors, fresh = x + step, tried, False
            damping = max(10.0 * damping, DAMPING_FELT)
        else:
            jacobian, fresh = problem.jacobian(x, errors), True
    return Fitted(x, errors, jacobian, False)


def _step(problem, x, errors, jacobian, damping):
    """The damped step from x that stays in the bounds, and the fall that the straight model promises."""
    gradient = jacobian.T @ errors
    free = ~(((x <= problem.low) & (gradient > 0.0)) | ((x >= problem.high) & (gradient < 0.0)))
    step = np.zeros(len(x))
    normal = jacobian.T @ jacobian
    for _ in range(len(x)):
        if not free.any():
            break
        inner = normal[np.ix_(free, free)]
        step[:] = 0.0
        step[free] = np.linalg.solve(inner + damping * np.diag(np.diag(inner) + 1e-12), -gradient[free])
        beyond = free & ((x + step < problem.low) | (x + step > problem.high))
        if not beyond.any():
            break
        # The first bound on the way: go there, and let the others choose anew from a shorter step.
        ends = np.where(step < 0.0, problem.low, problem.high)
        share = np.min((ends - x)[beyond] / step[beyond])
        if share > 1e-9:
            step *= share
            break
        free &= ~beyond
    step = np.clip(x + step, problem.low, problem.high) - x
    after = errors + jacobian @ step
    return step, float(errors @ errors - after @ after)
