"""The four flows through the solenoids (Eq. 7), and where each goes from one regime into another."""

from apesim.kernel import kernel
from apesim.restriction import SHUT, beyond_regime, next_regime, regime_between

SUPPLY_A, VENT_A, SUPPLY_B, VENT_B, FLOWS = range(5)
"""The flows, from supply to chamber and from chamber to ambient; how many there are."""


@kernel
def stretched(stretch, sides):
    """A flow's sides with the pressure difference, seen from the higher pressure, times a factor."""
    p_1, t_1, p_2, t_2 = sides
    if p_1 >= p_2:
        return p_1, t_1, p_1 - stretch * (p_1 - p_2), t_2
    return p_2 - stretch * (p_2 - p_1), t_1, p_2, t_2


@kernel
def solenoid_sides(state):
    """Pressures and temperatures before and behind each flow, stretched where the solenoids choke elsewhere than Eq. 8.

    Parameters
    ----------
    state : ValveState

    Returns
    -------
    tuple of tuple of float
        For each flow [Pa abs, K, Pa abs, K].
    """
    supply, ambient = (state.supply_pressure, state.supply_temperature), state.ambient
    a, b = (state.pressure_a, state.temperature_a), (state.pressure_b, state.temperature_b)
    fill_a = supply[0], supply[1], a[0], a[1]
    vent_a = a[0], a[1], state.vent_pressure, ambient.temperature
    fill_b = supply[0], supply[1], b[0], b[1]
    vent_b = b[0], b[1], state.vent_pressure, ambient.temperature
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
def open_shares(x_a, x_b):
    """Share of the effective area that each flow has at the solenoids' energised fractions."""
    return 1.0 - x_a, x_a, x_b, 1.0 - x_b


@kernel
def start_solenoid_segment(state, shares, shares_end, first, mode):
    """Regimes at the start of a stretch into mode, from its element ``first``.

    Parameters
    ----------
    state : ValveState
    shares, shares_end : tuple of float
        See `open_shares`, at the start and the end of the stretch; what is 0 at both is shut.
    first : int
    mode : float array
    """
    sides = solenoid_sides(state)
    for flow in range(FLOWS):
        is_open = shares[flow] > 0.0 or shares_end[flow] > 0.0
        mode[first + flow] = regime_between(state.gas, sides[flow]) if is_open else SHUT


@kernel
def solenoid_events(state, mode, first, g, first_event):
    """By how much each flow has left its regime, into g from its element ``first_event``."""
    sides = solenoid_sides(state)
    for flow in range(FLOWS):
        g[first_event + flow] = beyond_regime(state.gas, mode[first + flow], sides[flow])


@kernel
def change_solenoid_regime(state, flow, first, mode):
    """Take a flow over into the regime that follows."""
    mode[first + flow] = next_regime(state.gas, mode[first + flow], solenoid_sides(state)[flow])
