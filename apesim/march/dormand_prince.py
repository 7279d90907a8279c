"""A step of Dormand and Prince's 5(4) pair (J. Comp. Appl. Math. 6, 1980, 19), and its dense output.

The interpolant is that of Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, II.6.
"""

import numpy as np

from apesim.kernel import kernel
from apesim.march.hybrid_system import rates


@kernel(inline=False)
def slopes(p, t, y, mode, dy):
    """`rates`, laid down once for all callers but the stages."""
    return rates(p, t, y, mode, dy)


@kernel(inline=False)
def stages(p, t, h, y, mode, n, k, trial):
    """Stages 2 to 7 of a step from (t, y), k[0] given; trial ends as the new state. False outside the domain.

    A loop, so that `rates` is laid down once.
    """
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
            for i in range(y.shape[0]):
                trial[i] = y[i] + h * (
                    35.0 / 384.0 * k[0, i]
                    + 500.0 / 1113.0 * k[2, i]
                    + 125.0 / 192.0 * k[3, i]
                    - 2187.0 / 6784.0 * k[4, i]
                    + 11.0 / 84.0 * k[5, i]
                )
        if not rates(p, t + c * h, trial, mode, k[s]):
            return False
    return True


@kernel(inline=False)
def step_error(h, y, trial, k, tolerance, scale):
    """Root mean square of the error estimate over its tolerance."""
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
def interpolant(h, y, trial, k, c):
    """Coefficients of the dense output of a step into c, (5, n)."""
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
def dense(c, x, out):
    """The interpolant at the share x of the step."""
    u = 1.0 - x
    for i in range(c.shape[1]):
        out[i] = c[0, i] + x * (c[1, i] + u * (c[2, i] + x * (c[3, i] + u * c[4, i])))
