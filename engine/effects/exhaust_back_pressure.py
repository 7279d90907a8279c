"""Back pressure behind the exhaust valves: manifold, silencer, a turbine."""

from typing import TYPE_CHECKING, Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity

if TYPE_CHECKING:
    from apesim.engine.cycle.state import Cycle, CycleTables


class ExhaustBackPressure(NamedTuple):
    """A pressure above ambient behind the exhaust valves."""

    pressure: Annotated[float, Quantity("kPa", 0, 50, "a silencer; the second stage of a two-stage engine")] = 0.0


def adjust(effect: ExhaustBackPressure, cycle: "Cycle", tables: "CycleTables") -> tuple["Cycle", "CycleTables"]:
    """Raise the pressure behind all exhaust valves, ``p_e = p_0 + pressure``.

    Air that flows back keeps ambient temperature; p_0 is ambient pressure. The crank case stays at ambient pressure.
    Restrictions in series are ISO 6358-3 [1]_; a constant pressure in place of one is chosen.

    Parameters
    ----------
    effect : ExhaustBackPressure
        Parameters of the effect.
    cycle : apesim.engine.cycle.state.Cycle
        Machine at a speed, as numbers for the kernels.
    tables : apesim.engine.cycle.state.CycleTables
        Arrays of the machine.

    Returns
    -------
    cycle : apesim.engine.cycle.state.Cycle
        Machine with the effect.
    tables : apesim.engine.cycle.state.CycleTables
        Arrays of the machine with the effect.

    References
    ----------
    .. [1] ISO 6358-3:2014, "Pneumatic fluid power - Determination of flow-rate characteristics of components using
       compressible fluids - Part 3: Method for calculating steady-state flow-rate characteristics of systems".

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), speed=100.0)
    >>> adjust(ExhaustBackPressure(pressure=2e4), cycle, tables)[0].exhaust_pressure - cycle.exhaust_pressure
    20000.0
    """
    return cycle._replace(exhaust_pressure=cycle.exhaust_pressure + effect.pressure), tables


EFFECT = Effect(
    "exhaust_back_pressure",
    ExhaustBackPressure,
    equation="p_e = p_0 + pressure",
    source="ISO 6358-3: restrictions in series, here as a constant pressure",
    seen_in="cylinder pressure in the exhaust stroke, at any speed; confused with exhaust restriction",
    isolated_by="a pressure sensor behind the exhaust valve, or cylinder pressure in the exhaust stroke at two speeds",
    adjust=adjust,
)
