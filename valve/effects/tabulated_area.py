"""Flow through the solenoids that has no name, as a table over the pressure ratio."""

import numpy as np

from apesim.cubic_table import interpolate_clamped, table
from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.solenoid_flow import SUPPLY_A, SUPPLY_B, VENT_A, VENT_B
from apesim.valve.terms import FLOW_SHARE, ValveState

PLACES = 20, 40, 60, 80, 100
"""Lower over higher pressure at the values of the table [%]."""
SIZE = Quantity("", -0.5, 0.5, "discharge coefficients: 0.6 to 0.9")
"""Declaration of a value: the share by which a flow is larger."""

TabulatedArea = table("TabulatedArea", __name__, filling=(PLACES, SIZE), venting=(PLACES, SIZE))
TabulatedArea.__doc__ = "Shares by which the solenoids let more air in and out, over the pressure ratio."


@kernel
def ratio_node(pressure: float, other: float) -> float:
    """Return the place ``5 r - 1`` of a pressure ratio among the values of the table, r = lower / higher [Pa abs].

    >>> ratio_node(1e5, 2e5), ratio_node(2e5, 2e5)
    (1.5, 4.0)
    """
    return 5.0 * min(pressure, other) / max(pressure, other) - 1.0


@law.for_type(TabulatedArea)
@kernel
def tabulated_area(effect: tuple[float, ...], state: ValveState, balance: np.ndarray) -> None:
    """Make the flows through the solenoids larger by a table over the pressure ratio, ``S(r) = S (1 + s(r))``.

    Flows from the supply have one table s, those to the vent another; r is the lower over the higher pressure. Chosen.

    Parameters
    ----------
    effect : TabulatedArea
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
    >>> tabulated_area(TabulatedArea(filling_at_100=0.2), state, balance)
    >>> [round(float(share), 6) for share in balance[FLOW_SHARE : FLOW_SHARE + 4]]
    [0.2, 0.0, 0.0, 0.0]
    """
    supply, vent = state.supply.control.pressure, state.vent_pressure
    a, b = state.chamber_a.pressure, state.chamber_b.pressure
    balance[FLOW_SHARE + SUPPLY_A] += interpolate_clamped(effect[:5], ratio_node(supply, a))
    balance[FLOW_SHARE + VENT_A] += interpolate_clamped(effect[5:], ratio_node(vent, a))
    balance[FLOW_SHARE + SUPPLY_B] += interpolate_clamped(effect[:5], ratio_node(supply, b))
    balance[FLOW_SHARE + VENT_B] += interpolate_clamped(effect[5:], ratio_node(vent, b))


EFFECT = Effect(
    "tabulated_area",
    TabulatedArea,
    equation="S(r) = S (1 + s(r)), one s filling and one venting, cubic between nodes every fifth",
    source="no law: what effective area would close a gap",
    seen_in="shape of charge and discharge",
    isolated_by="discharge and charge tests of a solenoid",
    strengths=TabulatedArea._fields,
    tabulated="area",
)
