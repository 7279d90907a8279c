"""Solenoid B follows later than solenoid A."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.valve.solenoid import shifted


class SolenoidBDelay(NamedTuple):
    """A delay of solenoid B alone."""

    time: Annotated[float, Quantity("ms", -1, 1, "scatter of switching times of like valves")] = 0.0


def adjust(effect, actuator, tables):
    """Shift solenoid B's opening curve in time; not to before the command.

    Parameters
    ----------
    effect : SolenoidBDelay
    actuator : apesim.valve.actuator.Actuator
    tables : apesim.valve.actuator.ActuatorTables

    Returns
    -------
    apesim.valve.actuator.Actuator, apesim.valve.actuator.ActuatorTables
    """
    return actuator, tables._replace(curve_b=shifted(tables.curve_b, effect.time))


EFFECT = Effect(
    "solenoid_b_delay",
    SolenoidBDelay,
    equation="x_B(t) = x(t - time)",
    source="normally open and normally closed valves differ in their springs",
    seen_in="start of the pressure change in chamber B; confused with a delay of solenoid A",
    isolated_by="both chamber pressures against the coil current",
    adjust=adjust,
)
