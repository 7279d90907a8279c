"""Sides and regimes of the four flows through the solenoids, and where each goes from one regime into another.

The flows themselves are computed by `apesim.valve.actuator.solenoid_flows`, by the law of the EPV paper
(doi 10.1631/jzus.A0820373), Eqs. 7-8; see `apesim.restriction`.
"""

from typing import TYPE_CHECKING

import numpy as np

from apesim.air import GasState
from apesim.kernel import kernel
from apesim.restriction import SHUT, Sides, beyond_regime, next_regime, regime_between

if TYPE_CHECKING:
    from apesim.valve.terms import ValveState

SUPPLY_A, VENT_A, SUPPLY_B, VENT_B, FLOWS = range(5)
"""The flows, from supply to chamber and from chamber to ambient; FLOWS is how many there are."""


@kernel
def stretched(stretch: float, sides: Sides) -> Sides:
    """Return the sides of a flow with the pressure difference times a factor, seen from the higher pressure.

    ``r' = 1 - stretch (1 - r)``: the flow function of the stretched ratio chokes at another pressure ratio; chosen.

    Parameters
    ----------
    stretch : float
        Factor; 1 changes nothing.
    sides : apesim.restriction.Sides
        State of the air on both sides.

    Returns
    -------
    apesim.restriction.Sides
        State on both sides with the lower pressure changed.

    Examples
    --------
    >>> stretched(2.0, Sides(GasState(4e5, 300.0), GasState(3e5, 287.0))).behind
    GasState(pressure=200000.0, temperature=287.0)
    """
    (p_1, t_1), (p_2, t_2) = sides
    if p_1 >= p_2:
        return Sides(sides.before, GasState(p_1 - stretch * (p_1 - p_2), t_2))
    return Sides(GasState(p_2 - stretch * (p_2 - p_1), t_1), sides.behind)


@kernel
def solenoid_sides(state: "ValveState") -> tuple[Sides, ...]:
    """Return pressures and temperatures before and behind each flow through the solenoids.

    They are stretched where the solenoids choke at another pressure ratio than Eq. 8 of the EPV paper says.

    Parameters
    ----------
    state : apesim.valve.terms.ValveState
        State of the valve at an instant.

    Returns
    -------
    tuple of apesim.restriction.Sides
        Both sides of each flow, from SUPPLY_A to VENT_B.

    Examples
    --------
    >>> import apesim
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.supply import ValveSupply
    >>> actuator, _ = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> state = state_of(actuator, closed_at_rest(actuator, supply.control), supply)
    >>> sides = solenoid_sides(state)[SUPPLY_B]
    >>> round(float(sides.before.pressure), 3), round(float(sides.behind.pressure), 3)
    (1000000.0, 101325.0)
    """
    control, vent = state.supply.control, GasState(state.vent_pressure, state.ambient.temperature)
    fill_a, vent_a = Sides(control, state.chamber_a), Sides(state.chamber_a, vent)
    fill_b, vent_b = Sides(control, state.chamber_b), Sides(state.chamber_b, vent)
    if state.stretch == 1.0:
        return fill_a, vent_a, fill_b, vent_b
    stretch = state.stretch
    return (
        stretched(stretch, fill_a),
        stretched(stretch, vent_a),
        stretched(stretch, fill_b),
        stretched(stretch, vent_b),
    )


@kernel
def open_shares(x_a: float, x_b: float) -> tuple[float, float, float, float]:
    """Return the share of the effective area that each flow has, 0...1: SUPPLY_A, VENT_A, SUPPLY_B, VENT_B.

    De-energised, chamber A sees the supply and B the vent; energised, A sees the vent and B the supply. `x_a` and `x_b`
    are the energised fractions of the solenoids, 0...1.

    >>> open_shares(0.25, 1.0)
    (0.75, 0.25, 1.0, 0.0)
    """
    return 1.0 - x_a, x_a, x_b, 1.0 - x_b


@kernel
def start_solenoid_segment(
    state: "ValveState", shares: tuple[float, ...], shares_end: tuple[float, ...], first: int, mode: np.ndarray
) -> None:
    """Write the regimes of the flows at the start of a smooth stretch into `mode` (m,), from the element `first` on.

    `shares` and `shares_end` are those at its start and end, see `open_shares`; what is 0 at both is shut.
    """
    sides = solenoid_sides(state)
    for flow in range(FLOWS):
        is_open = shares[flow] > 0.0 or shares_end[flow] > 0.0
        mode[first + flow] = regime_between(state.gas, sides[flow]) if is_open else SHUT


@kernel
def solenoid_events(state: "ValveState", mode: np.ndarray, first: int, g: np.ndarray, first_event: int) -> None:
    """Write by how much each flow has left its regime into the events `g` (e,), from `first_event` on.

    A flow that is shut has -1. `first` is the element of `mode` (m,) that holds the regime of the first flow.
    """
    sides = solenoid_sides(state)
    for flow in range(FLOWS):
        g[first_event + flow] = beyond_regime(state.gas, mode[first + flow], sides[flow])


@kernel
def change_solenoid_regime(state: "ValveState", flow: int, first: int, mode: np.ndarray) -> None:
    """Take a flow, from SUPPLY_A to VENT_B, over into the regime that follows: changes `mode` (m,).

    `first` is its element that holds the regime of the first flow.

    A chamber of 0.11 MPa vents to ambient pressure without choking:

    >>> import apesim
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.supply import ValveSupply
    >>> actuator, _ = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> state = state_of(actuator, closed_at_rest(actuator, supply.control), supply)
    >>> from apesim.restriction import CHOKED, SUBSONIC
    >>> mode = np.full(4, float(CHOKED))
    >>> change_solenoid_regime(state._replace(chamber_a=GasState(1.1e5, 300.0)), VENT_A, 0, mode)
    >>> bool(mode[VENT_A] == SUBSONIC)
    True
    """
    mode[first + flow] = next_regime(state.gas, mode[first + flow], solenoid_sides(state)[flow])
