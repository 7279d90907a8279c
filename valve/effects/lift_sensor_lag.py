"""A lift sensor that lags."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.reading import Reading, lagging


class LiftSensorLag(NamedTuple):
    """A lag of first order."""

    time: Annotated[float, Quantity("ms", 0, 0.5, "an eddy-current sensor, filtered at 300 Hz and more")] = 0.0


def sensor(effect: LiftSensorLag, reading: Reading) -> Reading:
    """Let the recorded lift lag, ``time dy/dt = lift - y``.

    It is the law of an instrument of the first order [1]_.

    Parameters
    ----------
    effect : LiftSensorLag
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
    A lift that rises at 1 m/s is recorded one time constant late:

    >>> import numpy as np
    >>> reading = Reading(at=lambda times: {"lift": times})
    >>> lagging = sensor(LiftSensorLag(time=0.2e-3), reading)
    >>> (lagging.at(np.array([10e-3]))["lift"] * 1e3).round(3).tolist()
    [9.8]
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
