"""Friction of seals that the chamber pressures press on."""

from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, Search, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import BREAKAWAY, DRY, ValveState


class SealFriction(NamedTuple):
    """Dry friction proportional to the chambers' pressures over ambient."""

    coefficient: Annotated[
        float, Quantity("N/Pa", 0, 1e-4, "a lip of 1 mm on 120 mm of circumference, friction 0.5 to 0.8")
    ] = 0.0


@law.for_type(SealFriction)
@kernel
def seal_friction(effect: SealFriction, state: ValveState, balance: np.ndarray) -> None:
    """Add dry friction in proportion to the chambers' pressures, ``F_f = c (|p_A - p_0| + |p_B - p_0|)``.

    It acts against the motion and holds at rest. Belforte and others [1]_ measured that the friction of lip seals
    depends on the pressure; the proportion, with the coefficient c, is chosen. p_A, p_B and p_0 are the pressures of
    the chambers and the ambient.

    Parameters
    ----------
    effect : SealFriction
        Parameters of the effect.
    state : apesim.valve.terms.ValveState
        State of the valve.
    balance : (TERMS,) float array
        Balance of the valve that is added to, see `apesim.valve.terms`.

    References
    ----------
    .. [1] G. Belforte and others, "Study of the behavior of lip seals in pneumatic actuators", Lubrication Engineering
       49, 1993, pp. 775-780.

    Examples
    --------
    10 N/MPa times 0.5 MPa; chamber B is at ambient pressure:

    >>> import apesim
    >>> from apesim.air import GasState
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.supply import ValveSupply
    >>> from apesim.valve.terms import TERMS
    >>> actuator, _ = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> state = state_of(actuator, closed_at_rest(actuator, supply.control), supply)
    >>> balance = np.zeros(TERMS)
    >>> state = state._replace(chamber_a=GasState(state.ambient.pressure + 5e5, 300.0))
    >>> seal_friction(SealFriction(coefficient=1e-5), state, balance)
    >>> round(float(balance[DRY]), 6)
    5.0
    """
    ambient = state.ambient.pressure
    force = effect.coefficient * (abs(state.chamber_a.pressure - ambient) + abs(state.chamber_b.pressure - ambient))
    balance[DRY] += force
    balance[BREAKAWAY] += force


EFFECT = Effect(
    "seal_friction",
    SealFriction,
    equation="F_f = c (|p_A - p_0| + |p_B - p_0|) sign(v)",
    source="Belforte et al. 1993, Lubrication Engineering 49, 775: friction of lip seals over pressure and speed",
    seen_in="flight at high pressure; confused with quadratic drag",
    isolated_by="strokes at three supply pressures, with both chamber pressures measured",
    search=Search(isolated_on_rig="strokes at three pressures and one speed"),
)
