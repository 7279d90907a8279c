"""Sensors whose gain is not the one that was taken for it."""

from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, Search
from apesim.quantities import Quantity
from apesim.reading import Reading

SHARE = Quantity("", -0.2, 0.2, "calibration: 0.01 to 0.02")
"""Declaration of a share by which a channel reads more."""


class SensorGain(NamedTuple):
    """Shares by which channels read more; of the supply it is what a measured run states of it, above ambient."""

    lift: Annotated[float, SHARE] = 0.0
    pressure_a: Annotated[float, SHARE] = 0.0
    pressure_b: Annotated[float, SHARE] = 0.0
    cylinder_pressure: Annotated[float, SHARE] = 0.0
    torque: Annotated[float, SHARE] = 0.0
    air_flow: Annotated[float, SHARE] = 0.0
    supply_pressure: Annotated[float, SHARE] = 0.0
    force: Annotated[float, SHARE] = 0.0


def sensor(effect: SensorGain, reading: Reading) -> Reading:
    """Scale the recorded channels, ``recorded = (1 + share) x``; pressures as absolute ones.

    It is an error of the static calibration [1]_.

    Parameters
    ----------
    effect : SensorGain
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
    >>> scaled = sensor(SensorGain(lift=0.02), reading).at(np.array([0.1]))
    >>> (scaled["lift"] * 1e3).round(6).tolist(), scaled["pressure_a"].round(6).tolist()
    ([1.02], [100000.0])
    """
    shares = effect._asdict()

    def at(times: np.ndarray) -> dict[str, np.ndarray]:
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
    search=Search(is_nuisance=True),
)
