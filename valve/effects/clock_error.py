"""Record whose clock is fast or slow."""

from math import isnan
from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.reading import Reading, moved


class ClockError(NamedTuple):
    """A share by which recorded times are too long."""

    share: Annotated[float, Quantity("", -0.05, 0.05, "a sampling rate that is stated to two digits")] = 0.0


def sensor(effect: ClockError, reading: Reading) -> Reading:
    """Record all channels of a valve's bench by a clock that is fast, ``recorded(t) = x(t / (1 + share))``.

    The record of an engine stands over the crank angle and has no clock: it stays as it is.

    A constant share is chosen: an oscillator keeps its rate over a record.

    Parameters
    ----------
    effect : ClockError
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
    >>> sensor(ClockError(share=0.01), reading).at(np.array([101e-3]))["time"].round(9).tolist()
    [0.1]
    """
    return moved(reading, lambda times: times / (1.0 + effect.share)) if isnan(reading.speed) else reading


EFFECT = Effect(
    "clock_error",
    ClockError,
    equation="recorded(t) = x(t / (1 + share)), on a valve's bench",
    source="chosen",
    seen_in="all channels, the more the later; confused with a late release if all pulses are alike; never physics",
    isolated_by="pulses of very different length, or the solenoids' current on a channel of its own",
    sensor=sensor,
)
