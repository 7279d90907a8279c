"""Friction of the rings that fades with speed."""

from math import exp
from typing import Annotated, NamedTuple

from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import BREAKAWAY, DRY


class StribeckFriction(NamedTuple):
    """What friction at rest and at low speed has above that at high speed."""

    force: Annotated[float, Quantity("N", 0, 6, "as large as the Coulomb friction of a small piston")] = 0.0
    speed: Annotated[float, Quantity("m/s", 0.02, 0.2, "at which it has fallen to 1/e; lubricated elastomers")] = 0.05


@law.for_type(StribeckFriction)
@kernel
def stribeck_friction(effect, state, balance):
    """F exp(-(v/v_s)^2) against the motion, F at rest [N]."""
    if effect.force > 0.0:
        balance[DRY] += effect.force * exp(-((state.speed / effect.speed) ** 2))
        balance[BREAKAWAY] += effect.force


EFFECT = Effect(
    "stribeck_friction",
    StribeckFriction,
    equation="F_f = F exp(-(v/v_s)^2) sign(v)",
    source="Armstrong-Helouvry, Dupont and Canudas de Wit 1994, Automatica 30, 1083",
    seen_in="first 2 ms of flight; confused with a delay",
    isolated_by="slow strokes at low supply pressure, lift sampled at 20 kHz or more",
)
