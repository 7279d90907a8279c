"""Rebound of the piston from its stops."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, contact
from apesim.kernel import kernel
from apesim.quantities import Quantity


class Bounce(NamedTuple):
    """Stops that give back a share of the speed."""

    restitution: Annotated[float, Quantity("", 0, 0.6, "steel on steel, damped")] = 0.0


@contact.for_type(Bounce)
@kernel
def bounce(effect, speed):
    """Speed after over speed before contact (Newton's law of restitution)."""
    return effect.restitution


EFFECT = Effect(
    "bounce",
    Bounce,
    equation="v+ = -e v-",
    source="Newton's law of restitution",
    seen_in="rebound at the stops",
    isolated_by="lift sampled at 20 kHz or more around the contact",
)
