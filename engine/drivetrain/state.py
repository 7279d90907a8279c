"""State vector of a drivetrain: the blocks of its cylinders, its shaft, and ledgers behind them.

A block is the state vector of one cylinder without ledgers, as `apesim.engine.cycle.state` has it. The receiver that
several cylinders draw from stands in the block of the first of them; those of the others are empty there.
"""

from typing import NamedTuple

import numpy as np

from apesim.air import GasState
from apesim.engine.cycle.state import LEDGER, SIZE, Cycle, CycleTables, Instant, receiver_gas
from apesim.engine.cycle.state import MODES as CYCLE_MODES
from apesim.engine.shaft import Load, Shaft
from apesim.kernel import kernel
from apesim.packed import unpacked
from apesim.valve.actuator import ActuatorTables
from apesim.valve.chamber import chamber_state
from apesim.valve.edges import EDGES
from apesim.valve.solenoid import SolenoidCurves
from apesim.views import part_of

BLOCK = LEDGER
"""States of a cylinder: of its valve and of the gas in all its volumes."""
OWN_LEDGER = SIZE - LEDGER
"""Entries of a cylinder's ledgers, as in a cycle's state vector."""
ANGLE, SPEED, SHAFT_STATES = range(3)
"""States of the shaft behind the blocks: its angle in its revolution [rad], its speed [rad/s]; how many there are."""
GAS_WORK, FRICTION_WORK, LOAD_WORK, EXCHANGED_HEAT, WALL_HEAT, SHAFT_LEDGER = range(6)
"""Ledger of the shaft, behind those of the cylinders: work of the gas above ambient pressure, of friction and of the
load [J], heat from the exchanger and from the wall of the inter-receiver [J]; how many entries there are."""
MIN_SPEED, MAX_SPEED, MIN_TORQUE, MAX_TORQUE, SHAFT_EXTREMES = range(5)
"""Extremes since the last end of a revolution, behind that: speed [rad/s] and gas torque [N m] of the shaft; how many
there are."""
PEAK, MAX_PRESSURE, MIN_RECEIVER, MAX_RECEIVER, OWN_EXTREMES = range(5)
"""Extremes of each cylinder, behind those: pressure since its last passage of its own angle 0, and since the last end
of a revolution, pressure of the receiver in its block since then [Pa abs]; how many there are."""

(
    COMMANDED,
    ENERGISE,
    RELEASE,
    COMMAND_LOW,
    COMMAND_HIGH,
    CORNER,
    CORNER_LOW,
    CORNER_HIGH,
    FRICTION_PRESSURE,
    NEXT_TIME,
    EDGE_NUMBER,
    EDGE_COUNT,
    FIRST_EDGE,
) = range(CYCLE_MODES, CYCLE_MODES + 13)
"""Modes of a cylinder behind those of a cycle: whether its solenoids are energised; its command angles [rad]; the own
angles between which the command stays [rad]; the corner passed last and the angles to the next ones [rad]; the pressure
that its friction follows [Pa abs]; when its solenoids have their next corner [s]; edges so far, edges remembered, and
their times [s]."""
OWN_MODES = FIRST_EDGE + EDGES
"""Modes of a cylinder."""
(
    DIRECTION,
    ACCELERATION,
    LOAD,
    SUPPLY,
    CONTROL,
    TURNS,
    HELD_SINCE,
    ANGLE_REACHED,
    SPEED_REACHED,
    SHAFT_MODES,
) = range(10)
"""Modes of the shaft, behind those of the cylinders: direction in which it turns, 0 held; slope of an imposed speed
[rad/s2]; constant part of the load [N m]; pressures of supply and regulated control air [Pa abs]; whole turns; since
when it is held [s]; whether the angle and the speed that were waited for have been reached; how many there are."""
MARGIN = 1e-8
"""How far the crank has to pass a corner before it counts, and to come back [rad]; chosen: far above the error of a
step that is made again up to an event, far below what an angle is read to."""


class Exchanger(NamedTuple):
    """Heat exchanger before the inter-receiver, and the wall of that."""

    effectiveness: float
    """Share of the way to its temperature, of what flows forward."""
    temperature: float
    """Temperature of exchanger and wall [K]."""
    wall_conductance: float
    """Conductance of the wall to the air [W/K]."""


class Goal(NamedTuple):
    """What a march waits for."""

    angle: float
    """Angle of the shaft from its start, NaN: none [rad]."""
    speed: float
    """Speed to be reached from below, NaN: none [rad/s]."""
    max_rest: float
    """How long the shaft may be held before the march ends [s]; inf: for ever."""
    ends_with_revolution: int = 0
    """1: the march ends where the shaft's revolution does, too."""


class Drivetrain(NamedTuple):
    """Cylinders on one shaft, as numbers for the kernels."""

    template: Cycle
    """First cylinder: its types, and what all cylinders share."""
    numbers: np.ndarray
    """Each cylinder as a row of numbers, (n, m), see `apesim.packed`."""
    phases: np.ndarray
    """Angle of the shaft at angle 0 of each cylinder [rad], (n,)."""
    sources: np.ndarray
    """Block whose receiver each cylinder draws from, (n,)."""
    sinks: np.ndarray
    """Block whose receiver each cylinder exhausts to, (n,); -1: to the atmosphere."""
    shaft: Shaft
    """Inertia and breakaway."""
    load: Load
    """Kind of load and its coefficients; its table is apart."""
    load_table: np.ndarray
    """Torque of the load over speed: [rad/s] and [N m], (j, 2)."""
    is_imposed: int
    """1: the speed is imposed, 0: it follows from the torques."""
    corners: np.ndarray
    """Own angles at which something of a cylinder has a corner, ascending from 0 [rad], (n, c)."""
    read_corners: np.ndarray
    """Which of them is 180 deg, where each cylinder reads its schedule, (n,); -1: there is no schedule."""
    schedules: np.ndarray
    """Command angles of each cylinder over speed: [rad/s], energise and release [rad], (n, k, 3)."""
    deviations: np.ndarray
    """What is added to the dead time of the edges of each cylinder's command, in turn [s], (n, e)."""
    exchanger: Exchanger
    """Heat exchanger before the inter-receiver."""
    goal: Goal
    """What the march waits for."""
    is_followed: int
    """1: a march that notes follows zero crossings and the power, too."""


class DrivetrainTables(NamedTuple):
    """Arrays of a drivetrain: of each cylinder as (n, rows, 2), with the number of rows that count."""

    grooves: np.ndarray
    """Effective area of the groove over lift."""
    energising_a: np.ndarray
    """How solenoid A follows an edge that energises."""
    release_a: np.ndarray
    """How it follows one that releases."""
    energising_b: np.ndarray
    """How solenoid B follows an edge that energises."""
    release_b: np.ndarray
    """How it follows one that releases."""
    cams: np.ndarray
    """Lift curve of the cam."""
    rows: np.ndarray
    """Rows of these six, (n, 6)."""
    speeds: np.ndarray
    """Imposed speed over time: [s] and [rad/s], (j, 2)."""
    loads: np.ndarray
    """Constant part of the load from an instant on: [s] and [N m], (j, 2)."""
    supplies: np.ndarray
    """Pressures from an instant on: [s], of the supply and of regulated control air [Pa abs], (j, 3)."""


@kernel
def cylinders_of(p: Drivetrain) -> int:
    """Return how many cylinders a drivetrain has."""
    return p.numbers.shape[0]


@kernel
def shaft_states(p: Drivetrain) -> int:
    """Element of the state vector at which the states of the shaft begin."""
    return BLOCK * cylinders_of(p)


@kernel
def shaft_ledger(p: Drivetrain) -> int:
    """Element of the state vector at which the ledger of the shaft begins, behind those of the cylinders."""
    return shaft_states(p) + SHAFT_STATES + OWN_LEDGER * cylinders_of(p)


@kernel
def shaft_extremes(p: Drivetrain) -> int:
    """Element of the state vector at which the extremes of the shaft begin."""
    return shaft_ledger(p) + SHAFT_LEDGER


@kernel
def own_extremes(p: Drivetrain, i: int) -> int:
    """Element of the state vector at which the extremes of a cylinder begin."""
    return shaft_extremes(p) + SHAFT_EXTREMES + OWN_EXTREMES * i


@kernel
def state_size(p: Drivetrain) -> int:
    """Length of the state vector."""
    return own_extremes(p, cylinders_of(p))


@kernel
def shaft_modes(p: Drivetrain) -> int:
    """Element of the modes at which those of the shaft begin."""
    return OWN_MODES * cylinders_of(p)


@kernel
def ledger_place(p: Drivetrain, i: int) -> int:
    """Element from which a view has a cylinder's ledgers where a cycle's state vector has them, see `ledger_at`."""
    return shaft_states(p) + SHAFT_STATES + OWN_LEDGER * i - LEDGER


block_of = part_of(BLOCK, BLOCK)
"""Function from a state vector, or its rates, and a number to the states of that cylinder (BLOCK,), a view."""
own_modes = part_of(OWN_MODES, OWN_MODES)
"""Function from the modes and a number to the modes of that cylinder (OWN_MODES,), a view."""
ledger_at = part_of(SIZE, 1)
"""Function from a state vector, or its rates, and `ledger_place` to a view (SIZE,) with the ledgers of a cylinder."""


@kernel
def cylinder_of(p: Drivetrain, y: np.ndarray, mode: np.ndarray, i: int) -> Cycle:
    """Return a cylinder as the laws take it, at the speed of the shaft and with the supply of the moment."""
    c: Cycle = unpacked(p.template, p.numbers, i)
    first, speed = shaft_modes(p), y[shaft_states(p) + SPEED]
    return Cycle(
        c.actuator,
        GasState(mode[first + SUPPLY], c.supply.temperature),
        GasState(mode[first + CONTROL], c.control.temperature),
        c.control_from_receiver,
        c.receiver_volume,
        c.engine,
        c.exhausts,
        c.crank,
        speed,
        c.start,
        c.open_target,
        c.close_target,
        c.full_area,
        c.lap,
        c.has_ports,
        c.ports,
        c.has_lift_curve,
        c.exhaust_pressure,
        c.pipe,
        c.effects,
    )


@kernel
def own_angle(p: Drivetrain, y: np.ndarray, i: int) -> float:
    """Crank angle of a cylinder [rad], within a turn of that of the shaft in its revolution."""
    return y[shaft_states(p) + ANGLE] - p.phases[i]


@kernel
def receiver_in(p: Drivetrain, y: np.ndarray, mode: np.ndarray, i: int) -> GasState:
    """State of the air in the receiver of a block; that of the supply where it is infinite."""
    holder: Cycle = unpacked(p.template, p.numbers, i)
    if holder.receiver_volume > 0.0:
        return chamber_state(holder.actuator.gas, receiver_gas(block_of(y, i)), holder.receiver_volume)
    return GasState(mode[shaft_modes(p) + SUPPLY], holder.supply.temperature)


@kernel
def surroundings_of(p: Drivetrain, c: Cycle, y: np.ndarray, mode: np.ndarray, i: int) -> Instant:
    """What the laws of a cylinder `c`, number `i`, see around it."""
    behind = GasState(c.exhaust_pressure, c.actuator.ambient.temperature)
    if p.sinks[i] >= 0:
        behind = receiver_in(p, y, mode, p.sinks[i])
    return Instant(own_angle(p, y, i), receiver_in(p, y, mode, p.sources[i]), behind)


@kernel
def tables_of(tables: DrivetrainTables, mode: np.ndarray, i: int) -> CycleTables:
    """Return the arrays of a cylinder as its laws take them, with the edges that its modes (OWN_MODES,) remember."""
    rows = tables.rows[i]
    edges = mode[FIRST_EDGE : FIRST_EDGE + int(mode[EDGE_COUNT])]
    curves_a = SolenoidCurves(tables.energising_a[i, : rows[1]], tables.release_a[i, : rows[2]])
    curves_b = SolenoidCurves(tables.energising_b[i, : rows[3]], tables.release_b[i, : rows[4]])
    valve = ActuatorTables(edges, edges, np.inf, curves_a, curves_b, tables.grooves[i, : rows[0]])
    return CycleTables(valve, tables.cams[i, : rows[5]])
