"""Solenoids whose delay depends on the pressure that they work against."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Pressure, Quantity
from apesim.valve.solenoid import shifted


class PressureDependentDelay(NamedTuple):
    """A delay of both solenoids, proportional to the control pressure above a reference."""

    slope: Annotated[float, Quantity("ms/MPa", -2.5, 2.5, "plungers against a seat of some square millimetres")] = 0.0
    reference: Annotated[
        float, Pressure(0.02, 30, "at which the machine's own delay holds: 0.4 MPa gauge", show="gauge")
    ] = 0.501325e6


def adjust(effect, actuator, tables):
    """Shift both solenoids' opening curves by slope (p_c - reference); not to before the command.

    Parameters
    ----------
    effect : PressureDependentDelay
    actuator : apesim.valve.actuator.Actuator
    tables : apesim.valve.actuator.ActuatorTables

    Returns
    -------
    apesim.valve.actuator.Actuator, apesim.valve.actuator.ActuatorTables
    """
    time = effect.slope * (actuator.control_pressure - effect.reference)
    return actuator, tables._replace(curve_a=shifted(tables.curve_a, time), curve_b=shifted(tables.curve_b, time))


EFFECT = Effect(
    "pressure_dependent_delay",
    PressureDependentDelay,
    equation="x(t) = x(t - slope (p_c - reference))",
    source="force balance of a direct-acting plunger: the coil's current has to rise further against a higher pressure",
    seen_in="delay at one pressure against that at another; needs two pressures",
    isolated_by="start of the pressure change against the coil current, at three supply pressures",
    adjust=adjust,
)
