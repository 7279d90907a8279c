"""Valve on its bench, as a step of compiled code takes it: its inputs, its state as a row of numbers, its outputs."""

from typing import Any

import numpy as np
from numba import carray

from apesim.air import GasState
from apesim.engine.machine import Machine
from apesim.kernel import kernel
from apesim.march.adaptive import CARRIED, STOP, STRETCH_END
from apesim.march.hybrid_system import observe
from apesim.studies.fmu.flat import unflattener
from apesim.studies.fmu.model import RENEWED, Model, Variable, supply_inputs, update_carry
from apesim.studies.fmu.native import march
from apesim.valve.actuator import MODES, PHASE, START, ActuatorTables
from apesim.valve.bench import LINE, SIZE, TRACE, Bench, accuracy_of, bench_ledger, bench_of
from apesim.valve.chamber import filled
from apesim.valve.edges import EDGES, FAR, add_edge, len_of_ramps, next_corner_time
from apesim.valve.ledger import update_part
from apesim.valve.piston import HELD_CLOSED, volume_a, volume_b
from apesim.valve.supply import ValveSupply

CARRY = SIZE + MODES
"""Element of the state at which what the march carries begins, behind the state vector and the modes."""
CLOCK = CARRY + CARRIED
"""Element behind that: time on the march's clock [s]."""
BEFORE = CLOCK + 1
"""Element behind that at which the inputs of the last step begin."""
COMMAND, PRESSURE, TEMPERATURE, INPUTS = range(4)
"""Inputs: command, 0 or 1, pressure [Pa abs] and temperature [K] of the supply; how many there are."""
FIRST_EDGE = BEFORE + INPUTS
"""Element behind these at which the edges of the command [s] begin, see `apesim.valve.edges`."""
STATE_SIZE = FIRST_EDGE + EDGES
"""Length of a state."""
OUTPUTS = (
    Variable("lift_m", "m", "Lift of the valve"),
    Variable("velocity_m_s", "m/s", "Velocity of the lift, positive as the valve opens"),
    Variable("pressure_a_Pa", "Pa", "Pressure in chamber A, which pushes to closed, absolute"),
    Variable("pressure_b_Pa", "Pa", "Pressure in chamber B, which pushes to open, absolute"),
    Variable("control_air_kg", "kg", "Control air from its source since the start"),
)
FROM_TRACE = 4
"""Outputs that are the first columns of a trace."""
ROW = len(TRACE)
"""Columns of a trace."""
MAX_CORNERS = 256
"""Room for the corners of the solenoids in a step; a step with more is marched in parts."""


def numbers_of(machine: Machine) -> Any:
    """Prepare a machine's valve for the step: parameters, arrays and accuracy, see `flat.flatten`."""
    p, tables = bench_of(machine, edges=[])
    return p, (tables.curves_a, tables.curves_b, tables.groove), accuracy_of(p)


def valve_model(machine: Machine) -> Model:
    """Make the model of a machine's valve."""
    inputs = Variable("command", "", "Command: 1 energises both solenoids, 0 releases them", 0.0, 0.0, 1.0, True)
    control = machine.supply.control()
    return Model(
        "valve",
        (inputs, *supply_inputs(control.pressure, control.temperature, "control air")),
        OUTPUTS,
        numbers_of,
        STATE_SIZE,
        np.zeros(STATE_SIZE),
        make_step,
    )


def make_step(example: Any) -> Any:
    """Make the function of a step of a valve with the types and shapes of an example, see `numbers_of`.

    It takes the addresses of numbers, inputs and state, whether it begins at rest, the duration [s], and the address of
    the outputs; it returns the `apesim.march.adaptive.Status`.
    """
    unflatten = unflattener(example)

    def step(numbers: Any, inputs: Any, address: Any, begins: int, duration: float, outputs: Any) -> int:
        # The machine with the inputs of this step.
        p, (curves_a, curves_b, groove), accuracy = unflatten(numbers)
        given, state, shown = carray(inputs, INPUTS), carray(address, STATE_SIZE), carray(outputs, len(OUTPUTS))
        y, mode, carry, edges = state[:SIZE], state[SIZE:CARRY], state[CARRY:CLOCK], state[FIRST_EDGE:]
        control = GasState(given[PRESSURE], given[TEMPERATURE])
        bench = Bench(p.actuator, ValveSupply(control, p.supply.intake_pressure))
        tables = ActuatorTables(edges, edges, np.inf, curves_a, curves_b, groove)
        if begins != 0:
            begin_closed(bench, state)
            update_carry(carry, accuracy)
        elif duration > 0.0 and take_inputs(given, len_of_ramps(tables), state):
            carry[STRETCH_END] = -np.inf

        # On to the end, from corner to corner of the solenoids: a part for each set that there is room for.
        status, clock, end = 0, state[CLOCK], state[CLOCK] + duration
        corners, none = np.empty(MAX_CORNERS), np.empty((0, 0))
        while status == 0 and clock < end:
            count = corners_until(tables, clock, end, corners)
            carry[STOP] = min(end, corners[count - 1])
            outcome = march(bench, tables, clock, y, mode, corners[:count], accuracy, none, corners[:0], none, carry)
            status, clock = outcome.status, carry[STOP]
        state[CLOCK] = end

        row = np.empty(ROW)
        observe(bench, end, y, mode, row)
        for i in range(FROM_TRACE):
            shown[i] = row[i]
        shown[FROM_TRACE] = bench_ledger(y).line_fed.mass
        return status

    return step


@kernel(inline=False)
def begin_closed(p: Bench, state: np.ndarray) -> None:
    """Write the state of a bench at rest into that of an FMU: valve closed, supply line full, released for ever."""
    for i in range(STATE_SIZE):
        state[i] = 0.0 if i < FIRST_EDGE else np.inf
    gas, valve, control = p.actuator.gas, p.actuator.valve, p.supply.control
    vent = GasState(p.actuator.vent_pressure, control.temperature)
    state[0], state[SIZE + PHASE] = valve.stroke, HELD_CLOSED
    update_part(state, 2, filled(gas, volume_a(valve, valve.stroke), control))
    update_part(state, 4, filled(gas, volume_b(valve, valve.stroke), vent))
    update_part(state, LINE, filled(gas, p.actuator.line.volume, control))


@kernel(inline=False)
def take_inputs(given: np.ndarray, longest_ramp: float, state: np.ndarray) -> bool:
    """Take the inputs of a step over into the state; return whether anything is new, so that a stretch begins.

    `longest_ramp` is that of a solenoid [s].
    """
    is_new = state[CLOCK] > RENEWED
    if is_new:
        renew_clock(state)
    if given[COMMAND] != state[BEFORE + COMMAND]:
        add_edge(state[FIRST_EDGE:], state[CLOCK], longest_ramp)
    for i in range(INPUTS):
        is_new = is_new or given[i] != state[BEFORE + i]
        state[BEFORE + i] = given[i]
    return is_new


@kernel
def renew_clock(state: np.ndarray) -> None:
    """Let the clock begin anew at 0."""
    for i in range(FIRST_EDGE, STATE_SIZE):
        state[i] -= state[CLOCK]
    state[SIZE + START] -= state[CLOCK]
    state[CLOCK] = 0.0


@kernel(inline=False)
def corners_until(tables: ActuatorTables, t: float, end: float, corners: np.ndarray) -> int:
    """Write the corners of the solenoids after a time [s], up to the first one that is not before the end; count them.

    Where there is none, a time far behind the end stands for it; where there is no room, the last one is before it.
    """
    count, corner = 0, t
    while corner < end and count < corners.shape[0]:
        corner = min(next_corner_time(tables, corner), FAR)
        corners[count] = corner
        count += 1
    return count
