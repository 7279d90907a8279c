"""A record whose crank angle does not begin at top dead centre."""

from math import isnan
from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.reading import moved


class TdcError(NamedTuple):
    """An angle by which the record is late."""

    angle: Annotated[float, Quantity("deg", -2, 2, "a mark on the flywheel: 0.1 to 1 deg")] = 0.0


def sensor(effect, reading):
    """Record all channels at later crank angles; the solenoids are switched at the true ones.

    Parameters
    ----------
    effect : TdcError
    reading : apesim.reading.Reading

    Returns
    -------
    apesim.reading.Reading
    """
    return reading if isnan(reading.speed) else moved(reading, lambda times: times - effect.angle / reading.speed)


EFFECT = Effect(
    "tdc_error",
    TdcError,
    equation="recorded(phi) = x(phi - angle)",
    source="Heywood, Internal Combustion Engine Fundamentals, 9.2: phasing of pressure data",
    seen_in="phase of the cylinder pressure; work by its loop, not the brake's torque",
    isolated_by="a motored cycle, or a capacitive sensor of the top dead centre",
    sensor=sensor,
)
