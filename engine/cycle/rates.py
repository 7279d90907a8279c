"""The coupled cycle: valve, receiver and cylinder in one march."""

import numpy as np

from apesim.air import heat_capacity
from apesim.engine.angles import TURN
from apesim.engine.breathing import lift_line
from apesim.engine.cycle.flows import (
    FLOWS,
    breathing,
    effects_of,
    exchange_changes,
    exchange_events,
    intake_lift,
    piped,
    start_exchange_segment,
    start_groove_segment,
)
from apesim.engine.cycle.state import (
    BRANCHES,
    INTAKE_OPEN,
    LIFT,
    LIFT_SLOPE,
    SIZE,
    Cycle,
    EngineLedger,
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
from apesim.engine.cylinder import CAM, EPV, indicated_power
from apesim.engine.exergy import add_exergy_rates
from apesim.kernel import kernel
from apesim.march.hybrid_system import events, handle_event, observe, power, rates, start_segment, zero_crossings
from apesim.valve import actuator as valve_actuator
from apesim.valve.actuator import PHASE, PIECE, ActuatorRates, actuator_rates, state_of
from apesim.valve.groove import piece_of
from apesim.valve.ledger import control_rates, valve_states
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

FLOW = LINE_FLOW + 1
"""First event of the flows through groove, exhaust valve, feed and pipe: into another regime."""
BRANCHED = FLOW + FLOWS
"""Event: an effect of the cylinder on another branch of its law."""
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


@kernel
def is_above_zero(gas: tuple[float, float]) -> bool:
    """Check that mass and internal energy of a gas are above zero.

    Parameters
    ----------
    gas : tuple of float
        Mass [kg] and internal energy [J].

    Returns
    -------
    bool
        Whether both are above zero.

    Examples
    --------
    >>> is_above_zero((2e-4, 41.0)), is_above_zero((2e-4, -1.0))
    (True, False)
    """
    return gas[0] > 0.0 and gas[1] > 0.0


@kernel
def in_domain(p, y):
    """Whether masses and energies outside the valve are above zero."""
    if p.receiver_volume > 0.0 and not is_above_zero(receiver_gas(y)):
        return False
    if has_pipe(p) and not is_above_zero(pipe_gas(y)):
        return False
    if has_line(p.actuator) and not is_above_zero(line_gas(y)):
        return False
    return is_above_zero(cylinder_gas(y))


@kernel
def branches_of(p, t, y):
    """On which branches of their laws the cylinder's effects are."""
    if len(p.effects) > 0:
        return effects_of(p, cylinder_state(p, t, y)[0])[6]
    return 0.0


@rates.for_type(Cycle)
@kernel
def cycle_rates(p, t, y, mode, dy):
    """Rates of the engine, and of its exergy ledger where there is room; see `apesim.march.hybrid_system.rates`."""
    if not in_domain(p, y):
        return False
    cylinder, slope = cylinder_state(p, t, y)
    receiver = receiver_state(p, y)
    intake = intake_state(p, y, receiver)
    flows = breathing(p, y, mode, cylinder, receiver, intake)
    groove, groove_enthalpy, exhaust, exhaust_enthalpy, fed, fed_enthalpy = flows
    valve = ActuatorRates(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if p.engine.intake == EPV:
        if not valve_actuator.in_domain(p.actuator, y):
            return False
        valve = actuator_rates(p.actuator, t, y, mode, supply_of(p, y))
    line, line_enthalpy = line_feed(p.actuator, mode, *control_air(p, y), valve)
    mass, energy, past_groove, past_groove_enthalpy, _, _, _ = effects_of(p, cylinder)
    groove += past_groove
    groove_enthalpy += past_groove_enthalpy
    pipe, pipe_enthalpy = piped(p, mode, receiver, intake, groove, groove_enthalpy)
    work = cylinder.pressure * slope * p.speed
    drawn = drawn_enthalpy = 0.0
    if p.receiver_volume > 0.0:
        drawn, drawn_enthalpy = pipe, pipe_enthalpy
        if p.control_from_receiver:
            drawn += line
            drawn_enthalpy += line_enthalpy
    update_states(
        dy,
        valve[: valve_actuator.STATES],
        (groove - exhaust + mass, groove_enthalpy - exhaust_enthalpy - work + energy),
        (fed - drawn, fed_enthalpy - drawn_enthalpy),
        (line - valve.supplied, line_enthalpy - valve.supplied_enthalpy),
        (pipe - groove, pipe_enthalpy - groove_enthalpy),
    )
    update_ledgers(
        dy,
        control_rates(valve, line, line_enthalpy, valve.other_mass + mass, valve.other_energy + energy),
        EngineLedger(
            pipe,
            pipe_enthalpy,
            groove,
            groove_enthalpy,
            max(0.0, -groove),
            exhaust,
            exhaust_enthalpy,
            max(0.0, -exhaust),
            fed,
            fed_enthalpy,
            work,
        ),
    )
    if y.shape[0] > SIZE:
        add_exergy_rates(p, t, y, mode, cylinder, dy)
    return True


@events.for_type(Cycle)
@kernel
def cycle_events(p, t, y, mode, g):
    """Events of the engine: those of its valve, and flows into another regime."""
    if p.engine.intake == EPV:
        actuator_events(p.actuator, y, mode, supply_of(p, y), g)
        g[LINE_FLOW] = line_event(p.actuator, *control_air(p, y), mode)
    exchange_events(p, t, y, mode, g, FLOW)
    if len(p.effects) > 0:
        g[BRANCHED] = -1.0 if branches_of(p, t, y) == mode[BRANCHES] else 1.0


@handle_event.for_type(Cycle)
@kernel
def handle_cycle_event(p, tables, event, t, y, mode):
    """Responses of the engine: those of its valve, and the regimes of the flows that they change."""
    if event == BRANCHED:
        mode[BRANCHES] = branches_of(p, t, y)
    elif event >= FLOW:
        exchange_changes(p, t, y, event - FLOW, mode)
    elif event == LINE_FLOW:
        change_line_regime(p.actuator, *control_air(p, y), mode)
    else:
        handle_actuator_event(p.actuator, tables.valve, event, y, mode, supply_of(p, y))
        if event == CORNER:
            start_groove_segment(p, t, y, mode)


@kernel
def warming_of(p, content, rates, temperature):
    """Slope of the temperature of a gas volume, from its mass and energy and their rates [K/s]."""
    gas, (mass, energy), (mass_rate, energy_rate) = p.actuator.gas, content, rates
    cv = heat_capacity(gas, temperature) - gas.gas_constant
    return (energy_rate - energy / mass * mass_rate) / (mass * cv)


@zero_crossings.for_type(Cycle)
@kernel
def cycle_zero_crossings(p, t, y, dy, mode, w):
    """Zero crossings of the engine: those of its valve; slopes of the logarithms of both pressures, in cylinder and
    receiver, and of the cylinder temperature."""
    if p.engine.intake == EPV:
        actuator_zero_crossings(p.actuator, y, valve_states(dy).speed, mode, w)
    cylinder, slope = cylinder_state(p, t, y)
    (mass, _), (mass_rate, _), t_c = cylinder_gas(y), cylinder_gas(dy), cylinder.temperature
    warming = warming_of(p, cylinder_gas(y), cylinder_gas(dy), t_c)
    w[PRESSURE_EXTREMUM] = mass_rate / mass + warming / t_c - slope * p.speed / cylinder.volume
    w[TEMPERATURE_EXTREMUM] = warming
    if p.receiver_volume > 0.0:
        temperature = receiver_state(p, y)[1]
        (mass, _), (mass_rate, _) = receiver_gas(y), receiver_gas(dy)
        warming = warming_of(p, receiver_gas(y), receiver_gas(dy), temperature)
        w[RECEIVER_EXTREMUM] = mass_rate / mass + warming / temperature


@start_segment.for_type(Cycle)
@kernel
def start_cycle_segment(p, tables, t, t_end, y, mode):
    """Modes of a smooth stretch: the valve's; or the line of a cam's curve and which piece of the groove's table it is
    on, or whether the ideal valve is open; the flows' regimes."""
    middle = p.start + p.speed * 0.5 * (t + t_end)
    if p.engine.intake == EPV:
        start_actuator_segment(p.actuator, tables.valve, t, t_end, y, mode, supply_of(p, y))
        start_line_segment(p.actuator, *control_air(p, y), mode)
    elif p.engine.intake == CAM:
        if p.has_lift_curve:
            mode[LIFT], mode[LIFT_SLOPE] = lift_line(tables.cam, middle)
        mode[PIECE] = piece_of(tables.valve.groove, intake_lift(p, middle, y, mode))
        take_piece(tables.valve, mode)
    else:
        mode[INTAKE_OPEN] = 1.0 if (middle - p.open_target) % TURN < p.close_target - p.open_target else 0.0
    start_exchange_segment(p, t, t_end, y, mode)
    mode[BRANCHES] = branches_of(p, t, y)


@power.for_type(Cycle)
@kernel
def cycle_power(p, t, y):
    """Power of the gas on the engine's piston [W]."""
    cylinder, slope = cylinder_state(p, t, y)
    return cylinder.pressure * slope * p.speed


@observe.for_type(Cycle)
@kernel
def observe_cycle(p, t, y, mode, row):
    """A row of the trace."""
    cylinder, slope = cylinder_state(p, t, y)
    receiver = receiver_state(p, y)
    groove, _, exhaust, _, _, _ = breathing(p, y, mode, cylinder, receiver, intake_state(p, y, receiver))
    row[0], row[1] = cylinder.pressure, cylinder.temperature
    if p.engine.intake == EPV:
        valve = state_of(p.actuator, y, supply_of(p, y))
        row[2] = p.actuator.valve.stroke - valve.position
        row[3] = -valve.speed if is_moving(mode[PHASE]) else 0.0
        row[4], row[5] = valve.pressure_a, valve.pressure_b
    else:
        row[2] = p.actuator.valve.stroke * mode[INTAKE_OPEN]
        row[3] = row[4] = row[5] = np.nan
        if p.engine.intake == CAM:
            row[2] = intake_lift(p, cylinder.angle, y, mode)
    row[6] = groove + effects_of(p, cylinder)[2]
    row[7] = indicated_power(cylinder.pressure, p.actuator.ambient.pressure, slope, 1.0)
    row[8], row[9], row[10] = receiver[0], exhaust, cylinder.volume
