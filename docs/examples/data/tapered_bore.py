"""A bore that narrows towards its open end: the rings' viscous friction grows on the way there."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import FORCE


class TaperedBore(NamedTuple):
    """Viscous friction beside that of the valve, none where it is closed and all of it where it is open."""

    friction: Annotated[float, Quantity("N s/m", 0, 200, "an oil film of half the height doubles the 111 N s/m")] = 0.0


@law.for_type(TaperedBore)
@kernel
def tapered_bore(effect, state, balance):
    """-friction (1 - L/L_max) v [N]; L is 0 where the valve is open, L_max where it is closed."""
    balance[FORCE] -= effect.friction * (1.0 - state.position / state.valve.stroke) * state.speed


EFFECT = Effect(
    "tapered_bore",
    TaperedBore,
    equation="F = -c (1 - L/L_max) v",
    source="Newton's law of viscosity, F = mu A v/h, for an oil film whose height h falls along the stroke",
    seen_in="second half of the opening flight, first half of the closing; confused with viscous friction",
    isolated_by="speed over position in slow strokes of both directions",
    layer="valve",
)
