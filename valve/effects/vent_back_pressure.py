"""Back pressure behind the vents: silencers, long lines."""

from typing import TYPE_CHECKING, Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity

if TYPE_CHECKING:
    from apesim.valve.actuator import Actuator, ActuatorTables


class VentBackPressure(NamedTuple):
    """A pressure above ambient behind the vents of both solenoids."""

    pressure: Annotated[float, Quantity("kPa", 0, 30, "a clogged silencer")] = 0.0


def adjust(
    effect: VentBackPressure, actuator: "Actuator", tables: "ActuatorTables"
) -> tuple["Actuator", "ActuatorTables"]:
    """Raise the pressure behind the vents, ``p_vent = p_0 + pressure``; air that comes back keeps ambient temperature.

    Restrictions in series are ISO 6358-3 [1]_; a constant pressure in place of one is chosen.

    Parameters
    ----------
    effect : VentBackPressure
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
    .. [1] ISO 6358-3:2014, "Pneumatic fluid power - Determination of flow-rate characteristics of components using
       compressible fluids - Part 3: Method for calculating steady-state flow-rate characteristics of systems".

    Examples
    --------
    >>> import apesim
    >>> from apesim.valve.actuator import actuator_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> adjust(VentBackPressure(pressure=1e4), actuator, tables)[0].vent_pressure - actuator.vent_pressure
    10000.0
    """
    return actuator._replace(vent_pressure=actuator.vent_pressure + effect.pressure), tables


EFFECT = Effect(
    "vent_back_pressure",
    VentBackPressure,
    equation="p_vent = p_0 + pressure",
    source="ISO 6358-3: restrictions in series, here as a constant pressure",
    seen_in="tail of the venting chamber; chamber pressure at rest",
    isolated_by="chamber pressures after a long dwell, with and without silencers",
    adjust=adjust,
)
