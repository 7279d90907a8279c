"""Dormand and Prince's explicit step of order 5(4), and its dense output.

The pair: J. Comp. Appl. Math. 6, 1980, 19. The interpolant: Hairer, Norsett and Wanner, Solving Ordinary Differential
Equations I, II.6.
"""

from typing import Any

import numpy as np

from apesim.kernel import kernel
from apesim.march.hybrid_system import rates


@kernel(inline=False)
def slopes(p: Any, t: float, y: np.ndarray, mode: np.ndarray, dy: np.ndarray) -> bool:
    """Write the rates of a machine at `t` [s] into `dy` (m,); return whether the state lies in the domain of the laws.

    `y` (m,) holds state and ledger, `mode` (k,) the modes. It is laid down once in compiled code for all callers but
    the stages.
    """
    return rates(p, t, y, mode, dy)


@kernel(inline=False)
def stages(
    p: Any, t: float, h: float, y: np.ndarray, mode: np.ndarray, n: int, k: np.ndarray, trial: np.ndarray
) -> bool:
    """Take stages 2 to 7 of a step.

    They are taken in a loop, so that the rates are laid down once in compiled code.

    The coefficients are those of Dormand and Prince's pair of order 5(4) [1]_; the last stage is the first one of the
    next step.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.
    t, h : float
        Start and length of the step [s].
    y : (m,) float array
        State and ledger.
    mode : (k,) float array
        Modes of the machine.
    n : int
        Number of integrated states; the ledger is only needed in the last stage.
    k : (7, m) float array
        Rates of the stages; k[0] given, the others filled.
    trial : (m,) float array
        New state; filled.

    Returns
    -------
    bool
        Whether all stages lie in the domain of the laws.

    References
    ----------
    .. [1] J. R. Dormand and P. J. Prince, "A family of embedded Runge-Kutta formulae", J. Comput. Appl. Math. 6, 1980,
       pp. 19-26, doi 10.1016/0771-050X(80)90013-3; also E. Hairer, S. P. Norsett and G. Wanner, "Solving Ordinary
       Differential Equations I: Nonstiff Problems", 2nd ed., Springer, 1993, doi 10.1007/978-3-540-78862-1, Table 5.2
       of section II.5.

    Examples
    --------
    A decay at 2 per second over 0.1 s, exp(-0.2) = 0.8187308:

    >>> from typing import NamedTuple
    >>> import numpy as np
    >>> from apesim.kernel import kernel
    >>> from apesim.march.hybrid_system import rates
    >>> class Decay(NamedTuple):
    ...     rate: float
    >>> @rates.for_type(Decay)
    ... @kernel
    ... def decay_rates(p, t, y, mode, dy):
    ...     dy[0] = -p.rate * y[0]
    ...     return True
    >>> p, y, mode = Decay(rate=2.0), np.array([1.0]), np.zeros(1)
    >>> k, trial = np.zeros((7, 1)), np.empty(1)
    >>> _ = slopes(p, 0.0, y, mode, k[0])
    >>> stages(p, 0.0, 0.1, y, mode, 1, k, trial), round(float(trial[0]), 6)
    (True, 0.818731)
    """
    # Stages 2 to 6 are of the integrated states alone: the rates do not depend on the ledger.
    for s in range(1, 7):
        if s == 1:
            c = 0.2
            for i in range(n):
                trial[i] = y[i] + h * (k[0, i] / 5.0)
        elif s == 2:
            c = 0.3
            for i in range(n):
                trial[i] = y[i] + h * (3.0 / 40.0 * k[0, i] + 9.0 / 40.0 * k[1, i])
        elif s == 3:
            c = 0.8
            for i in range(n):
                trial[i] = y[i] + h * (44.0 / 45.0 * k[0, i] - 56.0 / 15.0 * k[1, i] + 32.0 / 9.0 * k[2, i])
        elif s == 4:
            c = 8.0 / 9.0
            for i in range(n):
                trial[i] = y[i] + h * (
                    19372.0 / 6561.0 * k[0, i]
                    - 25360.0 / 2187.0 * k[1, i]
                    + 64448.0 / 6561.0 * k[2, i]
                    - 212.0 / 729.0 * k[3, i]
                )
        elif s == 5:
            c = 1.0
            for i in range(n):
                trial[i] = y[i] + h * (
                    9017.0 / 3168.0 * k[0, i]
                    - 355.0 / 33.0 * k[1, i]
                    + 46732.0 / 5247.0 * k[2, i]
                    + 49.0 / 176.0 * k[3, i]
                    - 5103.0 / 18656.0 * k[4, i]
                )
        else:
            # Here the stage is the new state, and the ledger is taken with it.
            for i in range(y.shape[0]):
                trial[i] = y[i] + h * (
                    35.0 / 384.0 * k[0, i]
                    + 500.0 / 1113.0 * k[2, i]
                    + 125.0 / 192.0 * k[3, i]
                    - 2187.0 / 6784.0 * k[4, i]
                    + 11.0 / 84.0 * k[5, i]
                )

        # `rates` itself and not `slopes`: one call in a loop is laid down once anyway.
        if not rates(p, t + c * h, trial, mode, k[s]):
            return False
    return True


@kernel(inline=False)
def stiffness(h: float, y: np.ndarray, trial: np.ndarray, k: np.ndarray, scale: np.ndarray) -> float:
    """Return the length of a step times the largest slope of the rates over the states that it shows.

    It is ``h abs(k_7 - k_6)/abs(y_7 - y_6)``, as both stages lie at the end of the step [1]_; states are relative to
    their scale and size. Stability holds a step to 3.3 where its slopes are negative.

    Parameters
    ----------
    h : float
        Length of the step [s].
    y, trial : (m,) float array
        State and ledger at the start and at the end of the step.
    k : (7, m) float array
        Rates of the stages.
    scale : (n,) float array
        Scale of each integrated state.

    Returns
    -------
    float
        0 where the stages do not differ.

    References
    ----------
    .. [1] E. Hairer and G. Wanner, "Solving Ordinary Differential Equations II: Stiff and Differential-Algebraic
       Problems", 2nd ed., Springer, 1996, doi 10.1007/978-3-642-05221-7, IV.2, "Stiffness detection".

    Examples
    --------
    A decay at 2 per second over 0.1 s:

    >>> from typing import NamedTuple
    >>> import numpy as np
    >>> from apesim.kernel import kernel
    >>> from apesim.march.hybrid_system import rates
    >>> class Decay(NamedTuple):
    ...     rate: float
    >>> @rates.for_type(Decay)
    ... @kernel
    ... def decay_rates(p, t, y, mode, dy):
    ...     dy[0] = -p.rate * y[0]
    ...     return True
    >>> p, y, mode = Decay(rate=2.0), np.array([1.0]), np.zeros(1)
    >>> k, trial = np.zeros((7, 1)), np.empty(1)
    >>> _ = slopes(p, 0.0, y, mode, k[0]), stages(p, 0.0, 0.1, y, mode, 1, k, trial)
    >>> round(float(stiffness(0.1, y, trial, k, np.ones(1))), 6)
    0.2
    >>> print(stiffness(0.1, y, trial, np.zeros((7, 1)), np.ones(1)))
    0.0
    """
    slopes_apart = states_apart = 0.0
    for i in range(scale.shape[0]):
        size = scale[i] + max(abs(y[i]), abs(trial[i]))
        apart = (
            (35.0 / 384.0 - 9017.0 / 3168.0) * k[0, i]
            + 355.0 / 33.0 * k[1, i]
            + (500.0 / 1113.0 - 46732.0 / 5247.0) * k[2, i]
            + (125.0 / 192.0 - 49.0 / 176.0) * k[3, i]
            + (5103.0 / 18656.0 - 2187.0 / 6784.0) * k[4, i]
            + 11.0 / 84.0 * k[5, i]
        ) / size
        states_apart += apart * apart
        apart = (k[6, i] - k[5, i]) / size
        slopes_apart += apart * apart
    return np.sqrt(slopes_apart / states_apart) if states_apart > 0.0 else 0.0


@kernel(inline=False)
def step_error(h: float, y: np.ndarray, trial: np.ndarray, k: np.ndarray, tolerance: float, scale: np.ndarray) -> float:
    """Return the error estimate of a step over its tolerance.

    ``error^2 = mean of (e_i/sc_i)^2`` with ``sc_i = tolerance (scale_i + max(abs(y_0i), abs(y_1i)))`` [1]_; e is the
    difference of the orders 5 and 4 [2]_.

    Parameters
    ----------
    h : float
        Length of the step [s].
    y, trial : (m,) float array
        State and ledger at the start and at the end of the step.
    k : (7, m) float array
        Rates of the stages.
    tolerance : float
        Error of a step, relative to scale + abs(y).
    scale : (n,) float array
        Scale of the error of each integrated state.

    Returns
    -------
    float
        Root mean square of the error estimate over its tolerance; the step holds up to 1.

    References
    ----------
    .. [1] E. Hairer, S. P. Norsett and G. Wanner, "Solving Ordinary Differential Equations I: Nonstiff Problems", 2nd
       ed., Springer, 1993, doi 10.1007/978-3-540-78862-1, Eqs. 4.10 and 4.11 of section II.4.
    .. [2] J. R. Dormand and P. J. Prince, "A family of embedded Runge-Kutta formulae", J. Comput. Appl. Math. 6, 1980,
       pp. 19-26, doi 10.1016/0771-050X(80)90013-3.

    Examples
    --------
    Rates that are constant are integrated without error:

    >>> round(float(step_error(0.1, np.ones(1), np.ones(1), np.ones((7, 1)), 1e-7, np.ones(1))), 6)
    0.0
    """
    total = 0.0
    for i in range(scale.shape[0]):
        e = h * (
            71.0 / 57600.0 * k[0, i]
            - 71.0 / 16695.0 * k[2, i]
            + 71.0 / 1920.0 * k[3, i]
            - 17253.0 / 339200.0 * k[4, i]
            + 22.0 / 525.0 * k[5, i]
            - 1.0 / 40.0 * k[6, i]
        )
        ratio = e / (tolerance * (scale[i] + max(abs(y[i]), abs(trial[i]))))
        total += ratio * ratio
    return np.sqrt(total / scale.shape[0])


@kernel(inline=False)
def interpolant(h: float, y: np.ndarray, trial: np.ndarray, k: np.ndarray, c: np.ndarray) -> None:
    """Write the coefficients of the dense output of a step.

    It is the continuous extension of order 4 of Dormand and Prince's pair [1]_.

    Parameters
    ----------
    h : float
        Length of the step [s].
    y, trial : (m,) float array
        State and ledger at the start and at the end of the step.
    k : (7, m) float array
        Rates of the stages.
    c : (5, n) float array
        Coefficients of the dense output; filled.

    References
    ----------
    .. [1] E. Hairer, S. P. Norsett and G. Wanner, "Solving Ordinary Differential Equations I: Nonstiff Problems", 2nd
       ed., Springer, 1993, doi 10.1007/978-3-540-78862-1, section II.6.

    Examples
    --------
    A constant rate gives a line, here halfway from 1 to 1.2:

    >>> c, out = np.zeros((5, 1)), np.empty(1)
    >>> interpolant(0.1, np.array([1.0]), np.array([1.2]), np.full((7, 1), 2.0), c)
    >>> dense(c, 0.5, out)
    >>> round(float(out[0]), 6)
    1.1
    """
    for i in range(c.shape[1]):
        rise = trial[i] - y[i]
        bend = h * k[0, i] - rise
        c[0, i] = y[i]
        c[1, i] = rise
        c[2, i] = bend
        c[3, i] = rise - h * k[6, i] - bend
        c[4, i] = h * (
            -12715105075.0 / 11282082432.0 * k[0, i]
            + 87487479700.0 / 32700410799.0 * k[2, i]
            - 10690763975.0 / 1880347072.0 * k[3, i]
            + 701980252875.0 / 199316789632.0 * k[4, i]
            - 1453857185.0 / 822651844.0 * k[5, i]
            + 69997945.0 / 29380423.0 * k[6, i]
        )


@kernel(inline=False)
def dense(c: np.ndarray, x: float, out: np.ndarray) -> None:
    """Write the dense output of a step at a share of the step.

    It is a polynomial of degree 4 in the share of the step [1]_.

    Parameters
    ----------
    c : (5, n) float array
        Coefficients, see `interpolant`.
    x : float
        Share of the step, 0...1.
    out : (>= n,) float array
        States there; filled.

    References
    ----------
    .. [1] E. Hairer, S. P. Norsett and G. Wanner, "Solving Ordinary Differential Equations I: Nonstiff Problems", 2nd
       ed., Springer, 1993, doi 10.1007/978-3-540-78862-1, section II.6.

    Examples
    --------
    >>> out = np.empty(1)
    >>> dense(np.array([[1.0], [2.0], [0.0], [0.0], [0.0]]), 0.25, out)
    >>> out.tolist()
    [1.5]
    """
    u = 1.0 - x
    for i in range(c.shape[1]):
        out[i] = c[0, i] + x * (c[1, i] + u * (c[2, i] + x * (c[3, i] + u * c[4, i])))
