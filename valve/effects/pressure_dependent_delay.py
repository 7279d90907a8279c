"""Solenoids whose delay depends on the pressure that they work against."""

from typing import TYPE_CHECKING, Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Pressure, Quantity
from apesim.valve.solenoid import shifted

if TYPE_CHECKING:
    from apesim.valve.actuator import Actuator, ActuatorTables


class PressureDependentDelay(NamedTuple):
    """A delay of both solenoids, proportional to the control pressure above a reference."""

    slope: Annotated[float, Quantity("ms/MPa", -2.5, 2.5, "plungers against a seat of some square millimetres")] = 0.0
    reference: Annotated[
        float, Pressure(0.02, 30, "at which the machine's own delay holds: 0.4 MPa gauge", show="gauge")
    ] = 0.501325e6


def adjust(
    effect: PressureDependentDelay, actuator: "Actuator", tables: "ActuatorTables"
) -> tuple["Actuator", "ActuatorTables"]:
    """Shift both solenoids in time with the control pressure, but not to before the command.

    ``x(t) = x(t - slope (p_c - reference))``; the line over the pressure is chosen, after the force balance of a
    plunger.

    Parameters
    ----------
    effect : PressureDependentDelay
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

    Examples
    --------
    0.6 MPa above the reference, 1 ms/MPa:

    >>> import apesim
    >>> from apesim.valve.actuator import actuator_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> effect = PressureDependentDelay(slope=1e-9, reference=actuator.control_pressure - 0.6e6)
    >>> _, later = adjust(effect, actuator, tables)
    >>> ((later.curves_a.release - tables.curves_a.release)[:, 0] * 1e3).round(6).tolist()
    [0.6, 0.6]
    """
    time = effect.slope * (actuator.control_pressure - effect.reference)
    a, b = (curves.changed(lambda curve: shifted(curve, time)) for curves in (tables.curves_a, tables.curves_b))
    return actuator, tables._replace(curves_a=a, curves_b=b)


EFFECT = Effect(
    "pressure_dependent_delay",
    PressureDependentDelay,
    equation="x(t) = x(t - slope (p_c - reference))",
    source="force balance of a direct-acting plunger: the coil's current has to rise further against a higher pressure",
    seen_in="delay at one pressure against that at another; needs two pressures",
    isolated_by="start of the pressure change against the coil current, at three supply pressures",
    adjust=adjust,
)
