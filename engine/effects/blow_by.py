"""Blow-by: leakage past the engine's piston rings."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, law
from apesim.engine.cylinder import BRANCH, ENERGY, MASS
from apesim.kernel import kernel
from apesim.leak import leak
from apesim.quantities import Quantity


class BlowBy(NamedTuple):
    """An orifice between cylinder and ambient."""

    area: Annotated[float, Quantity("mm^2", 0, 1, "a ring gap of some tenths of a millimetre")] = 0.0


@law.for_type(BlowBy)
@kernel
def blow_by(effect, state, balance):
    """Flow from the cylinder to ambient through an effective area (Eq. 7)."""
    sides = state.pressure, state.temperature, state.ambient.pressure, state.ambient.temperature
    mass, energy = leak(state.gas, effect.area, sides, balance, BRANCH)
    balance[MASS] -= mass
    balance[ENERGY] -= energy


EFFECT = Effect(
    "blow_by",
    BlowBy,
    equation="mdot = S psi(r) p / sqrt(R T), from cylinder to ambient",
    source="paper, Eqs. 7-8, for a ring gap",
    seen_in="decay of the cylinder pressure, air balance; confused with a leak past the groove",
    isolated_by="a pressurised cylinder at rest with both valves closed",
)
