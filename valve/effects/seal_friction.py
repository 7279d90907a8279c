"""Friction of seals that the chamber pressures press on."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import BREAKAWAY, DRY


class SealFriction(NamedTuple):
    """Dry friction proportional to the chambers' pressures over ambient."""

    coefficient: Annotated[
        float, Quantity("N/Pa", 0, 1e-4, "a lip of 1 mm on 120 mm of circumference, friction 0.5 to 0.8")
    ] = 0.0


@law.for_type(SealFriction)
@kernel
def seal_friction(effect, state, balance):
    """c (abs(p_A - p_0) + abs(p_B - p_0)), moving and at rest [N]."""
    ambient = state.ambient.pressure
    force = effect.coefficient * (abs(state.pressure_a - ambient) + abs(state.pressure_b - ambient))
    balance[DRY] += force
    balance[BREAKAWAY] += force


EFFECT = Effect(
    "seal_friction",
    SealFriction,
    equation="F_f = c (|p_A - p_0| + |p_B - p_0|) sign(v)",
    source="Belforte et al. 1993, Lubrication Engineering 49, 775: friction of lip seals over pressure and speed",
    seen_in="flight at high pressure; confused with quadratic drag",
    isolated_by="strokes at three supply pressures, with both chamber pressures measured",
)
