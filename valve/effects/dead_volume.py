"""Volume of each chamber that the machine file leaves out: bores, fittings, sensors."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity


class DeadVolume(NamedTuple):
    """A volume more in each chamber."""

    volume: Annotated[float, Quantity("mm^3", 0, 5000, "bores and fittings of a pressure sensor")] = 0.0


def adjust(effect, actuator, tables):
    """Enlarge the clearance volume of both chambers.

    Parameters
    ----------
    effect : DeadVolume
    actuator : apesim.valve.actuator.Actuator
    tables : apesim.valve.actuator.ActuatorTables

    Returns
    -------
    apesim.valve.actuator.Actuator, apesim.valve.actuator.ActuatorTables
    """
    valve = actuator.valve
    valve = valve._replace(clearance_volume=valve.clearance_volume + effect.volume)
    return actuator._replace(valve=valve), tables


EFFECT = Effect(
    "dead_volume",
    DeadVolume,
    equation="V_A,B = V_A,B + volume",
    source="paper, Eq. 6",
    seen_in="delay and flight; confused with the effective area",
    isolated_by="filling a chamber with liquid, or a discharge test at both ends of the stroke",
    adjust=adjust,
)
