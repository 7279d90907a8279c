"""Force of the intake air on the piston."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import FORCE


class IntakeFlowForce(NamedTuple):
    """An unbalanced area on which intake pressure above ambient pushes to closed."""

    area: Annotated[float, Quantity("mm^2", 0, 150, "at most the groove's own effective area")] = 0.0


@law.for_type(IntakeFlowForce)
@kernel
def intake_flow_force(effect, state, balance):
    """area (p_intake - p_0), to closed [N]."""
    balance[FORCE] += effect.area * (state.intake_pressure - state.ambient.pressure)


EFFECT = Effect(
    "intake_flow_force",
    IntakeFlowForce,
    equation="F = area (p_i - p_0)",
    source="Merritt 1967, Hydraulic Control Systems: flow forces on a spool tend to close it",
    seen_in="flight with intake pressure on and off",
    isolated_by="bench strokes with the intake pressurised and open to ambient",
)
