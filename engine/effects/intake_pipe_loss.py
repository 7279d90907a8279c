"""An intake pipe that throttles between receiver and groove."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity

AREA_LEAST = 30e-6
"""Smallest area of a pipe [m2]."""


class IntakePipeLoss(NamedTuple):
    """A pipe with a volume of its own, fed from the receiver through an area; the larger, the less it loses."""

    area: Annotated[float, Quantity("mm^2", 0, 500, "effective, from 30 mm2 on: bends and fittings; 0: no pipe")] = 0.0
    volume: Annotated[float, Quantity("L", 0.05, 2, "half a metre of 16 mm")] = 0.1e-3

    def faults(self):
        """Faults that the range does not show."""
        if 0.0 < self.area < AREA_LEAST:
            yield "area", "starves the engine", "30 to 500 mm^2, or 0 for no pipe"


def volume(effect):
    """Volume of the pipe [m3] and effective area of its feed [m2]."""
    return effect.volume, effect.area


EFFECT = Effect(
    "intake_pipe_loss",
    IntakePipeLoss,
    equation="dm/dt = S psi(r) p_r / sqrt(R T_r) - mdot through the groove; S = area",
    source="paper, Eqs. 3-8, for a volume of its own",
    seen_in="receiver pressure over the crank angle; cylinder pressure in admission",
    isolated_by="pressure right before the groove against that in the receiver",
    volume=volume,
)
