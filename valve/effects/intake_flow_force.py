"""Force of the intake air on the piston."""

from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import FORCE, ValveState


class IntakeFlowForce(NamedTuple):
    """An unbalanced area on which intake pressure above ambient pushes to closed."""

    area: Annotated[float, Quantity("mm^2", 0, 150, "at most the groove's own effective area")] = 0.0


@law.for_type(IntakeFlowForce)
@kernel
def intake_flow_force(effect: IntakeFlowForce, state: ValveState, balance: np.ndarray) -> None:
    """Add the force of the intake air on an unbalanced area, ``F = area (p_i - p_0)``, to closed.

    Merritt [1]_ shows that flow forces tend to close a spool; an area on which the pressure acts is chosen in their
    place.

    Parameters
    ----------
    effect : IntakeFlowForce
        Parameters of the effect.
    state : apesim.valve.terms.ValveState
        State of the valve.
    balance : (TERMS,) float array
        Balance of the valve that is added to, see `apesim.valve.terms`.

    References
    ----------
    .. [1] H. E. Merritt, "Hydraulic Control Systems", Wiley, 1967.

    Examples
    --------
    100 mm2 times 0.4 MPa:

    >>> import apesim
    >>> from apesim.air import GasState
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.supply import ValveSupply
    >>> from apesim.valve.terms import TERMS
    >>> actuator, _ = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> state = state_of(actuator, closed_at_rest(actuator, supply.control), supply)
    >>> balance = np.zeros(TERMS)
    >>> state = state._replace(supply=supply._replace(intake_pressure=state.ambient.pressure + 4e5))
    >>> intake_flow_force(IntakeFlowForce(area=100e-6), state, balance)
    >>> round(float(balance[FORCE]), 6)
    40.0
    """
    balance[FORCE] += effect.area * (state.supply.intake_pressure - state.ambient.pressure)


EFFECT = Effect(
    "intake_flow_force",
    IntakeFlowForce,
    equation="F = area (p_i - p_0)",
    source="Merritt 1967, Hydraulic Control Systems: flow forces on a spool tend to close it",
    seen_in="flight with intake pressure on and off",
    isolated_by="bench strokes with the intake pressurised and open to ambient",
)
