"""Back pressure behind the vents: silencers, long lines."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity


class VentBackPressure(NamedTuple):
    """A pressure above ambient behind the vents of both solenoids."""

    pressure: Annotated[float, Quantity("kPa", 0, 30, "a clogged silencer")] = 0.0


def adjust(effect, actuator, tables):
    """Raise the pressure behind the vents; air that comes back keeps ambient temperature.

    Parameters
    ----------
    effect : VentBackPressure
    actuator : apesim.valve.actuator.Actuator
    tables : apesim.valve.actuator.ActuatorTables

    Returns
    -------
    apesim.valve.actuator.Actuator, apesim.valve.actuator.ActuatorTables
    """
    return actuator._replace(vent_pressure=actuator.vent_pressure + effect.pressure), tables


EFFECT = Effect(
    "vent_back_pressure",
    VentBackPressure,
    equation="p_vent = p_0 + pressure",
    source="ISO 6358-1: an exhaust restriction in series, as a constant pressure",
    seen_in="tail of the venting chamber; chamber pressure at rest",
    isolated_by="chamber pressures after a long dwell, with and without silencers",
    adjust=adjust,
)
