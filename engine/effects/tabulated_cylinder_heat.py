"""Heat into the cylinder as a table over the crank angle, for heat that no law of the library explains."""

from math import pi

import numpy as np

from apesim.cubic_table import interpolate_periodic, table
from apesim.effect import Effect, law
from apesim.engine.cylinder import ENERGY, HEAT, WALL_EXERGY, CylinderState
from apesim.exergy import heat_exergy
from apesim.kernel import kernel
from apesim.quantities import Quantity

PLACES = range(0, 360, 30)
"""Crank angles of the nodes [deg]."""

TabulatedCylinderHeat = table(
    "TabulatedCylinderHeat", __name__, share=(PLACES, Quantity("", -1, 1, "as much as the air holds, in a radian"))
)
TabulatedCylinderHeat.__doc__ = "Heat into the cylinder over the crank angle, as a share of p V times the speed."


@law.for_type(TabulatedCylinderHeat)
@kernel
def tabulated_cylinder_heat(effect: tuple[float, ...], state: CylinderState, balance: np.ndarray) -> None:
    """Add the heat that a table gives over the crank angle.

    ``Q = q(phi) p V omega``, with the share q at the crank angle phi, the pressure p, the volume V and the speed omega.
    The scale p V omega is chosen. The wall is not known; it counts as one with the temperature of the air.

    Parameters
    ----------
    effect : TabulatedCylinderHeat
        Parameters of the effect.
    state : apesim.engine.cylinder.CylinderState
        State of the cylinder.
    balance : (TERMS,) float array
        Balance of the cylinder that is added to, see `apesim.engine.cylinder`.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.cycle.state import cylinder_state, instant_at
    >>> from apesim.engine.cylinder import TERMS
    >>> from apesim.engine.machine import Machine
    >>> cycle, _, _ = cycle_of(Machine(), speed=100.0)
    >>> y, _ = charged_at_rest(cycle)
    >>> state, _ = cylinder_state(cycle, instant_at(cycle, 0.0, y), y)
    >>> effect, balance = TabulatedCylinderHeat(*[0.1] * len(PLACES)), np.zeros(TERMS)
    >>> tabulated_cylinder_heat(effect, state, balance)
    >>> print(round(balance[HEAT] / (state.air.pressure * state.volume * state.speed), 9))
    0.1
    """
    share = interpolate_periodic(effect, state.angle * 6.0 / pi)
    heat = share * state.air.pressure * state.volume * state.speed
    balance[ENERGY] += heat
    balance[HEAT] += heat
    balance[WALL_EXERGY] += heat_exergy(state.ambient, heat, state.air.temperature)


EFFECT = Effect(
    "tabulated_cylinder_heat",
    TabulatedCylinderHeat,
    equation="Q = q(angle) p V omega, cubic between nodes every 30 deg",
    source="no law: what heat would close a gap",
    seen_in="compression and expansion",
    isolated_by="motored compression and expansion with both valves closed, at two speeds",
    strengths=TabulatedCylinderHeat._fields,
    tabulated="heat",
)
