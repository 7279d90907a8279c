"""Leakage from chamber B."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.leak import leak
from apesim.quantities import Quantity
from apesim.valve.terms import BRANCH, ENERGY_B, MASS_B


class LeakageB(NamedTuple):
    """An orifice between chamber B and ambient."""

    area: Annotated[float, Quantity("mm^2", 0, 0.3, "a worn seal")] = 0.0


@law.for_type(LeakageB)
@kernel
def leakage_b(effect, state, balance):
    """Flow from chamber B to ambient through an effective area (Eq. 7)."""
    sides = state.pressure_b, state.temperature_b, state.ambient.pressure, state.ambient.temperature
    mass, energy = leak(state.gas, effect.area, sides, balance, BRANCH)
    balance[MASS_B] -= mass
    balance[ENERGY_B] -= energy


EFFECT = Effect(
    "leakage_b",
    LeakageB,
    equation="mdot = S psi(r) p / sqrt(R T), from B to ambient",
    source="paper, Eqs. 7-8; the paper neglects it",
    seen_in="standing pressure of chamber B; confused with a leak of chamber A on lift alone",
    isolated_by="chamber B charged and shut off, piston on its stop: pressure over time",
)
