"""What sensors show of a run, as a function of the time that is asked for.

An effect of the measurement has the slot ``sensor``: from its parameters and a reading it makes another reading, and
no march knows of it. Time is the model's, from the energising on; what an engine does repeats for ever.
"""

from collections.abc import Callable
from math import nan
from typing import NamedTuple

import numpy as np

LAG_STEP = 1e-5
"""Time between the instants at which a lagging sensor is followed [s]; chosen, below the time between two samples."""
LAG_MEMORY = 25.0
"""Time constants after which a lag has forgotten what was before: exp(-25) is 1.4e-11."""


class Reading(NamedTuple):
    """Run as sensors see it."""

    at: Callable
    """Function from (n,) times [s] to a dict of channels: (n,) arrays, and numbers for means; SI."""
    speed: float = nan
    """Speed of an engine's crank, as recorded [rad/s]; NaN on a valve's bench, whose record stands over time."""
    start: float = nan
    """Recorded crank angle at time 0 [rad]."""


def moved(reading: Reading, instants: Callable[[np.ndarray], np.ndarray]) -> Reading:
    """Return a reading whose records are taken at other times, as sensors with another clock show them.

    `instants` maps recorded times (n,) [s] to those at which the recorded happened.
    """
    return reading._replace(at=lambda times: reading.at(instants(times)))


def lagging(reading: Reading, names: Callable[[str], bool], lag: float) -> Reading:
    """Return a reading some of whose channels lag, ``lag dy/dt = x - y``.

    It is the law of an instrument of the first order [1]_ with the input x, the output y and the time constant lag.

    Parameters
    ----------
    reading : Reading
        What the sensors show.
    names : callable
        Function from the name of a channel to whether it lags.
    lag : float
        Time constant [s].

    Returns
    -------
    Reading
        What lagging sensors show.

    References
    ----------
    .. [1] E. O. Doebelin, "Measurement Systems: Application and Design", McGraw-Hill, section 3.3.

    Examples
    --------
    A ramp is recorded one time constant late:

    >>> reading = Reading(at=lambda times: {"lift": times})
    >>> late = lagging(reading, lambda name: name == "lift", 1e-3).at(np.array([0.1]))
    >>> late["lift"].round(9).tolist()
    [0.099]
    """

    def at(times: np.ndarray) -> dict[str, np.ndarray]:
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


def followed(values: np.ndarray, lag: float) -> np.ndarray:
    """Return what lags a signal that is linear between its instants, `LAG_STEP` apart, and had rested before the first.

    Each stretch adds the exact answer of an instrument of the first order [1]_ to a ramp.

    Parameters
    ----------
    values : (n,) float array
        Signal.
    lag : float
        Time constant [s].

    Returns
    -------
    (n,) float array
        Lagging signal.

    References
    ----------
    .. [1] E. O. Doebelin, "Measurement Systems: Application and Design", McGraw-Hill, section 3.3.

    Examples
    --------
    A step within 0.01 ms, seen by a time constant of 0.01 ms: 1 - (1 - exp(-1)) = exp(-1)

    >>> followed(np.array([0.0, 1.0]), 1e-5).round(4).tolist()
    [0.0, 0.3679]
    """
    from scipy.signal import lfilter  # here, as few runs have a lagging sensor

    kept, rise = float(np.exp(-LAG_STEP / lag)), values - values[0]
    drive = stepped(0.0, rise[:-1], rise[1:], LAG_STEP, lag)
    return values[0] + np.append(0.0, lfilter([1.0], [1.0, -kept], drive))  # y_(n+1) = kept y_n + drive_n


def stepped(
    y: np.ndarray | float, first: np.ndarray, last: np.ndarray, time: np.ndarray | float, lag: float
) -> np.ndarray:
    """Return what lags a signal at the end of a straight stretch, the exact solution of ``lag dy/dt = x - y``.

    It is the answer of an instrument of the first order [1]_ to a step and a ramp:
    ``y(t) = x(t) - behind + (y_0 - x_0 + behind) exp(-t/lag)``, with behind = lag dx/dt.

    Parameters
    ----------
    y : (n,) float array or float
        Lagging signal at the beginning of the stretch.
    first, last : (n,) float array
        Signal at the ends of the stretch.
    time : (n,) float array or float
        Length of the stretch [s].
    lag : float
        Time constant [s].

    Returns
    -------
    (n,) float array
        Lagging signal at the end of the stretch.

    References
    ----------
    .. [1] E. O. Doebelin, "Measurement Systems: Application and Design", McGraw-Hill, section 3.3.

    Examples
    --------
    A constant signal is approached by 1 - exp(-1) in one time constant:

    >>> stepped(0.0, np.array([1.0]), np.array([1.0]), 1e-3, 1e-3).round(4).tolist()
    [0.6321]
    """
    behind = (last - first) * np.where(time > 0.0, lag / np.maximum(time, 1e-300), 0.0)  # of a ramp
    return last - behind + (y - first + behind) * np.exp(-time / lag)
