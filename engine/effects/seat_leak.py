"""Leakage past the closed groove."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, law
from apesim.engine.cylinder import BRANCH, GROOVE_ENERGY, GROOVE_MASS
from apesim.kernel import kernel
from apesim.leak import leak
from apesim.quantities import Quantity


class SeatLeak(NamedTuple):
    """An orifice beside the groove, open at any lift."""

    area: Annotated[float, Quantity("mm^2", 0, 1, "a gap of some hundredths of a millimetre round the piston")] = 0.0


@law.for_type(SeatLeak)
@kernel
def seat_leak(effect, state, balance):
    """Flow from before the groove into the cylinder through an effective area (Eq. 7)."""
    sides = state.intake_pressure, state.intake_temperature, state.pressure, state.temperature
    mass, energy = leak(state.gas, effect.area, sides, balance, BRANCH)
    balance[GROOVE_MASS] += mass
    balance[GROOVE_ENERGY] += energy


EFFECT = Effect(
    "seat_leak",
    SeatLeak,
    equation="mdot = S psi(r) p / sqrt(R T), from before the groove into the cylinder",
    source="paper, Eqs. 7-8, for the gap between groove and ports",
    seen_in="cylinder pressure before opening, air; confused with blow-by",
    isolated_by="a cylinder at rest with the groove closed and intake pressure on: rise of its pressure",
)
