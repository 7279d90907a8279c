"""Motion of the piston in smooth stretches: contacts, starts from rest, corners of tables, regimes of flow.

The pieces are what the march needs to locate every jump of the laws; see `apesim.march.hybrid_system`.
"""

import numpy as np

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
    Actuator,
    ActuatorTables,
    state_of,
)
from apesim.valve.groove import piece_line, piece_of
from apesim.valve.ledger import update_motion, valve_states
from apesim.valve.piston import (
    HELD_CLOSED,
    HELD_OPEN,
    STUCK,
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
from apesim.valve.supply import ValveSupply
from apesim.valve.terms import BRANCH, BREAKAWAY, FORCE, TERMS, ValveState

MET_CLOSED, MET_OPEN, LEFT, TURNED, CORNER, FLOW = range(6)
"""Events: contact with the closed and the open stop, start from rest, speed through zero, corner of the groove's
table; from FLOW on, one of the flows through the solenoids into another regime.
"""
BRANCHED = FLOW + FLOWS
"""Event: an effect goes over to another branch of its law."""
CREEP = 1e-6
"""Speed against its direction up to which a piston has not turned [m/s]; chosen above the error of a step, or one that
creeps would turn at every step."""
ONE_PERCENT, NEAR_OPEN, SPEED_EXTREMUM = range(3)
"""Zero crossings: 1 % of the stroke from closed and from open, extremum of the speed."""
DETECTED = 0.01
"""Share of the stroke at which a motion counts as begun: chosen, Fig. 7 of the EPV paper (doi 10.1631/jzus.A0820373)
names no share."""


@kernel
def rest_forces(actuator: Actuator, state: ValveState) -> tuple[float, float]:
    """Return the force on a piston at rest, and what holds it.

    The force is that of Eq. 1 of the EPV paper (doi 10.1631/jzus.A0820373) without dry friction, what holds is the
    static friction of its Eq. 2.

    Parameters
    ----------
    actuator : apesim.valve.actuator.Actuator
        Valve as the kernels take it.
    state : apesim.valve.terms.ValveState
        State of the valve.

    Returns
    -------
    force : float
        Force without dry friction, positive to closed [N].
    breakaway : float
        Dry friction that holds it, without sign [N].

    Examples
    --------
    >>> import apesim
    >>> import numpy as np
    >>> from apesim.air import GasState
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> y = closed_at_rest(actuator, supply.control)
    >>> force, breakaway = rest_forces(actuator, state_of(actuator, y, supply))
    >>> round(float(force), 2), breakaway
    (1002.74, 0.0)
    """
    force = smooth_force(
        actuator.valve, state.position, state.speed, state.chamber_a.pressure, state.chamber_b.pressure
    )
    if len(actuator.effects) > 0:
        balance = zeros(TERMS)
        add_laws(actuator.effects, state, balance)
        return force + balance[FORCE], balance[BREAKAWAY]
    return force, 0.0


@kernel
def branches_of(actuator: Actuator, state: ValveState) -> float:
    """Return on which branches of their laws the effects are, as one number, see `apesim.effect.note_branch`.

    It is 0 without effects.
    """
    if len(actuator.effects) > 0:
        balance = zeros(TERMS)
        add_laws(actuator.effects, state, balance)
        return balance[BRANCH]
    return 0.0


@kernel
def actuator_events(actuator: Actuator, y: np.ndarray, mode: np.ndarray, supply: ValveSupply, g: np.ndarray) -> None:
    """Write the values of the valve's events into `g` (>= BRANCHED + 1,); an event happens where it rises above zero.

    `y` (>= 6,) has position [m], speed [m/s], mass [kg] and energy [J] of chamber A, mass and energy of chamber B;
    `mode` (>= MODES,) its modes.
    """
    phase = mode[PHASE]
    stroke = actuator.valve.stroke
    moving = is_moving(phase)
    state = state_of(actuator, y, supply)
    solenoid_events(state, mode, REGIME, g, FLOW)
    if len(actuator.effects) > 0:
        g[BRANCHED] = -1.0 if branches_of(actuator, state) == mode[BRANCHES] else 1.0
    g[MET_CLOSED] = state.position - stroke if moving else -1.0
    g[MET_OPEN] = -state.position if moving else -1.0
    g[TURNED] = -phase * state.speed - CREEP if moving else -1.0
    if moving:
        lift = stroke - state.position
        g[LEFT] = -1.0
        g[CORNER] = max(mode[PIECE_LOW] - lift, lift - mode[PIECE_HIGH])
    else:
        force, breakaway = rest_forces(actuator, state)
        g[LEFT] = overcome(phase, force, breakaway)
        g[CORNER] = -1.0


@kernel
def set_free(actuator: Actuator, y: np.ndarray, mode: np.ndarray, supply: ValveSupply) -> None:
    """Let a piston at rest start where the force on it exceeds what holds it: changes its phase in `mode`.

    `y` (>= 6,) has position [m], speed [m/s], mass [kg] and energy [J] of chamber A, mass and energy of chamber B;
    `mode` (>= MODES,) its modes.

    With chamber A at the pressure of chamber B the springs alone open the valve:

    >>> import apesim
    >>> import numpy as np
    >>> from apesim.air import GasState
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> y = closed_at_rest(actuator, supply.control)
    >>> from apesim.valve.actuator import MODES
    >>> mode = np.zeros(MODES)
    >>> mode[PHASE] = HELD_CLOSED
    >>> set_free(actuator, closed_at_rest(actuator, GasState(101325.0, 300.0)), mode, supply)
    >>> from apesim.valve.piston import TO_OPEN
    >>> bool(mode[PHASE] == TO_OPEN)
    True
    """
    force, breakaway = rest_forces(actuator, state_of(actuator, y, supply))
    if overcome(mode[PHASE], force, breakaway) > 0.0:
        mode[PHASE] = start_moving(mode[PHASE], force)


@kernel
def handle_actuator_event(
    actuator: Actuator,
    tables: ActuatorTables,
    event: int,
    y: np.ndarray,
    mode: np.ndarray,
    supply: ValveSupply,
) -> None:
    """Change state `y` and modes `mode` at an event of the valve, from MET_CLOSED to BRANCHED.

    `y` (>= 6,) has position [m], speed [m/s], mass [kg] and energy [J] of chamber A, mass and energy of chamber B;
    `mode` is (>= MODES,).
    """
    if event <= MET_OPEN:
        stop = HELD_CLOSED if event == MET_CLOSED else HELD_OPEN
        speed = valve_states(y).speed
        speed_after, mode[PHASE] = land(stop, speed, restitution(actuator.effects, abs(speed)))
        update_motion(y, actuator.valve.stroke if event == MET_CLOSED else 0.0, speed_after)
        if mode[PHASE] == stop:
            set_free(actuator, y, mode, supply)
    elif event == LEFT:
        force, _ = rest_forces(actuator, state_of(actuator, y, supply))
        mode[PHASE] = start_moving(mode[PHASE], force)
    elif event == TURNED:
        update_motion(y, valve_states(y).position, 0.0)
        mode[PHASE] = STUCK
        set_free(actuator, y, mode, supply)
    elif event == CORNER:
        lift = actuator.valve.stroke - valve_states(y).position
        # A piston that creeps goes against its phase.
        mode[PIECE] += 1.0 if lift - mode[PIECE_HIGH] > mode[PIECE_LOW] - lift else -1.0
        take_piece(tables, mode)
    elif FLOW <= event < BRANCHED:
        change_solenoid_regime(state_of(actuator, y, supply), event - FLOW, REGIME, mode)
    mode[BRANCHES] = branches_of(actuator, state_of(actuator, y, supply))


@kernel
def take_piece(tables: ActuatorTables, mode: np.ndarray) -> None:
    """Write the line of the current piece of the groove's table into the modes `mode` (>= MODES,).

    The default groove opens from 0 to 150 mm2 over 8 mm, a slope of 18.75 mm:

    >>> import apesim
    >>> import numpy as np
    >>> from apesim.air import GasState
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> y = closed_at_rest(actuator, supply.control)
    >>> from apesim.valve.actuator import MODES
    >>> mode = np.zeros(MODES)
    >>> mode[PIECE] = 1
    >>> take_piece(tables, mode)
    >>> round(float(mode[AREA_SLOPE]) * 1e3, 6)
    18.75
    """
    line = piece_line(tables.groove, int(mode[PIECE]))
    mode[AREA], mode[AREA_SLOPE], mode[PIECE_LOW], mode[PIECE_HIGH] = line


@kernel
def actuator_zero_crossings(
    actuator: Actuator, y: np.ndarray, acceleration: float, mode: np.ndarray, w: np.ndarray
) -> None:
    """Write the values whose zero crossings are located without ending a step.

    What is measured from them are the times of Fig. 7 of the EPV paper (doi 10.1631/jzus.A0820373).

    Parameters
    ----------
    actuator : apesim.valve.actuator.Actuator
        Valve as the kernels take it.
    y : (>= 6,) float array
        Position [m], speed [m/s], mass [kg] and energy [J] of chamber A, mass and energy of chamber B.
    acceleration : float
        Acceleration of the piston [m/s2].
    mode : (>= MODES,) float array
        Modes of the valve, see `apesim.valve.actuator`.
    w : (>= 3,) float array
        Values; filled.

    Examples
    --------
    A closed valve is 0.09 mm below 1 % of its stroke:

    >>> import apesim
    >>> import numpy as np
    >>> from apesim.air import GasState
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> y = closed_at_rest(actuator, supply.control)
    >>> w = np.zeros(3)
    >>> actuator_zero_crossings(actuator, y, 0.0, np.zeros(20), w)
    >>> round(float(w[ONE_PERCENT]) * 1e3, 6)
    -0.09
    """
    stroke = actuator.valve.stroke
    lift = stroke - valve_states(y).position
    w[ONE_PERCENT] = lift - DETECTED * stroke
    w[NEAR_OPEN] = lift - (1.0 - DETECTED) * stroke
    w[SPEED_EXTREMUM] = acceleration


@kernel
def put_at_rest(actuator: Actuator, y: np.ndarray, mode: np.ndarray) -> None:
    """Put a piston at rest where it can rest: on its stop, or between the stops, and without speed; changes `y`.

    A march leaves it there; a step of the search for the periodic state may not. `y` (>= 6,) begins with position [m]
    and speed [m/s]; `mode` (>= MODES,) has the phase.

    >>> import apesim
    >>> import numpy as np
    >>> from apesim.valve.actuator import MODES, actuator_of
    >>> from apesim.valve.piston import STUCK
    >>> actuator, tables = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> y, mode = np.zeros(6), np.zeros(MODES)
    >>> y[:2], mode[PHASE] = (10e-3, 0.2), STUCK
    >>> put_at_rest(actuator, y, mode)
    >>> y[:2].tolist()
    [0.009, 0.0]
    """
    phase = mode[PHASE]
    if is_moving(phase):
        return
    stroke = actuator.valve.stroke
    if phase == STUCK:
        update_motion(y, min(max(valve_states(y).position, 0.0), stroke), 0.0)
    else:
        update_motion(y, stroke if phase == HELD_CLOSED else 0.0, 0.0)


@kernel
def start_actuator_segment(
    actuator: Actuator,
    tables: ActuatorTables,
    t: float,
    t_end: float,
    y: np.ndarray,
    mode: np.ndarray,
    supply: ValveSupply,
) -> None:
    """Write what is constant over a smooth stretch into the modes, and put a piston at rest where it can rest.

    Constant from `t` to `t_end` [s] are the piece of the groove's table, the solenoids' lines over time, the regimes of
    the flows and the branches of the effects. `y` (>= 6,) has position [m], speed [m/s], mass [kg] and energy [J] of
    chamber A, mass and energy of chamber B; `mode` (>= MODES,) and, of a piston at rest, `y` are changed.
    """
    put_at_rest(actuator, y, mode)
    mode[PIECE] = piece_of(tables.groove, actuator.valve.stroke - valve_states(y).position)
    take_piece(tables, mode)
    mode[START] = t
    x_a = energised_fraction(tables.edges_a, tables.period, tables.curves_a, t)
    x_b = energised_fraction(tables.edges_b, tables.period, tables.curves_b, t)
    x_a_end = energised_fraction(tables.edges_a, tables.period, tables.curves_a, t_end)
    x_b_end = energised_fraction(tables.edges_b, tables.period, tables.curves_b, t_end)
    mode[X_A], mode[X_A_SLOPE] = x_a, (x_a_end - x_a) / (t_end - t)
    mode[X_B], mode[X_B_SLOPE] = x_b, (x_b_end - x_b) / (t_end - t)
    shares, shares_end = open_shares(x_a, x_b), open_shares(x_a_end, x_b_end)
    state = state_of(actuator, y, supply)
    start_solenoid_segment(state, shares, shares_end, REGIME, mode)
    mode[BRANCHES] = branches_of(actuator, state)
