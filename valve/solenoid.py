"""The two solenoid valves: when they are switched, and how far they have followed."""

from math import inf
from typing import Annotated, NamedTuple

import numpy as np

from apesim.kernel import kernel
from apesim.quantities import NO_CURVE, Curve, Quantity


class Solenoid(NamedTuple):
    """Two three-way solenoid valves, driven together."""

    effective_area: Annotated[
        float, Quantity("mm^2", 0.01, 500, "chosen: 0.72 of the paper's 4 mm bore; the paper prints no number")
    ] = 9.0e-6
    dead_time: Annotated[float, Quantity("ms", 0, 50, "chosen: a solenoid valve of 120 Hz")] = 1.5e-3
    ramp_time: Annotated[float, Quantity("ms", 0.001, 50, "chosen: a solenoid valve of 120 Hz")] = 1.5e-3
    opening_curve: Annotated[
        np.ndarray,
        Curve(("time [ms]", "opening [-]"), "a discharge test (Eq. 10); not given: dead time, then a linear ramp"),
    ] = NO_CURVE

    def faults(self):
        """Faults that no single key shows."""
        if len(self.opening_curve):
            time, opening = self.opening_curve.T
            if time[0] < 0.0 or opening[0] != 0.0 or opening[-1] != 1.0 or np.any(np.diff(opening) < 0.0):
                right = "opening 0 in the first row (time >= 0), 1 in the last, never falling"
                yield "opening_curve", "does not rise from 0 to 1", right

    def overruled(self):
        """Keys that are not looked at, and by what."""
        if len(self.opening_curve):
            yield from ((key, "valve.solenoid.opening_curve is given") for key in ("dead_time", "ramp_time"))


def opening_curve(solenoid):
    """The energised fraction after a switch.

    Parameters
    ----------
    solenoid : Solenoid

    Returns
    -------
    (j, 2) float array
        Time after the switch [s], fraction; linear in between.
    """
    if len(solenoid.opening_curve):
        return np.ascontiguousarray(solenoid.opening_curve)
    dead, ramp = solenoid.dead_time, solenoid.ramp_time
    return np.array([[dead, 0.0], [dead + ramp, 1.0]])


def shifted(curve, time):
    """A solenoid's opening curve, later by a time [s]; not to before the switch."""
    return curve + np.array([max(time, -curve[0, 0]), 0.0])


@kernel
def followed(curve, lag):
    """How far a solenoid has followed a switch that lies ``lag`` seconds back, 0...1."""
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
def energised_fraction(edges, period, curve, t):
    """Energised fraction x(t): the sum of the ramps of all past edges, clipped to 0...1.

    Parameters
    ----------
    edges : (n,) float array
        Energise, release, energise, ... ascending [s].
    period : float
        At which they repeat for ever, in the past too [s]; inf: they happen once.
    curve : (j, 2) float array
        How the solenoid follows a switch, see `opening_curve`.
    t : float
        [s]

    Returns
    -------
    float
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


def breakpoints_of(edges, period, delays, start, end):
    """Times at which an edge happens or a followed curve bends.

    Parameters
    ----------
    edges : (n,) float array
        [s]
    period : float
        At which they repeat [s]; inf: they happen once.
    delays : (j,) float array
        From an edge to the corners of the curves that follow it [s].
    start, end : float
        [s]

    Returns
    -------
    float array
        Ascending, after start and up to end, end itself included [s].
    """
    times = (np.asarray(edges)[:, None] + np.append(0.0, delays)).ravel()
    if period < inf:
        first = np.floor((start - times) / period) * period
        turns = np.arange(int((end - start) / period) + 3) * period
        times = ((times + first)[:, None] + turns).ravel()
    return np.unique(np.append(times[(times > start) & (times < end)], end))
