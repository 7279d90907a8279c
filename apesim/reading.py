"""What sensors show of a run, as a function of the time that is asked for.

An effect of the measurement has the slot ``sensor``: from its parameters and a reading it makes another reading, and
no march knows of it. Time is the model's, from the energising on; what an engine does repeats for ever.
"""

from collections.abc import Callable
from itertools import accumulate
from math import nan
from typing import NamedTuple

import numpy as np

LAG_STEP = 1e-5
"""Between the instants at which a lagging sensor is followed [s]."""
LAG_MEMORY = 25.0
"""Time constants after which a lag has forgotten what was before."""


class Reading(NamedTuple):
    """A run as sensors see it."""

    at: Callable
    """From (n,) times [s] to a dict of channels: (n,) arrays, and numbers for means; SI."""
    speed: float = nan
    """Of an engine's crank, as recorded [rad/s]; NaN on a valve's bench, whose record stands over time."""
    start: float = nan
    """Its recorded crank angle at time 0 [rad]."""


def moved(reading, instants):
    """A reading whose records are taken at other times.

    Parameters
    ----------
    reading : Reading
    instants : callable
        From recorded times to those at which the recorded happened, (n,) arrays [s].

    Returns
    -------
    Reading
    """
    return reading._replace(at=lambda times: reading.at(instants(times)))


def lagging(reading, names, lag):
    """A reading whose channels of some names lag: ``lag dy/dt = x - y``.

    Parameters
    ----------
    reading : Reading
    names : callable
        Whether a channel's name is one of them.
    lag : float
        Time constant [s].

    Returns
    -------
    Reading
    """

    def at(times):
        if not len(times):
            return reading.at(times)
        first = times.min() - LAG_MEMORY * lag
        fine = np.arange(first, times.max(), LAG_STEP)
        before = np.minimum(((times - first) / LAG_STEP).astype(int), len(fine) - 1)
        instants, asked = np.unique(np.concatenate([fine, times]), return_inverse=True)
        channels = {}
        for name, values in reading.at(instants).items():
            if np.ndim(values):
                grid, values = np.split(values[asked], [len(fine)])
                if names(name):
                    y = followed(grid, lag)
                    values = stepped(y[before], grid[before], values, times - fine[before], lag)
            channels[name] = values
        return channels

    return reading._replace(at=at)


def followed(values, lag):
    """What lags a signal that is linear between its instants, `LAG_STEP` apart, and had rested before the first.

    Parameters
    ----------
    values : (n,) float array
    lag : float
        Time constant [s].

    Returns
    -------
    (n,) float array
    """
    kept, rise = float(np.exp(-LAG_STEP / lag)), values - values[0]
    drive = stepped(0.0, rise[:-1], rise[1:], LAG_STEP, lag)
    return values[0] + np.array(list(accumulate(drive.tolist(), lambda y, x: kept * y + x, initial=0.0)))


def stepped(y, first, last, time, lag):
    """What lags a signal at the end of a straight stretch.

    Parameters
    ----------
    y : (n,) float array or float
        The lagging at its beginning.
    first, last : (n,) float array
        The signal at its ends.
    time : (n,) float array or float
        That it takes [s].
    lag : float
        Time constant [s].

    Returns
    -------
    (n,) float array
    """
    behind = (last - first) * np.where(time > 0.0, lag / np.maximum(time, 1e-300), 0.0)  # of a ramp
    return last - behind + (y - first + behind) * np.exp(-time / lag)
