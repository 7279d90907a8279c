"""Heat into the cylinder that has no name."""

from math import pi

from apesim.effect import Effect, law
from apesim.engine.cylinder import ENERGY, HEAT, WALL_EXERGY
from apesim.exergy import heat_exergy
from apesim.kernel import kernel
from apesim.nodes import round_the_nodes, table
from apesim.quantities import Quantity

PLACES = range(0, 360, 30)
"""Crank angle [deg]."""

TabulatedCylinderHeat = table(
    "TabulatedCylinderHeat", __name__, share=(PLACES, Quantity("", -1, 1, "as much as the air holds, in a radian"))
)
TabulatedCylinderHeat.__doc__ = "Heat into the cylinder over the crank angle, as a share of p V times the speed."


@law.for_type(TabulatedCylinderHeat)
@kernel
def tabulated_cylinder_heat(effect, state, balance):
    """Q = q(angle) p V omega; its wall, which nobody knows, counts as one of the air's temperature."""
    share = round_the_nodes(effect, state.angle * 6.0 / pi)
    heat = share * state.pressure * state.volume * state.speed
    balance[ENERGY] += heat
    balance[HEAT] += heat
    balance[WALL_EXERGY] += heat_exergy(state.ambient, heat, state.temperature)


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
