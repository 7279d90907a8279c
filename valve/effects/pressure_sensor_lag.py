"""Pressure sensors that lag."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.reading import lagging


class PressureSensorLag(NamedTuple):
    """A lag of first order, the same in all pressure channels."""

    time: Annotated[float, Quantity("ms", 0, 0.5, "a tapping hole and an amplifier of 300 Hz and more")] = 0.0


def sensor(effect, reading):
    """Let every pressure lag, those of the chambers as well as the cylinder's and the receiver's.

    Parameters
    ----------
    effect : PressureSensorLag
    reading : apesim.reading.Reading

    Returns
    -------
    apesim.reading.Reading
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
