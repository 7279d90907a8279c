"""State and ledger of a cycle of the engine, and what the kernels know of its machine."""

from typing import NamedTuple

import numpy as np

from apesim.effect import NoEffects
from apesim.kernel import kernel
from engine.cylinder import CylinderState, Engine
from engine.effects import EngineLaws
from engine.kinematics import Crank, cylinder_volume
from valve import actuator as valve_actuator
from valve.actuator import Actuator, ActuatorTables
from valve.chamber import chamber_state
from valve.ports import Ports

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
INTAKE_OPEN, GROOVE_FLOW, EXHAUST_FLOW, FEED_FLOW, LIFT, LIFT_SLOPE, MODES = range(
    valve_actuator.MODES, valve_actuator.MODES + 7
)
"""Modes: whether the ideal valve is open; regimes of the flows; the line of a cam's lift curve, as lift at crank angle
0 [m] and slope [m/rad]; how many modes there are."""
SCALE = valve_actuator.SCALE + 4 * (valve_actuator.GAS_SCALE,)


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
    effects: EngineLaws | NoEffects


class CycleTables(NamedTuple):
    """The machine's arrays."""

    valve: ActuatorTables
    cam: np.ndarray
    """The cam's lift curve: crank angle [rad] and lift [m]; no rows: it has none."""


@kernel
def receiver_state(p, y):
    """Pressure [Pa abs] and temperature [K] before the groove."""
    if p.receiver_volume > 0.0:
        return chamber_state(p.actuator.gas, y[RECEIVER_MASS], y[RECEIVER_ENERGY], p.receiver_volume)
    return p.supply


@kernel
def cylinder_state(p, t, y):
    """State of the cylinder, and the slope of its volume [m3/rad]."""
    angle = p.start + p.speed * t
    volume, slope = cylinder_volume(p.crank, angle)
    gas = p.actuator.gas
    pressure, temperature = chamber_state(gas, y[CYLINDER_MASS], y[CYLINDER_ENERGY], volume)
    intake = receiver_state(p, y) if len(p.effects) > 0 else p.supply
    return CylinderState(
        gas, p.actuator.ambient, p.engine, p.speed, angle, volume, pressure, temperature, intake[0], intake[1]
    ), slope


@kernel
def control_air(p, y):
    """Pressure [Pa abs] and temperature [K] before the solenoids, and pressure before the groove [Pa abs]."""
    if p.control_from_receiver:
        pressure, temperature = receiver_state(p, y)
        return pressure, temperature, pressure
    before_groove = receiver_state(p, y)[0] if len(p.actuator.effects) > 0 else p.supply[0]
    return p.control[0], p.control[1], before_groove
