"""Leakage from chamber A."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.leak import leak
from apesim.quantities import Quantity
from apesim.valve.terms import BRANCH, ENERGY_A, MASS_A


class LeakageA(NamedTuple):
    """An orifice between chamber A and ambient."""

    area: Annotated[float, Quantity("mm^2", 0, 0.3, "a worn seal")] = 0.0


@law.for_type(LeakageA)
@kernel
def leakage_a(effect, state, balance):
    """Flow from chamber A to ambient through an effective area (Eq. 7)."""
    sides = state.pressure_a, state.temperature_a, state.ambient.pressure, state.ambient.temperature
    mass, energy = leak(state.gas, effect.area, sides, balance, BRANCH)
    balance[MASS_A] -= mass
    balance[ENERGY_A] -= energy


EFFECT = Effect(
    "leakage_a",
    LeakageA,
    equation="mdot = S psi(r) p / sqrt(R T), from A to ambient",
    source="paper, Eqs. 7-8; the paper neglects it",
    seen_in="standing pressure of chamber A; confused with a leak of chamber B on lift alone",
    isolated_by="chamber A charged and shut off, piston on its stop: pressure over time",
)
