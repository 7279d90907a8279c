"""A constant force along the piston's axis."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import FORCE


class SideForce(NamedTuple):
    """A force to closed: weight, an unbalanced area, a preloaded spring."""

    force: Annotated[float, Quantity("N", -12, 12, "ten times the weight of the piston")] = 0.0


@law.for_type(SideForce)
@kernel
def side_force(effect, state, balance):
    """A constant force, positive to closed [N]."""
    balance[FORCE] += effect.force


EFFECT = Effect(
    "side_force",
    SideForce,
    equation="M d2L/dt2 = ... + force",
    source="paper, Eq. 1, with a force that does not depend on the motion",
    seen_in="opening against closing; confused with the springs' rest position",
    isolated_by="strokes with the valve upright and upside down, or force over travel with both chambers open",
)
