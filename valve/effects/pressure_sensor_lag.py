"""Pressure sensors that lag."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.reading import Reading, lagging


class PressureSensorLag(NamedTuple):
    """A lag of first order, the same in all pressure channels."""

    time: Annotated[float, Quantity("ms", 0, 0.5, "a tapping hole and an amplifier of 300 Hz and more")] = 0.0


def sensor(effect: PressureSensorLag, reading: Reading) -> Reading:
    """Let every recorded pressure lag, ``time dy/dt = p - y``; those of the chambers, the cylinder and the receiver.

    It is the law of an instrument of the first order [1]_.

    Parameters
    ----------
    effect : PressureSensorLag
        Parameters of the effect.
    reading : apesim.reading.Reading
        What the sensors would record without the effect.

    Returns
    -------
    apesim.reading.Reading
        What they record with it.

    References
    ----------
    .. [1] E. O. Doebelin, "Measurement Systems: Application and Design", McGraw-Hill, section 3.3.

    Examples
    --------
    A pressure that rises by 1 kPa in a millisecond is recorded one time constant late:

    >>> import numpy as np
    >>> reading = Reading(at=lambda times: {"pressure_a": 1e6 * times})
    >>> lagging = sensor(PressureSensorLag(time=0.2e-3), reading)
    >>> lagging.at(np.array([10e-3]))["pressure_a"].round(3).tolist()
    [9800.0]
    """
    return lagging(reading, lambda name: "pressure" in name, effect.time)


EFFECT = Effect(
    "pressure_sensor_lag",
    PressureSensorLag,
    equation="time dy/dt = p - y, y is recorded",
    source="Doebelin, Measurement Systems, 3.3: first-order instruments",
    seen_in="pressures alone, late on every slope; never physics",
    isolated_by="a burst diaphragm, or a flush-mounted sensor beside it",
    sensor=sensor,
)
