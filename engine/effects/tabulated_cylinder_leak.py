"""Leaks of the cylinder that have no name."""

from math import pi

from apesim.effect import Effect, law
from apesim.engine.cylinder import BRANCH, ENERGY, GROOVE_ENERGY, GROOVE_MASS, MASS
from apesim.kernel import kernel
from apesim.leak import leak
from apesim.nodes import round_the_nodes, table
from apesim.quantities import Quantity

PLACES = range(0, 360, 30)
"""Crank angle [deg]."""
QUARTERS = range(0, 360, 90)

TabulatedCylinderLeak = table(
    "TabulatedCylinderLeak",
    __name__,
    out=(PLACES, Quantity("mm^2", -20, 20, "a part of an exhaust valve")),
    past_groove=(QUARTERS, Quantity("mm^2", 0, 2, "worn seals")),
)
TabulatedCylinderLeak.__doc__ = "Effective areas over the crank angle: to ambient, below zero too, and past the groove."


@law.for_type(TabulatedCylinderLeak)
@kernel
def tabulated_cylinder_leak(effect, state, balance):
    """Flows through S(angle) to ambient, and through S_g(angle) from before the groove (Eq. 7)."""
    turns = 0.5 * state.angle / pi
    out = round_the_nodes(effect[:12], 12.0 * turns)
    sign = -1.0 if out < 0.0 else 1.0
    cylinder, ambient = (state.pressure, state.temperature), (state.ambient.pressure, state.ambient.temperature)
    mass, energy = leak(state.gas, abs(out), (*cylinder, *ambient), balance, BRANCH)
    balance[MASS] -= sign * mass
    balance[ENERGY] -= sign * energy
    intake = state.intake_pressure, state.intake_temperature
    mass, energy = leak(state.gas, round_the_nodes(effect[12:], 4.0 * turns), (*intake, *cylinder), balance, BRANCH)
    balance[GROOVE_MASS] += mass
    balance[GROOVE_ENERGY] += energy


EFFECT = Effect(
    "tabulated_cylinder_leak",
    TabulatedCylinderLeak,
    equation="mdot = S(angle) psi(r) p / sqrt(R T), cubic between nodes every 30 deg, past the groove every 90 deg",
    source="no law: what leaks would close a gap",
    seen_in="cylinder pressure, air",
    isolated_by="a pressurised cylinder at rest, turned to several angles",
    strengths=TabulatedCylinderLeak._fields,
    tabulated="leak",
)
