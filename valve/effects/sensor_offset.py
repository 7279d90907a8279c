"""Sensors whose zero is not the one that was taken for it."""

from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, Search
from apesim.quantities import Quantity
from apesim.reading import Reading

PRESSURE = Quantity("kPa", -100, 100, "drift of the zero: 1 to 5 kPa")
"""Declaration of a pressure by which a channel reads more."""


class SensorOffset(NamedTuple):
    """What channels read more, each in its own unit; of the supply it is what a measured run states of it."""

    lift: Annotated[float, Quantity("mm", -2, 2, "mounting: 0.02 to 0.1 mm")] = 0.0
    pressure_a: Annotated[float, PRESSURE] = 0.0
    pressure_b: Annotated[float, PRESSURE] = 0.0
    cylinder_pressure: Annotated[float, PRESSURE] = 0.0
    torque: Annotated[float, Quantity("N m", -20, 20, "tare of the brake: 0.2 to 0.5 N m")] = 0.0
    air_flow: Annotated[float, Quantity("g/s", -20, 20, "zero of the meter: 0.05 to 0.2 g/s")] = 0.0
    supply_temperature: Annotated[float, Quantity("K", -50, 50, "thermocouple: 1 to 3 K")] = 0.0
    force: Annotated[float, Quantity("N", -100, 100, "tare of the load cell: 0.2 to 2 N")] = 0.0


def sensor(effect: SensorOffset, reading: Reading) -> Reading:
    """Shift the recorded channels, ``recorded = x + offset``.

    It is an error of the static calibration [1]_.

    Parameters
    ----------
    effect : SensorOffset
        Parameters of the effect.
    reading : apesim.reading.Reading
        What the sensors would record without the effect.

    Returns
    -------
    apesim.reading.Reading
        What they record with it.

    References
    ----------
    .. [1] E. O. Doebelin, "Measurement Systems: Application and Design", McGraw-Hill, section 3.2.

    Examples
    --------
    >>> import numpy as np
    >>> reading = Reading(at=lambda times: {"lift": 1e-3 + 0.0 * times, "pressure_a": 1e6 * times})
    >>> shifted = sensor(SensorOffset(pressure_a=2e3), reading).at(np.array([0.1]))
    >>> shifted["pressure_a"].round(6).tolist()
    [102000.0]
    """
    offsets = effect._asdict()

    def at(times: np.ndarray) -> dict[str, np.ndarray]:
        return {name: values + offsets.get(name, 0.0) for name, values in reading.at(times).items()}

    return reading._replace(at=at)


EFFECT = Effect(
    "sensor_offset",
    SensorOffset,
    equation="recorded = x + offset, of each channel",
    source="Doebelin, Measurement Systems, 3.2: static calibration",
    seen_in="one channel alone, the same at all times",
    isolated_by="known values at rest: the closed stop, ambient pressure, a free shaft",
    strengths=SensorOffset._fields,
    sensor=sensor,
    search=Search(is_nuisance=True),
)
