"""Solenoid valves: when they are switched, and how far they have followed.

Dead time and linear ramp are chosen; a curve measured by a discharge test (the EPV paper, doi 10.1631/jzus.A0820373,
Eq. 10) replaces them.
"""

from collections.abc import Iterator
from math import inf
from typing import Annotated, NamedTuple

import numpy as np

from apesim.kernel import kernel
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

    def faults(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with the opening curve, beyond the ranges of its single values.

        Yields
        ------
        key, wrong, right : str
            Key of the machine file, what is wrong with it, and what would be right.

        Examples
        --------
        >>> [wrong for _, wrong, _ in Solenoid(opening_curve=np.array([[0.0, 0.0], [1e-3, 0.5]])).faults()]
        ['does not rise from 0 to 1']
        """
        if len(self.opening_curve):
            time, opening = self.opening_curve.T
            if time[0] < 0.0 or opening[0] != 0.0 or opening[-1] != 1.0 or np.any(np.diff(opening) < 0.0):
                right = "opening 0 in the first row (time >= 0), 1 in the last, never falling"
                yield "opening_curve", "does not rise from 0 to 1", right

    def overruled(self) -> Iterator[tuple[str, str]]:
        """Find keys that are not used because the opening curve is given.

        Yields
        ------
        key, reason : str
            Key, and what is used in its place.

        Examples
        --------
        >>> list(Solenoid().overruled())
        []
        """
        if len(self.opening_curve):
            yield from ((key, "valve.solenoid.opening_curve is given") for key in ("dead_time", "ramp_time"))


def opening_curve(solenoid: Solenoid) -> np.ndarray:
    """Return the energised fraction over the time after a switch.

    Without a measured curve it is 0 up to the dead time, then a linear ramp to 1.

    Parameters
    ----------
    solenoid : Solenoid
        Parameters of the solenoid valves.

    Returns
    -------
    (j, 2) float array
        Time after the switch [s] and fraction, linear in between.

    Notes
    -----
    A catalogue's shifting time (ISO 12238 [1]_) runs from the signal to a change of the pressure behind the valve. It
    is longer than the dead time here, at which the valve begins to open.

    References
    ----------
    .. [1] ISO 12238:2023, "Pneumatic fluid power - Directional control valves - Measurement of shifting time".

    Examples
    --------
    >>> opening_curve(Solenoid(dead_time=1.5e-3, ramp_time=1.5e-3)).tolist()
    [[0.0015, 0.0], [0.003, 1.0]]
    """
    if len(solenoid.opening_curve):
        return np.ascontiguousarray(solenoid.opening_curve)
    dead, ramp = solenoid.dead_time, solenoid.ramp_time
    return np.array([[dead, 0.0], [dead + ramp, 1.0]])


def shifted(curve: np.ndarray, time: float) -> np.ndarray:
    """Return an opening curve that comes later, or earlier, but not before the switch.

    Parameters
    ----------
    curve : (j, 2) float array
        Opening curve, see `opening_curve`.
    time : float
        Delay; negative: earlier [s].

    Returns
    -------
    (j, 2) float array
        Shifted curve.

    Examples
    --------
    >>> shifted(np.array([[1.0, 0.0], [2.0, 1.0]]), -3.0).tolist()
    [[0.0, 0.0], [1.0, 1.0]]
    """
    return curve + np.array([max(time, -curve[0, 0]), 0.0])


@kernel
def followed(curve: np.ndarray, lag: float) -> float:
    """Return how far a solenoid has followed a switch.

    Parameters
    ----------
    curve : (j, 2) float array
        Opening curve, see `opening_curve`.
    lag : float
        Time since the switch [s].

    Returns
    -------
    float
        Fraction, 0...1.

    Examples
    --------
    >>> float(followed(np.array([[1.0, 0.0], [2.0, 1.0]]), 1.25))
    0.25
    """
    last = curve.shape[0] - 1
    if lag <= curve[0, 0]:
        return curve[0, 1]
    if lag >= curve[last, 0]:
        return curve[last, 1]
    i = 0
    while lag > curve[i + 1, 0]:
        i += 1
    share = (lag - curve[i, 0]) / (curve[i + 1, 0] - curve[i, 0])
    return curve[i, 1] + share * (curve[i + 1, 1] - curve[i, 1])


@kernel
def energised_fraction(edges: np.ndarray, period: float, curve: np.ndarray, t: float) -> float:
    """Return the energised fraction x(t): the sum of the ramps of all past edges, clipped to 0...1.

    The law is chosen: an edge that comes before the last ramp has ended acts on top of it.

    Parameters
    ----------
    edges : (n,) float array
        Times of the edges energise, release, energise, ..., ascending [s].
    period : float
        Period at which they repeat for ever, in the past too [s]; inf: they happen once.
    curve : (j, 2) float array
        How the solenoid follows a switch, see `opening_curve`.
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
    >>> [float(energised_fraction(np.array([0.0, 10.0]), inf, curve, t)) for t in (0.5, 1.25, 5.0, 11.75)]
    [0.0, 0.25, 1.0, 0.25]
    """
    end = curve[curve.shape[0] - 1, 0]
    nearest = inf
    x = 0.0
    missing = 0.0
    sign = 1.0
    for edge in edges:
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
    return min(1.0, max(0.0, x - missing))


def breakpoints_of(edges: np.ndarray, period: float, delays: np.ndarray, start: float, end: float) -> np.ndarray:
    """Return the times at which an edge happens or an energised fraction has a corner.

    Parameters
    ----------
    edges : (n,) float array
        Times of the edges [s].
    period : float
        Period at which they repeat [s]; inf: they happen once.
    delays : (j,) float array
        Times from an edge to the corners of the curves that follow it [s].
    start, end : float
        Stretch of time that is looked at [s].

    Returns
    -------
    (m,) float array
        Ascending, after start and up to end, end itself included [s].

    Examples
    --------
    >>> breakpoints_of([0.0, 10.0], inf, np.array([1.0, 2.0]), 0.0, 20.0).tolist()
    [1.0, 2.0, 10.0, 11.0, 12.0, 20.0]
    """
    times = (np.asarray(edges)[:, None] + np.append(0.0, delays)).ravel()
    if period < inf:
        first = np.floor((start - times) / period) * period
        turns = np.arange(int((end - start) / period) + 3) * period
        times = ((times + first)[:, None] + turns).ravel()
    return np.unique(np.append(times[(times > start) & (times < end)], end))
