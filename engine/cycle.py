"""The coupled cycle: valve, receiver and cylinder in one march."""

from typing import NamedTuple

import numpy as np

from apesim.air import flow_between, heat_capacity
from apesim.effect import add_laws
from apesim.kernel import kernel
from apesim.slots import enter, events, observe, power, rates, respond, watch
from engine.breathing import TURN, raised_cosine
from engine.cylinder import CAM, ENERGY, EPV, IDEAL_VALVE, MASS, TERMS, CylinderState, Engine, indicated_power
from engine.effects import EngineEffects
from engine.kinematics import Crank, cylinder_volume
from valve import actuator as valve_actuator
from valve.actuator import (
    AREA,
    AREA_SLOPE,
    PHASE,
    PIECE,
    Actuator,
    ActuatorRates,
    actuator_rates,
    state_of,
)
from valve.chamber import chamber_state
from valve.groove import piece_of
from valve.motion import actuator_enters, actuator_events, actuator_responds, actuator_watches, take_piece
from valve.piston import is_moving

CYLINDER_MASS, CYLINDER_ENERGY, RECEIVER_MASS, RECEIVER_ENERGY = range(valve_actuator.STATES, valve_actuator.STATES + 4)
STATES = valve_actuator.STATES + 4
(
    SUPPLIED,
    SUPPLIED_ENTHALPY,
    VENTED,
    VENTED_ENTHALPY,
    OTHER_MASS,
    OTHER_ENERGY,
    VALVE_WORK,
    GROOVE,
    GROOVE_ENTHALPY,
    GROOVE_BACK,
    EXHAUSTED,
    EXHAUSTED_ENTHALPY,
    EXHAUST_BACK,
    FED,
    FED_ENTHALPY,
    WORK,
) = range(STATES, STATES + 16)
"""The ledger: control air, vents, effects, work on the valve's piston; engine air through the groove and what of it
flowed back, exhaust and what of it flowed back, feed of the receiver; work on the engine's piston. kg and J."""
SIZE = STATES + 16
INTAKE_OPEN = valve_actuator.MODES
MODES = INTAKE_OPEN + 1
PRESSURE_EXTREMUM = 3
"""Watch: extremum of the cylinder pressure."""
STEP_MOST = 0.2e-3
"""Longest step [s]: no contact and start from rest of a valve fit into it unseen."""
SCALE = valve_actuator.SCALE + 4 * (valve_actuator.GAS_SCALE,)
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
"""Columns of a trace, after ``crank_angle [deg]``; velocity is that of the lift, torque is indicated."""


class Cycle(NamedTuple):
    """A machine at a speed, as numbers for the kernels."""

    actuator: Actuator
    supply: tuple[float, float]
    """Engine air: pressure [Pa abs], temperature [K]."""
    control: tuple[float, float]
    """Control air from the regulator."""
    control_from_receiver: int
    receiver_volume: float
    """[m3]; 0: infinite."""
    engine: Engine
    crank: Crank
    speed: float
    """[rad/s]"""
    start: float
    """Crank angle at the start of a cycle, where the solenoids are energised [rad]."""
    open_target: float
    close_target: float
    full_area: float
    """Of the groove at full lift [m2]."""
    effects_on: int
    effects: EngineEffects


@kernel
def cylinder_state(p, t, y):
    """State of the cylinder, and the slope of its volume [m3/rad]."""
    angle = p.start + p.speed * t
    volume, slope = cylinder_volume(p.crank, angle)
    gas = p.actuator.gas
    pressure, temperature = chamber_state(gas, y[CYLINDER_MASS], y[CYLINDER_ENERGY], volume)
    return CylinderState(gas, p.actuator.ambient, p.engine, p.speed, angle, volume, pressure, temperature), slope


@kernel
def receiver_state(p, y):
    """Pressure [Pa abs] and temperature [K] before the groove."""
    if p.receiver_volume > 0.0:
        return chamber_state(p.actuator.gas, y[RECEIVER_MASS], y[RECEIVER_ENERGY], p.receiver_volume)
    return p.supply


@kernel
def control_air(p, y):
    """Pressure [Pa abs] and temperature [K] before the solenoids."""
    if p.control_from_receiver:
        return receiver_state(p, y)
    return p.control


@kernel
def intake_lift(p, angle, y):
    """Lift of the intake [m]."""
    if p.engine.intake == EPV:
        return p.actuator.valve.stroke - y[0]
    cam = p.engine.cam
    return cam.lift * raised_cosine(angle, cam.opens, cam.closes, cam.flank)


@kernel
def intake_area(p, angle, y, mode):
    """Effective area of the groove [m2]."""
    if p.engine.intake == IDEAL_VALVE:
        return p.full_area * mode[INTAKE_OPEN]
    return max(0.0, mode[AREA] + mode[AREA_SLOPE] * intake_lift(p, angle, y))


@kernel
def breathing(p, y, mode, cylinder):
    """Flows through groove and exhaust valve, each with its enthalpy [kg/s, W]."""
    gas, engine, ambient = p.actuator.gas, p.engine, p.actuator.ambient
    pressure, temperature = receiver_state(p, y)
    area = intake_area(p, cylinder.angle, y, mode)
    groove, groove_enthalpy = flow_between(gas, area, pressure, temperature, cylinder.pressure, cylinder.temperature)
    valve = engine.exhaust
    area = valve.effective_area * raised_cosine(cylinder.angle, valve.opens, valve.closes, valve.flank)
    exhaust, exhaust_enthalpy = flow_between(
        gas, area, cylinder.pressure, cylinder.temperature, ambient.pressure, ambient.temperature
    )
    return groove, groove_enthalpy, exhaust, exhaust_enthalpy


@rates.for_type(Cycle)
@kernel
def cycle_rates(p, t, y, mode, dy):
    """Rates of the engine; see `apesim.march.rates`."""
    if y[CYLINDER_MASS] <= 0.0 or y[CYLINDER_ENERGY] <= 0.0:
        return False
    if p.receiver_volume > 0.0 and (y[RECEIVER_MASS] <= 0.0 or y[RECEIVER_ENERGY] <= 0.0):
        return False
    gas = p.actuator.gas
    cylinder, slope = cylinder_state(p, t, y)
    groove, groove_enthalpy, exhaust, exhaust_enthalpy = breathing(p, y, mode, cylinder)
    valve = ActuatorRates(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if p.engine.intake == EPV:
        if not valve_actuator.in_domain(p.actuator, y):
            return False
        valve = actuator_rates(p.actuator, t, y, mode, control_air(p, y))
    mass = energy = 0.0
    if p.effects_on:
        balance = np.zeros(TERMS)
        add_laws(p.effects, cylinder, balance)
        mass, energy = balance[MASS], balance[ENERGY]
    work = cylinder.pressure * slope * p.speed
    fed = fed_enthalpy = drawn = drawn_enthalpy = 0.0
    if p.receiver_volume > 0.0:
        pressure, temperature = receiver_state(p, y)
        fed, fed_enthalpy = flow_between(
            gas, p.engine.receiver.feed_area, p.supply[0], p.supply[1], pressure, temperature
        )
        drawn, drawn_enthalpy = groove, groove_enthalpy
        if p.control_from_receiver:
            drawn += valve.supplied
            drawn_enthalpy += valve.supplied_enthalpy
    for i in range(valve_actuator.STATES):
        dy[i] = valve[i]
    dy[CYLINDER_MASS] = groove - exhaust + mass
    dy[CYLINDER_ENERGY] = groove_enthalpy - exhaust_enthalpy - work + energy
    dy[RECEIVER_MASS] = fed - drawn
    dy[RECEIVER_ENERGY] = fed_enthalpy - drawn_enthalpy
    dy[SUPPLIED], dy[SUPPLIED_ENTHALPY] = valve.supplied, valve.supplied_enthalpy
    dy[VENTED], dy[VENTED_ENTHALPY] = valve.vented, valve.vented_enthalpy
    dy[OTHER_MASS], dy[OTHER_ENERGY] = valve.other_mass + mass, valve.other_energy + energy
    dy[VALVE_WORK] = valve.work
    dy[GROOVE], dy[GROOVE_ENTHALPY], dy[GROOVE_BACK] = groove, groove_enthalpy, max(0.0, -groove)
    dy[EXHAUSTED], dy[EXHAUSTED_ENTHALPY], dy[EXHAUST_BACK] = exhaust, exhaust_enthalpy, max(0.0, -exhaust)
    dy[FED], dy[FED_ENTHALPY] = fed, fed_enthalpy
    dy[WORK] = work
    return True


@events.for_type(Cycle)
@kernel
def cycle_events(p, t, y, mode, g):
    """Events of the engine: those of its valve."""
    if p.engine.intake == EPV:
        actuator_events(p.actuator, y, mode, control_air(p, y), g)


@respond.for_type(Cycle)
@kernel
def cycle_responds(p, tables, event, t, y, mode):
    """Responses of the engine: those of its valve."""
    actuator_responds(p.actuator, tables, event, y, mode, control_air(p, y))


@watch.for_type(Cycle)
@kernel
def cycle_watches(p, t, y, dy, mode, w):
    """Watches of the engine: those of its valve, and the slope of the cylinder pressure's logarithm."""
    if p.engine.intake == EPV:
        actuator_watches(p.actuator, y, dy[1], mode, w)
    cylinder, slope = cylinder_state(p, t, y)
    gas = p.actuator.gas
    mass_rate, t_c = dy[CYLINDER_MASS], cylinder.temperature
    cv = heat_capacity(gas, t_c) - gas.gas_constant
    warming = (dy[CYLINDER_ENERGY] - y[CYLINDER_ENERGY] / y[CYLINDER_MASS] * mass_rate) / (y[CYLINDER_MASS] * cv)
    w[PRESSURE_EXTREMUM] = mass_rate / y[CYLINDER_MASS] + warming / t_c - slope * p.speed / cylinder.volume


@enter.for_type(Cycle)
@kernel
def cycle_enters(p, tables, t, t_end, y, mode):
    """Modes of a smooth stretch: the valve's; or which piece of the groove's table a cam is on, or whether the ideal
    valve is open."""
    middle = p.start + p.speed * 0.5 * (t + t_end)
    if p.engine.intake == EPV:
        actuator_enters(p.actuator, tables, t, t_end, y, mode)
    elif p.engine.intake == CAM:
        mode[PIECE] = piece_of(tables.groove, intake_lift(p, middle, y))
        take_piece(tables, mode)
    else:
        mode[INTAKE_OPEN] = 1.0 if (middle - p.open_target) % TURN < p.close_target - p.open_target else 0.0


@power.for_type(Cycle)
@kernel
def cycle_power(p, t, y):
    """Power of the gas on the engine's piston [W]."""
    cylinder, slope = cylinder_state(p, t, y)
    return cylinder.pressure * slope * p.speed


@observe.for_type(Cycle)
@kernel
def cycle_observes(p, t, y, mode, row):
    """A row of the trace."""
    cylinder, slope = cylinder_state(p, t, y)
    groove, _, exhaust, _ = breathing(p, y, mode, cylinder)
    receiver_pressure, _ = receiver_state(p, y)
    row[0], row[1] = cylinder.pressure, cylinder.temperature
    if p.engine.intake == EPV:
        valve = state_of(p.actuator, y, control_air(p, y))
        row[2] = p.actuator.valve.stroke - y[0]
        row[3] = -y[1] if is_moving(mode[PHASE]) else 0.0
        row[4], row[5] = valve.pressure_a, valve.pressure_b
    else:
        row[2] = p.actuator.valve.stroke * mode[INTAKE_OPEN]
        row[3] = row[4] = row[5] = np.nan
        if p.engine.intake == CAM:
            row[2] = intake_lift(p, cylinder.angle, y)
    row[6] = groove
    row[7] = indicated_power(cylinder.pressure, p.actuator.ambient.pressure, slope, 1.0)
    row[8], row[9], row[10] = receiver_pressure, exhaust, cylinder.volume
