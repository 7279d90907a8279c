"""Volume of each chamber that the machine file leaves out: bores, fittings, sensors."""

from operator import add
from typing import TYPE_CHECKING, Annotated, NamedTuple

from apesim.effect import Effect, Misstated, Search
from apesim.quantities import Quantity

if TYPE_CHECKING:
    from apesim.valve.actuator import Actuator, ActuatorTables


class DeadVolume(NamedTuple):
    """A volume more in each chamber."""

    volume: Annotated[float, Quantity("mm^3", 0, 20000, "bores, fittings and hoses of a pressure sensor")] = 0.0


def adjust(effect: DeadVolume, actuator: "Actuator", tables: "ActuatorTables") -> tuple["Actuator", "ActuatorTables"]:
    """Enlarge the clearance volume of both chambers, ``V_c = V_c + volume``.

    V_c is the clearance volume of Table 1 of the EPV paper (doi 10.1631/jzus.A0820373).

    Parameters
    ----------
    effect : DeadVolume
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
    >>> adjusted, _ = adjust(DeadVolume(volume=1000e-9), actuator, tables)
    >>> round((adjusted.valve.clearance_volume - actuator.valve.clearance_volume) * 1e9, 6)
    1000.0
    """
    valve = actuator.valve
    valve = valve._replace(clearance_volume=valve.clearance_volume + effect.volume)
    return actuator._replace(valve=valve), tables


EFFECT = Effect(
    "dead_volume",
    DeadVolume,
    equation="V_A,B = V_A,B + volume",
    source="EPV paper (doi 10.1631/jzus.A0820373), Table 1: the clearance volume",
    seen_in="delay and flight; confused with the effective area",
    isolated_by="filling a chamber with liquid, or a discharge test at both ends of the stroke",
    adjust=adjust,
    search=Search(misstated=(Misstated("valve.clearance_volume", add),)),
)
