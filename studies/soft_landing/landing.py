"""Strokes with a brake: one or both solenoids switched back for a while, and how the piston lands."""

from collections.abc import Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.march.adaptive import LOG_HEAD, LOG_ROWS, NO_CARRY, ZERO_CROSSING, Status, march
from apesim.valve.actuator import STATES, ActuatorTables
from apesim.valve.bench import TRACE, BenchRun, accuracy_of, bench_of, closed_at_start, run_bench
from apesim.valve.measures import NEVER
from apesim.valve.motion import MET_CLOSED, MET_OPEN, NEAR_OPEN, ONE_PERCENT
from apesim.valve.solenoid import breakpoints_of

OPENING, CLOSING = STROKES = ("opening", "closing")
BOTH, ONLY_A, ONLY_B = SOLENOIDS = ("both", "a", "b")
"""Solenoids that a brake switches: both at once, A alone, B alone."""
NO_TRACE = np.empty(0), np.empty((0, len(TRACE))), NO_CARRY
"""Times and rows of a march of which no trace is taken."""
Edges = Sequence[float] | np.ndarray
"""Both edges of a brake after the command [s]; empty: no brake."""


class Landing(NamedTuple):
    """How a stroke ends."""

    delay: float = NEVER
    """Command edge to 1 % of the stroke [s]; NaN: the piston does not move so far."""
    contact: float = NEVER
    """Command edge to first contact with the far stop [s]; NaN: it is not met."""
    speed: float = NEVER
    """Highest speed at any contact, with either stop, from the command to the end of the dwell [m/s]."""
    stays: bool = False
    """Whether the piston keeps within 1 % of the stroke of the far stop from first contact to the end of the dwell."""


class Task(NamedTuple):
    """Stroke that is to land softly."""

    machine: Machine
    """Machine with the valve and its control air."""
    dwell: float
    """Time from each command edge to the next [s]."""
    stroke: str
    """Name of the stroke, one of `STROKES`."""
    solenoids: str = BOTH
    """Solenoids that a brake of this stroke switches, one of `SOLENOIDS`."""
    before: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())
    """Edges of the brake in the opening that goes before a closing, of solenoid A and of B [s]."""

    @property
    def command(self) -> float:
        """Command edge of the stroke [s]."""
        return 0.0 if self.stroke == OPENING else self.dwell

    def edges(self, brake: Edges) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Collect all edges [s] of brakes in a run, of solenoids A and B, for a brake of this stroke.

        `brake` has its two edges after the command [s]; empty: no brake.
        """
        times = tuple(self.command + edge for edge in brake)
        before_a, before_b = self.before
        switched_a, switched_b = self.solenoids != ONLY_B, self.solenoids != ONLY_A
        return before_a + times * switched_a, before_b + times * switched_b

    def run(self, brake: Edges = (), until: float | None = None, sample: float = 1e-4) -> BenchRun:
        """Run the bench with a brake.

        `brake` has its two edges after the command [s]; empty: no brake. The run ends at `until` [s], at the end of the
        closing if left out; the rows of the trace are `sample` [s] apart.
        """
        edges_a, edges_b = self.edges(brake)
        return run_bench(self.machine, self.dwell, until, sample=sample, brakes=edges_a, brakes_b=edges_b)


def _landing_of(log: np.ndarray, stroke: str, command: float, until: float) -> Landing:
    """Judge how a stroke ends, by the log of a bench run from its command edge to the end of its dwell [s].

    The columns 3 and 4 of the log are position and speed, see `apesim.march.adaptive.march`.
    """
    log = log[np.searchsorted(log[:, 0], command) : np.searchsorted(log[:, 0], until, "right")]
    time, code, sign = log[:, 0], log[:, 1], log[:, 2]
    is_open, is_closed = code == MET_OPEN, code == MET_CLOSED
    contacts = time[is_open if stroke == OPENING else is_closed]
    if not len(contacts):
        return Landing()
    near_closed, near_open = code == ZERO_CROSSING + ONE_PERCENT, code == ZERO_CROSSING + NEAR_OPEN
    if stroke == OPENING:
        begins, leaves = near_closed & (sign > 0.0), near_open & (sign < 0.0)
    else:
        begins, leaves = near_open & (sign < 0.0), near_closed & (sign > 0.0)
    hardest = np.abs(log[is_open | is_closed, LOG_HEAD + 1]).max()
    stays = not np.any(time[leaves] > contacts[0])
    return Landing(float(time[begins][0] - command), float(contacts[0] - command), float(hardest), stays)


class Point(NamedTuple):
    """Point of a run that others may start from."""

    time: float
    """Time [s]."""
    y: np.ndarray
    """State of the bench."""
    mode: np.ndarray
    """Modes of the bench."""
    log: np.ndarray
    """Log from the command of the stroke on, see `apesim.march.adaptive.march`."""
    status: int = Status.DONE
    """How the march to it ended."""


class Lander:
    """Bench of a stroke that is run with many brakes: what these have in common is marched once.

    All closings have the same opening, and strokes whose brakes begin at the same time are the same up to then.

    >>> lander = Lander(Task(Machine(), 50e-3, "closing"))
    >>> landings = [lander.land((8.72e-3, release)) for release in (9.46e-3, 9.6e-3)]
    >>> [round(landing.speed, 2) for landing in landings]  # [m/s]
    [0.04, 0.76]
    """

    def __init__(self, task: Task) -> None:
        self.task = task
        edges_a, edges_b = self._edges(())
        self.p, self.tables = bench_of(task.machine, edges_a, edges_b=edges_b)
        self.accuracy, self.rows = accuracy_of(self.p), np.empty((LOG_ROWS, LOG_HEAD + STATES))
        given, kept = (edges_a, edges_b), (self.tables.edges_a, self.tables.edges_b)
        self._keeps_edges = all(map(np.array_equal, given, kept))
        self._known_corners: dict[tuple[int, tuple[float, ...]], set[float]] = {}
        curves = (*self.tables.curves_a, *self.tables.curves_b)
        self._ahead = min(0.0, *(float(curve[0, 0]) for curve in curves))
        rest = Point(0.0, *closed_at_start(self.p), self.rows[:0].copy())
        at_command = _Flight(self, (), rest).march_to(task.command)
        self._begins = {0.0: at_command._replace(log=rest.log)}

    def _edges(self, brake: Edges) -> list[np.ndarray]:
        """Collect all edges of each solenoid [s]."""
        return [np.array(sorted((0.0, self.task.dwell, *own))) for own in self.task.edges(brake)]

    def _tables_for(self, edges: Sequence[np.ndarray]) -> ActuatorTables:
        """Arrays of the valve with other edges [s]; made anew where an effect moves edges."""
        if self._keeps_edges:
            return self.tables._replace(edges_a=edges[0], edges_b=edges[1])
        return bench_of(self.task.machine, edges[0], edges_b=edges[1])[1]

    def _corners(self, tables: ActuatorTables) -> set[float]:
        """Find the times at which the energised fraction of a solenoid has a corner [s]."""
        corners: set[float] = set()
        both = (tables.edges_a, tables.curves_a), (tables.edges_b, tables.curves_b)
        are_alike = tables.curves_a is tables.curves_b
        for number, (edges, curves) in enumerate(both):
            key = number * (not are_alike), tuple(edges.tolist())
            if key not in self._known_corners:
                self._known_corners[key] = set(breakpoints_of(edges, inf, curves, 0.0, 2.0 * self.task.dwell).tolist())
            corners |= self._known_corners[key]
        return corners

    def fly(self, brake: Edges = ()) -> "_Flight":
        """Begin a run with a brake, where it first acts; without one at the command of the stroke.

        `brake` has its two edges after the command [s]; empty: no brake. The flight returned is to be marched on.
        """
        begin = max(0.0, min(brake[0], self.task.dwell) + self._ahead) if len(brake) else 0.0
        if begin not in self._begins:
            flight = _Flight(self, (), self._begins[0.0])
            self._begins[begin] = flight.march_to(self.task.command + begin)
        return _Flight(self, brake, self._begins[begin])

    def land(self, brake: Edges = (), within: float = inf) -> Landing:
        """Run the stroke to the end of its dwell, or no farther than `within` [s] after its command.

        `brake` has the brake's two edges after the command [s]; empty: no brake.
        """
        until = min(self.task.dwell, within)
        acts = len(brake) and brake[0] + self._ahead < until
        return self.fly(brake if acts else ()).land(until)


class _Flight:
    """Run of a stroke from the point `at` with a brake, which goes on as far as it is asked to.

    `brake` has its two edges after the command [s]; empty: no brake.
    """

    def __init__(self, lander: Lander, brake: Edges, at: Point) -> None:
        self.lander, self.at = lander, at
        self.tables = lander._tables_for(lander._edges(brake))
        self.corners = sorted(lander._corners(self.tables))

    def march_to(self, end: float) -> Point:
        """March on to a time [s], and return the point that was come to."""
        lander, (time, y, mode, log, status) = self.lander, self.at
        if status == Status.DONE and end > time:
            y, mode = y.copy(), mode.copy()
            breakpoints = np.array([*[corner for corner in self.corners if time < corner < end], end])
            outcome = march(lander.p, self.tables, time, y, mode, breakpoints, lander.accuracy, lander.rows, *NO_TRACE)
            log = np.concatenate((log, lander.rows[: outcome.logged]))
            self.at = Point(end, y, mode, log, outcome.status)
        return self.at

    def land(self, until: float) -> Landing:
        """March on to a time after the command [s], and judge how the stroke has ended by then."""
        task = self.lander.task
        end = task.command + until
        at = self.march_to(end)
        return _landing_of(at.log, task.stroke, task.command, end) if at.status == Status.DONE else Landing()


def land(task: Task, brake: Edges = (), within: float = inf) -> Landing:
    """Run a stroke to the end of its dwell, or no farther than `within` [s] after its command.

    `brake` has the brake's two edges after the command [s]; empty: no brake.

    >>> task = Task(Machine(), 50e-3, "closing")
    >>> plain, braked = land(task), land(task, (8.72e-3, 9.46e-3))
    >>> round(plain.speed, 2), braked.speed < 0.1, braked.stays  # [m/s]
    (1.54, True, True)
    """
    return Lander(task).land(brake, within)


def apart_of(task: Task, brake: Edges) -> float:
    """Find the shortest time [s] between two edges of a solenoid that a brake switches.

    The command edges of the stroke count, too; `brake` has its two edges after the command [s].
    """
    return round(min(brake[0], brake[1] - brake[0], task.dwell - brake[1]), 9)
