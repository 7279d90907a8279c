"""A machine as the march of its drivetrain takes it, with what is imposed over time, and its state at rest."""

from collections.abc import Sequence
from math import inf, nan, pi, sqrt
from typing import NamedTuple

import numpy as np

from apesim.engine.angles import TURN
from apesim.engine.cam import cam_corners, window_corners, within_turn
from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
from apesim.engine.cycle.state import CYLINDER, GAS_ENTRIES, RECEIVER, Cycle, CycleTables
from apesim.engine.cycle.state import MODES as CYCLE_MODES
from apesim.engine.cylinder import CAM, IDEAL_VALVE
from apesim.engine.drivetrain.corners import find_command, find_corner, issue_edge
from apesim.engine.drivetrain.rates import LONGEST_STEP, begin_extremes
from apesim.engine.drivetrain.shaft_balance import come_to_rest
from apesim.engine.drivetrain.state import (
    ANGLE,
    ANGLE_REACHED,
    BLOCK,
    CONTROL,
    DIRECTION,
    EDGE_COUNT,
    ENERGISE,
    FIRST_EDGE,
    FRICTION_PRESSURE,
    LOAD,
    NEXT_TIME,
    OWN_MODES,
    PEAK,
    RELEASE,
    SHAFT_MODES,
    SHAFT_STATES,
    SPEED,
    SPEED_REACHED,
    SUPPLY,
    TURNS,
    Drivetrain,
    DrivetrainTables,
    Exchanger,
    Goal,
    block_of,
    own_angle,
    own_extremes,
    own_modes,
    shaft_extremes,
    shaft_modes,
    shaft_states,
    state_size,
    tables_of,
)
from apesim.engine.kinematics import cylinder_volume
from apesim.engine.machine import Machine
from apesim.march.adaptive import Accuracy
from apesim.packed import packed
from apesim.valve.actuator import GAS_SCALE
from apesim.valve.actuator import SCALE as VALVE_SCALE
from apesim.valve.chamber import filled
from apesim.valve.edges import EDGES

MERGED = 1e-9
"""Angle up to which two corners of a cylinder are one [rad]; chosen below the margin by which one is passed."""
ANGLE_SCALE, SPEED_SCALE = 1.0, 1.0
"""Scales of the errors of the shaft's angle [rad] and speed [rad/s]; chosen."""


class Course(NamedTuple):
    """What is imposed on a drivetrain over time, each as rows whose first column is the time [s], ascending."""

    speeds: np.ndarray = np.empty((0, 2))
    """Speed [rad/s], linear between rows; none: the shaft is free."""
    loads: np.ndarray = np.empty((0, 2))
    """Constant part of the load from then on [N m]; before the first row that of the machine."""
    supplies: np.ndarray = np.empty((0, 2))
    """Pressure of the supply from then on [Pa abs]; before the first row that of the machine."""
    schedules: Sequence[np.ndarray] = ()
    """Command angles of each cylinder over speed, not over time, (k, 3): [rad/s], energise and release [rad]; none:
    those of the machine."""
    deviations: np.ndarray = np.empty((0, 0))
    """What is added to the dead times of each cylinder's edges, in turn [s], (n, e); none: nothing."""


TRANSIENT_TOLERANCE = 5e-8
"""Relative tolerance of a step; half of a cycle's, as the torques of several cylinders cancel out in part."""
EMPTY_STATES = 4
"""States of a block that are nearly always empty: the gas of supply line and intake pipe."""
NO_GOAL = Goal(nan, nan, inf)
"""Nothing to wait for."""
NO_COURSE = Course()
"""Nothing that is imposed."""


class Prepared(NamedTuple):
    """Drivetrain with its state at the start of a march."""

    p: Drivetrain
    """Numbers for the kernels."""
    tables: DrivetrainTables
    """Arrays for the kernels."""
    y: np.ndarray
    """State vector."""
    mode: np.ndarray
    """Modes."""
    breakpoints: np.ndarray
    """Times at which something imposed changes [s]."""


def count_cylinders(machine: Machine) -> int:
    """Count the cylinders of a machine, or its stages, which have one each."""
    return 2 if machine.stage_2.is_on else int(machine.engine.cylinders)


def machines_of(machine: Machine) -> list[Machine]:
    """Make the machine of each cylinder, or of each stage."""
    if not machine.stage_2.is_on:
        return [machine.machine_of_cylinder(i) for i in range(count_cylinders(machine))]
    stage = machine.stage_2
    same = {name: getattr(stage, name) for name in ("bore", "stroke", "rod_length", "pin_offset")}
    engine = machine.engine._replace(
        **same, compression_ratio=stage.compression_ratio, exhaust=stage.exhaust, cam=stage.cam
    )
    return [machine, machine._replace(engine=engine, groove=stage.groove, command=stage.command)]


def prepare(machine: Machine, angle: float, course: Course = NO_COURSE, goal: Goal = NO_GOAL) -> Prepared:
    """Prepare a machine's drivetrain at rest, its crank at an angle [rad] of the shaft.

    Receivers are at supply pressure, the cylinders at ambient state in the volumes of their angles, the valves closed;
    an inter-receiver is at ambient state. A solenoid whose command is energised there has its first edge at once.
    """
    cycles = [cycle_of(each, 1.0)[:2] for each in machines_of(machine)]
    count, stages = len(cycles), machine.stage_2.is_on
    phases = np.array([0.0, machine.stage_2.phase]) if stages else np.array(machine.engine.resolve_phases())
    corners = corners_of(cycles)
    reads = np.abs(corners - pi).argmin(axis=1) if len(course.schedules) else np.full(count, -1)

    # The receiver is in the block of the first cylinder: the others have none of their own, and no feed.
    holders = [cycles[0][0]]
    for cycle, _ in cycles[1:]:
        volume = machine.inter_receiver.volume if stages else 0.0
        receiver = cycle.engine.receiver._replace(feed_area=0.0)
        holders.append(cycle._replace(receiver_volume=volume, engine=cycle.engine._replace(receiver=receiver)))
    ambient = machine.ambient.temperature
    exchanger = Exchanger(
        machine.inter_receiver.effectiveness,
        machine.inter_receiver.resolve_temperature(ambient),
        machine.inter_receiver.wall_conductance if stages else 0.0,
    )
    p = Drivetrain(
        holders[0],
        packed(holders),
        phases,
        np.arange(count) if stages else np.zeros(count, dtype=int),
        np.array([1, -1]) if stages else np.full(count, -1),
        machine.shaft,
        machine.load._replace(table=None),  # type: ignore[arg-type]
        np.ascontiguousarray(machine.load.table).reshape(-1, 2),
        int(len(course.speeds) > 0),
        corners,
        reads,
        stack_schedules(course.schedules, count),
        np.ascontiguousarray(course.deviations).reshape(count, -1),
        exchanger,
        goal,
        is_followed=0,
    )
    tables = _tables(machine, [each for _, each in cycles], course)
    y, mode = _at_rest(p, tables, angle, [each for each, _ in cycles], [each for _, each in cycles], machine)
    times = [course.loads[:, 0], course.supplies[:, 0], course.speeds[:, 0]]
    return Prepared(p, tables, y, mode, np.unique(np.concatenate(times)))


def released(free: Prepared, y: np.ndarray, mode: np.ndarray, time: float) -> Prepared:
    """Let a free shaft begin in a state that was reached at an imposed speed, after a time [s] and whole turns.

    Ledgers and extremes begin anew, and with them the count of turns.
    """
    p, y, mode = free.p, y.copy(), mode.copy()
    y[shaft_states(p) + ANGLE] = 0.0
    begin_ledgers(p, y)
    shift_times(p, mode, time)
    for i in range(len(p.numbers)):
        find_corner(p.corners[i], own_angle(p, y, i), own_modes(mode, i))
        find_command(own_angle(p, y, i), own_modes(mode, i))
    mode[shaft_modes(p) + TURNS] = 0.0
    return free._replace(y=y, mode=mode)


def begin_ledgers(p: Drivetrain, y: np.ndarray) -> None:
    """Let ledgers and extremes begin anew, all but the pressures that friction follows; changes `y`."""
    y[shaft_states(p) + SHAFT_STATES : shaft_extremes(p)] = 0.0
    begin_extremes(p, y)


def shift_times(p: Drivetrain, mode: np.ndarray, time: float) -> None:
    """Count the times of edges from a later instant [s] on; changes `mode`."""
    for i in range(len(p.numbers)):
        own = own_modes(mode, i)
        own[FIRST_EDGE : FIRST_EDGE + EDGES] -= time
        own[NEXT_TIME] = -inf


def corners_of(cycles: Sequence[tuple[Cycle, CycleTables]]) -> np.ndarray:
    """Find the own angles at which something of each cylinder has a corner, from 0 up to a turn, (n, c) [rad].

    They are its dead centres at 0 and 180 deg, and the corners of its exhaust valves and of its cam or ideal valve.
    """
    rows = []
    for p, tables in cycles:
        angles = [np.array([0.0, pi]), *(window_corners(valve) for valve in p.exhausts)]
        if p.engine.intake == CAM:
            cam = p.engine.cam._replace(lift_curve=tables.cam)
            angles.append(cam_corners(cam, tables.valve.groove[:, 0]))
        elif p.engine.intake == IDEAL_VALVE:
            angles.append(np.array([p.open_target, p.close_target]))
        found = np.sort(np.concatenate(angles) % TURN)
        found = found[found < TURN - MERGED]
        rows.append(found[np.append(True, np.diff(found) > MERGED)])

    # Cylinders with fewer corners have the last one several times, each a little later: passed, it changes nothing.
    most = max(map(len, rows))
    return np.array([np.append(row, row[-1] + 1e-6 * (1.0 + np.arange(most - len(row)))) for row in rows])


def stack_schedules(schedules: Sequence[np.ndarray], count: int) -> np.ndarray:
    """Return the schedules of all cylinders as (n, k, 3): the shorter ones have their last row several times."""
    most = max(map(len, schedules), default=0)
    rows = [np.append(each, np.repeat(each[-1:], most - len(each), axis=0), axis=0) for each in schedules]
    return np.array(rows).reshape(count, most, 3)


def _stacked(arrays: Sequence[np.ndarray]) -> np.ndarray:
    """Arrays of two columns as one, (n, rows, 2), the shorter ones filled up."""
    stacked = np.zeros((len(arrays), max(1, *(len(array) for array in arrays)), 2))
    for i, array in enumerate(arrays):
        stacked[i, : len(array)] = array.reshape(-1, 2)
    return stacked


def _tables(machine: Machine, tables: Sequence[CycleTables], course: Course) -> DrivetrainTables:
    """Arrays of the cylinders, and of what is imposed."""
    kinds = [
        [each.valve.groove for each in tables],
        [each.valve.curves_a.energising for each in tables],
        [each.valve.curves_a.release for each in tables],
        [each.valve.curves_b.energising for each in tables],
        [each.valve.curves_b.release for each in tables],
        [each.cam for each in tables],
    ]
    supply = machine.supply
    supplies = [(-inf, supply.engine_air().pressure, supply.control().pressure)]
    supplies += [supply_row(machine, time, pressure) for time, pressure in course.supplies]
    loads = np.vstack(([(-inf, machine.load.constant)], course.loads))
    rows = np.array([[len(array) for array in arrays] for arrays in kinds]).T
    grooves, *curves, cams = map(_stacked, kinds)
    rows = np.ascontiguousarray(rows)
    return DrivetrainTables(grooves, *curves, cams, rows, course.speeds, loads, np.array(supplies))  # type: ignore[call-arg]


def supply_row(machine: Machine, time: float, pressure: float) -> tuple[float, float, float]:
    """Return the pressures of the supply and of its control air [Pa abs] behind the time [s] from which they hold."""
    return time, pressure, machine.supply._replace(pressure=pressure).control().pressure


def _at_rest(
    p: Drivetrain,
    tables: DrivetrainTables,
    angle: float,
    cycles: Sequence[Cycle],
    cycle_tables: Sequence[CycleTables],
    machine: Machine,
) -> tuple[np.ndarray, np.ndarray]:
    """State vector and modes of a drivetrain at rest."""
    count = len(cycles)
    y, mode = np.zeros(state_size(p)), np.zeros(OWN_MODES * count + SHAFT_MODES)
    first, modes = shaft_states(p), shaft_modes(p)
    y[first + ANGLE] = within_turn(angle)
    mode[modes + SUPPLY], mode[modes + CONTROL] = tables.supplies[0, 1:]
    mode[modes + LOAD] = tables.loads[0, 1]

    # Each cylinder in the volume of its angle; a receiver of its own is empty unless it holds one.
    for i, (cycle, own_tables) in enumerate(zip(cycles, cycle_tables, strict=True)):
        block, own = block_of(y, i), own_modes(mode, i)
        at_rest, cycle_mode = charged_at_rest(cycle)
        block[:] = at_rest[:BLOCK]
        own[:CYCLE_MODES] = cycle_mode
        volume, _ = cylinder_volume(cycle.crank, own_angle(p, y, i))
        gas, ambient = cycle.actuator.gas, cycle.actuator.ambient
        block[CYLINDER : CYLINDER + GAS_ENTRIES] = filled(gas, volume, ambient)
        if i > 0:
            content = filled(gas, machine.inter_receiver.volume, ambient) if p.sources[i] == i else (0.0, 0.0)
            block[RECEIVER : RECEIVER + GAS_ENTRIES] = content
        own[ENERGISE], own[RELEASE] = cycle.start, cycle.start + own_tables.valve.edges_a[1]
        find_corner(p.corners[i], own_angle(p, y, i), own)
        own[FRICTION_PRESSURE] = ambient.pressure
        own[NEXT_TIME], own[EDGE_COUNT] = -inf, 0.0
        y[own_extremes(p, i) + PEAK] = ambient.pressure
        if find_command(own_angle(p, y, i), own):
            issue_edge(p, tables_of(tables, own, i), i, 0.0, own)
    begin_extremes(p, y)

    # The shaft is held unless the gas turns it at once; a speed that is imposed is there from the first instant on.
    mode[modes + ANGLE_REACHED], mode[modes + SPEED_REACHED] = np.isnan(p.goal.angle), np.isnan(p.goal.speed)
    if p.is_imposed:
        y[first + SPEED] = tables.speeds[0, 1]
        mode[modes + DIRECTION] = np.sign(tables.speeds[0, 1] or tables.speeds[1, 1])
    else:
        come_to_rest(p, 0.0, y, mode)
    return y, mode


def accuracy_of(p: Drivetrain, tolerance: float = TRANSIENT_TOLERANCE) -> Accuracy:
    """Compute what the march of a drivetrain holds to: a relative tolerance, its longest step and its scales.

    The error of a step is a mean over all states; those of volumes that are not there have none, and are not to count.
    """
    block = [*VALVE_SCALE, *[GAS_SCALE] * (BLOCK - len(VALVE_SCALE))]
    scale = np.array([*block * len(p.numbers), ANGLE_SCALE, SPEED_SCALE])
    empty = len(p.numbers) * EMPTY_STATES
    return Accuracy(tolerance * sqrt((len(scale) - empty) / len(scale)), LONGEST_STEP, scale)
