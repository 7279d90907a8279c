"""Sensors whose gain is not the one that was taken for it."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity

SHARE = Quantity("", -0.2, 0.2, "calibration: 0.01 to 0.02")


class SensorGain(NamedTuple):
    """Shares by which channels read more; of the supply it is what a measured run states of it, above ambient."""

    lift: Annotated[float, SHARE] = 0.0
    pressure_a: Annotated[float, SHARE] = 0.0
    pressure_b: Annotated[float, SHARE] = 0.0
    cylinder_pressure: Annotated[float, SHARE] = 0.0
    torque: Annotated[float, SHARE] = 0.0
    air_flow: Annotated[float, SHARE] = 0.0
    supply_pressure: Annotated[float, SHARE] = 0.0


def sensor(effect, reading):
    """Scale the channels, pressures as absolute ones.

    Parameters
    ----------
    effect : SensorGain
    reading : apesim.reading.Reading

    Returns
    -------
    apesim.reading.Reading
    """
    shares = effect._asdict()

    def at(times):
        return {name: values * (1.0 + shares.get(name, 0.0)) for name, values in reading.at(times).items()}

    return reading._replace(at=at)


EFFECT = Effect(
    "sensor_gain",
    SensorGain,
    equation="recorded = (1 + share) x, of each channel",
    source="Doebelin, Measurement Systems, 3.2: static calibration",
    seen_in="one channel alone, as a scale; lift: another stroke",
    isolated_by="known values: the stops, a dead-weight tester, a calibrated arm",
    strengths=SensorGain._fields,
    sensor=sensor,
)
