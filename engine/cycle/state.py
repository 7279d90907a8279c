"""State vector of an engine: where its states and ledgers stand, and what the kernels know of its machine."""

from typing import NamedTuple

import numpy as np

from apesim.air import GasContent, GasState
from apesim.effect import FedVolume, NoEffects
from apesim.engine.cylinder import CylinderState, Engine
from apesim.engine.effects import EngineLaws, EngineTables
from apesim.engine.exhaust import Exhaust
from apesim.engine.kinematics import Crank, cylinder_volume
from apesim.kernel import kernel
from apesim.restriction import Flow, Sides
from apesim.valve import actuator as valve_actuator
from apesim.valve.actuator import Actuator, ActuatorTables
from apesim.valve.chamber import chamber_state
from apesim.valve.ledger import (
    CONTROL_ENTRIES,
    FLOW_ENTRIES,
    ControlLedger,
    ValveStates,
    control_ledger_at,
    gas_of_volume,
    ledger_flow,
    update_control_ledger,
    update_flows,
    update_part,
    valve_states,
)
from apesim.valve.line import before_solenoids
from apesim.valve.ports import Ports
from apesim.valve.supply import ValveSupply

VOLUMES = "cylinder", "receiver", "line", "pipe"
"""Volumes beside the valve's chambers whose gas is integrated, in the order of the state vector; the supply line and
the intake pipe come last, as without these their gas is not controlled."""
GAS_ENTRIES = len(GasContent._fields)
"""Entries of a gas in the state vector: mass [kg] and internal energy [J]."""
CYLINDER, RECEIVER, LINE, PIPE = (valve_actuator.STATES + GAS_ENTRIES * i for i in range(len(VOLUMES)))
"""Elements of the state vector at which the gas of each of these volumes begins."""
STATES = LINE
"""States that every engine has: of its valve, cylinder and receiver."""
LEDGER = valve_actuator.STATES + GAS_ENTRIES * len(VOLUMES)
"""Element at which the ledger of the control air begins."""
EFFECTS_LEDGER = LEDGER + CONTROL_ENTRIES
"""Element at which the ledger of what effects let in begins."""
ENGINE_LEDGER = EFFECTS_LEDGER + FLOW_ENTRIES
"""Element at which the ledger of the engine air begins."""


class EngineLedger(NamedTuple):
    """Ledger of the engine air: sums since the start, or their rates."""

    groove: Flow
    """Net mass [kg] and enthalpy [J] through the groove, with what passes beside it."""
    exhaust: Flow
    """Net, through the exhaust valves."""
    feed: Flow
    """Net, through the feed into the receiver."""
    pipe: Flow
    """Net, out of the receiver into the intake pipe; none where there is no pipe."""
    groove_back: float
    """Air that flowed back through the groove [kg]."""
    exhaust_back: float
    """Air that flowed in through the exhaust valves [kg]."""
    work: float
    """Work of the gas on the engine's piston [J]."""


GROOVE_BACK = ENGINE_LEDGER + FLOW_ENTRIES * sum(kind is Flow for kind in EngineLedger.__annotations__.values())
EXHAUST_BACK, WORK, SIZE = range(GROOVE_BACK + 1, GROOVE_BACK + 4)
"""Elements of what stands behind the flows in the engine air's ledger; SIZE is how many a state vector has."""
GROOVE, EXHAUST, EXHAUST_2, FEED, PIPE_FEED = range(5)
"""Numbers of the ports of the gas exchange, see `apesim.engine.cycle.gas_exchange.ports_at`."""
PORTS = 5
"""Number of these ports."""
EXHAUSTS = EXHAUST, EXHAUST_2
"""Ports that lead from the cylinder to what is behind the exhaust valves."""
INTAKE_OPEN, LIFT, LIFT_SLOPE, BRANCHES, EXCHANGE = range(valve_actuator.MODES, valve_actuator.MODES + 5)
MODES = EXCHANGE + PORTS
"""Modes of a smooth segment, behind those of the valve.

INTAKE_OPEN says whether the ideal valve is open. LIFT [m] and LIFT_SLOPE [m/rad] are the line of a cam's lift curve,
from crank angle 0. BRANCHES holds the branches of the effects' laws. From EXCHANGE on they hold the regimes of the
flows through the ports, in their order; MODES is how many modes there are."""
SCALE = valve_actuator.SCALE + (STATES - valve_actuator.STATES) * (valve_actuator.GAS_SCALE,)
"""Scale of the error of each state beside its own size, without supply line and intake pipe."""


class Cycle(NamedTuple):
    """Machine at a speed, as numbers for the kernels."""

    actuator: Actuator
    """Valve with what surrounds it."""
    supply: GasState
    """State of the engine air in its supply."""
    control: GasState
    """State of the control air from the regulator."""
    control_from_receiver: int
    """1: control air comes from the receiver, 0: from the regulator."""
    receiver_volume: float
    """Volume of the receiver [m3]; 0: infinite."""
    engine: Engine
    """Keys of the engine, without its cam's curve, which is in the tables."""
    exhausts: tuple[Exhaust, ...]
    """Exhaust valves that the engine has; their number makes a kind of march."""
    crank: Crank
    """Dimensions of the slider-crank."""
    speed: float
    """Speed of the crank [rad/s]."""
    start: float
    """Crank angle at the start of a cycle, where the solenoids are energised [rad]."""
    open_target: float
    """Crank angle of the intended opening [rad]."""
    close_target: float
    """Crank angle of the intended closing [rad]."""
    full_area: float
    """Effective area of the groove at full lift [m2]."""
    lap: float
    """Lift at which the groove begins to open [m]."""
    has_ports: int
    """1: the groove's area is that of its ports, 0: that of its table."""
    ports: Ports
    """Ports of the groove."""
    has_lift_curve: int
    """1: the cam's lift is that of its curve, 0: that of its flanks."""
    exhaust_pressure: float
    """Pressure behind the exhaust valves [Pa abs]."""
    pipe: FedVolume
    """Intake pipe before the groove, where an effect puts one there."""
    effects: EngineLaws | EngineTables | NoEffects  # type: ignore[valid-type]
    """Parameters of the effects that act on the cylinder."""


class Instant(NamedTuple):
    """What the laws of a cylinder see around it at an instant, beside its own states."""

    angle: float
    """Crank angle of the cylinder [rad]."""
    receiver: GasState
    """State of the air in the receiver that it draws from."""
    behind_exhaust: GasState
    """State of the air behind its exhaust valves."""


class CycleTables(NamedTuple):
    """Arrays of a machine."""

    valve: ActuatorTables
    """Arrays of the valve."""
    cam: np.ndarray
    """Lift curve of the cam: crank angle [rad] and lift [m], (n, 2); no rows: it has none."""


@kernel
def cylinder_gas(y: np.ndarray) -> GasContent:
    """Read the gas of the cylinder from a state vector of the engine (>= STATES,), or its rates."""
    return gas_of_volume(y, CYLINDER)


@kernel
def receiver_gas(y: np.ndarray) -> GasContent:
    """Read the gas of the receiver from a state vector of the engine (>= STATES,), or its rates.

    Both values are 0 where the receiver is infinite.
    """
    return gas_of_volume(y, RECEIVER)


@kernel
def line_gas(y: np.ndarray) -> GasContent:
    """Read the gas of the supply line from a state vector of the engine (SIZE,), or its rates.

    Both values are 0 where there is no line.
    """
    return gas_of_volume(y, LINE)


@kernel
def pipe_gas(y: np.ndarray) -> GasContent:
    """Read the gas of the intake pipe from a state vector of the engine (SIZE,), or its rates.

    Both values are 0 where there is no pipe.
    """
    return gas_of_volume(y, PIPE)


def gas_held(y: np.ndarray) -> GasContent:
    """All gas that a state vector of the engine (>= STATES,) holds."""
    valve = valve_states(y)
    volumes = (cylinder_gas(y), receiver_gas(y), line_gas(y), pipe_gas(y))
    mass, energy = valve.mass_a + valve.mass_b, valve.energy_a + valve.energy_b
    for volume_mass, volume_energy in volumes:
        mass, energy = mass + volume_mass, energy + volume_energy
    return GasContent(mass, energy)


@kernel
def control_ledger(y: np.ndarray) -> ControlLedger:
    """Read the ledger of the control air from a state vector of the engine (SIZE,), or its rates."""
    return control_ledger_at(y, LEDGER)


@kernel
def effects_ledger(y: np.ndarray) -> Flow:
    """Read what effects have let into chambers and cylinder from a state vector of the engine (SIZE,), or its rates.

    Mass in [kg], energy in [J].
    """
    return ledger_flow(y, EFFECTS_LEDGER)


def engine_ledger(y: np.ndarray) -> EngineLedger:
    """Read the ledger of the engine air from a state vector of the engine (SIZE,), or its rates."""
    groove, exhaust, feed, pipe = (ledger_flow(y, i) for i in range(ENGINE_LEDGER, GROOVE_BACK, FLOW_ENTRIES))
    return EngineLedger(groove, exhaust, feed, pipe, y[GROOVE_BACK], y[EXHAUST_BACK], y[WORK])


@kernel
def update_states(y: np.ndarray, valve: ValveStates | np.ndarray, gases: tuple[GasContent, ...]) -> None:
    """Write the states of an engine, or their rates, into its state vector `y` (SIZE,); `valve` as an array is (6,).

    `gases` are those of `VOLUMES`, in their order.
    """
    update_part(y, 0, valve)
    for i in range(len(VOLUMES)):
        first, gas = valve_actuator.STATES + GAS_ENTRIES * i, gases[i]
        y[first], y[first + 1] = gas.mass, gas.energy


@kernel
def update_ledgers(y: np.ndarray, control: ControlLedger, let_in: Flow, engine: EngineLedger) -> None:
    """Write the ledgers of an engine, or their rates, into its state vector `y` (SIZE,).

    `let_in` is what effects let in.
    """
    update_control_ledger(y, LEDGER, control)
    update_part(y, EFFECTS_LEDGER, let_in)
    update_flows(y, ENGINE_LEDGER, (engine.groove, engine.exhaust, engine.feed, engine.pipe))
    y[GROOVE_BACK], y[EXHAUST_BACK], y[WORK] = engine.groove_back, engine.exhaust_back, engine.work


@kernel
def receiver_state(p: Cycle, y: np.ndarray) -> GasState:
    """State of the air in the receiver; that of the supply where the receiver is infinite.

    `y` (>= STATES,) is the state vector.

    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> state = receiver_state(cycle, y)
    >>> print(round(state.pressure), "Pa,", round(state.temperature, 6), "K")
    1101325 Pa, 287.0 K
    """
    if p.receiver_volume > 0.0:
        return chamber_state(p.actuator.gas, receiver_gas(y), p.receiver_volume)
    return p.supply


@kernel
def has_pipe(p: Cycle) -> bool:
    """Check whether the machine has an intake pipe, by an effect."""
    return len(p.effects) > 0 and p.pipe.feed_area > 0.0


@kernel
def intake_state(p: Cycle, y: np.ndarray, receiver: GasState) -> GasState:
    """State of the air before the groove: in the intake pipe, or where there is none, in the receiver.

    `y` (>= SIZE,) is the state vector.
    """
    if has_pipe(p):
        return chamber_state(p.actuator.gas, pipe_gas(y), p.pipe.volume)
    return receiver


@kernel
def instant_at(p: Cycle, t: float, y: np.ndarray) -> Instant:
    """What the laws of the cylinder see around it, `t` [s] from the start of the cycle, from `y` (>= STATES,)."""
    behind_exhaust = GasState(p.exhaust_pressure, p.actuator.ambient.temperature)
    return Instant(p.start + p.speed * t, receiver_state(p, y), behind_exhaust)


@kernel
def cylinder_state(p: Cycle, now: Instant, y: np.ndarray) -> tuple[CylinderState, float]:
    """State of the cylinder, as its effects' laws see it, and the slope of its volume over the crank angle [m3/rad].

    `y` (>= STATES,) is the state vector.
    """
    volume, slope = cylinder_volume(p.crank, now.angle)
    gas, ambient = p.actuator.gas, p.actuator.ambient
    air = chamber_state(gas, cylinder_gas(y), volume)
    intake = intake_state(p, y, now.receiver) if len(p.effects) > 0 else p.supply
    speed = abs(p.speed)  # of a crank that turns backwards, too
    return CylinderState(gas, ambient, p.engine, speed, now.angle, volume, air, intake, now.behind_exhaust), slope


@kernel
def control_air(p: Cycle, y: np.ndarray, receiver: GasState) -> Sides:
    """State of the control air at its source, receiver or regulator, and before the solenoids, from `y` (>= SIZE,).

    Both are equal where there is no supply line.
    """
    source = receiver if p.control_from_receiver else p.control
    return Sides(source, before_solenoids(p.actuator, y, LINE, source))


@kernel
def supply_of(p: Cycle, y: np.ndarray, receiver: GasState) -> ValveSupply:
    """State of the air that is fed to the valve, from the state vector `y` (>= SIZE,).

    It is the control air before the solenoids, and the pressure before the groove; that of the supply where no effect
    of the valve asks for it.
    """
    intake = p.supply
    if len(p.actuator.effects) > 0:
        intake = intake_state(p, y, receiver)
    return ValveSupply(control_air(p, y, receiver).behind, intake.pressure)
