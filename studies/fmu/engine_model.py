"""Engine on its shaft, as a step of compiled code takes it: its inputs, its state as a row of numbers, its outputs."""

from functools import partial
from math import isnan, nan
from typing import Any

import numpy as np
from numba import carray

from apesim.air import GasState
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.drivetrain.preparing import Course, Prepared, accuracy_of, machines_of, prepare, released
from apesim.engine.drivetrain.rates import SHAFT_TRACE
from apesim.engine.drivetrain.run import EVENTS_A_REVOLUTION, LONGEST_PIECE, SLOWEST, air_of, draws_from_supply
from apesim.engine.drivetrain.state import (
    FIRST_EDGE,
    HELD_SINCE,
    NEXT_TIME,
    OWN_MODES,
    SHAFT_MODES,
    SPEED,
    Drivetrain,
    DrivetrainTables,
    block_of,
    cylinder_of,
    cylinders_of,
    own_modes,
    shaft_modes,
    shaft_states,
    state_size,
)
from apesim.engine.drivetrain.steady import settle_at
from apesim.engine.machine import Machine
from apesim.kernel import kernel
from apesim.march.adaptive import CARRIED, MAX_EVENTS, STOP, STRETCH_END, Status
from apesim.march.hybrid_system import observe
from apesim.packed import numbers_in
from apesim.quantities.trees import leaves_of
from apesim.results import NotConverged
from apesim.studies.fmu.flat import unflattener
from apesim.studies.fmu.model import RENEWED, Model, Variable, supply_inputs, update_carry
from apesim.studies.fmu.native import march
from apesim.studies.run.operating_conditions import SPEED as SPEED_RANGE
from apesim.valve.actuator import START
from apesim.valve.edges import EDGES, FAR
from apesim.valve.motion import put_at_rest

ENERGISE_INPUT, RELEASE_INPUT, PRESSURE, TEMPERATURE, SHAFT, INPUTS = range(6)
"""Inputs: command angles [deg], pressure [Pa abs] and temperature [K] of the supply, speed [rad/s] or load [N m] of the
shaft; how many there are."""
OUTPUTS = (
    Variable("lift_m", "m", "Lift of the valve"),
    Variable("velocity_m_s", "m/s", "Velocity of the lift, positive as the valve opens"),
    Variable("pressure_a_Pa", "Pa", "Pressure in chamber A of the valve, which pushes to closed, absolute"),
    Variable("pressure_b_Pa", "Pa", "Pressure in chamber B of the valve, which pushes to open, absolute"),
    Variable("torque_Nm", "N m", "Torque of the gas less friction, of all cylinders"),
    Variable("cylinder_pressure_Pa", "Pa", "Pressure in the cylinder, absolute"),
    Variable("angle_deg", "deg", "Angle of the crank since the start, which is at top dead centre"),
    Variable("speed_rad_s", "rad/s", "Speed of the shaft"),
    Variable("air_kg", "kg", "Air from the supply through the grooves of all cylinders since the start"),
    Variable("control_air_kg", "kg", "Control air of all cylinders since the start"),
)
"""Outputs; those of a valve and a cylinder are of the first."""
AT_EXPORT = (
    *("command.", "engine.cam.", "engine.exhaust.opens", "engine.exhaust.closes", "engine.exhaust.flank"),
    *("engine.exhaust_2.", "stage_2.", "inter_receiver."),
)
"""Beginnings of keys that the state at the start holds, too: corners of the crank's angle. They are fixed."""
GIVEN = ("supply.pressure", "supply.temperature", "supply.control_pressure", "load.constant")
"""Keys that inputs stand for, or that follow them."""
OF_VALVE = "lift", "velocity", "pressure_a", "pressure_b"
FROM_VALVE = [i for i, name in enumerate(TRACE) if name.split()[0] in OF_VALVE]
"""Columns of a cylinder's trace that are of its valve."""


def engine_model(machine: Machine, speed: float, is_free: bool) -> Model:
    """Make the model of a machine's engine, in its periodic state at a speed [rad/s]; its shaft is free, or imposed."""
    prepared = _settled(machine, speed)
    command, supply = machine.command, machine.supply
    leaves = leaves_of(type(machine))
    shaft = Variable("speed_rad_s", "rad/s", "Speed of the shaft", speed, 0.0, SPEED_RANGE.ends[1])
    if is_free:
        low, high = leaves["load.constant"].declaration.ends
        shaft = Variable("load_torque_Nm", "N m", "Constant part of the load", machine.load.constant, low, high)
    angles = [
        Variable(f"{name}_deg", "deg", text, getattr(command, name) / DEGREE, low / DEGREE, high / DEGREE)
        for name, text in (
            ("energise", "Crank angle of energising, read when the crank passes 180 deg"),
            ("release", "Crank angle of release, less than a turn behind that"),
        )
        for low, high in (leaves[f"command.{name}"].declaration.ends,)
    ]
    outputs = [each for each in OUTPUTS if is_free or each.name != shaft.name]
    return Model(
        "engine",
        (*angles, *supply_inputs(supply.pressure, supply.temperature, "engine air and control air"), shaft),
        outputs,
        partial(numbers_of, is_free=is_free),
        len(prepared.y) + len(prepared.mode) + CARRIED + 1 + INPUTS,
        np.concatenate((prepared.y, prepared.mode, np.zeros(CARRIED + 1 + INPUTS))),
        make_step,
        GIVEN,
        AT_EXPORT,
    )


def _course(machine: Machine, speed: float) -> Course:
    """What an importer imposes: command angles of each cylinder, and a speed [rad/s] unless the shaft is free."""
    commands = [each.command for each in machines_of(machine)]
    schedules = [np.array([[0.0, command.energise, command.release]]) for command in commands]
    return Course(np.array([[0.0, speed], [1.0, speed]]), schedules=schedules)


def _settled(machine: Machine, speed: float) -> Prepared:
    """Prepare a drivetrain in its periodic state at a speed [rad/s]; raises NotConverged where it has none."""
    course = _course(machine, speed)
    _, _, orbit = settle_at(machine, speed, course.schedules)
    if orbit.status != Status.DONE:
        raise NotConverged(
            "the engine's FMU", "it has no periodic state to begin in", Status(orbit.status).remedy, None
        )
    return released(prepare(machine, 0.0, course), orbit.y, orbit.mode, 0.0)


def numbers_of(machine: Machine, is_free: bool) -> Any:
    """Prepare a machine's engine for the step: parameters, arrays, accuracy, and its own control pressure [Pa abs].

    A free shaft has the types and shapes of an imposed one: one library is compiled for both.
    """
    p, tables, _, _, _ = prepare(machine, 0.0, _course(machine, 1.0))
    own = machine.supply.control_pressure
    return p._replace(is_imposed=int(not is_free)), tables, accuracy_of(p), nan if isnan(own) else float(own)


def make_step(example: Any) -> Any:
    """Make the function of a step of an engine with the types and shapes of an example, see `numbers_of`.

    It takes and returns what that of a valve does, see `apesim.studies.fmu.valve_model.make_step`.
    """
    # Places and lengths, which are constants of the compiled code.
    p_of_example = example[0]
    unflatten, temperatures = unflattener(example), _temperature_columns(p_of_example)
    size, count = state_size(p_of_example), len(p_of_example.numbers)
    mode_end = size + OWN_MODES * count + SHAFT_MODES
    clock_place = mode_end + CARRIED
    before = clock_place + 1
    total = before + INPUTS
    columns = len(SHAFT_TRACE) + len(TRACE) * count
    groove, control = air_of(p_of_example, np.arange(size))
    air = tuple(int(i) for i in groove[draws_from_supply(p_of_example)])
    control_air = tuple(int(i) for i in control)
    first = len(SHAFT_TRACE)
    lift, velocity, pressure_a, pressure_b = (first + i for i in FROM_VALVE)
    longest = MAX_EVENTS / (2.0 * EVENTS_A_REVOLUTION * count) * TURN
    speed_place = shaft_states(p_of_example) + SPEED

    def step(numbers: Any, inputs: Any, address: Any, begins: int, duration: float, outputs: Any) -> int:
        # The machine, and the inputs of this step, which its arrays take up.
        p, tables, accuracy, own_control = unflatten(numbers)
        given, state, shown = carray(inputs, INPUTS), carray(address, total), carray(outputs, len(OUTPUTS))
        y, mode, carry = state[:size], state[size:mode_end], state[mode_end:clock_place]
        write_inputs(p, tables, given, own_control)
        for i in range(p.numbers.shape[0]):
            for column in temperatures:
                p.numbers[i, column] = given[TEMPERATURE]
        if begins != 0:
            begin_at_rest(p, y, mode)
            update_carry(carry, accuracy)
        elif duration > 0.0:
            if state[clock_place] > RENEWED:
                renew_clock(p, mode, state[clock_place])
                state[clock_place] = 0.0
                carry[STRETCH_END] = -np.inf
            for i in range(INPUTS):
                if given[i] != state[before + i]:
                    carry[STRETCH_END] = -np.inf
                state[before + i] = given[i]

        # On to the end, in pieces that have room for their events.
        status, clock, end = 0, state[clock_place], state[clock_place] + duration
        far, none, no_times = np.full(1, FAR), np.empty((0, 0)), np.empty(0)
        while status == 0 and clock < end:
            carry[STOP] = min(end, clock + min(LONGEST_PIECE, longest / max(abs(y[speed_place]), SLOWEST)))
            outcome = march(p, tables, clock, y, mode, far, accuracy, none, no_times, none, carry)
            status, clock = outcome.status, carry[STOP]
        state[clock_place] = end

        row = np.empty(columns)
        observe(p, end, y, mode, row)
        shown[0], shown[1] = row[lift], row[velocity]
        shown[2], shown[3] = row[pressure_a], row[pressure_b]
        shown[4], shown[5], shown[6] = row[2] - row[3], row[first], row[0]
        place = 7
        if p.is_imposed == 0:
            shown[place] = y[speed_place]
            place += 1
        shown[place] = shown[place + 1] = 0.0
        for i in air:
            shown[place] += y[i]
        for i in control_air:
            shown[place + 1] += y[i]
        return status

    return step


def _temperature_columns(p: Drivetrain) -> tuple[int, ...]:
    """Columns of a drivetrain's numbers that hold the temperatures of the supply and of the control air."""
    unknown = GasState(0.0, nan)
    template = p.template._replace(supply=unknown, control=unknown)
    pairs = zip(numbers_in(template), numbers_in(p.template), strict=True)
    return tuple(i for i, (a, b) in enumerate(pairs) if isnan(a) and not isnan(b))


@kernel(inline=False)
def write_inputs(p: Drivetrain, tables: DrivetrainTables, given: np.ndarray, own_control: float) -> None:
    """Write the inputs of a step into the arrays of the machine, which the march reads; a second stage has its own."""
    for i in range(cylinders_of(p)):
        if p.sources[i] == 0:
            for row in range(p.schedules.shape[1]):
                p.schedules[i, row, 1] = given[ENERGISE_INPUT] * DEGREE
                p.schedules[i, row, 2] = given[RELEASE_INPUT] * DEGREE
    tables.supplies[0, 1] = given[PRESSURE]
    tables.supplies[0, 2] = own_control if own_control > 0.0 else given[PRESSURE]
    if p.is_imposed == 1:
        for row in range(tables.speeds.shape[0]):
            tables.speeds[row, 1] = given[SHAFT]
    else:
        tables.loads[0, 1] = given[SHAFT]


@kernel(inline=False)
def begin_at_rest(p: Drivetrain, y: np.ndarray, mode: np.ndarray) -> None:
    """Put the pistons of valves that rest on the stops of this machine, whose stroke may be another."""
    for i in range(cylinders_of(p)):
        put_at_rest(cylinder_of(p, y, mode, i).actuator, block_of(y, i), own_modes(mode, i))


@kernel(inline=False)
def renew_clock(p: Drivetrain, mode: np.ndarray, clock: float) -> None:
    """Let the clock, at `clock` [s], begin anew at 0."""
    mode[shaft_modes(p) + HELD_SINCE] -= clock
    for i in range(cylinders_of(p)):
        own = own_modes(mode, i)
        own[START] -= clock
        own[NEXT_TIME] = -np.inf
        for edge in range(FIRST_EDGE, FIRST_EDGE + EDGES):
            own[edge] -= clock
