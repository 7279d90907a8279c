"""Solenoid A follows later than solenoid B."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.valve.solenoid import shifted


class SolenoidADelay(NamedTuple):
    """A delay of solenoid A alone."""

    time: Annotated[float, Quantity("ms", -1, 1, "scatter of switching times of like valves")] = 0.0


def adjust(effect, actuator, tables):
    """Shift solenoid A's opening curve in time; not to before the command.

    Parameters
    ----------
    effect : SolenoidADelay
    actuator : apesim.valve.actuator.Actuator
    tables : apesim.valve.actuator.ActuatorTables

    Returns
    -------
    apesim.valve.actuator.Actuator, apesim.valve.actuator.ActuatorTables
    """
    return actuator, tables._replace(curve_a=shifted(tables.curve_a, effect.time))


EFFECT = Effect(
    "solenoid_a_delay",
    SolenoidADelay,
    equation="x_A(t) = x(t - time)",
    source="normally open and normally closed valves differ in their springs",
    seen_in="start of the pressure change in chamber A; confused with a delay of solenoid B",
    isolated_by="both chamber pressures against the coil current",
    adjust=adjust,
)
