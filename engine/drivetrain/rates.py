"""Rates, events and traces of a drivetrain: all cylinders with their valves, receivers and shaft in one march."""

import numpy as np

from apesim.air import GasContent, enthalpy
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cycle.cylinder_laws import (
    TRACE,
    cylinder_events,
    cylinder_rates,
    cylinder_zero_crossings,
    handle_cylinder_event,
    observe_cylinder,
    start_cylinder_segment,
    start_window,
    temperature_rate,
)
from apesim.engine.cycle.gas_exchange import add_flow
from apesim.engine.cycle.operating_point import MAX_TURN
from apesim.engine.cycle.state import (
    CYLINDER,
    RECEIVER,
    Cycle,
    cylinder_gas,
    receiver_gas,
)
from apesim.engine.cylinder import EPV, MAX_CYLINDERS, indicated_power
from apesim.engine.drivetrain.corners import (
    find_command,
    issue_edge,
    leaves,
    pass_command,
    pass_corner,
    shift_turn,
)
from apesim.engine.drivetrain.shaft_balance import (
    breaks_away,
    come_to_rest,
    driving_torque,
    gas_torque,
    resistance_at,
)
from apesim.engine.drivetrain.state import (
    ACCELERATION,
    ANGLE,
    ANGLE_REACHED,
    BLOCK,
    COMMAND_HIGH,
    COMMAND_LOW,
    COMMANDED,
    CONTROL,
    CORNER_HIGH,
    CORNER_LOW,
    DIRECTION,
    ENERGISE,
    EXCHANGED_HEAT,
    FRICTION_PRESSURE,
    FRICTION_WORK,
    GAS_WORK,
    HELD_SINCE,
    LOAD,
    LOAD_WORK,
    MAX_PRESSURE,
    MAX_RECEIVER,
    MAX_SPEED,
    MAX_TORQUE,
    MIN_RECEIVER,
    MIN_SPEED,
    MIN_TORQUE,
    NEXT_TIME,
    PEAK,
    RELEASE,
    SPEED,
    SPEED_REACHED,
    SUPPLY,
    TURNS,
    WALL_HEAT,
    Drivetrain,
    DrivetrainTables,
    block_of,
    cylinder_of,
    cylinders_of,
    ledger_at,
    ledger_place,
    own_angle,
    own_extremes,
    own_modes,
    shaft_extremes,
    shaft_ledger,
    shaft_modes,
    shaft_states,
    surroundings_of,
    tables_of,
)
from apesim.engine.kinematics import cylinder_volume, volume_curvature
from apesim.kernel import kernel
from apesim.linear_table import read_table
from apesim.march.adaptive import EVENTS
from apesim.march.hybrid_system import (
    event_count,
    events,
    finish_step,
    handle_event,
    is_final,
    is_followed,
    max_short_steps,
    observe,
    power,
    rates,
    segment_end,
    start_segment,
    step_share,
    zero_crossings,
)
from apesim.packed import unpacked
from apesim.restriction import Flow
from apesim.stack_array import zeros
from apesim.valve.actuator import MAX_STEP
from apesim.valve.chamber import chamber_state
from apesim.valve.edges import next_corner_time
from apesim.valve.ledger import FLOW_ENTRIES, ledger_flow

LONGEST_STEP = MAX_STEP
"""Longest step [s], of a shaft at rest, too: stability would hold most of longer ones, which would count as stiff."""
CORNER_PASSED, COMMAND_PASSED, OWN_EVENTS = range(EVENTS, EVENTS + 3)
"""Events of a cylinder behind those of a cycle: a corner is passed, an end of its command; how many there are."""
HALTED, BROKE_AWAY, REVOLVED, REACHED_ANGLE, REACHED_SPEED, HELD_LONG, SHAFT_EVENTS = range(7)
"""Events of the shaft, behind those of all cylinders: speed zero, breakaway from rest, an end of a revolution passed,
the angle and the speed reached that are waited for, held for the longest time; how many there are."""
ADIABATIC = 0.4
"""Exponent of the volume by which the energy of shut air changes, k - 1 of ideal air; near it for others."""
SHAFT_TRACE = (
    "angle [deg]",
    "speed [rpm]",
    "gas_torque [N m]",
    "friction_torque [N m]",
    "load_torque [N m]",
)
"""Columns of a trace; behind them, for each cylinder, `apesim.engine.cycle.cylinder_laws.TRACE`."""
FLOWS_IN = FLOW_ENTRIES * MAX_CYLINDERS
"""Entries of the flows into the receivers of all blocks."""


@event_count.for_type(Drivetrain)
@kernel
def drivetrain_event_count(p: Drivetrain) -> int:
    """Return how many events a drivetrain has."""
    return OWN_EVENTS * cylinders_of(p) + SHAFT_EVENTS


@is_followed.for_type(Drivetrain)
@kernel
def drivetrain_is_followed(p: Drivetrain) -> bool:
    """Return whether zero crossings are located; usually `keep_extremes` and the ledger do."""
    return p.is_followed == 1


@zero_crossings.for_type(Drivetrain)
@kernel
def drivetrain_zero_crossings(
    p: Drivetrain, t: float, y: np.ndarray, dy: np.ndarray, mode: np.ndarray, w: np.ndarray
) -> None:
    """Write what is located where it crosses zero, of each cylinder at the number of its first event."""
    if p.is_followed == 0:
        return
    for i in range(cylinders_of(p)):
        c = cylinder_of(p, y, mode, i)
        now, own_w = surroundings_of(p, c, y, mode, i), w[OWN_EVENTS * i : OWN_EVENTS * (i + 1)]
        cylinder_zero_crossings(c, now, block_of(y, i), block_of(dy, i), own_modes(mode, i), own_w)


@power.for_type(Drivetrain)
@kernel
def drivetrain_power(p: Drivetrain, t: float, y: np.ndarray) -> float:
    """Power of the gas above ambient pressure on the pistons of all cylinders."""
    place, torque = shaft_states(p), 0.0
    for i in range(cylinders_of(p)):
        c: Cycle = unpacked(p.template, p.numbers, i)
        volume, slope = cylinder_volume(c.crank, own_angle(p, y, i))
        pressure = chamber_state(c.actuator.gas, cylinder_gas(block_of(y, i)), volume).pressure
        torque += indicated_power(pressure, c.actuator.ambient.pressure, slope, 1.0)
    return torque * y[place + SPEED]


@max_short_steps.for_type(Drivetrain)
@kernel
def drivetrain_max_short_steps(p: Drivetrain) -> int:
    """Return so many that a slow turn past a dead centre, where a small volume fills, does not count as stiff."""
    return 20000


@kernel
def exchanged_heat(p: Drivetrain, c: Cycle, exhausted: Flow, temperature: float) -> float:
    """Heat that the exchanger gives to the air that flows forward out of a cylinder; none to what flows back.

    ``Q = mdot (h(T + eps (T_x - T)) - h(T))``, with the effectiveness eps and the temperature T_x of the exchanger.

    The effectiveness is defined here as the share of the way to that temperature.

    Parameters
    ----------
    p : apesim.engine.drivetrain.state.Drivetrain
        Cylinders on one shaft.
    c : apesim.engine.cycle.state.Cycle
        Cylinder.
    exhausted : apesim.restriction.Flow
        Flow mdot out of the cylinder.
    temperature : float
        Temperature T in the cylinder [K].

    Returns
    -------
    float
        Heat flow [W].

    Examples
    --------
    Half of the way from 200 K to 300 K, of 1 g/s with a heat capacity of 1004.7 J/(kg K):

    >>> from apesim.engine.drivetrain.preparing import prepare
    >>> from apesim.engine.drivetrain.state import Exchanger
    >>> from apesim.engine.machine import Machine
    >>> p = prepare(Machine(), 0.5).p._replace(exchanger=Exchanger(0.5, 300.0, 0.0))
    >>> flow = Flow(1e-3, 1e-3 * enthalpy(p.template.actuator.gas, 200.0))
    >>> round(exchanged_heat(p, p.template, flow, 200.0), 2)
    50.23
    """
    if exhausted.mass <= 0.0:
        return 0.0
    warmed = temperature + p.exchanger.effectiveness * (p.exchanger.temperature - temperature)
    return exhausted.mass * enthalpy(c.actuator.gas, warmed) - exhausted.enthalpy


@rates.for_type(Drivetrain)
@kernel
def drivetrain_rates(p: Drivetrain, t: float, y: np.ndarray, mode: np.ndarray, dy: np.ndarray) -> bool:
    """Write the rates of a drivetrain's state vector: of all cylinders, their receivers, the shaft, and the ledgers.

    ``J domega/dt = sum((p - p_0) dV/dtheta) - F - L`` [1]_, with the inertia J, the friction F against the motion and
    the load L; of an imposed speed the slope is given. What several cylinders draw from one receiver is summed there.

    Parameters
    ----------
    p : apesim.engine.drivetrain.state.Drivetrain
        Cylinders on one shaft.
    t : float
        Time [s].
    y : (state_size,) float array
        State vector.
    mode : (k,) float array
        Modes.
    dy : (state_size,) float array
        Rates of the state vector; changed.

    Returns
    -------
    bool
        Whether the state is in its domain.

    References
    ----------
    .. [1] J. B. Heywood, "Internal Combustion Engine Fundamentals", McGraw-Hill, 1988, section 2.2.

    Examples
    --------
    At rest, with all valves closed, the shaft is held:

    >>> from apesim.engine.drivetrain.preparing import prepare
    >>> from apesim.engine.machine import Machine
    >>> p, _, y, mode, _ = prepare(Machine(), 0.5)
    >>> dy = np.zeros_like(y)
    >>> drivetrain_rates(p, 0.0, y, mode, dy), float(dy[shaft_states(p) + SPEED])
    (True, 0.0)
    """
    first, ledger, modes = shaft_states(p), shaft_ledger(p), shaft_modes(p)
    speed, direction = y[first + SPEED], mode[modes + DIRECTION]
    flows_in: np.ndarray = zeros(FLOWS_IN)  # type: ignore[call-arg]
    torque = heat = wall_heat = 0.0

    # Each cylinder by its own laws; what it draws and exhausts is put down for the receivers.
    for i in range(cylinders_of(p)):
        c = cylinder_of(p, y, mode, i)
        now, block, own = surroundings_of(p, c, y, mode, i), block_of(y, i), own_modes(mode, i)
        exchanged = cylinder_rates(c, t, now, block, own, block_of(dy, i), ledger_at(dy, ledger_place(p, i)))
        if not exchanged.in_domain:
            return False
        torque += exchanged.torque
        if p.sources[i] != i:
            add_flow(flows_in, p.sources[i], exchanged.receiver)
        if p.sinks[i] >= 0:
            warmed = exchanged_heat(p, c, exchanged.outside, exchanged.temperature)
            heat += warmed
            add_flow(flows_in, p.sinks[i], Flow(exchanged.outside.mass, exchanged.outside.enthalpy + warmed))
            if p.exchanger.wall_conductance > 0.0:
                into = p.exchanger.wall_conductance * (p.exchanger.temperature - now.behind_exhaust.temperature)
                wall_heat += into
                add_flow(flows_in, p.sinks[i], Flow(0.0, into))
    for i in range(cylinders_of(p)):
        holder: Cycle = unpacked(p.template, p.numbers, i)
        if holder.receiver_volume > 0.0:
            flow = ledger_flow(flows_in, FLOW_ENTRIES * i)
            dy[BLOCK * i + RECEIVER] += flow.mass
            dy[BLOCK * i + RECEIVER + 1] += flow.enthalpy

    # The shaft, and its ledger.
    resistance = resistance_at(p, y, mode, abs(speed))
    against = direction * (resistance.friction + resistance.brake) + resistance.hoist
    if p.is_imposed:
        dy[first + SPEED] = mode[modes + ACCELERATION]
    else:
        dy[first + SPEED] = (torque - against) / p.shaft.inertia if direction != 0.0 else 0.0
    dy[first + ANGLE] = speed
    dy[ledger + GAS_WORK] = torque * speed
    dy[ledger + FRICTION_WORK] = direction * resistance.friction * speed
    dy[ledger + LOAD_WORK] = (direction * resistance.brake + resistance.hoist) * speed
    dy[ledger + EXCHANGED_HEAT], dy[ledger + WALL_HEAT] = heat, wall_heat
    for i in range(shaft_extremes(p), dy.shape[0]):
        dy[i] = 0.0
    return True


@step_share.for_type(Drivetrain)
@kernel
def drivetrain_step_share(p: Drivetrain, y: np.ndarray, mode: np.ndarray) -> float:
    """Return the longest step as a share of `LONGEST_STEP`, that of a valve which moves: `MAX_TURN` of the crank."""
    return min(1.0, MAX_TURN / max(LONGEST_STEP * abs(y[shaft_states(p) + SPEED]), 1e-300))


@events.for_type(Drivetrain)
@kernel
def drivetrain_events(p: Drivetrain, t: float, y: np.ndarray, mode: np.ndarray, g: np.ndarray) -> None:
    """Write the values of a drivetrain's events into `g` (n,): of each cylinder, then of the shaft."""
    for i in range(cylinders_of(p)):
        c, own, angle = cylinder_of(p, y, mode, i), own_modes(mode, i), own_angle(p, y, i)
        own_g = g[OWN_EVENTS * i : OWN_EVENTS * (i + 1)]
        cylinder_events(c, surroundings_of(p, c, y, mode, i), block_of(y, i), own, own_g)
        own_g[CORNER_PASSED] = leaves(angle, own[CORNER_LOW], own[CORNER_HIGH])
        own_g[COMMAND_PASSED] = leaves(angle, own[COMMAND_LOW], own[COMMAND_HIGH]) if c.engine.intake == EPV else -1.0
    first, modes = OWN_EVENTS * cylinders_of(p), shaft_modes(p)
    angle, speed = y[shaft_states(p) + ANGLE], y[shaft_states(p) + SPEED]
    direction = mode[modes + DIRECTION]
    is_held = direction == 0.0 and p.is_imposed == 0
    g[first + HALTED] = -1.0 if direction == 0.0 else -direction * speed
    g[first + BROKE_AWAY] = breaks_away(p, y, mode) if is_held else -1.0
    g[first + REVOLVED] = leaves(angle, 0.0, TURN)
    goal = p.goal
    g[first + REACHED_ANGLE] = -1.0 if mode[modes + ANGLE_REACHED] else mode[modes + TURNS] * TURN + angle - goal.angle
    g[first + REACHED_SPEED] = -1.0 if mode[modes + SPEED_REACHED] else speed - goal.speed
    g[first + HELD_LONG] = t - mode[modes + HELD_SINCE] - goal.max_rest if is_held else -1.0


@kernel
def pass_own_corner(p: Drivetrain, tables: DrivetrainTables, i: int, t: float, y: np.ndarray, mode: np.ndarray) -> None:
    """Take cylinder `i` over a corner of its own angle: its ports, the pressure of its friction, its schedule."""
    own, angle = own_modes(mode, i), own_angle(p, y, i)
    is_forward = angle > own[CORNER_HIGH]
    passed = pass_corner(p.corners[i], is_forward, own)
    if passed == 0:
        peak = own_extremes(p, i) + PEAK
        own[FRICTION_PRESSURE] = y[peak]
        y[peak] = 0.0
    if passed == p.read_corners[i] and is_forward:
        schedule, speed = p.schedules[i], abs(y[shaft_states(p) + SPEED])
        own[ENERGISE], own[RELEASE] = read_table(schedule, speed, 1), read_table(schedule, speed, 2)
        is_on = find_command(angle, own)
        if is_on != (own[COMMANDED] > 0.0):
            issue_edge(p, tables_of(tables, own, i), i, t, own)


@kernel
def start_own_segment(
    p: Drivetrain, tables: DrivetrainTables, i: int, t: float, t_end: float, y: np.ndarray, mode: np.ndarray
) -> None:
    """Set the modes of cylinder `i` for a smooth segment from `t` to `t_end` [s]."""
    c, own = cylinder_of(p, y, mode, i), own_modes(mode, i)
    now, middle = surroundings_of(p, c, y, mode, i), 0.5 * (own[CORNER_LOW] + own[CORNER_HIGH])
    start_cylinder_segment(c, tables_of(tables, own, i), t, t_end, now, middle, block_of(y, i), own)


@kernel
def end_revolution(p: Drivetrain, y: np.ndarray, mode: np.ndarray) -> None:
    """Let the shaft's angle begin anew, a turn further or back, and its extremes with it."""
    place = shaft_states(p) + ANGLE
    turn = TURN if y[place] > 0.5 * TURN else -TURN
    y[place] -= turn
    mode[shaft_modes(p) + TURNS] += turn / TURN
    for i in range(cylinders_of(p)):
        shift_turn(-turn, own_modes(mode, i))
    begin_extremes(p, y)


@kernel
def begin_extremes(p: Drivetrain, y: np.ndarray) -> None:
    """Let the extremes of a revolution begin anew, all but the pressures that friction follows; changes `y`."""
    first = shaft_extremes(p)
    y[first + MIN_SPEED], y[first + MAX_SPEED] = np.inf, -np.inf
    y[first + MIN_TORQUE], y[first + MAX_TORQUE] = np.inf, -np.inf
    for i in range(cylinders_of(p)):
        own = own_extremes(p, i)
        y[own + MAX_PRESSURE], y[own + MIN_RECEIVER], y[own + MAX_RECEIVER] = -np.inf, np.inf, -np.inf


@handle_event.for_type(Drivetrain)
@kernel
def handle_drivetrain_event(
    p: Drivetrain, tables: DrivetrainTables, event: int, t: float, y: np.ndarray, mode: np.ndarray
) -> None:
    """Change state and modes at an event of a drivetrain: of one of its cylinders, or of its shaft."""
    i, own_event = event // OWN_EVENTS, event % OWN_EVENTS
    modes = shaft_modes(p)
    if i < cylinders_of(p):
        own = own_modes(mode, i)
        if own_event == CORNER_PASSED:
            pass_own_corner(p, tables, i, t, y, mode)
            c = cylinder_of(p, y, mode, i)
            now, middle = surroundings_of(p, c, y, mode, i), 0.5 * (own[CORNER_LOW] + own[CORNER_HIGH])
            start_window(c, tables_of(tables, own, i), now, middle, block_of(y, i), own)
        elif own_event == COMMAND_PASSED:
            pass_command(own_angle(p, y, i) > own[COMMAND_HIGH], own)
            issue_edge(p, tables_of(tables, own, i), i, t, own)
        else:
            c = cylinder_of(p, y, mode, i)
            now = surroundings_of(p, c, y, mode, i)
            handle_cylinder_event(c, tables_of(tables, own, i), own_event, now, block_of(y, i), own)
        return
    shaft_event = event - OWN_EVENTS * cylinders_of(p)
    if shaft_event == HALTED:
        come_to_rest(p, t, y, mode)
    elif shaft_event == BROKE_AWAY:
        mode[modes + DIRECTION] = np.sign(driving_torque(p, y, mode))
    elif shaft_event == REVOLVED:
        end_revolution(p, y, mode)
    elif shaft_event == REACHED_ANGLE:
        mode[modes + ANGLE_REACHED] = 1.0
    elif shaft_event == REACHED_SPEED:
        mode[modes + SPEED_REACHED] = 1.0


@is_final.for_type(Drivetrain)
@kernel
def drivetrain_is_final(p: Drivetrain, event: int, mode: np.ndarray) -> bool:
    """Return whether all that was waited for is reached, a revolution ends that was, or the shaft is held for long."""
    shaft_event, modes = event - OWN_EVENTS * cylinders_of(p), shaft_modes(p)
    if shaft_event == REVOLVED:
        return p.goal.ends_with_revolution == 1
    if shaft_event in (REACHED_ANGLE, REACHED_SPEED):
        return mode[modes + ANGLE_REACHED] > 0.0 and mode[modes + SPEED_REACHED] > 0.0
    return shaft_event == HELD_LONG


@segment_end.for_type(Drivetrain)
@kernel
def drivetrain_segment_end(
    p: Drivetrain, tables: DrivetrainTables, t: float, breakpoint: float, mode: np.ndarray
) -> float:
    """Return when a solenoid of any cylinder has its next corner, or the next breakpoint if that is sooner [s]."""
    end = breakpoint
    if p.template.engine.intake == EPV:
        for i in range(cylinders_of(p)):
            own = own_modes(mode, i)
            if own[NEXT_TIME] <= t:
                own[NEXT_TIME] = next_corner_time(tables_of(tables, own, i).valve, t)
            end = min(end, own[NEXT_TIME])
    return end


@start_segment.for_type(Drivetrain)
@kernel
def start_drivetrain_segment(
    p: Drivetrain, tables: DrivetrainTables, t: float, t_end: float, y: np.ndarray, mode: np.ndarray
) -> None:
    """Set the modes of a smooth segment from `t` to `t_end` [s]: load, supply and imposed speed, then each cylinder."""
    modes, middle = shaft_modes(p), 0.5 * (t + t_end)
    mode[modes + LOAD] = tables.loads[row_at(tables.loads, middle), 1]
    row = row_at(tables.supplies, middle)
    mode[modes + SUPPLY], mode[modes + CONTROL] = tables.supplies[row, 1], tables.supplies[row, 2]
    if p.is_imposed:
        speeds, place = tables.speeds, shaft_states(p) + SPEED
        row = min(row_at(speeds, middle), speeds.shape[0] - 2)
        slope = (speeds[row + 1, 1] - speeds[row, 1]) / (speeds[row + 1, 0] - speeds[row, 0])
        y[place] = speeds[row, 1] + slope * (t - speeds[row, 0])
        mode[modes + ACCELERATION] = slope
        mode[modes + DIRECTION] = np.sign(y[place] + slope * (middle - t))
    elif mode[modes + DIRECTION] == 0.0 and breaks_away(p, y, mode) > 0.0:
        mode[modes + DIRECTION] = np.sign(driving_torque(p, y, mode))
    for i in range(cylinders_of(p)):
        start_own_segment(p, tables, i, t, t_end, y, mode)


@kernel
def row_at(table: np.ndarray, t: float) -> int:
    """Find the last row of a table over time whose time [s], in the first column, is not after `t`; else the first."""
    row = table.shape[0] - 1
    while row > 0 and table[row, 0] > t:
        row -= 1
    return row


@kernel
def hermite(h: float, a: float, slope_a: float, b: float, slope_b: float, x: float) -> float:
    """Value at a share `x` of an interval of the length `h`, of the cubic through its ends with their slopes."""
    da, db, rise = h * slope_a, h * slope_b, b - a
    return a + x * (da + x * (3.0 * rise - 2.0 * da - db + x * (da + db - 2.0 * rise)))


@kernel
def peak_share(h: float, a: float, slope_a: float, b: float, slope_b: float) -> float:
    """Share of an interval at which the cubic through its ends is highest; an end of it where none is in between."""
    if not (slope_a > 0.0 and slope_b < 0.0):
        return 0.0 if a > b else 1.0
    # Zero of the slope, a parabola over the share of the interval that is above zero at 0 and below at 1.
    da, db, rise = h * slope_a, h * slope_b, b - a
    bend, tilt = 3.0 * (da + db - 2.0 * rise), 2.0 * (3.0 * rise - 2.0 * da - db)
    return 2.0 * da / (-tilt + np.sqrt(max(0.0, tilt * tilt - 4.0 * bend * da)))


@kernel
def largest_between(h: float, a: float, slope_a: float, b: float, slope_b: float) -> float:
    """Largest value over an interval of the length `h`, of the cubic through its ends with their slopes.

    >>> round(float(largest_between(2.0, 0.0, 1.0, 0.0, -1.0)), 9)
    0.5
    """
    return hermite(h, a, slope_a, b, slope_b, peak_share(h, a, slope_a, b, slope_b))


@kernel
def smallest_between(h: float, a: float, slope_a: float, b: float, slope_b: float) -> float:
    """Smallest value over an interval of the length `h`, of the cubic through its ends with their slopes."""
    return -largest_between(h, -a, -slope_a, -b, -slope_b)


@kernel
def pressure_and_slope(
    c: Cycle, content: GasContent, content_rates: GasContent, volume: float, widening: float
) -> tuple[float, float]:
    """Pressure of a gas [Pa abs] and its rate [Pa/s], in a volume [m3] that grows at a rate [m3/s]."""
    air = chamber_state(c.actuator.gas, content, volume)
    warming = temperature_rate(c, content, content_rates, air.temperature)
    relative = content_rates.mass / content.mass + warming / air.temperature - widening / volume
    return air.pressure, air.pressure * relative


@kernel
def torque_and_slope(
    c: Cycle, angle: float, speed: float, block: np.ndarray, block_rates: np.ndarray
) -> tuple[float, float, float, float]:
    """Pressure [Pa abs] in a cylinder and torque [N m] of its gas, and behind them the rates of both."""
    volume, slope = cylinder_volume(c.crank, angle)
    pressure, rising = pressure_and_slope(c, cylinder_gas(block), cylinder_gas(block_rates), volume, slope * speed)
    above = pressure - c.actuator.ambient.pressure
    return pressure, above * slope, rising, rising * slope + above * volume_curvature(c.crank, angle) * speed


@kernel
def expansion_of(c: Cycle, y: np.ndarray, phase: float, place: int) -> tuple[float, float]:
    """Volume of a cylinder to the power `ADIABATIC`, and the rate of its logarithm [1/s].

    Shut in, the product of that power and the internal energy hardly changes, and bends less than the energy.
    `place` is the element of the shaft's angle.
    """
    volume, slope = cylinder_volume(c.crank, y[place] - phase)
    return volume**ADIABATIC, ADIABATIC * slope * y[place + 1] / volume


@kernel
def torque_within(
    p: Drivetrain,
    h: float,
    x: float,
    y: np.ndarray,
    dy: np.ndarray,
    y_end: np.ndarray,
    dy_end: np.ndarray,
    mode: np.ndarray,
) -> float:
    """Torque of the gas in all cylinders at a share `x` of a step of the length `h` [N m], by cubics of the states."""
    place, torque = shaft_states(p) + ANGLE, 0.0
    angle = hermite(h, y[place], dy[place], y_end[place], dy_end[place], x)
    for i in range(cylinders_of(p)):
        c, gas = cylinder_of(p, y, mode, i), BLOCK * i + CYLINDER
        volume, slope = cylinder_volume(c.crank, angle - p.phases[i])
        before, widening = expansion_of(c, y, p.phases[i], place)
        after, widening_end = expansion_of(c, y_end, p.phases[i], place)
        energy = hermite(
            h,
            before * y[gas + 1],
            before * (dy[gas + 1] + widening * y[gas + 1]),
            after * y_end[gas + 1],
            after * (dy_end[gas + 1] + widening_end * y_end[gas + 1]),
            x,
        )
        mass = hermite(h, y[gas], dy[gas], y_end[gas], dy_end[gas], x)
        content = GasContent(mass, energy / volume**ADIABATIC)
        pressure = chamber_state(c.actuator.gas, content, volume).pressure
        torque += indicated_power(pressure, c.actuator.ambient.pressure, slope, 1.0)
    return torque


@finish_step.for_type(Drivetrain)
@kernel(inline=False)
def keep_extremes(
    p: Drivetrain,
    t: float,
    h: float,
    y: np.ndarray,
    dy: np.ndarray,
    y_end: np.ndarray,
    dy_end: np.ndarray,
    mode: np.ndarray,
) -> None:
    """Keep the extremes of pressures, speed and torque over a step, by the cubic through its ends; changes `y_end`."""
    shaft, first = shaft_states(p), shaft_extremes(p)
    speed, speed_end = y[shaft + SPEED], y_end[shaft + SPEED]
    torque = torque_end = slope = slope_end = 0.0
    for i in range(cylinders_of(p)):
        c, own = cylinder_of(p, y, mode, i), own_extremes(p, i)
        begin = torque_and_slope(c, own_angle(p, y, i), speed, block_of(y, i), block_of(dy, i))
        end = torque_and_slope(c, own_angle(p, y_end, i), speed_end, block_of(y_end, i), block_of(dy_end, i))
        torque, slope = torque + begin[1], slope + begin[3]
        torque_end, slope_end = torque_end + end[1], slope_end + end[3]
        peak = largest_between(h, begin[0], begin[2], end[0], end[2])
        y_end[own + PEAK] = max(y_end[own + PEAK], peak)
        y_end[own + MAX_PRESSURE] = max(y_end[own + MAX_PRESSURE], peak)
        if c.receiver_volume > 0.0:
            block, block_end = block_of(y, i), block_of(y_end, i)
            before, rising = pressure_and_slope(
                c, receiver_gas(block), receiver_gas(block_of(dy, i)), c.receiver_volume, 0.0
            )
            after, rising_end = pressure_and_slope(
                c, receiver_gas(block_end), receiver_gas(block_of(dy_end, i)), c.receiver_volume, 0.0
            )
            least = smallest_between(h, before, rising, after, rising_end)
            most = largest_between(h, before, rising, after, rising_end)
            y_end[own + MIN_RECEIVER] = min(y_end[own + MIN_RECEIVER], least)
            y_end[own + MAX_RECEIVER] = max(y_end[own + MAX_RECEIVER], most)
        elif p.sources[i] == i:  # an endless receiver is as the supply
            supply = mode[shaft_modes(p) + SUPPLY]
            y_end[own + MIN_RECEIVER] = min(y_end[own + MIN_RECEIVER], supply)
            y_end[own + MAX_RECEIVER] = max(y_end[own + MAX_RECEIVER], supply)
    growth, growth_end = dy[shaft + SPEED], dy_end[shaft + SPEED]
    y_end[first + MIN_SPEED] = min(y_end[first + MIN_SPEED], smallest_between(h, speed, growth, speed_end, growth_end))
    y_end[first + MAX_SPEED] = max(y_end[first + MAX_SPEED], largest_between(h, speed, growth, speed_end, growth_end))

    # The torque bends more than the gas does: at the share of its extremum it is found from the gas there.
    lowest = peak_share(h, -torque, -slope, -torque_end, -slope_end)
    highest = peak_share(h, torque, slope, torque_end, slope_end)
    low = torque_within(p, h, lowest, y, dy, y_end, dy_end, mode) if 0.0 < lowest < 1.0 else min(torque, torque_end)
    high = torque_within(p, h, highest, y, dy, y_end, dy_end, mode) if 0.0 < highest < 1.0 else max(torque, torque_end)
    y_end[first + MIN_TORQUE] = min(y_end[first + MIN_TORQUE], low)
    y_end[first + MAX_TORQUE] = max(y_end[first + MAX_TORQUE], high)


@observe.for_type(Drivetrain)
@kernel
def observe_drivetrain(p: Drivetrain, t: float, y: np.ndarray, mode: np.ndarray, row: np.ndarray) -> None:
    """Write a row of the trace: `SHAFT_TRACE`, then `apesim.engine.cycle.cylinder_laws.TRACE` of each cylinder."""
    first, modes, columns = shaft_states(p), shaft_modes(p), len(TRACE)
    speed, direction = y[first + SPEED], mode[modes + DIRECTION]
    resistance, torque = resistance_at(p, y, mode, abs(speed)), 0.0
    for i in range(cylinders_of(p)):
        c = cylinder_of(p, y, mode, i)
        torque += gas_torque(p, c, y, mode, i)
        start = len(SHAFT_TRACE) + columns * i
        own_row = row[start : start + columns]
        observe_cylinder(c, surroundings_of(p, c, y, mode, i), block_of(y, i), own_modes(mode, i), own_row)
    row[0] = (mode[modes + TURNS] * TURN + y[first + ANGLE]) / DEGREE
    row[1] = speed * 60.0 / TURN
    row[2] = torque
    row[3] = direction * resistance.friction
    row[4] = direction * resistance.brake + resistance.hoist
