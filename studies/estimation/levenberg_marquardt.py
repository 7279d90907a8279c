"""Least squares with few simulations: Levenberg and Marquardt's steps, sensitivities kept up by Broyden's rule.

`scipy.optimize.least_squares` has no such rule and takes a Jacobian anew at each step. Measured on six fits of three
benches, calibrations and fits of one or two effects: 208 evaluations of all runs here, 399 there with the same finite
differences ("trf", tolerances of 1e-5), to sums of squares within 0.005 of each other.
"""

from contextlib import suppress
from typing import NamedTuple, Protocol

import numpy as np

from apesim.studies.estimation.residuals import EndedEarly, first_steps

MAX_STEPS = 40
CONVERGED = 0.02
"""Fall of the sum of squares that a step would still promise at a minimum, by sensitivities taken within `FRESH`."""
SAME = 0.1
"""Difference of two sums of squares that are those of one minimum: five times what a descent may leave."""
FORESEEN = 0.5, 1.5
"""Fall over that promised, beyond which sensitivities are taken anew."""
CREEPING = 0.25
"""Share of a promise over that of the step before: sensitivities gone stale keep small promises, and hide large
ones."""
MIN_PROMISE = 0.05
"""Share of the way down to the limit that a step has to promise in a descent from nearby. In a hundred fits of a valve,
all that came below the limit were there after their first step; of the others five had a second step that promised
more."""
ROUGH = 20.0
"""Sum of squares above its minimum where a descent may come to rest by sensitivities gone stale; the most that was seen
in 100 fits of a bench is 3.4."""
UNDAMPED = 1e-5
"""Damping below which a promise is not one that damping shortens."""
DAMPING_FELT = 1e-2
"""Share of a sensitivity's square from which damping shortens a step."""
BENT = 0.3
"""Share of a promise that counts as kept where no damped step keeps its promise, as a contact bends the data."""
FRESH = 0.5
"""Standard deviations of the data by which a point may have moved from where its sensitivities were taken, so that they
prove a minimum: a finite difference goes half as far again, see `apesim.studies.estimation.residuals.CHANGE`."""
FORETOLD = 0.3
"""Share of a change of the residuals that the sensitivities at a minimum may miss where a point lies in its basin."""


class Fitted(NamedTuple):
    """A minimum of a sum of squares, with the residuals and their sensitivities there."""

    x: np.ndarray
    """Scaled parameters, (p,)."""
    residuals: np.ndarray
    """Whitened residuals, and behind them the pulls of the priors, (n + p,) [standard deviations]."""
    jacobian: np.ndarray
    """Sensitivities of the residuals at x or close to it, (n + p, p)."""
    converged: bool
    """Whether no step promises more, by sensitivities taken at x or where the data differ by less than `FRESH`."""
    steps: np.ndarray
    """Steps of finite differences with which the next sensitivities near x are to be taken, (p,)."""

    @property
    def cost(self) -> float:
        """Sum of squares, priors included."""
        return float(self.residuals @ self.residuals)

    @property
    def data_residuals(self) -> np.ndarray:
        """Whitened residuals without the pulls of the priors, (n,) [standard deviations]."""
        return self.residuals[: len(self.residuals) - len(self.x)]

    @property
    def covariance(self) -> np.ndarray:
        """Covariance of the scaled parameters by the curvature, ``pinv(J'J)``, (p, p)."""
        return np.linalg.pinv(self.jacobian.T @ self.jacobian)

    def leads_here(self, x: np.ndarray, residuals: np.ndarray) -> bool:
        """Whether a descent from x (p,), where the `residuals` are (n + p,), leads to this minimum.

        It does where the sensitivities here foretell the residuals there, but for the share `FORETOLD` of the change.
        """
        change = self.jacobian @ (x - self.x)
        missed = residuals - self.residuals - change
        return bool(missed @ missed < FORETOLD**2 * (change @ change) and residuals @ residuals >= self.cost)


class LeastSquares(Protocol):
    """Residuals as a function of bounded parameters: all that `descend` needs to know of them."""

    low: np.ndarray
    """Least parameters, (p,)."""
    high: np.ndarray
    """Largest parameters, (p,)."""

    def at(self, x: np.ndarray) -> np.ndarray:
        """Find the residuals [standard deviations], (n,), at x, (p,).

        Raises EndedEarly where a simulation does not come to its end.
        """

    def jacobian(self, x: np.ndarray, residuals: np.ndarray, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Find the sensitivities, (n, p), of the residuals at x, and the steps for the next differences.

        Given are x, (p,), the residuals there, (n,), and the step of each finite difference, in units of x. Raises
        EndedEarly where a simulation does not come to its end.
        """


def descend(
    residuals: LeastSquares,
    x: np.ndarray,
    jacobian: np.ndarray | None = None,
    steps: np.ndarray | None = None,
    converged: float = CONVERGED,
    *,
    errors: np.ndarray | None = None,
    is_exact: bool = False,
    known: Fitted | None = None,
    limit: float = np.inf,
    least_promise: float = MIN_PROMISE,
    is_scout: bool = False,
) -> Fitted:
    """Descend to the nearest minimum of the sum of squares within the bounds.

    Each step solves ``(J'J + damping diag(J'J)) step = -J'e`` (Levenberg 1944, doi 10.1090/qam/10666; Marquardt 1963,
    doi 10.1137/0111030) for the parameters that no bound holds; J is kept up by Broyden's rule ``J + (e_new - e - J
    step) step' / (step' step)`` (Broyden 1965, doi 10.1090/S0025-5718-1965-0198670-6), and taken anew where a step does
    not keep its promise. The start `x` is clipped to the bounds; `jacobian` and `steps` come from nearby (`is_exact`:
    `jacobian` was taken at the start, or within `FRESH` of it), else they are taken at the start; `errors` are the
    residuals there; `converged` is the fall of the sum of squares that a step would still promise at the end, by
    sensitivities that were taken where the data differ by less than `FRESH`. A descent is over, without
    sensitivities anew, where it leads to a minimum that is `known` or comes as near as `SAME` to its sum of squares,
    comes to rest above `limit`, or where a step after the first promises less than the share `least_promise` of the way
    down to it (0 for starts from far away); that of a scout (`is_scout`), wherever they would be wanted. The result's
    ``converged`` is False then, and where `MAX_STEPS` did not suffice; raises EndedEarly where the simulation does not
    come to its end at the start.
    """
    start = np.asarray(x, dtype=float)
    x = np.clip(start, residuals.low, residuals.high)
    if errors is None or not np.array_equal(x, start):
        errors = residuals.at(x)

    # Sensitivities from nearby spare an evaluation for each parameter. What they are worth is told by how far the data
    # have moved since they were taken; of those from nearby nothing is known.
    drift = 0.0 if jacobian is None or is_exact else np.inf
    steps = first_steps(len(x)) if steps is None else steps
    if jacobian is None:
        jacobian, steps = residuals.jacobian(x, errors, steps)
    damping, before = 1e-3, np.inf
    for number in range(MAX_STEPS):
        step, promise = _step(residuals, x, errors, jacobian, damping)
        end = Fitted(x, errors, jacobian, False, steps)

        # The ends of a descent. Sensitivities from close by alone prove a minimum; the other ends spare the evaluations
        # of a way that leads to a known minimum, or nowhere below the limit.
        if promise < converged and drift < FRESH:
            return end._replace(converged=True)
        if known is not None and known.leads_here(x, errors):
            return end
        if promise < converged and (end.cost > limit or (known is not None and abs(end.cost - known.cost) < SAME)):
            return end
        if number and promise < least_promise * (end.cost - limit):
            return end

        # Stale sensitivities that promise nothing, or little less than before, are taken anew: they hide larger falls.
        is_stale = drift > 0.0 and (promise < converged or (promise > CREEPING * before and damping < UNDAMPED))

        # The trial. A step at which a simulation ends early counts as one that keeps nothing of its promise.
        fall = -np.inf
        if not is_stale:
            before = promise
            with suppress(EndedEarly):
                tried = residuals.at(x + step)
                fall = errors @ errors - tried @ tried

        # A step that keeps enough of its promise is taken, and Broyden's rule keeps the sensitivities up. Otherwise
        # stale sensitivities are blamed first, and the length of the step only where they are fresh.
        if fall > 0.1 * promise:
            jacobian = jacobian + np.outer(tried - errors - jacobian @ step, step) / (step @ step)
            drift += float(np.linalg.norm(tried - errors))
            x, errors = x + step, tried
            damping = max(damping / 5.0, 1e-9)
            is_stale = not FORESEEN[0] < fall / promise < FORESEEN[1]
        elif drift > 0.0:
            is_stale = True
        else:
            if promise < BENT and damping > 1.0:
                return end._replace(converged=True)
            if fall > 0.0:
                drift, x, errors = np.inf, x + step, tried
            damping = max(10.0 * damping, DAMPING_FELT)

        if is_stale and is_scout:
            return Fitted(x, errors, jacobian, False, steps)
        if is_stale:
            jacobian, steps = residuals.jacobian(x, errors, steps)
            drift = 0.0
    return Fitted(x, errors, jacobian, False, steps)


def _step(
    residuals: LeastSquares, x: np.ndarray, errors: np.ndarray, jacobian: np.ndarray, damping: float
) -> tuple[np.ndarray, float]:
    """The damped step from x that stays in the bounds, and the fall that the straight model promises."""
    gradient = jacobian.T @ errors
    free = ~(((x <= residuals.low) & (gradient > 0.0)) | ((x >= residuals.high) & (gradient < 0.0)))
    step = np.zeros(len(x))
    normal = jacobian.T @ jacobian
    for _ in range(len(x)):
        if not free.any():
            break
        inner = normal[np.ix_(free, free)]
        step[:] = 0.0
        step[free] = np.linalg.solve(inner + damping * np.diag(np.diag(inner) + 1e-12), -gradient[free])
        beyond = free & ((x + step < residuals.low) | (x + step > residuals.high))
        if not beyond.any():
            break
        # The first bound on the way: go there, and let the others choose anew from a shorter step.
        ends = np.where(step < 0.0, residuals.low, residuals.high)
        share = np.min((ends - x)[beyond] / step[beyond])
        if share > 1e-9:
            step *= share
            break
        free &= ~beyond
    step = np.clip(x + step, residuals.low, residuals.high) - x
    after = errors + jacobian @ step
    return step, float(errors @ errors - after @ after)
