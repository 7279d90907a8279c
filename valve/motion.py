"""How the piston's motion breaks up into smooth stretches: contacts, starts from rest, corners of tables,
regimes of flow."""

from apesim.effect import add_laws, restitution
from apesim.kernel import kernel
from apesim.stack_array import zeros
from apesim.valve.actuator import (
    AREA,
    AREA_SLOPE,
    BRANCHES,
    PHASE,
    PIECE,
    PIECE_HIGH,
    PIECE_LOW,
    REGIME,
    START,
    X_A,
    X_A_SLOPE,
    X_B,
    X_B_SLOPE,
    state_of,
)
from apesim.valve.groove import piece_line, piece_of
from apesim.valve.piston import (
    HELD_CLOSED,
    HELD_OPEN,
    STUCK,
    TO_OPEN,
    is_moving,
    land,
    overcome,
    smooth_force,
    start_moving,
)
from apesim.valve.solenoid import energised_fraction
from apesim.valve.solenoid_flow import (
    FLOWS,
    change_solenoid_regime,
    open_shares,
    solenoid_events,
    start_solenoid_segment,
)
from apesim.valve.terms import BRANCH, BREAKAWAY, FORCE, TERMS

MET_CLOSED, MET_OPEN, LEFT, TURNED, CORNER, FLOW = range(6)
"""Events: contact with the closed and the open stop, start from rest, speed through zero, corner of the groove's
table; from FLOW on, one of the flows through the solenoids into another regime."""
BRANCHED = FLOW + FLOWS
"""Event: an effect on another branch of its law."""
ONE_PERCENT, NEAR_OPEN, SPEED_EXTREMUM = range(3)
"""Zero crossings: 1 % of the stroke from closed and from open, extremum of the speed."""
DETECTED = 0.01
"""Share of the stroke at which a motion counts as begun (Fig. 7)."""


@kernel
def rest_forces(actuator, state):
    """Force on a piston without dry friction, and what holds it at rest [N]."""
    force = smooth_force(actuator.valve, state.position, state.speed, state.pressure_a, state.pressure_b)
    if len(actuator.effects) > 0:
        balance = zeros(TERMS)
        add_laws(actuator.effects, state, balance)
        return force + balance[FORCE], balance[BREAKAWAY]
    return force, 0.0


@kernel
def branches_of(actuator, state):
    """On which branches of their laws the effects are."""
    if len(actuator.effects) > 0:
        balance = zeros(TERMS)
        add_laws(actuator.effects, state, balance)
        return balance[BRANCH]
    return 0.0


@kernel
def actuator_events(actuator, y, mode, supply, g):
    """Values of the valve's events."""
    phase = mode[PHASE]
    stroke = actuator.valve.stroke
    moving = is_moving(phase)
    state = state_of(actuator, y, supply)
    solenoid_events(state, mode, REGIME, g, FLOW)
    if len(actuator.effects) > 0:
        g[BRANCHED] = -1.0 if branches_of(actuator, state) == mode[BRANCHES] else 1.0
    g[MET_CLOSED] = y[0] - stroke if moving else -1.0
    g[MET_OPEN] = -y[0] if moving else -1.0
    g[TURNED] = -phase * y[1] if moving else -1.0
    if moving:
        lift = stroke - y[0]
        g[LEFT] = -1.0
        g[CORNER] = max(mode[PIECE_LOW] - lift, lift - mode[PIECE_HIGH])
    else:
        force, breakaway = rest_forces(actuator, state)
        g[LEFT] = overcome(phase, force, breakaway)
        g[CORNER] = -1.0


@kernel
def set_free(actuator, y, mode, supply):
    """Let a piston at rest start where the force on it exceeds what holds it."""
    force, breakaway = rest_forces(actuator, state_of(actuator, y, supply))
    if overcome(mode[PHASE], force, breakaway) > 0.0:
        mode[PHASE] = start_moving(mode[PHASE], force)


@kernel
def handle_actuator_event(actuator, tables, event, y, mode, supply):
    """What the valve does at an event of its own."""
    if event <= MET_OPEN:
        stop = HELD_CLOSED if event == MET_CLOSED else HELD_OPEN
        y[0] = actuator.valve.stroke if event == MET_CLOSED else 0.0
        e = restitution(actuator.effects, abs(y[1]))
        y[1], mode[PHASE] = land(stop, y[1], e)
        if mode[PHASE] == stop:
            set_free(actuator, y, mode, supply)
    elif event == LEFT:
        force, _ = rest_forces(actuator, state_of(actuator, y, supply))
        mode[PHASE] = start_moving(mode[PHASE], force)
    elif event == TURNED:
        y[1] = 0.0
        mode[PHASE] = STUCK
        set_free(actuator, y, mode, supply)
    elif event == CORNER:
        mode[PIECE] += 1.0 if mode[PHASE] == TO_OPEN else -1.0
        take_piece(tables, mode)
    elif FLOW <= event < BRANCHED:
        change_solenoid_regime(state_of(actuator, y, supply), event - FLOW, REGIME, mode)
    mode[BRANCHES] = branches_of(actuator, state_of(actuator, y, supply))


@kernel
def take_piece(tables, mode):
    """Take over the line of the current piece of the groove's table."""
    line = piece_line(tables.groove, int(mode[PIECE]))
    mode[AREA], mode[AREA_SLOPE], mode[PIECE_LOW], mode[PIECE_HIGH] = line


@kernel
def actuator_zero_crossings(actuator, y, acceleration, mode, w):
    """Values of the valve's zero crossings."""
    stroke = actuator.valve.stroke
    lift = stroke - y[0]
    w[ONE_PERCENT] = lift - DETECTED * stroke
    w[NEAR_OPEN] = lift - (1.0 - DETECTED) * stroke
    w[SPEED_EXTREMUM] = acceleration


@kernel
def start_actuator_segment(actuator, tables, t, t_end, y, mode, supply):
    """Set what the valve keeps over a stretch: piece of the groove's table, the solenoids' lines, regimes of flow."""
    mode[PIECE] = piece_of(tables.groove, actuator.valve.stroke - y[0])
    take_piece(tables, mode)
    mode[START] = t
    x_a = energised_fraction(tables.edges_a, tables.period, tables.curve_a, t)
    x_b = energised_fraction(tables.edges_b, tables.period, tables.curve_b, t)
    x_a_end = energised_fraction(tables.edges_a, tables.period, tables.curve_a, t_end)
    x_b_end = energised_fraction(tables.edges_b, tables.period, tables.curve_b, t_end)
    mode[X_A], mode[X_A_SLOPE] = x_a, (x_a_end - x_a) / (t_end - t)
    mode[X_B], mode[X_B_SLOPE] = x_b, (x_b_end - x_b) / (t_end - t)
    shares, shares_end = open_shares(x_a, x_b), open_shares(x_a_end, x_b_end)
    state = state_of(actuator, y, supply)
    start_solenoid_segment(state, shares, shares_end, REGIME, mode)
    mode[BRANCHES] = branches_of(actuator, state)
