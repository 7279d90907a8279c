"""Leaks that have no name."""

from apesim.cubic_table import interpolate_clamped, table
from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.leak import leak
from apesim.quantities import Quantity
from apesim.valve.terms import BRANCH, ENERGY_A, ENERGY_B, MASS_A, MASS_B

PLACES = 0, 50, 100
"""Share of the stroke [%]."""
SIZE = Quantity("mm^2", 0, 1, "worn seals")

TabulatedLeak = table("TabulatedLeak", __name__, a=(PLACES, SIZE), b=(PLACES, SIZE), between=(PLACES, SIZE))
TabulatedLeak.__doc__ = "Effective areas over the lift, from chamber A and B to ambient and between the two."


@law.for_type(TabulatedLeak)
@kernel
def tabulated_leak(effect, state, balance):
    """Flows through S_A(lift) and S_B(lift) to ambient and S_AB(lift) from A to B (Eq. 7)."""
    place = 2.0 * (1.0 - state.position / state.valve.stroke)
    a, b = (state.pressure_a, state.temperature_a), (state.pressure_b, state.temperature_b)
    ambient = state.ambient.pressure, state.ambient.temperature
    mass_a, energy_a = leak(state.gas, interpolate_clamped(effect[:3], place), (*a, *ambient), balance, BRANCH)
    mass_b, energy_b = leak(state.gas, interpolate_clamped(effect[3:6], place), (*b, *ambient), balance, BRANCH)
    mass, energy = leak(state.gas, interpolate_clamped(effect[6:], place), (*a, *b), balance, BRANCH)
    balance[MASS_A] -= mass_a + mass
    balance[ENERGY_A] -= energy_a + energy
    balance[MASS_B] += mass - mass_b
    balance[ENERGY_B] += energy - energy_b


EFFECT = Effect(
    "tabulated_leak",
    TabulatedLeak,
    equation="mdot = S(lift) psi(r) p / sqrt(R T), cubic between nodes every half of the stroke",
    source="no law: what leaks would close a gap",
    seen_in="standing pressures of the chambers",
    isolated_by="a charged chamber shut off, piston held at several lifts: pressure over time",
    strengths=TabulatedLeak._fields,
    tabulated="leak",
)
