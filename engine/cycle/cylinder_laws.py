"""What a cylinder and its valve do at an instant: rates, events, segments and traces, with what is around them given.

A state vector here is that of `apesim.engine.cycle.state`: of an engine, or of one of its cylinders.
"""

from typing import NamedTuple

import numpy as np

from apesim.air import GasContent, heat_capacity
from apesim.engine.angles import TURN
from apesim.engine.cam import lift_line
from apesim.engine.cycle.gas_exchange import (
    AIRS,
    CYLINDER_AIR,
    INTAKE_AIR,
    OUTSIDE_AIR,
    RECEIVER_AIR,
    add_flow,
    airs_at,
    change_exchange_regime,
    effect_terms,
    exchange_events,
    intake_lift,
    port_flows,
    ports_at,
    start_exchange_segment,
    start_groove_segment,
    update_exchange,
)
from apesim.engine.cycle.state import (
    BRANCHES,
    EXHAUSTS,
    FEED,
    GROOVE,
    INTAKE_OPEN,
    LIFT,
    LIFT_SLOPE,
    PIPE_FEED,
    PORTS,
    SIZE,
    Cycle,
    CycleTables,
    EngineLedger,
    Instant,
    control_air,
    cylinder_gas,
    cylinder_state,
    has_pipe,
    intake_state,
    line_gas,
    pipe_gas,
    receiver_gas,
    receiver_state,
    supply_of,
    update_ledgers,
    update_states,
)
from apesim.engine.cylinder import CAM, EPV, IDEAL_VALVE, indicated_power
from apesim.engine.exergy import add_exergy_rates
from apesim.kernel import kernel
from apesim.restriction import NO_FLOW, Flow
from apesim.stack_array import zeros
from apesim.valve import actuator as valve_actuator
from apesim.valve.actuator import AT_REST, PHASE, PIECE, actuator_rates, state_of
from apesim.valve.groove import piece_of
from apesim.valve.ledger import FLOW_ENTRIES, ControlLedger, ledger_flow, valve_states
from apesim.valve.line import LINE_FLOW, change_line_regime, has_line, line_event, line_feed, start_line_segment
from apesim.valve.motion import (
    CORNER,
    actuator_events,
    actuator_zero_crossings,
    handle_actuator_event,
    start_actuator_segment,
    take_piece,
)
from apesim.valve.piston import is_moving

AIR_FLOWS = FLOW_ENTRIES * AIRS
"""Entries of the flows into or out of all airs."""
FLOW = LINE_FLOW + 1
"""First of the events of flows through the ports of the gas exchange into another regime."""
BRANCHED = FLOW + PORTS
"""Event of an effect of the cylinder on another branch of its law."""
PRESSURE_EXTREMUM, RECEIVER_EXTREMUM, TEMPERATURE_EXTREMUM = range(3, 6)
"""Zero crossings: extremum of the pressure in the cylinder and in the receiver, and of the cylinder temperature."""
TRACE = (
    "cylinder_pressure [Pa abs]",
    "cylinder_temperature [K]",
    "lift [m]",
    "velocity [m/s]",
    "pressure_a [Pa abs]",
    "pressure_b [Pa abs]",
    "groove_flow [kg/s]",
    "torque [N m]",
    "receiver_pressure [Pa abs]",
    "exhaust_flow [kg/s]",
    "cylinder_volume [m3]",
)
"""Columns of a trace, after ``crank_angle [deg]``; the velocity is that of the lift, torque is indicated."""


class Exchanged(NamedTuple):
    """What a cylinder and its valve exchange with the air around them at an instant."""

    in_domain: bool
    """Whether the state is in its domain; if not, no rate was written."""
    receiver: Flow
    """Net flow into the receiver that it draws from, by its own ports and its control air."""
    outside: Flow
    """Net flow through its exhaust valves."""
    torque: float
    """Torque of its gas above ambient pressure on the shaft [N m]."""
    temperature: float
    """Temperature of its gas [K]."""


@kernel
def is_above_zero(gas: GasContent) -> bool:
    """Check that mass and internal energy of a gas are above zero."""
    return gas.mass > 0.0 and gas.energy > 0.0


@kernel
def in_domain(p: Cycle, y: np.ndarray) -> bool:
    """Check that masses and energies outside the valve are above zero, in the state vector `y` (>= SIZE,)."""
    if p.receiver_volume > 0.0 and not is_above_zero(receiver_gas(y)):
        return False
    if has_pipe(p) and not is_above_zero(pipe_gas(y)):
        return False
    if has_line(p.actuator) and not is_above_zero(line_gas(y)):
        return False
    return is_above_zero(cylinder_gas(y))


@kernel
def effect_branches(p: Cycle, now: Instant, y: np.ndarray) -> float:
    """Find on which branches of their laws the effects of the cylinder are, see `apesim.effect.note_branch`.

    It is 0 without effects. `y` (>= SIZE,) is the state vector.
    """
    if len(p.effects) > 0:
        cylinder, _ = cylinder_state(p, now, y)
        return effect_terms(p, cylinder).branches
    return 0.0


@kernel
def net_flow(entering: np.ndarray, leaving: np.ndarray, air: int) -> Flow:
    """Net flow into an air, from what enters and what leaves each air (FLOW_ENTRIES * AIRS,)."""
    first = FLOW_ENTRIES * air
    return Flow(entering[first] - leaving[first], entering[first + 1] - leaving[first + 1])


@kernel
def gas_rates(is_there: bool, net: Flow) -> GasContent:
    """Rates of the gas of a volume without work, from the net flow into it; 0 where the machine has no such volume."""
    return GasContent(net.mass, net.enthalpy) if is_there else GasContent(0.0, 0.0)


@kernel
def cylinder_rates(
    p: Cycle, t: float, now: Instant, y: np.ndarray, mode: np.ndarray, dy: np.ndarray, ledger: np.ndarray
) -> Exchanged:
    """Write the rates of a cylinder's states into `dy`, and those of its ledgers into `ledger`; see `cycle_rates`.

    `t` is the time [s], `y` (>= LEDGER,) the state vector, `mode` (MODES,) are the modes. `ledger` (>= SIZE,) may be
    `dy` itself, where it is as long; then the exergy ledger behind it is written, too, if `y` has room for it.
    """
    if not in_domain(p, y):
        return Exchanged(False, NO_FLOW, NO_FLOW, 0.0, 0.0)

    # The air of every volume, then the flows between them.
    cylinder, slope = cylinder_state(p, now, y)
    receiver = now.receiver
    intake = intake_state(p, y, receiver)
    ports, airs = ports_at(p, cylinder.angle, y, mode), airs_at(p, cylinder, receiver, intake)
    flows = port_flows(p, mode, ports, airs)

    # The valve, with its own domain; a cam or an ideal valve leaves its states where they are.
    valve = AT_REST
    if p.engine.intake == EPV:
        if not valve_actuator.in_domain(p.actuator, y):
            return Exchanged(False, NO_FLOW, NO_FLOW, 0.0, 0.0)
        valve = actuator_rates(p.actuator, t, y, mode, supply_of(p, y, receiver))
    line = line_feed(p.actuator, mode, control_air(p, y, receiver), valve)

    # Effects of the cylinder.
    terms = effect_terms(p, cylinder)
    let_in, past = terms.let_in, terms.past_groove
    work = cylinder.air.pressure * slope * p.speed

    # What enters and what leaves each air, with what passes beside the groove; the valve draws from the receiver where
    # its control air comes from there.
    entering: np.ndarray = zeros(AIR_FLOWS)  # type: ignore[call-arg]
    leaving: np.ndarray = zeros(AIR_FLOWS)  # type: ignore[call-arg]
    update_exchange(ports, flows, entering, leaving)
    add_flow(entering, CYLINDER_AIR, past)
    add_flow(leaving, ports[GROOVE].before, past)
    if p.control_from_receiver:
        add_flow(leaving, RECEIVER_AIR, line)

    # Balances, then the ledgers that show whether they close; the exergy only where a march has room for it.
    in_cylinder = net_flow(entering, leaving, CYLINDER_AIR)
    in_receiver, outside = net_flow(entering, leaving, RECEIVER_AIR), net_flow(entering, leaving, OUTSIDE_AIR)
    update_states(
        dy,
        valve.states,
        (
            GasContent(in_cylinder.mass + let_in.mass, in_cylinder.enthalpy - work + let_in.enthalpy),
            gas_rates(p.receiver_volume > 0.0, in_receiver),
            GasContent(line.mass - valve.supplied.mass, line.enthalpy - valve.supplied.enthalpy),
            gas_rates(has_pipe(p), net_flow(entering, leaving, INTAKE_AIR)),
        ),
    )
    groove, exhaust_back = ledger_flow(entering, FLOW_ENTRIES * CYLINDER_AIR), 0.0
    for i in EXHAUSTS:
        exhaust_back += max(0.0, -flows[i].mass)
    update_ledgers(
        ledger,
        ControlLedger(line, valve.supplied, valve.vented, valve.work),
        Flow(valve.let_in.mass + let_in.mass, valve.let_in.enthalpy + let_in.enthalpy),
        EngineLedger(
            groove,
            ledger_flow(entering, FLOW_ENTRIES * OUTSIDE_AIR),
            flows[FEED],
            flows[PIPE_FEED],
            max(0.0, -groove.mass),
            exhaust_back,
            work,
        ),
    )
    if y.shape[0] > SIZE:
        add_exergy_rates(p, t, y, mode, cylinder, receiver, intake, flows, terms, dy)
    torque = indicated_power(cylinder.air.pressure, p.actuator.ambient.pressure, slope, 1.0)
    return Exchanged(True, in_receiver, outside, torque, cylinder.air.temperature)


@kernel
def cylinder_events(p: Cycle, now: Instant, y: np.ndarray, mode: np.ndarray, g: np.ndarray) -> None:
    """Write the values of a cylinder's events into `g` (n,): those of its valve, and flows into another regime.

    Above zero the event has happened. `y` (>= LEDGER,) is the state vector, `mode` (MODES,) are the modes.
    """
    if p.engine.intake == EPV:
        actuator_events(p.actuator, y, mode, supply_of(p, y, now.receiver), g)
        g[LINE_FLOW] = line_event(p.actuator, control_air(p, y, now.receiver), mode)
    exchange_events(p, now, y, mode, g, FLOW)
    if len(p.effects) > 0:
        g[BRANCHED] = -1.0 if effect_branches(p, now, y) == mode[BRANCHES] else 1.0


@kernel
def handle_cylinder_event(
    p: Cycle, tables: CycleTables, event: int, now: Instant, y: np.ndarray, mode: np.ndarray
) -> None:
    """Change state and modes at an event of a cylinder: one of its valve, or a flow into another regime.

    `event` is its number; `y` (>= LEDGER,) and `mode` (MODES,) are changed.
    """
    if event == BRANCHED:
        mode[BRANCHES] = effect_branches(p, now, y)
    elif event >= FLOW:
        change_exchange_regime(p, now, y, event - FLOW, mode)
    elif event == LINE_FLOW:
        change_line_regime(p.actuator, control_air(p, y, now.receiver), mode)
    else:
        handle_actuator_event(p.actuator, tables.valve, event, y, mode, supply_of(p, y, now.receiver))
        if event == CORNER:
            start_groove_segment(p, now, y, mode)


@kernel
def start_cylinder_segment(
    p: Cycle,
    tables: CycleTables,
    t: float,
    t_end: float,
    now: Instant,
    middle: float,
    y: np.ndarray,
    mode: np.ndarray,
) -> None:
    """Set the modes of a smooth segment from `t` to `t_end` [s]: changes `mode` (MODES,).

    These are the valve's modes; or the line of a cam's curve and its piece of the groove's table; or whether the ideal
    valve is open; then the regimes of the flows, and the branches of the effects. `middle` is a crank angle within the
    segment [rad]. `y` (>= LEDGER,) is the state vector, changed where the valve's piston rests.
    """
    if p.engine.intake == EPV:
        start_actuator_segment(p.actuator, tables.valve, t, t_end, y, mode, supply_of(p, y, now.receiver))
        start_line_segment(p.actuator, control_air(p, y, now.receiver), mode)
    start_window(p, tables, now, middle, y, mode)


@kernel
def start_window(p: Cycle, tables: CycleTables, now: Instant, middle: float, y: np.ndarray, mode: np.ndarray) -> None:
    """Set the modes that depend on the crank angle alone, and with them the regimes and branches, in `mode` (MODES,).

    `middle` is a crank angle within the window [rad]; `y` (>= LEDGER,) is the state vector.
    """
    if p.engine.intake == CAM:
        if p.has_lift_curve:
            mode[LIFT], mode[LIFT_SLOPE] = lift_line(tables.cam, middle)
        mode[PIECE] = piece_of(tables.valve.groove, intake_lift(p, middle, y, mode))
        take_piece(tables.valve, mode)
    elif p.engine.intake == IDEAL_VALVE:
        mode[INTAKE_OPEN] = 1.0 if (middle - p.open_target) % TURN < p.close_target - p.open_target else 0.0
    start_exchange_segment(p, now, middle, y, mode)
    mode[BRANCHES] = effect_branches(p, now, y)


@kernel
def temperature_rate(p: Cycle, content: GasContent, rates: GasContent, temperature: float) -> float:
    """Rate of the temperature of a gas volume.

    ``dT/dt = (dU/dt - u dm/dt)/(m cv)``, with the mass m, the internal energy U, ``u = U/m`` and the heat capacity cv.

    It is Eq. 5 of the EPV paper (doi 10.1631/jzus.A0820373), solved for the temperature of a volume whose mass and
    energy are known.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    content : apesim.air.GasContent
        Mass and internal energy of the gas.
    rates : apesim.air.GasContent
        Rates of mass [kg/s] and internal energy [W].
    temperature : float
        Temperature of the gas [K].

    Returns
    -------
    float
        Rate of the temperature [K/s].

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)

    717.6 W into 1 kg of air at constant volume, 717.6 J/(kg K), warm it by 1 K/s:

    >>> print(round(temperature_rate(cycle, GasContent(1.0, 2e5), GasContent(0.0, 717.625), 290.0), 6))
    1.0
    """
    gas, (mass, energy), (mass_rate, energy_rate) = p.actuator.gas, content, rates
    cv = heat_capacity(gas, temperature) - gas.gas_constant
    return (energy_rate - energy / mass * mass_rate) / (mass * cv)


@kernel
def cylinder_zero_crossings(
    p: Cycle, now: Instant, y: np.ndarray, dy: np.ndarray, mode: np.ndarray, w: np.ndarray
) -> None:
    """Write what is located where it crosses zero: slopes of both pressures and of the cylinder's temperature.

    The slopes are those of the logarithms of the pressures in cylinder and receiver, and of the cylinder's temperature;
    the zero crossings of the valve are added.

    The slope of a pressure follows from ``p V = m R T``, Eq. 3 of the EPV paper (doi 10.1631/jzus.A0820373).

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    now : apesim.engine.cycle.state.Instant
        What is around the cylinder.
    y : (>= STATES,) float array
        State vector.
    dy : (>= STATES,) float array
        Rates of the state vector.
    mode : (>= MODES,) float array
        Modes of the smooth segment.
    w : (n,) float array
        Values that are followed; changed.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.cycle.rates import cycle_rates
    >>> from apesim.engine.cycle.state import instant_at
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)

    With no flow, temperature and pressure rise as long as the piston compresses:

    >>> (dy, w), compressing = (np.zeros_like(y), np.zeros(16)), -0.001
    >>> cycle_rates(cycle, compressing, y, mode, dy)
    True
    >>> cylinder_zero_crossings(cycle, instant_at(cycle, compressing, y), y, dy, mode, w)
    >>> bool(w[PRESSURE_EXTREMUM] > 0.0 and w[TEMPERATURE_EXTREMUM] > 0.0)
    True
    """
    if p.engine.intake == EPV:
        actuator_zero_crossings(p.actuator, y, valve_states(dy).speed, mode, w)
    cylinder, slope = cylinder_state(p, now, y)
    (mass, _), (mass_rate, _), t_c = cylinder_gas(y), cylinder_gas(dy), cylinder.air.temperature
    warming = temperature_rate(p, cylinder_gas(y), cylinder_gas(dy), t_c)
    w[PRESSURE_EXTREMUM] = mass_rate / mass + warming / t_c - slope * p.speed / cylinder.volume
    w[TEMPERATURE_EXTREMUM] = warming
    if p.receiver_volume > 0.0:
        temperature = receiver_state(p, y).temperature
        (mass, _), (mass_rate, _) = receiver_gas(y), receiver_gas(dy)
        warming = temperature_rate(p, receiver_gas(y), receiver_gas(dy), temperature)
        w[RECEIVER_EXTREMUM] = mass_rate / mass + warming / temperature


@kernel
def observe_cylinder(p: Cycle, now: Instant, y: np.ndarray, mode: np.ndarray, row: np.ndarray) -> None:
    """Write the columns `TRACE` of a cylinder into `row` (11,).

    `y` (>= LEDGER,) is the state vector, `mode` (MODES,) are the modes.
    """
    cylinder, slope = cylinder_state(p, now, y)
    receiver = now.receiver
    ports, airs = ports_at(p, cylinder.angle, y, mode), airs_at(p, cylinder, receiver, intake_state(p, y, receiver))
    flows = port_flows(p, mode, ports, airs)
    row[0], row[1] = cylinder.air.pressure, cylinder.air.temperature
    if p.engine.intake == EPV:
        valve = state_of(p.actuator, y, supply_of(p, y, receiver))
        row[2] = p.actuator.valve.stroke - valve.position
        row[3] = -valve.speed if is_moving(mode[PHASE]) else 0.0
        row[4], row[5] = valve.chamber_a.pressure, valve.chamber_b.pressure
    else:
        row[2] = p.actuator.valve.stroke * mode[INTAKE_OPEN]
        row[3] = row[4] = row[5] = np.nan
        if p.engine.intake == CAM:
            row[2] = intake_lift(p, cylinder.angle, y, mode)
    row[6] = flows[GROOVE].mass + effect_terms(p, cylinder).past_groove.mass
    row[7] = indicated_power(cylinder.air.pressure, p.actuator.ambient.pressure, slope, 1.0)
    row[8], row[9], row[10] = receiver.pressure, 0.0, cylinder.volume
    for i in EXHAUSTS:
        row[9] += flows[i].mass
