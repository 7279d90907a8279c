"""Coulomb friction of the piston rings."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import BREAKAWAY, DRY


class CoulombFriction(NamedTuple):
    """Constant friction against the motion, and what must be overcome from rest."""

    force: Annotated[float, Quantity("N", 0, 12, "paper: below 1.1 N, neglected")] = 0.0
    breakaway: Annotated[float, Quantity("N", 0, 50, "at least the force; smaller values count as the force")] = 0.0


@law.for_type(CoulombFriction)
@kernel
def coulomb_friction(effect, state, balance):
    """F_d against the motion, F_s at rest (Eq. 2) [N]."""
    balance[DRY] += effect.force
    balance[BREAKAWAY] += max(effect.force, effect.breakaway)


EFFECT = Effect(
    "coulomb_friction",
    CoulombFriction,
    equation="F_f = F_d sign(dL/dt) in motion, up to F_s at rest",
    source="paper, Eq. 2; Richer and Hurmuzlu 2000, J. Dyn. Syst. Meas. Control 122, 416",
    seen_in="flight at low pressure; confused with the springs",
    isolated_by="slow strokes at low supply pressure, with both chamber pressures measured",
    strengths=("force", "breakaway"),
)
