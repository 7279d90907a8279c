"""Record whose time does not begin as the solenoids are energised."""

from math import isnan
from typing import Annotated, NamedTuple

from apesim.effect import Effect, Search
from apesim.quantities import Quantity
from apesim.reading import Reading, moved


class TimeZero(NamedTuple):
    """A time by which the record is late."""

    time: Annotated[float, Quantity("ms", -1, 1, "a trigger beside the solenoids' current")] = 0.0


def sensor(effect: TimeZero, reading: Reading) -> Reading:
    """Record all channels of a valve's bench late, ``recorded(t) = x(t - time)``.

    The record of an engine stands over the crank angle and has no zero of time: it stays as it is.

    A constant time is chosen.

    Parameters
    ----------
    effect : TimeZero
        Parameters of the effect.
    reading : apesim.reading.Reading
        What the sensors would record without the effect.

    Returns
    -------
    apesim.reading.Reading
        What they record with it.

    Examples
    --------
    >>> import numpy as np
    >>> reading = Reading(at=lambda times: {"time": times})
    >>> sensor(TimeZero(time=0.5e-3), reading).at(np.array([2e-3]))["time"].round(9).tolist()
    [0.0015]
    """
    return moved(reading, lambda times: times - effect.time) if isnan(reading.speed) else reading


EFFECT = Effect(
    "time_zero",
    TimeZero,
    equation="recorded(t) = x(t - time), on a valve's bench",
    source="chosen",
    seen_in="all channels of all runs alike; confused with the solenoids' dead time",
    isolated_by="the solenoids' current on a channel of its own",
    sensor=sensor,
    search=Search(is_nuisance=True),
)
