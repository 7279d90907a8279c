"""Leakage past the piston rings."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.leak import leak
from apesim.quantities import Quantity
from apesim.valve.terms import BRANCH, ENERGY_A, ENERGY_B, MASS_A, MASS_B


class RingLeakage(NamedTuple):
    """An orifice between the chambers."""

    area: Annotated[float, Quantity("mm^2", 0, 0.3, "a ring gap of a few hundredths of a millimetre")] = 0.0


@law.for_type(RingLeakage)
@kernel
def ring_leakage(effect, state, balance):
    """Flow from chamber A to chamber B through an effective area (Eq. 7)."""
    sides = state.pressure_a, state.temperature_a, state.pressure_b, state.temperature_b
    mass, energy = leak(state.gas, effect.area, sides, balance, BRANCH)
    balance[MASS_A] -= mass
    balance[ENERGY_A] -= energy
    balance[MASS_B] += mass
    balance[ENERGY_B] += energy


EFFECT = Effect(
    "ring_leakage",
    RingLeakage,
    equation="mdot = S psi(r) p / sqrt(R T), from A to B",
    source="paper, Eqs. 7-8; the paper neglects it",
    seen_in="chamber pressures in dwell",
    isolated_by="one chamber pressurised and the other vented, solenoids held, piston on its stop",
)
