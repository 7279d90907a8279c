"""Cushions at both ends of the stroke."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, law, note_branch
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import BRANCH, FORCE


class EndCushion(NamedTuple):
    """Damping towards a stop over the last of the travel, rising to the stop; none on the way back."""

    damping: Annotated[float, Quantity("N s/m", 0, 200, "at the stop; air squeezed out of a gap")] = 0.0
    length: Annotated[float, Quantity("mm", 0.2, 2, "of the travel before each stop")] = 0.5e-3


@law.for_type(EndCushion)
@kernel
def end_cushion(effect, state, balance):
    """-damping (1 - d/length) v within a length of the stop ahead, d away from it [N]."""
    ahead = state.position if state.speed < 0.0 else state.valve.stroke - state.position
    if effect.damping > 0.0:
        cushioned = ahead < effect.length and state.speed != 0.0
        note_branch(balance, BRANCH, 1 if cushioned else 0)
        if cushioned:
            balance[FORCE] -= effect.damping * (1.0 - ahead / effect.length) * state.speed


EFFECT = Effect(
    "end_cushion",
    EndCushion,
    equation="F = -c (1 - d/length) v",
    source="cushions of pneumatic cylinders, with check valves; squeezed films",
    seen_in="last millimetre before a stop; confused with bounce",
    isolated_by="lift sampled at 20 kHz or more around the contact",
)
