"""Implicit step for stiff stretches: RODAS, a stiffly accurate Rosenbrock method of order 4(3), and its dense output.

A volume that is small for the area that fills it follows its supply within microseconds, which holds an explicit step
down to that time however slowly the machine turns. Method, coefficients and dense output are those of Hairer and
Wanner, Solving Ordinary Differential Equations II, IV.7 and IV.10. The ledger is integrated by the same stages as the
states, so that balances close as they do in explicit steps.
"""

from typing import Any

import numpy as np

from apesim.kernel import kernel
from apesim.march.dormand_prince import slopes

GAMMA = 0.25
"""Diagonal coefficient of the method."""
STAGES = 6
"""Number of stages."""
_AT = np.array([0.0, 0.386, 0.21, 0.63, 1.0, 1.0])
_IN_TIME = np.array([0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0])
_STATES = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [1.544, 0.0, 0.0, 0.0, 0.0],
        [0.9466785280815826, 0.2557011698983284, 0.0, 0.0, 0.0],
        [3.314825187068521, 2.896124015972201, 0.9986419139977817, 0.0, 0.0],
        [1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 0.0],
        [1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1.0],
    ]
)
_SLOPES = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [-5.6688, 0.0, 0.0, 0.0, 0.0],
        [-2.430093356833875, -0.2063599157091915, 0.0, 0.0, 0.0],
        [-0.1073529058151375, -9.594562251023355, -20.47028614809616, 0.0, 0.0],
        [7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160, 0.0],
        [8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054],
    ]
)
_DENSE = np.array(
    [
        [10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823, 1.025137723295662],
        [-0.6762803392801253, 6.087714651680015, 16.43084320892478, 24.76722511418386, -6.594389125716872],
    ]
)
NUDGE = 3e-7
"""Relative change of a state, up and down, for its column of the Jacobian; chosen. Where a volume is filled within a
nanosecond, a larger one leaves an error of its square that counts a million times in a step, and a smaller one one of
rounding."""
NUDGE_IN_SCALE = 1.5e-9
"""That change, over its scale, of a state whose error is not relative alone, as a position: a piston may be a
micrometre from its stop, and little gas before it; chosen."""
NUDGE_IN_TIME = 1e-5
"""Change of the time for the last column of the Jacobian, as a share of the step."""
MIN_NUDGE_IN_TIME = 1e-11
"""Least change of the time, relative: far above its rounding error."""


@kernel(inline=False)
def slopes_of_rates(
    p: Any,
    t: float,
    h: float,
    y: np.ndarray,
    mode: np.ndarray,
    scale: np.ndarray,
    k: np.ndarray,
    trial: np.ndarray,
    jacobian: np.ndarray,
    room: np.ndarray,
) -> int:
    """Take the slopes of the rates of states and ledger over the states and time into `jacobian` (m, n + 1), time last.

    Returns the number of evaluations of the rates; 0 where a state near by lies outside the domain of the laws. `t` and
    `h` are start and length of the step [s], `k[0]` of `k` (7, m) the rates there; `k[1]`, `trial` (m,) and the last
    two columns of `room` (n, n + 2) are overwritten: which states stand still, and whose slopes are taken. Over the
    states they are central differences: forward ones, off by 1e-8, leave steps a tenth as long where an area is large
    for its volume. States that stand still whatever the others and the time do, as those of a valve at rest, have
    slopes of 0.
    """
    m, n = y.shape[0], scale.shape[0]
    still, taken = n, n + 1

    # Over time, first: it also shows which states stand still, now and a little later.
    for i in range(m):
        trial[i] = y[i]
    later = t + max(NUDGE_IN_TIME * h, MIN_NUDGE_IN_TIME * max(abs(t), h))
    if not slopes(p, later, trial, mode, k[1]):
        return 0
    for i in range(m):
        jacobian[i, n] = (k[1, i] - k[0, i]) / (later - t)
    for j in range(n):
        room[j, still] = 1.0 if k[0, j] == 0.0 and k[1, j] == 0.0 else 0.0
        room[j, taken] = 0.0
        for i in range(m):
            jacobian[i, j] = 0.0

    # Over the states that move. Each may be found to move others: rounds go on until one adds none.
    evaluations, before = 1, 0
    while before < evaluations:
        before = evaluations
        for j in range(n):
            if room[j, still] or room[j, taken]:
                continue
            room[j, taken] = 1.0
            evaluations += 2

            # A state whose error is not relative alone, as a position, is nudged by less: its stop may be near.
            nudge = NUDGE * abs(y[j])
            if nudge <= scale[j]:
                nudge = NUDGE_IN_SCALE * (scale[j] + abs(y[j]))

            # Central differences: the column holds the rates of the lower end until those of the upper one are there.
            low, high = y[j] - nudge, y[j] + nudge
            for end in (low, high):
                trial[j] = end
                if not slopes(p, t, trial, mode, k[1]):
                    return 0
                for i in range(n):
                    if k[1, i] != 0.0:
                        room[i, still] = 0.0
                for i in range(m):
                    jacobian[i, j] = (k[1, i] - jacobian[i, j]) / (high - low) if end == high else k[1, i]
            trial[j] = y[j]
    return evaluations


@kernel(inline=False)
def _factorise(matrix: np.ndarray) -> bool:
    """Factorise a matrix (n, n + 2) in place into triangles, with partial pivoting. False where it is singular.

    Column n is filled with the rows that were exchanged; column n + 1 is left for a right-hand side.
    """
    n = matrix.shape[0]
    for column in range(n):
        pivot = column
        for i in range(column + 1, n):
            if abs(matrix[i, column]) > abs(matrix[pivot, column]):
                pivot = i
        matrix[column, n] = pivot
        if not abs(matrix[pivot, column]) > 0.0:
            return False
        if pivot != column:
            for j in range(n):
                matrix[column, j], matrix[pivot, j] = matrix[pivot, j], matrix[column, j]
        for i in range(column + 1, n):
            matrix[i, column] /= matrix[column, column]
            for j in range(column + 1, n):
                matrix[i, j] -= matrix[i, column] * matrix[column, j]
    return True


@kernel(inline=False)
def _substitute(matrix: np.ndarray) -> None:
    """Solve for the right-hand side in the last column, in place, with the factors of `_factorise`."""
    n = matrix.shape[0]
    x = n + 1
    for i in range(n):
        pivot = int(matrix[i, n])
        matrix[i, x], matrix[pivot, x] = matrix[pivot, x], matrix[i, x]
        for j in range(i):
            matrix[i, x] -= matrix[i, j] * matrix[j, x]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            matrix[i, x] -= matrix[i, j] * matrix[j, x]
        matrix[i, x] /= matrix[i, i]


@kernel(inline=False)
def implicit_stages(
    p: Any,
    t: float,
    h: float,
    y: np.ndarray,
    mode: np.ndarray,
    scale: np.ndarray,
    jacobian: np.ndarray,
    k: np.ndarray,
    trial: np.ndarray,
    u: np.ndarray,
    room: np.ndarray,
) -> bool:
    """Take an implicit step.

    It is a step of RODAS [1]_, of order 4 and stiffly accurate, its stages transformed so that no product with the
    Jacobian is needed.

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
    scale : (n,) float array
        Scale of the error of each integrated state.
    jacobian : (m, n + 1) float array
        Slopes of the rates at (t, y), see `slopes_of_rates`.
    k : (7, m) float array
        Rates; k[0] given at (t, y), k[1] overwritten, k[6] filled with those at the end.
    trial : (m,) float array
        New state; filled.
    u : (6, m) float array
        Stages; filled. The last is the error of the step.
    room : (n, n + 2) float array
        Overwritten: the matrix of the stages with its pivots, and their right-hand side.

    Returns
    -------
    bool
        Whether all stages lie in the domain of the laws.

    References
    ----------
    .. [1] E. Hairer and G. Wanner, "Solving Ordinary Differential Equations II: Stiff and Differential-Algebraic
       Problems", 2nd ed., Springer, 1996, doi 10.1007/978-3-642-05221-7, IV.7.

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
    >>> k, trial, u, jacobian = np.zeros((7, 1)), np.empty(1), np.zeros((STAGES, 1)), np.array([[-2.0, 0.0]])
    >>> room = np.empty((1, 3))
    >>> _ = slopes(p, 0.0, y, mode, k[0])
    >>> implicit_stages(p, 0.0, 0.1, y, mode, np.ones(1), jacobian, k, trial, u, room), round(float(trial[0]), 5)
    (True, 0.81873)
    """
    m, n = y.shape[0], scale.shape[0]

    # One matrix serves all stages. States are relative to their sizes in it, as pivots are compared with each other.
    for i in range(n):
        for j in range(n):
            room[i, j] = -jacobian[i, j] * (scale[j] + abs(y[j])) / (scale[i] + abs(y[i]))
        room[i, i] += 1.0 / (h * GAMMA)
    if not _factorise(room):
        return False
    for s in range(STAGES):
        # The first stage is taken at the start of the step, where the rates are given.
        if s > 0:
            for i in range(m):
                trial[i] = y[i]
                for r in range(s):
                    trial[i] += _STATES[s, r] * u[r, i]
            if not slopes(p, t + _AT[s] * h, trial, mode, k[1]):
                return False

        # The right-hand side, and its solution for the states.
        for i in range(m):
            u[s, i] = k[min(s, 1), i] + _IN_TIME[s] * h * jacobian[i, n]
            for r in range(s):
                u[s, i] += _SLOPES[s, r] / h * u[r, i]
        for i in range(n):
            room[i, n + 1] = u[s, i] / (scale[i] + abs(y[i]))
        _substitute(room)
        for i in range(n):
            u[s, i] = room[i, n + 1] * (scale[i] + abs(y[i]))

        # The ledger follows from the states: no rate depends on it, so that its part of the matrix is a diagonal.
        for i in range(n, m):
            for j in range(n):
                u[s, i] += jacobian[i, j] * u[s, j]
            u[s, i] *= h * GAMMA

    # Stiffly accurate: the last stage is the error of the embedded solution, and leads from there to the new state.
    for i in range(m):
        trial[i] += u[5, i]
    return slopes(p, t + h, trial, mode, k[6])


@kernel(inline=False)
def implicit_error(y: np.ndarray, trial: np.ndarray, u: np.ndarray, tolerance: float, scale: np.ndarray) -> float:
    """Return the error estimate of an implicit step over its tolerance.

    ``error^2 = mean of (e_i/sc_i)^2`` with ``sc_i = tolerance (scale_i + max(abs(y_0i), abs(y_1i)))`` [1]_; e is the
    last stage, the difference to the embedded method of order 3 [2]_.

    Parameters
    ----------
    y, trial : (m,) float array
        State and ledger at the start and at the end of the step.
    u : (6, m) float array
        Stages of the step; the last is its error.
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
    .. [2] E. Hairer and G. Wanner, "Solving Ordinary Differential Equations II: Stiff and Differential-Algebraic
       Problems", 2nd ed., Springer, 1996, doi 10.1007/978-3-642-05221-7, IV.7.

    Examples
    --------
    An error of 2e-7 of a state of size 1 and scale 1 is the tolerance of 1e-7:

    >>> round(float(implicit_error(np.ones(1), np.ones(1), np.full((6, 1), 2e-7), 1e-7, np.ones(1))), 6)
    1.0
    """
    total = 0.0
    for i in range(scale.shape[0]):
        ratio = u[5, i] / (tolerance * (scale[i] + max(abs(y[i]), abs(trial[i]))))
        total += ratio * ratio
    return np.sqrt(total / scale.shape[0])


@kernel(inline=False)
def implicit_interpolant(y: np.ndarray, trial: np.ndarray, u: np.ndarray, c: np.ndarray) -> None:
    """Write the coefficients of the dense output of an implicit step, for `apesim.march.dormand_prince.dense`.

    It is the dense output of RODAS [1]_, a cubic in the share of the step.

    Parameters
    ----------
    y, trial : (m,) float array
        State and ledger at the start and at the end of the step.
    u : (6, m) float array
        Stages of the step.
    c : (5, n) float array
        Coefficients of the dense output; filled.

    References
    ----------
    .. [1] E. Hairer and G. Wanner, "Solving Ordinary Differential Equations II: Stiff and Differential-Algebraic
       Problems", 2nd ed., Springer, 1996, doi 10.1007/978-3-642-05221-7, IV.7 and IV.10.

    Examples
    --------
    Without stages it is the line from start to end:

    >>> c = np.zeros((5, 1))
    >>> implicit_interpolant(np.array([1.0]), np.array([1.5]), np.zeros((6, 1)), c)
    >>> c[:2].ravel().tolist()
    [1.0, 0.5]
    """
    for i in range(c.shape[1]):
        c[0, i] = y[i]
        c[1, i] = trial[i] - y[i]
        c[2, i] = c[3, i] = c[4, i] = 0.0
        for r in range(5):
            c[2, i] += _DENSE[0, r] * u[r, i]
            c[3, i] += _DENSE[1, r] * u[r, i]
