"""State vector of an engine: where its states and ledgers stand, and what the kernels know of its machine."""

from typing import NamedTuple

import numpy as np

from apesim.air import GasContent, GasState
from apesim.effect import FedVolume, NoEffects
from apesim.engine.cycle.exchange import FLOWS, Exchange
from apesim.engine.cylinder import CylinderState, Engine
from apesim.engine.effects import EngineLaws, EngineTables
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
)
from apesim.valve.line import before_solenoids
from apesim.valve.ports import Ports
from apesim.valve.supply import ValveSupply

CYLINDER, RECEIVER = valve_actuator.STATES, valve_actuator.STATES + 2
"""Elements of the state vector at which the gas of the cylinder and of the receiver begins."""
STATES = RECEIVER + 2
"""States that every engine has: of its valve, cylinder and receiver."""
LINE, PIPE = STATES, STATES + 2
"""Elements at which the gas of the supply line and of the intake pipe begins; without these it is not controlled."""
LEDGER = PIPE + 2
"""Element at which the ledger of the control air begins."""
EFFECTS_LEDGER = LEDGER + CONTROL_ENTRIES
"""Element at which the ledger of what effects let in begins."""
ENGINE_LEDGER = EFFECTS_LEDGER + FLOW_ENTRIES
"""Element at which the ledger of the engine air begins."""


class EngineLedger(NamedTuple):
    """Ledger of the engine air: sums since the start, or their rates."""

    flows: Exchange[Flow]
    """Net mass [kg] and enthalpy [J] through each flow of the gas exchange; the groove's with what passes beside it."""
    groove_back: float
    """Air that flowed back through the groove [kg]."""
    exhaust_back: float
    """Air that flowed in through the exhaust valve [kg]."""
    work: float
    """Work of the gas on the engine's piston [J]."""


GROOVE_BACK = ENGINE_LEDGER + FLOW_ENTRIES * FLOWS
EXHAUST_BACK, WORK, SIZE = range(GROOVE_BACK + 1, GROOVE_BACK + 4)
"""Elements of what stands behind the flows in the engine air's ledger; SIZE is how many a state vector has."""
INTAKE_OPEN, LIFT, LIFT_SLOPE, BRANCHES, EXCHANGE = range(valve_actuator.MODES, valve_actuator.MODES + 5)
MODES = EXCHANGE + FLOWS
"""Modes of a smooth segment, behind those of the valve.

INTAKE_OPEN says whether the ideal valve is open. LIFT [m] and LIFT_SLOPE [m/rad] are the line of a cam's lift curve,
from crank angle 0. BRANCHES holds the branches of the effects' laws. From EXCHANGE on they hold the regimes of the
flows, in the order of `apesim.engine.cycle.exchange.Exchange`; MODES is how many modes there are."""
SCALE = valve_actuator.SCALE + 4 * (valve_actuator.GAS_SCALE,)
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
    """Pressure behind the exhaust valve [Pa abs]."""
    pipe: FedVolume
    """Intake pipe before the groove, where an effect puts one there."""
    effects: EngineLaws | EngineTables | NoEffects  # type: ignore[valid-type]
    """Parameters of the effects that act on the cylinder."""


class CycleTables(NamedTuple):
    """Arrays of a machine."""

    valve: ActuatorTables
    """Arrays of the valve."""
    cam: np.ndarray
    """Lift curve of the cam: crank angle [rad] and lift [m], (n, 2); no rows: it has none."""


@kernel
def cylinder_gas(y: np.ndarray) -> GasContent:
    """Read the gas of the cylinder from a state vector of the engine, or its rates.

    Parameters
    ----------
    y : (>= STATES,) float array
        State vector, a difference or the rates of such vectors.

    Returns
    -------
    apesim.air.GasContent
        Mass and internal energy.

    Examples
    --------
    >>> print(*cylinder_gas(np.arange(float(SIZE))))
    6.0 7.0
    """
    return gas_of_volume(y, CYLINDER)


@kernel
def receiver_gas(y: np.ndarray) -> GasContent:
    """Read the gas of the receiver from a state vector of the engine, or its rates.

    Parameters
    ----------
    y : (>= STATES,) float array
        State vector, a difference or the rates of such vectors.

    Returns
    -------
    apesim.air.GasContent
        Mass and internal energy; 0 where the receiver is infinite.

    Examples
    --------
    >>> print(*receiver_gas(np.arange(float(SIZE))))
    8.0 9.0
    """
    return gas_of_volume(y, RECEIVER)


@kernel
def line_gas(y: np.ndarray) -> GasContent:
    """Read the gas of the supply line from a state vector of the engine, or its rates.

    Parameters
    ----------
    y : (SIZE,) float array
        State vector, a difference or the rates of such vectors.

    Returns
    -------
    apesim.air.GasContent
        Mass and internal energy; 0 where there is no line.

    Examples
    --------
    >>> print(*line_gas(np.arange(float(SIZE))))
    10.0 11.0
    """
    return gas_of_volume(y, LINE)


@kernel
def pipe_gas(y: np.ndarray) -> GasContent:
    """Read the gas of the intake pipe from a state vector of the engine, or its rates.

    Parameters
    ----------
    y : (SIZE,) float array
        State vector, a difference or the rates of such vectors.

    Returns
    -------
    apesim.air.GasContent
        Mass and internal energy; 0 where there is no pipe.

    Examples
    --------
    >>> print(*pipe_gas(np.arange(float(SIZE))))
    12.0 13.0
    """
    return gas_of_volume(y, PIPE)


@kernel
def control_ledger(y: np.ndarray) -> ControlLedger:
    """Read the ledger of the control air from a state vector of the engine, or its rates.

    Parameters
    ----------
    y : (SIZE,) float array
        State vector, a difference or the rates of such vectors.

    Returns
    -------
    apesim.valve.ledger.ControlLedger
        Its entries, by name.

    Examples
    --------
    >>> print(control_ledger(np.arange(float(SIZE))).line_fed.mass)
    14.0
    """
    return control_ledger_at(y, LEDGER)


@kernel
def effects_ledger(y: np.ndarray) -> Flow:
    """Read what effects have let into chambers and cylinder from a state vector of the engine, or its rates.

    Parameters
    ----------
    y : (SIZE,) float array
        State vector, a difference or the rates of such vectors.

    Returns
    -------
    apesim.restriction.Flow
        Mass [kg] and energy [J].

    Examples
    --------
    >>> print(effects_ledger(np.arange(float(SIZE))).mass)
    21.0
    """
    return ledger_flow(y, EFFECTS_LEDGER)


def engine_ledger(y: np.ndarray) -> EngineLedger:
    """Read the ledger of the engine air from a state vector of the engine, or its rates.

    Parameters
    ----------
    y : (SIZE,) float array
        State vector, a difference or the rates of such vectors.

    Returns
    -------
    EngineLedger
        Its entries, by name.

    Examples
    --------
    >>> ledger = engine_ledger(np.arange(float(SIZE)))
    >>> print(ledger.flows.groove.mass, ledger.work)
    23.0 33.0
    """
    flows = Exchange(*(ledger_flow(y, ENGINE_LEDGER + FLOW_ENTRIES * flow) for flow in range(FLOWS)))
    return EngineLedger(flows, y[GROOVE_BACK], y[EXHAUST_BACK], y[WORK])


@kernel
def update_states(
    y: np.ndarray,
    valve: ValveStates | np.ndarray,
    cylinder: GasContent,
    receiver: GasContent,
    line: GasContent,
    pipe: GasContent,
) -> None:
    """Write the states of an engine into its state vector, or their rates.

    Parameters
    ----------
    y : (SIZE,) float array
        State vector that is changed.
    valve : apesim.valve.ledger.ValveStates or (6,) float array
        States of the valve.
    cylinder, receiver, line, pipe : apesim.air.GasContent
        Gas in each volume.

    Examples
    --------
    >>> y = np.zeros(SIZE)
    >>> none = GasContent(0.0, 0.0)
    >>> update_states(y, ValveStates(9e-3, 0.0, 0.0, 0.0, 0.0, 0.0), GasContent(2e-4, 41.0), none, none, none)
    >>> print(cylinder_gas(y).mass)
    0.0002
    """
    update_part(y, 0, valve)
    update_part(y, CYLINDER, cylinder)
    update_part(y, RECEIVER, receiver)
    update_part(y, LINE, line)
    update_part(y, PIPE, pipe)


@kernel
def update_ledgers(y: np.ndarray, control: ControlLedger, let_in: Flow, engine: EngineLedger) -> None:
    """Write the ledgers of an engine into its state vector, or their rates.

    Parameters
    ----------
    y : (SIZE,) float array
        State vector that is changed.
    control : apesim.valve.ledger.ControlLedger
        Ledger of the control air.
    let_in : apesim.restriction.Flow
        Mass and energy that effects let in.
    engine : EngineLedger
        Ledger of the engine air.

    Examples
    --------
    >>> y = np.zeros(SIZE)
    >>> update_ledgers(y, control_ledger(y), effects_ledger(y), engine_ledger(y)._replace(work=120.0))
    >>> print(engine_ledger(y).work)
    120.0
    """
    update_control_ledger(y, LEDGER, control)
    update_part(y, EFFECTS_LEDGER, let_in)
    update_flows(y, ENGINE_LEDGER, engine.flows)
    y[GROOVE_BACK], y[EXHAUST_BACK], y[WORK] = engine.groove_back, engine.exhaust_back, engine.work


@kernel
def receiver_state(p: Cycle, y: np.ndarray) -> GasState:
    """State of the air in the receiver.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    y : (>= STATES,) float array
        State vector.

    Returns
    -------
    apesim.air.GasState
        State of the air in the receiver; that of the supply where the receiver is infinite.

    Examples
    --------
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
    """Check whether the machine has an intake pipe, by an effect.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.

    Returns
    -------
    bool
        Whether there is an intake pipe.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> has_pipe(cycle)
    False
    """
    return len(p.effects) > 0 and p.pipe.feed_area > 0.0


@kernel
def intake_state(p: Cycle, y: np.ndarray, receiver: GasState) -> GasState:
    """State of the air before the groove: in the intake pipe, or where there is none, in the receiver.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    y : (>= SIZE,) float array
        State vector.
    receiver : apesim.air.GasState
        State of the air in the receiver.

    Returns
    -------
    apesim.air.GasState
        State of the air before the groove.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> intake_state(cycle, y, GasState(1e6, 290.0))
    GasState(pressure=1000000.0, temperature=290.0)
    """
    if has_pipe(p):
        return chamber_state(p.actuator.gas, pipe_gas(y), p.pipe.volume)
    return receiver


@kernel
def cylinder_state(p: Cycle, t: float, y: np.ndarray) -> tuple[CylinderState, float]:
    """State of the cylinder, and the slope of its volume over the crank angle.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    t : float
        Time from the start of the cycle [s].
    y : (>= STATES,) float array
        State vector.

    Returns
    -------
    state : apesim.engine.cylinder.CylinderState
        State of the cylinder, as the laws of its effects see it.
    slope : float
        Slope of the cylinder's volume over the crank angle [m3/rad].

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> state, slope = cylinder_state(cycle, 0.0, y)
    >>> print(round(state.air.pressure), "Pa,", round(state.air.temperature, 6), "K")
    101325 Pa, 293.15 K
    """
    angle = p.start + p.speed * t
    volume, slope = cylinder_volume(p.crank, angle)
    gas = p.actuator.gas
    air = chamber_state(gas, cylinder_gas(y), volume)
    intake = intake_state(p, y, receiver_state(p, y)) if len(p.effects) > 0 else p.supply
    behind_exhaust = GasState(p.exhaust_pressure, p.actuator.ambient.temperature)
    return CylinderState(gas, p.actuator.ambient, p.engine, p.speed, angle, volume, air, intake, behind_exhaust), slope


@kernel
def control_air(p: Cycle, y: np.ndarray) -> Sides:
    """State of the control air at its source and before the solenoids.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    y : (>= SIZE,) float array
        State vector.

    Returns
    -------
    apesim.restriction.Sides
        State of the air in the receiver or behind the regulator, and in the supply line; equal where there is none.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> control_air(cycle, y).before
    GasState(pressure=1101325.0, temperature=287.0)
    """
    source = receiver_state(p, y) if p.control_from_receiver else p.control
    return Sides(source, before_solenoids(p.actuator, y, LINE, source))


@kernel
def supply_of(p: Cycle, y: np.ndarray) -> ValveSupply:
    """State of the air that is fed to the valve.

    Parameters
    ----------
    p : apesim.engine.cycle.state.Cycle
        Machine at a speed.
    y : (>= SIZE,) float array
        State vector.

    Returns
    -------
    apesim.valve.supply.ValveSupply
        Control air before the solenoids, and pressure before the groove; that of the supply where no effect of the
        valve asks for it.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), 100.0)
    >>> y, mode = charged_at_rest(cycle)
    >>> supply_of(cycle, y).intake_pressure
    1101325.0
    """
    intake = p.supply
    if len(p.actuator.effects) > 0:
        intake = intake_state(p, y, receiver_state(p, y))
    return ValveSupply(control_air(p, y).behind, intake.pressure)
