"""What sensors show of a run, as a function of the time that is asked for.

An effect of the measurement has the slot ``sensor``: from its parameters and a reading it makes another reading, and
no march knows of it. Time is the model's, from the energising on; what an engine does repeats for ever.
"""

from collections.abc import Callable
from math import nan
from typing import NamedTuple

import numpy as np

from apesim.kernel import kernel

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
        fine = np.arange(times.min() - LAG_MEMORY * lag, times.max(), LAG_STEP)
        instants = np.union1d(fine, times)
        asked = np.searchsorted(instants, times)
        channels = {}
        for name, values in reading.at(instants).items():
            if np.ndim(values):
                values = (followed(instants, values, lag) if names(name) else values)[asked]
            channels[name] = values
        return channels

    return reading._replace(at=at)


@kernel
def followed(times, values, lag):
    """What lags a signal that is linear between its instants, and had rested before the first of them.

    Parameters
    ----------
    times, values : (n,) float array
    lag : float
        Time constant [s].

    Returns
    -------
    (n,) float array
    """
    y = values.copy()
    for i in range(1, len(times)):
        h = times[i] - times[i - 1]
        kept = np.exp(-h / lag)
        behind = (values[i] - values[i - 1]) / h * lag  # of a ramp
        y[i] = values[i] - behind + (y[i - 1] - values[i - 1] + behind) * kept
    return y
