"""Edges of a command that come while the valve is marched, and when what follows them has its next corner."""

import numpy as np

from apesim.kernel import kernel
from apesim.valve.actuator import ActuatorTables
from apesim.valve.solenoid import MIN_EXCESS, SolenoidCurves, summed_ramps

EDGES = 32
"""Edges of a command that are remembered; chosen: those of 16 pulses whose ramps have not ended."""
FAR = 1e12
"""Time of a last breakpoint that no march comes to [s]; finite, so that the slope up to it is a number."""
MERGED = 1e-12
"""Time up to which two corners of a solenoid are one [s]."""


@kernel
def add_edge(edges: np.ndarray, t: float, longest_ramp: float) -> None:
    """Add an edge at `t` [s] to the edges (n,) [s] of a command, ascending, with inf in the places that are empty.

    Edges energise and release in turn. A pair whose ramps, of at most `longest_ramp` [s], have ended is forgotten, and
    the oldest one where there is no room.

    >>> edges = np.full(4, np.inf)
    >>> for t in (0.0, 1.0, 5.0):
    ...     add_edge(edges, t, longest_ramp=2.0)
    >>> edges.tolist()
    [5.0, inf, inf, inf]
    """
    count, last = 0, edges.shape[0] - 1
    while count <= last and edges[count] < np.inf:
        count += 1
    while count >= 2 and (edges[1] + longest_ramp < t or count >= last):
        for i in range(count):
            edges[i] = edges[i + 2] if i + 2 < count else np.inf
        count -= 2
    edges[count] = t


@kernel
def len_of_ramps(valve: ActuatorTables) -> float:
    """Time from an edge to the end of the longest ramp of both solenoids [s]."""
    return max(_end_of(valve.curves_a), _end_of(valve.curves_b))


@kernel
def _end_of(curves: SolenoidCurves) -> float:
    """Time from an edge to the end of the longer ramp of a solenoid [s]."""
    energising, release = curves.energising, curves.release
    return max(energising[energising.shape[0] - 1, 0], release[release.shape[0] - 1, 0])


@kernel
def next_corner_time(valve: ActuatorTables, t: float) -> float:
    """Find the next time after `t` [s] at which an energised fraction has a corner; inf: there is none."""
    return min(_next_of(valve.edges_a, valve.curves_a, t), _next_of(valve.edges_b, valve.curves_b, t))


@kernel
def _next_of(edges: np.ndarray, curves: SolenoidCurves, t: float) -> float:
    """Find the next corner of one solenoid after `t` [s]: a row of a curve, or where the sum of ramps is clipped."""
    found, sign = np.inf, 1.0
    for edge in edges:
        curve = curves.energising if sign > 0.0 else curves.release
        for row in range(curve.shape[0]):
            at = edge + curve[row, 0]
            if t + MERGED < at < found:
                found = at
        sign = -sign
    if found == np.inf:
        return found

    # Between two rows the sum of the ramps is a line: where it leaves 0...1 or comes back is a corner, too.
    before, after = summed_ramps(edges, np.inf, curves, t), summed_ramps(edges, np.inf, curves, found)
    first = found
    for level in (0.0, 1.0):
        low, high = min(before, after) - level, max(before, after) - level
        if low < -MIN_EXCESS and high > MIN_EXCESS:
            at = t + (found - t) * (level - before) / (after - before)
            if t + MERGED < at < first:
                first = at
    return first
