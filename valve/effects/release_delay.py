"""Solenoids that let go later than they pull in."""

from typing import TYPE_CHECKING, Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.valve.solenoid import shifted

if TYPE_CHECKING:
    from apesim.valve.actuator import Actuator, ActuatorTables


class ReleaseDelay(NamedTuple):
    """A delay of both solenoids, as they are released alone."""

    time: Annotated[
        float, Quantity("ms", -1, 2, "a diode across the coil holds its current for some milliseconds; chosen")
    ] = 0.0


def adjust(effect: ReleaseDelay, actuator: "Actuator", tables: "ActuatorTables") -> tuple["Actuator", "ActuatorTables"]:
    """Shift both solenoids in time as they are released, ``f_r(t) = f_r(t - time)``, but not to before the command.

    f_r is the share of the way back over the time t after a release [1]_. A coil's current does not stop with its
    voltage: a diode across it lets the current fade with the coil's own time constant. A pure delay is chosen.

    Parameters
    ----------
    effect : ReleaseDelay
        Parameters of the effect.
    actuator : apesim.valve.actuator.Actuator
        Valve as the kernels take it.
    tables : apesim.valve.actuator.ActuatorTables
        Arrays of the valve.

    Returns
    -------
    apesim.valve.actuator.Actuator
        Valve with the effect.
    apesim.valve.actuator.ActuatorTables
        Arrays with the effect.

    References
    ----------
    .. [1] ISO 12238:2023, "Pneumatic fluid power - Directional control valves - Measurement of shifting time", which
       gives a time for energising and one for release.

    Examples
    --------
    >>> import apesim
    >>> from apesim.valve.actuator import actuator_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> _, later = adjust(ReleaseDelay(time=0.5e-3), actuator, tables)
    >>> [((after - before)[:, 0] * 1e3).round(6).tolist() for after, before in zip(later.curves_a, tables.curves_a)]
    [[0.0, 0.0], [0.5, 0.5]]
    """
    a, b = (
        curves._replace(release=shifted(curves.release, effect.time)) for curves in (tables.curves_a, tables.curves_b)
    )
    return actuator, tables._replace(curves_a=a, curves_b=b)


EFFECT = Effect(
    "release_delay",
    ReleaseDelay,
    equation="f_r(t) = f_r(t - time), f_r the share of the way back after a release",
    source="ISO 12238: times to switch on and to switch off differ; the coil's current fades through its diode",
    seen_in="closing against opening; confused with the rate of the recorder's clock if all pulses are alike",
    isolated_by="pulses of two lengths, one three times the other, or the coil current on a channel of its own",
    adjust=adjust,
)
