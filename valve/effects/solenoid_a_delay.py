"""Solenoid A follows later than solenoid B."""

from typing import TYPE_CHECKING, Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity
from apesim.valve.solenoid import shifted

if TYPE_CHECKING:
    from apesim.valve.actuator import Actuator, ActuatorTables


class SolenoidADelay(NamedTuple):
    """A delay of solenoid A alone."""

    time: Annotated[float, Quantity("ms", -1, 1, "scatter of switching times of like valves")] = 0.0


def adjust(
    effect: SolenoidADelay, actuator: "Actuator", tables: "ActuatorTables"
) -> tuple["Actuator", "ActuatorTables"]:
    """Shift solenoid A in time at both edges, ``x_A(t) = x(t - time)``, but not to before the command.

    A pure delay is chosen; x is the energised fraction.

    Parameters
    ----------
    effect : SolenoidADelay
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
    >>> import apesim
    >>> from apesim.valve.actuator import actuator_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> _, later = adjust(SolenoidADelay(time=0.5e-3), actuator, tables)
    >>> ((later.curves_a.release - later.curves_b.release)[:, 0] * 1e3).round(6).tolist()
    [0.5, 0.5]
    """
    return actuator, tables._replace(curves_a=tables.curves_a.changed(lambda curve: shifted(curve, effect.time)))


EFFECT = Effect(
    "solenoid_a_delay",
    SolenoidADelay,
    equation="x_A(t) = x(t - time)",
    source="normally open and normally closed valves differ in their springs",
    seen_in="start of the pressure change in chamber A; confused with a delay of solenoid B",
    isolated_by="both chamber pressures against the coil current",
    adjust=adjust,
)
