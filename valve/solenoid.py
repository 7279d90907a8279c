"""Solenoid valves: when they are switched, and how far they have followed.

Dead time and linear ramp are chosen, for each edge of the command; a curve measured by a discharge test (the EPV paper,
doi 10.1631/jzus.A0820373, Eq. 10) replaces them.
"""

from collections.abc import Callable, Iterator
from math import floor, inf, isnan, nan
from typing import Annotated, NamedTuple

import numpy as np

from apesim.kernel import kernel
from apesim.linear_table import read_table
from apesim.quantities import NO_CURVE, Curve, Quantity


class Solenoid(NamedTuple):
    """Two three-way solenoid valves, driven together.

    The bore of 4 mm and the 120 Hz that the chosen numbers follow are those of the EPV paper
    (doi 10.1631/jzus.A0820373), and its Eq. 10 is the test that gives an opening curve.
    """

    effective_area: Annotated[
        float, Quantity("mm^2", 0.01, 500, "chosen: 0.72 of the paper's 4 mm bore; the paper prints no number")
    ] = 9.0e-6
    dead_time: Annotated[float, Quantity("ms", 0, 50, "chosen: a solenoid valve of 120 Hz")] = 1.5e-3
    ramp_time: Annotated[float, Quantity("ms", 0.001, 50, "chosen: a solenoid valve of 120 Hz")] = 1.5e-3
    opening_curve: Annotated[
        np.ndarray,
        Curve(("time [ms]", "opening [-]"), "a discharge test (Eq. 10); not given: dead time, then a linear ramp"),
    ] = NO_CURVE
    release_dead_time: Annotated[
        float, Quantity("ms", 0, 50, "from the release on", text="that of energising", optional=True)
    ] = nan
    release_ramp_time: Annotated[
        float, Quantity("ms", 0.001, 50, "from energised to released", text="that of energising", optional=True)
    ] = nan
    release_curve: Annotated[
        np.ndarray,
        Curve(
            ("time [ms]", "release [-]"),
            "measured: 0 energised, 1 released; not given: energising's curve, from the release's dead time on, over "
            "its ramp",
        ),
    ] = NO_CURVE

    def faults(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with the measured curves, beyond the ranges of their single values: key, wrong, right."""
        for key, curve, share in (
            ("opening_curve", self.opening_curve, "opening"),
            ("release_curve", self.release_curve, "release"),
        ):
            if len(curve):
                time, fraction = curve.T
                if time[0] < 0.0 or fraction[0] != 0.0 or fraction[-1] != 1.0 or np.any(np.diff(fraction) < 0.0):
                    right = f"{share} 0 in the first row (time >= 0), 1 in the last, never falling"
                    yield key, "does not rise from 0 to 1", right

    def overruled(self) -> Iterator[tuple[str, str]]:
        """Find keys that are not used because a measured curve is given, and what is used in their place."""
        for curve, given, keys in (
            ("opening_curve", self.opening_curve, ("dead_time", "ramp_time")),
            ("release_curve", self.release_curve, ("release_dead_time", "release_ramp_time")),
        ):
            if len(given):
                yield from ((key, f"valve.solenoid.{curve} is given") for key in keys)


class SolenoidCurves(NamedTuple):
    """How a solenoid follows its command: the share of the way that it has gone over the time after an edge."""

    energising: np.ndarray
    """Time after an edge that energises [s] and energised fraction, linear in between, shape (j, 2)."""
    release: np.ndarray
    """Time after an edge that releases [s] and share of the way back, linear in between, shape (k, 2)."""

    def changed(self, change: Callable[[np.ndarray], np.ndarray]) -> "SolenoidCurves":
        """Return the curves with one change of both, a function of the curve of an edge."""
        return SolenoidCurves(change(self.energising), change(self.release))


def opening_curve(solenoid: Solenoid) -> np.ndarray:
    """Return the energised fraction over the time [s] after a solenoid was energised: rows (j, 2), linear in between.

    Without a measured curve it is 0 up to the dead time, then a linear ramp to 1. A catalogue's shifting time (ISO
    12238:2023) runs from the signal to a change of the pressure behind the valve: it is longer than the dead time here,
    at which the valve begins to open.
    """
    if len(solenoid.opening_curve):
        return np.ascontiguousarray(solenoid.opening_curve)
    dead, ramp = solenoid.dead_time, solenoid.ramp_time
    return np.array([[dead, 0.0], [dead + ramp, 1.0]])


def solenoid_curves(solenoid: Solenoid) -> SolenoidCurves:
    """Return how a solenoid follows an edge that energises it, and one that releases it.

    Release goes the way back as energising goes the way there, ``f_r(t) = f((t - t_0r) t_r/t_rr + t_0)``, with dead
    time t_0 and ramp time t_r of energising, t_0r and t_rr of release. Those of release are those of energising where
    they are not given. A measured release curve replaces all this. That both ways have one shape is chosen.

    Parameters
    ----------
    solenoid : Solenoid
        Parameters of the solenoid valves. Where an opening curve is given, its dead time ends in its last row of 0, and
        its ramp in its first row of 1.

    Returns
    -------
    SolenoidCurves
        Curves of both edges.

    Examples
    --------
    A solenoid that begins to let go 0.8 ms later than it begins to pull in, and takes 1 ms longer:

    >>> curves = solenoid_curves(Solenoid(release_dead_time=2.3e-3, release_ramp_time=2.5e-3))
    >>> [(1e3 * curve[:, 0]).round(6).tolist() for curve in curves]
    [[1.5, 3.0], [2.3, 4.8]]
    """
    energising = opening_curve(solenoid)
    if len(solenoid.release_curve):
        return SolenoidCurves(energising, np.ascontiguousarray(solenoid.release_curve))
    dead, ramp = solenoid.release_dead_time, solenoid.release_ramp_time
    if isnan(dead) and isnan(ramp):
        return SolenoidCurves(energising, energising)
    time, fraction = energising.T
    begin, end = time[fraction == 0.0][-1], time[fraction == 1.0][0]
    way = energising[(time >= begin) & (time <= end)]
    share = (way[:, 0] - begin) / (end - begin)
    own_ramp = end - begin if len(solenoid.opening_curve) else solenoid.ramp_time
    start, length = begin if isnan(dead) else dead, own_ramp if isnan(ramp) else ramp
    return SolenoidCurves(energising, np.column_stack((start + share * length, way[:, 1])))


def shifted(curve: np.ndarray, time: float) -> np.ndarray:
    """Return a curve (j, 2) that comes later by `time` [s], or earlier (negative), but not before the edge."""
    return curve + np.array([max(time, -curve[0, 0]), 0.0])


@kernel
def followed(curve: np.ndarray, lag: float) -> float:
    """Return how far, 0...1, a solenoid has followed an edge of its command, `lag` [s] after it.

    `curve` (j, 2) is that of the edge, see `SolenoidCurves`.
    """
    return read_table(curve, lag)


@kernel
def summed_ramps(edges: np.ndarray, period: float, curves: SolenoidCurves, t: float) -> float:
    """Return the sum of the ramps of all past edges, those of release taken off: the energised fraction unclipped.

    It is below 0 or above 1 where release takes another time than energising. `edges` (n,) [s] energise and release in
    turn, ascending; they repeat with `period` [s] for ever, in the past too, or happen once (inf).

    A solenoid that lets go at once and takes 1 s to pull in, after a pulse of 0.5 s:

    >>> curves = SolenoidCurves(np.array([[1.0, 0.0], [2.0, 1.0]]), np.array([[0.0, 0.0], [0.5, 1.0]]))
    >>> [float(summed_ramps(np.array([0.0, 0.5]), inf, curves, t)) for t in (0.5, 1.0, 1.5, 2.0)]
    [0.0, -1.0, -0.5, 0.0]
    """
    nearest = inf
    x = 0.0
    missing = 0.0
    sign = 1.0
    for edge in edges:
        curve = curves.energising if sign > 0.0 else curves.release
        end = curve[curve.shape[0] - 1, 0]
        lag = t - edge
        if period < inf:
            lag -= np.floor(lag / period) * period
        if 0.0 <= lag < nearest:
            nearest = lag
            x = 0.5 * (1.0 + sign)
        while 0.0 <= lag < end:
            missing += sign * (1.0 - followed(curve, lag))
            lag += period
        sign = -sign
    return x - missing


@kernel
def energised_fraction(edges: np.ndarray, period: float, curves: SolenoidCurves, t: float) -> float:
    """Return the energised fraction x(t): the sum of the ramps of all past edges, clipped to 0...1.

    ``x(t) = min(1, max(0, sum(f(t - t_i)) - sum(f_r(t - t_j))))``, over past edges t_i that energise, each with the
    curve f of energising, and t_j that release, each with the curve f_r of release.

    The law is chosen. It depends on the edges alone, and says of ramps that are interrupted:

    - An edge that comes before the last ramp has ended acts on top of it. The ramp goes on; from the dead time of the
      new edge on, both ramps add up.
    - A pulse moves nothing where release is ahead of energising at every instant.
    - A pause between two pulses moves nothing where the second energising is ahead of the release at every instant.

    Parameters
    ----------
    edges : (n,) float array
        Times of the edges energise, release, energise, ..., ascending [s].
    period : float
        Period at which they repeat for ever, in the past too [s]; inf: they happen once.
    curves : SolenoidCurves
        How the solenoid follows each kind of edge.
    t : float
        Time [s].

    Returns
    -------
    float
        x, 0: released, 1: energised.

    Examples
    --------
    A quarter of the ramp after the edge at 0, and a quarter before its end after the edge at 10:

    >>> curve = np.array([[1.0, 0.0], [2.0, 1.0]])
    >>> curves = SolenoidCurves(curve, curve)
    >>> [float(energised_fraction(np.array([0.0, 10.0]), inf, curves, t)) for t in (0.5, 1.25, 5.0, 11.75)]
    [0.0, 0.25, 1.0, 0.25]

    Release takes 2 s longer to begin:

    >>> later = curves._replace(release=shifted(curve, 2.0))
    >>> [float(energised_fraction(np.array([0.0, 10.0]), inf, later, t)) for t in (1.25, 11.75, 13.75)]
    [0.25, 1.0, 0.25]
    """
    return min(1.0, max(0.0, summed_ramps(edges, period, curves, t)))


MIN_EXCESS = 1e-9
"""Smallest excess of the sum of the ramps over 0...1 whose clipping is a corner; chosen: above rounding, far below the
tolerance of the march."""


def breakpoints_of(edges: np.ndarray, period: float, curves: SolenoidCurves, start: float, end: float) -> np.ndarray:
    """Return the times (m,) [s] at which an edge happens or the energised fraction has a corner, ascending.

    They lie after `start` and up to `end` [s], `end` itself included. Corners are the rows of the curves after each
    edge, and where the sum of the ramps leaves 0...1 or comes back. `edges` (n,) [s] energise and release in turn,
    ascending; they repeat with `period` [s], or happen once (inf).
    """
    # Plain numbers and a set: for so few, arrays would take ten times as long.
    rows = [(0.0, *curve[:, 0].tolist()) for curve in curves]
    times = [edge + row for number, edge in enumerate(np.asarray(edges).tolist()) for row in rows[number % 2]]
    if period < inf:
        turns = [turn * period for turn in range(int((end - start) / period) + 3)]
        times = [time + floor((start - time) / period) * period + turn for time in times for turn in turns]
    corners = np.array(sorted({end, *(time for time in times if start < time < end)}))
    if np.array_equal(*curves):
        return corners  # edges take turns: with one curve for both their sum stays within 0...1
    ends = np.append(start, corners)
    sums = np.array([summed_ramps(np.asarray(edges), period, curves, t) for t in ends])
    crossings = []
    for level in (0.0, 1.0):
        before, after = sums[:-1] - level, sums[1:] - level
        crosses = (np.minimum(before, after) < -MIN_EXCESS) & (np.maximum(before, after) > MIN_EXCESS)
        share = before[crosses] / (before - after)[crosses]
        crossings.append(ends[:-1][crosses] + share * np.diff(ends)[crosses])
    return np.unique(np.concatenate((corners, *crossings)))
