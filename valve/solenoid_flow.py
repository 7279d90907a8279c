"""The four flows through the solenoids (Eq. 7), and where each goes from one regime into another."""

from apesim.kernel import kernel
from apesim.restriction import SHUT, beyond_regime, flow_in, next_regime, regime_between

SUPPLY_A, VENT_A, SUPPLY_B, VENT_B, FLOWS = range(5)
"""The flows, from supply to chamber and from chamber to ambient; how many there are."""


@kernel
def beside(state, flow):
    """Pressures and temperatures before and behind a flow [Pa abs, K, Pa abs, K]."""
    ambient = state.ambient
    if flow == SUPPLY_A:
        return state.supply_pressure, state.supply_temperature, state.pressure_a, state.temperature_a
    if flow == SUPPLY_B:
        return state.supply_pressure, state.supply_temperature, state.pressure_b, state.temperature_b
    if flow == VENT_A:
        return state.pressure_a, state.temperature_a, ambient.pressure, ambient.temperature
    return state.pressure_b, state.temperature_b, ambient.pressure, ambient.temperature


@kernel
def solenoid_flow(state, flow, regime, area):
    """One of the flows.

    Parameters
    ----------
    state : ValveState
    flow : int
        SUPPLY_A...VENT_B.
    regime : int
        See `apesim.restriction`.
    area : float
        Effective area [m2].

    Returns
    -------
    mass_flow, enthalpy_flow : float
        [kg/s, W]
    """
    return flow_in(state.gas, regime, area, *beside(state, flow))


@kernel
def open_share(flow, x_a, x_b):
    """Share of the effective area that a flow has at the solenoids' energised fractions."""
    if flow == SUPPLY_A:
        return 1.0 - x_a
    if flow == VENT_A:
        return x_a
    return x_b if flow == SUPPLY_B else 1.0 - x_b


@kernel
def regime_in_stretch(state, flow, share, share_end):
    """Regime at the start of a stretch, given the flow's shares of the area at its ends; SHUT where both are zero."""
    if share > 0.0 or share_end > 0.0:
        return regime_between(state.gas, *beside(state, flow))
    return SHUT


@kernel
def beyond(state, flow, regime):
    """By how much a flow has left its regime, see `apesim.restriction.beyond_regime`."""
    return beyond_regime(state.gas, regime, *beside(state, flow))


@kernel
def following(state, flow, regime):
    """The regime that a flow goes over to."""
    return next_regime(state.gas, regime, *beside(state, flow))
