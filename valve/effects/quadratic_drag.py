"""Drag that grows with the square of the speed."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import FORCE


class QuadraticDrag(NamedTuple):
    """Drag of air and oil that the piston displaces."""

    coefficient: Annotated[
        float, Quantity("N s^2/m^2", 0, 40, "flow through the rings' gap and the groove at some m/s")
    ] = 0.0


@law.for_type(QuadraticDrag)
@kernel
def quadratic_drag(effect, state, balance):
    """-c v abs(v) [N]."""
    balance[FORCE] -= effect.coefficient * state.speed * abs(state.speed)


EFFECT = Effect(
    "quadratic_drag",
    QuadraticDrag,
    equation="F = -c v |v|",
    source="turbulent drag; Idelchik, Handbook of Hydraulic Resistance",
    seen_in="fast flight; viscous friction eats it",
    isolated_by="strokes at high supply pressure, speed over position with both chamber pressures",
)
