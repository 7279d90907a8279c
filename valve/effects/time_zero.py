"""A record whose time does not begin as the solenoids are energised."""

from math import isnan
from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.reading import moved


class TimeZero(NamedTuple):
    """A time by which the record is late."""

    time: Annotated[float, Quantity("ms", -1, 1, "a trigger beside the solenoids' current")] = 0.0


def sensor(effect, reading):
    """Record all channels of a valve's bench late; an engine's stand over crank angle and have no zero of time.

    Parameters
    ----------
    effect : TimeZero
    reading : apesim.reading.Reading

    Returns
    -------
    apesim.reading.Reading
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
)
