"""The periodic state of a machine that is driven in cycles."""

from typing import NamedTuple

import numpy as np

from apesim.march import LOG_HEAD, Status, march

PERIODIC_TOLERANCE = 1e-8
CYCLES_MOST = 600
NOISE = 100.0
"""Two cycles that differ by less than this many tolerances of a step differ by the solver's error."""
PATIENCE = 60
"""Cycles after which a tenth of that is good enough."""
BURST = 15
"""Plain cycles before the march is helped by Newton's method, and between two such helps."""
NO_TIMES, NO_TRACE = np.empty(0), np.empty((0, 0))
LOOSE = 1e-9
"""A state whose map differs from the identity by less is held, as a piston on its stop."""
NUDGE = 1e-3
"""Relative change of a state for a difference of the cycle's map."""


class Orbit(NamedTuple):
    """What a machine settles to."""

    y: np.ndarray
    """State at the start of the cycle; the ledger behind it is zero."""
    mode: np.ndarray
    converged: bool
    period: int
    """Cycles after which the state repeats: 1 or 2; 0 where it was not seen to repeat."""
    cycles: int
    """Marched in all."""
    change: float
    """Largest change of a state over the last cycle, relative to scale + abs(state)."""
    change_of_two: float
    """The same over the last two cycles."""
    status: int
    """`Status` of the last march."""


def distance(a, b, scale):
    """Largest difference of two states, relative to scale + abs(state)."""
    n = len(scale)
    sizes = scale + np.maximum(np.abs(a[:n]), np.abs(b[:n]))
    return float(np.max(np.abs(a[:n] - b[:n]) / sizes))


def _cycle(p, tables, y, mode, kinks, accuracy):
    """State and mode after one cycle, the state's ledger that cycle's, and the march's status."""
    n = len(accuracy.scale)
    y, mode = y.copy(), mode.copy()
    y[n:] = 0.0
    status = march(p, tables, 0.0, y, mode, kinks, accuracy, np.empty((0, LOG_HEAD + n)), NO_TIMES, NO_TRACE).status
    return y, mode, status


def _plain_cycles(p, tables, y, mode, kinks, accuracy, tolerance, most):
    """Plain cycles until two in a row repeat the state, or four in a row that of two cycles before, or the most.

    Returns
    -------
    y, mode : arrays
    status, cycles : int
    change, change_of_two : float
        Of the state over the last cycle and the last two.
    """
    before = before_that = None
    change = change_of_two = np.inf
    steady = steady_of_two = 0
    cycles = 0
    while cycles < most:
        cycles += 1
        before_that, before = before, (y, mode)
        y, mode, status = _cycle(p, tables, y, mode, kinks, accuracy)
        if status != Status.DONE:
            break
        change = _change(before, y, mode, accuracy.scale)
        change_of_two = _change(before_that, y, mode, accuracy.scale)
        steady = steady + 1 if change <= tolerance else 0
        steady_of_two = steady_of_two + 1 if change_of_two <= tolerance else 0
        if steady >= 2 or steady_of_two >= 4:
            break
    return y, mode, status, cycles, change, change_of_two


def _change(earlier, y, mode, scale):
    """Distance from an earlier state and mode; infinite where the phase differs or there was none."""
    if earlier is None or earlier[1][0] != mode[0]:
        return np.inf
    return distance(earlier[0], y, scale)


def _period(change, change_of_two, tolerance, noise, done):
    """1 or 2 where the state repeats, else 0. What stays within the solver's error is no difference."""
    if change <= tolerance:
        return 1
    if change_of_two <= tolerance:
        return 1 if change <= noise else 2
    # A drift changes twice as much in two cycles as in one, the solver's error does not.
    return int(done >= PATIENCE and change_of_two <= change <= 0.1 * noise)


def _newton(p, tables, y, mode, kinks, accuracy):
    """One Newton step towards the fixed point of the cycle's map.

    Returns
    -------
    y : array or None
        None where a cycle changes the mode or fails, so that the map has no slope; or where the slope repels, so that
        the fixed point is none that a machine settles to.
    cycles : int
    """
    n = accuracy.scale.shape[0]
    image, mode_image, status = _cycle(p, tables, y, mode, kinks, accuracy)
    if status != Status.DONE or mode_image[0] != mode[0]:
        return None, 1
    slopes = np.zeros((n, n))
    sizes = accuracy.scale + np.abs(y[:n])
    for i in range(n):
        nudged = y.copy()
        nudged[i] -= NUDGE * sizes[i]
        other, mode_other, status = _cycle(p, tables, nudged, mode, kinks, accuracy)
        if status != Status.DONE or mode_other[0] != mode[0]:
            return None, i + 2
        slopes[:, i] = (image[:n] - other[:n]) / sizes / NUDGE
    if np.abs(np.linalg.eigvals(slopes)).max() > 1.0 + accuracy.tolerance / NUDGE:
        return None, n + 1
    gap = np.eye(n) - slopes
    free = np.flatnonzero(np.abs(gap).max(axis=1) > LOOSE)
    step = np.zeros(n)
    step[free] = np.linalg.lstsq(gap[np.ix_(free, free)], ((image - y)[:n] / sizes)[free], rcond=1e-9)[0]
    better = y.copy()
    better[:n] += np.clip(step, -0.3, 0.3) * sizes
    return better, n + 1


def periodic_orbit(p, tables, y, mode, kinks, accuracy, tolerance=PERIODIC_TOLERANCE, most=CYCLES_MOST):
    """March to the periodic state, helped by Newton's method where plain cycles converge slowly.

    What a Newton step found is kept only where the plain cycles after it come nearer to a period than those before it.

    Parameters
    ----------
    p : NamedTuple
        The machine.
    tables : NamedTuple
        Its arrays.
    y : (n,) float array
        Start.
    mode : (m,) float array
    kinks : (j,) float array
        Of a cycle from 0; the last is its period [s].
    accuracy : Accuracy
    tolerance : float
        Largest change of any state over a cycle, relative.
    most : int
        Cycles at most.

    Returns
    -------
    Orbit
    """
    done, kept = 0, None
    while True:
        y, mode, status, cycles, change, change_of_two = _plain_cycles(
            p, tables, y, mode, kinks, accuracy, tolerance, max(1, min(BURST, most - done))
        )
        done += cycles
        period = _period(change, change_of_two, tolerance, NOISE * accuracy.tolerance, done)
        astray = kept is not None and not period and not (status == Status.DONE and change < 0.5 * kept[2])
        if astray:
            y, mode, change, change_of_two, status = *kept, Status.DONE
        if status != Status.DONE or period or done >= most:
            break
        found, kept = None, None
        if not astray:
            found, cycles = _newton(p, tables, y, mode, kinks, accuracy)
            done += cycles
        if found is not None:
            kept = y, mode, change, change_of_two
            y = found
    y[accuracy.scale.shape[0] :] = 0.0
    return Orbit(y, mode, bool(period), period, done, change, change_of_two, status)
