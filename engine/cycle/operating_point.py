"""Operating point: a machine at a speed, as the march takes it, with the ends of its smooth segments and a start."""

from math import isinf, sqrt

import numpy as np

from apesim.effect import adjusted, chosen, kind_of_march, library_for, volume_of
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cam import cam_corners, window_corners
from apesim.engine.cycle.state import (
    MODES,
    SCALE,
    SIZE,
    Cycle,
    CycleTables,
    has_pipe,
    update_states,
)
from apesim.engine.cylinder import CAM, EPV
from apesim.engine.effects import ENGINE_LIBRARY, library_of
from apesim.engine.exergy import RATES
from apesim.engine.kinematics import crank_of, cylinder_volume, swept_volume
from apesim.engine.machine import Machine
from apesim.march.adaptive import TOLERANCE, Accuracy
from apesim.valve.actuator import GAS_SCALE, PHASE, actuator_of, closed_at_rest
from apesim.valve.chamber import filled
from apesim.valve.line import has_line
from apesim.valve.piston import HELD_CLOSED
from apesim.valve.supply import RECEIVER

MAX_TURN = 2.0 * DEGREE
"""Longest step [rad]; chosen. While our valve moves, `apesim.valve.actuator.MAX_STEP` is the longest, if it is less."""
EXERGY_SCALE = 0.01
"""Scale of the exergy ledger's terms, as a share of what the supply's pressure would do over the swept volume."""
NOT_HELD = 1e300
"""Scale of what an accuracy is not to hold; not infinite, as an implicit step divides by it."""


def cycle_of(machine: Machine, speed: float) -> tuple[Cycle, CycleTables, np.ndarray]:
    """Compute what the kernels need to know of a machine, its effects included, at a speed [rad/s], above 0.

    The last array (n,) has the times at which a smooth segment ends, from the start of the cycle at the energising; the
    last of them is the period [s].
    """
    engine, command = machine.engine, machine.command
    period = TURN / speed
    edges = [0.0, (command.release - command.energise) / speed]

    # One kind of march for valve and engine together: a kind for each would mean many more marches to compile.
    library = library_for(machine.effects, ENGINE_LIBRARY, "engine")
    kind = kind_of_march(library_of(machine.effects), machine.effects)
    actuator, valve_tables = actuator_of(machine, edges, period, kind=kind)

    # What the kernels know: numbers in `p`, arrays in the tables. A volume of 0 stands for an infinite receiver.
    tables = CycleTables(valve_tables, np.ascontiguousarray(engine.cam.lift_curve))
    infinite = isinf(engine.receiver.volume)
    cam = engine.cam.resolve_lift(machine.valve.stroke)._replace(lift_curve=None)  # type: ignore[arg-type]
    p = Cycle(
        actuator,
        machine.supply.engine_air(),
        machine.supply.control(),
        int(machine.supply.control_air == RECEIVER),
        0.0 if infinite else engine.receiver.volume,
        engine._replace(cam=cam, phases=None),  # type: ignore[arg-type]
        engine.exhausts,
        crank_of(engine),
        speed,
        command.energise,
        command.open_target,
        command.close_target,
        float(np.interp(actuator.valve.stroke, valve_tables.groove[:, 0], valve_tables.groove[:, 1])),
        machine.groove.lap,
        int(machine.groove.has_ports),
        machine.groove.ports,
        int(len(engine.cam.lift_curve) > 0),
        actuator.ambient.pressure,
        volume_of(library.effects, machine.effects),
        chosen(library, machine.effects, kind),
    )

    # Effects change the machine when it is whole, and breakpoints are those of what they leave.
    p, tables = adjusted(library.effects, machine.effects, p, tables)
    p = p._replace(exhausts=p.engine.exhausts)  # those that the effects leave
    return p, tables, breakpoints_of_cycle(p, tables, period)


def breakpoints_of_cycle(p: Cycle, tables: CycleTables, period: float) -> np.ndarray:
    """Find the times (n,) [s] from the start of a cycle at which a smooth segment ends; the last is `period` [s]."""
    angles, starts = [window_corners(valve) for valve in p.exhausts], [np.array([period])]
    if p.engine.intake == EPV:
        starts.append(tables.valve.breakpoints(0.0, period))
    elif p.engine.intake == CAM:
        angles.append(cam_corners(p.engine.cam._replace(lift_curve=tables.cam), tables.valve.groove[:, 0]))
    else:
        angles.append(np.array([p.open_target, p.close_target]))
    starts.append((np.concatenate(angles) - p.start) % TURN / p.speed)
    times = np.unique(np.concatenate(starts))
    is_new = np.append(np.diff(times) > 1e-12 * period, True)
    return times[is_new & (times > 1e-12 * period)]


def accuracy_at(p: Cycle, tolerance: float = TOLERANCE) -> Accuracy:
    """Compute what the march of an engine holds to; its supply line and intake pipe are states where it has them.

    This is the relative `tolerance` of a step, the longest step and the scales of the states.
    """
    more = 4 if has_pipe(p) else 2 if has_line(p.actuator) else 0
    return Accuracy(tolerance, MAX_TURN / p.speed, np.array(SCALE + more * (GAS_SCALE,)))


def with_exergy(p: Cycle, accuracy: Accuracy) -> Accuracy:
    """Extend an accuracy so that the march holds the exergy ledger to it, too, in a state vector (SIZE + RATES,).

    The states alone do not show how well the ledger is integrated: where a flow is choked, mass and energy are lines in
    time and a step may be long, while the entropy of the air bends.
    """
    energy = EXERGY_SCALE * max(p.supply.pressure, p.actuator.ambient.pressure) * swept_volume(p.engine)
    others = np.full(SIZE - len(accuracy.scale), NOT_HELD)
    scale = np.concatenate((accuracy.scale, others, np.full(RATES, energy)))
    # The error of a step is a mean over all elements: the states are to count in it as they do without the ledger.
    return accuracy._replace(tolerance=accuracy.tolerance * sqrt(len(accuracy.scale) / len(scale)), scale=scale)


def charged_at_rest(p: Cycle) -> tuple[np.ndarray, np.ndarray]:
    """State vector (SIZE,) and modes (MODES,) of an engine at rest.

    The valve is closed; receiver, line and pipe are at supply pressure, the cylinder is at ambient pressure.
    """
    y, mode = np.zeros(SIZE), np.zeros(MODES)
    gas, ambient = p.actuator.gas, p.actuator.ambient
    control = p.supply if p.control_from_receiver else p.control
    volume, _ = cylinder_volume(p.crank, p.start)
    update_states(
        y,
        closed_at_rest(p.actuator, control),
        (
            filled(gas, volume, ambient),
            filled(gas, p.receiver_volume, p.supply),
            filled(gas, p.actuator.line.volume, control),
            filled(gas, p.pipe.volume, p.supply),
        ),
    )
    mode[PHASE] = HELD_CLOSED
    return y, mode
