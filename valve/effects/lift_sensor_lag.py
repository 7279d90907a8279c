"""A lift sensor that lags."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.reading import lagging


class LiftSensorLag(NamedTuple):
    """A lag of first order."""

    time: Annotated[float, Quantity("ms", 0, 0.5, "an eddy-current sensor, filtered at 300 Hz and more")] = 0.0


def sensor(effect, reading):
    """Let the lift lag.

    Parameters
    ----------
    effect : LiftSensorLag
    reading : apesim.reading.Reading

    Returns
    -------
    apesim.reading.Reading
    """
    return lagging(reading, lambda name: name == "lift", effect.time)


EFFECT = Effect(
    "lift_sensor_lag",
    LiftSensorLag,
    equation="time dy/dt = lift - y, y is recorded",
    source="Doebelin, Measurement Systems, 3.3: first-order instruments",
    seen_in="lift alone, rounded at both contacts; never physics",
    isolated_by="a step of the target, or a second sensor on the same piston",
    sensor=sensor,
)
