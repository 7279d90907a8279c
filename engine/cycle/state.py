"""State and ledger of a cycle of the engine, and what the kernels know of its machine."""

from typing import NamedTuple

import numpy as np

from apesim.effect import NoEffects
from apesim.engine.cylinder import CylinderState, Engine
from apesim.engine.effects import EngineLaws, EngineTables
from apesim.engine.kinematics import Crank, cylinder_volume
from apesim.kernel import kernel
from apesim.valve import actuator as valve_actuator
from apesim.valve.actuator import Actuator, ActuatorTables
from apesim.valve.chamber import chamber_state
from apesim.valve.line import before_solenoids
from apesim.valve.ports import Ports

CYLINDER_MASS, CYLINDER_ENERGY, RECEIVER_MASS, RECEIVER_ENERGY = range(valve_actuator.STATES, valve_actuator.STATES + 4)
STATES = valve_actuator.STATES + 4
LINE_MASS, LINE_ENERGY, PIPE_MASS, PIPE_ENERGY = range(STATES, STATES + 4)
"""States of the supply line and of the intake pipe; they belong to the ledger, of no size, where there is none."""
(
    LINE_FED,
    LINE_FED_ENTHALPY,
    PIPE_FED,
    PIPE_FED_ENTHALPY,
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
) = range(STATES + 4, STATES + 24)
"""The ledger: control air from its source, engine air from the receiver; control air into the solenoids, vents,
effects, work on the valve's piston; engine air through the groove and what of it flowed back, exhaust and what of it
flowed back, feed of the receiver; work on the engine's piston. kg and J."""
SIZE = STATES + 24
INTAKE_OPEN, GROOVE_FLOW, EXHAUST_FLOW, FEED_FLOW, PIPE_FLOW, LIFT, LIFT_SLOPE, BRANCHES, MODES = range(
    valve_actuator.MODES, valve_actuator.MODES + 9
)
"""Modes: whether the ideal valve is open; regimes of the flows; the line of a cam's lift curve, as lift at crank angle
0 [m] and slope [m/rad]; branches of the effects' laws; how many modes there are."""
SCALE = valve_actuator.SCALE + 4 * (valve_actuator.GAS_SCALE,)
"""Without line and pipe."""


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
    """Without its cam's curve, which is in the tables."""
    crank: Crank
    speed: float
    """[rad/s]"""
    start: float
    """Crank angle at the start of a cycle, where the solenoids are energised [rad]."""
    open_target: float
    close_target: float
    full_area: float
    """Of the groove at full lift [m2]."""
    lap: float
    """Of the groove [m]."""
    has_ports: int
    """1: the groove's area is that of its ports."""
    ports: Ports
    has_lift_curve: int
    """1: the cam's lift is that of its curve."""
    pipe: tuple[float, float]
    """Intake pipe between receiver and groove, see `apesim.effect.volume_of`."""
    effects: EngineLaws | EngineTables | NoEffects


class CycleTables(NamedTuple):
    """The machine's arrays."""

    valve: ActuatorTables
    cam: np.ndarray
    """The cam's lift curve: crank angle [rad] and lift [m]; no rows: it has none."""


@kernel
def receiver_state(p, y):
    """Pressure [Pa abs] and temperature [K] in the receiver."""
    if p.receiver_volume > 0.0:
        return chamber_state(p.actuator.gas, y[RECEIVER_MASS], y[RECEIVER_ENERGY], p.receiver_volume)
    return p.supply


@kernel
def has_pipe(p):
    """Whether there is an intake pipe."""
    return len(p.effects) > 0 and p.pipe[1] > 0.0


@kernel
def intake_state(p, y, receiver):
    """Pressure [Pa abs] and temperature [K] before the groove."""
    if has_pipe(p):
        return chamber_state(p.actuator.gas, y[PIPE_MASS], y[PIPE_ENERGY], p.pipe[0])
    return receiver


@kernel
def cylinder_state(p, t, y):
    """State of the cylinder, and the slope of its volume [m3/rad]."""
    angle = p.start + p.speed * t
    volume, slope = cylinder_volume(p.crank, angle)
    gas = p.actuator.gas
    pressure, temperature = chamber_state(gas, y[CYLINDER_MASS], y[CYLINDER_ENERGY], volume)
    intake = intake_state(p, y, receiver_state(p, y)) if len(p.effects) > 0 else p.supply
    return CylinderState(
        gas, p.actuator.ambient, p.engine, p.speed, angle, volume, pressure, temperature, intake[0], intake[1]
    ), slope


@kernel
def control_air(p, y):
    """Where control air comes from, and what is before the solenoids, both as pressure [Pa abs] and temperature [K]."""
    source = receiver_state(p, y) if p.control_from_receiver else p.control
    return source, before_solenoids(p.actuator, y, LINE_MASS, source)


@kernel
def supply_of(p, y):
    """What `apesim.valve.actuator.state_of` wants to know."""
    pressure, temperature = control_air(p, y)[1]
    before_groove = p.supply[0]
    if len(p.actuator.effects) > 0:
        before_groove = intake_state(p, y, receiver_state(p, y))[0]
    return pressure, temperature, before_groove
