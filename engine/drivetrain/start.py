"""Starts from rest: whether the engine starts from an angle, and from which angles it does."""

from collections.abc import Callable, Iterable
from math import ceil, nan
from typing import NamedTuple

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.drivetrain.preparing import NO_COURSE, Course, Goal, prepare
from apesim.engine.drivetrain.run import DrivetrainRun, EventKind, run_drivetrain
from apesim.engine.machine import Machine

STARTED = 3.0 * TURN
"""Angle after which an engine has started [rad]: three turns, in which each cylinder has passed all that it does."""
MAX_REST = 0.25
"""Time for which a crank is held that will not start [s]: far longer than a valve and a ramp take."""
MAX_TIME = 60.0
"""Time after which a start is given up [s]."""
SCAN = 2.0 * DEGREE
"""Angle between the starts that are tried first [rad]; intervals that are narrower may be missed."""
NEAR_EDGE = 0.02 * DEGREE
"""Distance from the ends of a command at which starts are tried, too [rad]."""
LOCATED = 1e-4 * DEGREE
"""Error to which the end of an interval is located [rad]."""


class Start(NamedTuple):
    """One start from rest."""

    starts: bool
    """Whether the shaft came three turns forwards."""
    is_target_met: bool
    """Whether it reached the speed that was asked for; True where none was."""
    time: float
    """When that was, or else when three turns were done; NaN: never [s]."""
    turns: float
    """Turns until then."""
    engine_air: float
    """Air through the grooves until then [kg]."""
    control_air: float
    """Control air until then [kg]."""
    run: DrivetrainRun
    """The march."""


def run_start(
    machine: Machine,
    angle: float,
    target: float = nan,
    course: Course = NO_COURSE,
    times: np.ndarray | None = None,
) -> Start:
    """March a start from rest at an angle of the shaft [rad], until it has turned thrice and reached a speed [rad/s].

    It ends without that where the crank is held for `MAX_REST`, or after `MAX_TIME`.
    """
    first = angle % TURN
    prepared = prepare(machine, first, course, Goal(first + STARTED, target, MAX_REST))
    run = run_drivetrain(prepared, MAX_TIME, times)
    found = {event.kind: event for event in reversed(run.events)}
    turned, fast = found.get(EventKind.ANGLE_REACHED), found.get(EventKind.SPEED_REACHED)
    told = turned if np.isnan(target) else fast
    if told is None:
        return Start(turned is not None, bool(np.isnan(target)), nan, nan, nan, nan, run)
    turns = (told.angle - first) / TURN
    return Start(turned is not None, True, told.time, turns, told.engine_air, told.control_air, run)


def find_intervals(
    machine: Machine,
    course: Course = NO_COURSE,
    run_all: Callable[[list[float]], Iterable[bool]] | None = None,
) -> list[tuple[float, float]]:
    """Find the intervals of the shaft's angle from which an engine starts, ends located to `LOCATED` [rad].

    They are ascending; the upper end of one that passes zero is above a turn. (0, turn) alone: from every angle.
    `run_all` says of a list of angles whether the engine starts from each; by default one is tried after the other.
    """
    run_all = run_all or (lambda angles: [run_start(machine, angle, course=course).starts for angle in angles])

    # Cylinders that are alike and evenly spread repeat themselves.
    engine, period = machine.engine, TURN
    if not (len(engine.phases) or any(machine.cylinder) or machine.stage_2.is_on):
        period = TURN / engine.cylinders
    angles = np.append(np.arange(ceil(period / SCAN - 1e-9)) * SCAN, _near_edges(machine, period))
    angles = np.unique(angles[angles < period])
    starts = np.array(list(run_all(angles.tolist())), dtype=bool)
    if starts.all() or not starts.any():
        return [(0.0, TURN)] if starts.all() else []

    # Where two neighbours differ there is an end: all of them are halved at once.
    others = np.roll(starts, -1)
    at = np.flatnonzero(starts != others)
    low, high = angles[at], np.append(angles, angles[0] + period)[at + 1]
    rises = ~starts[at]
    while (high - low).max() > LOCATED:
        middle = 0.5 * (low + high)
        is_in = np.array(list(run_all(middle.tolist())), dtype=bool)
        moves_low = is_in != rises
        low, high = np.where(moves_low, middle, low), np.where(moves_low, high, middle)
    ends = 0.5 * (low + high)

    # From each rise to the fall behind it, over all repetitions.
    intervals = []
    for begin in ends[rises]:
        falls = np.append(ends[~rises], ends[~rises] + period)
        end = falls[falls > begin].min()
        intervals += [(begin + k * period, end + k * period) for k in range(round(TURN / period))]
    return sorted((float(begin % TURN), float(begin % TURN + end - begin)) for begin, end in intervals)


def _near_edges(machine: Machine, period: float) -> np.ndarray:
    """Angles on both sides of the ends of each cylinder's command, and just behind its dead centre [rad]."""
    phases = [0.0, machine.stage_2.phase] if machine.stage_2.is_on else machine.engine.resolve_phases()
    ends = [machine.command.energise, machine.command.release, 0.0]
    places = [phase + end for phase in phases for end in ends]
    return np.array([(place + side * NEAR_EDGE) % TURN % period for place in places for side in (-1.0, 1.0)])
