"""A constant force along the piston's axis."""

from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, Search, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import FORCE, ValveState


class SideForce(NamedTuple):
    """A force to closed: weight, an unbalanced area, a preloaded spring."""

    force: Annotated[float, Quantity("N", -12, 12, "ten times the weight of the piston")] = 0.0


@law.for_type(SideForce)
@kernel
def side_force(effect: SideForce, state: ValveState, balance: np.ndarray) -> None:
    """Add a constant force on the piston, positive to closed; chosen, as weight or a preloaded spring.

    It stands beside the forces of Eq. 1 of the EPV paper (doi 10.1631/jzus.A0820373).

    Parameters
    ----------
    effect : SideForce
        Parameters of the effect.
    state : apesim.valve.terms.ValveState
        State of the valve.
    balance : (TERMS,) float array
        Balance of the valve that is added to, see `apesim.valve.terms`.

    Examples
    --------
    >>> import apesim
    >>> from apesim.air import GasState
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.supply import ValveSupply
    >>> from apesim.valve.terms import TERMS
    >>> actuator, _ = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> state = state_of(actuator, closed_at_rest(actuator, supply.control), supply)
    >>> balance = np.zeros(TERMS)
    >>> side_force(SideForce(force=-3.0), state, balance)
    >>> float(balance[FORCE])
    -3.0
    """
    balance[FORCE] += effect.force


EFFECT = Effect(
    "side_force",
    SideForce,
    equation="M d2L/dt2 = ... + force",
    source="EPV paper (doi 10.1631/jzus.A0820373), Eq. 1, with a force that does not depend on the motion",
    seen_in="opening against closing; confused with the springs' rest position",
    isolated_by="strokes with the valve upright and upside down, or force over travel with both chambers open",
    search=Search(isolated_on_rig="the load cell tared with the piston free, and the rig turned over"),
)
