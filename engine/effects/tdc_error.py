"""Crank angle that is recorded from a point other than top dead centre."""

from math import isnan
from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.reading import Reading, moved


class TdcError(NamedTuple):
    """Angle by which the record is late."""

    angle: Annotated[float, Quantity("deg", -2, 2, "a mark on the flywheel: 0.1 to 1 deg")] = 0.0


def sensor(effect: TdcError, reading: Reading) -> Reading:
    """Record all channels at later crank angles; the solenoids are switched at the true ones.

    Heywood has more on the phase of pressure data [1]_.

    Parameters
    ----------
    effect : TdcError
        Parameters of the effect.
    reading : apesim.reading.Reading
        What the sensors would record without the effect.

    Returns
    -------
    apesim.reading.Reading
        What they record with it; without a speed, as on a bench, the same reading.

    References
    ----------
    .. [1] J. B. Heywood, "Internal Combustion Engine Fundamentals", McGraw-Hill, 1988, section 9.2.

    Examples
    --------
    A channel that shows the true angle reads 0.9 rad where the record says 1.0 rad:

    >>> import numpy as np
    >>> reading = Reading(at=lambda times: {"angle": 100.0 * times}, speed=100.0, start=0.0)
    >>> sensor(TdcError(angle=0.1), reading).at(np.array([0.01]))["angle"].round(9).tolist()
    [0.9]
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
