"""Strokes with a brake: one or both solenoids switched back for a while, and how the piston lands."""

from collections.abc import Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.march.adaptive import LOG_HEAD, ZERO_CROSSING
from apesim.valve.bench import BenchRun, run_bench
from apesim.valve.measures import NEVER
from apesim.valve.motion import MET_CLOSED, MET_OPEN, NEAR_OPEN, ONE_PERCENT

OPENING, CLOSING = STROKES = ("opening", "closing")
BOTH, ONLY_A, ONLY_B = SOLENOIDS = ("both", "a", "b")
"""Solenoids that a brake switches: both at once, A alone, B alone."""
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
        """Collect all edges of brakes in a run, for a brake of this stroke.

        Parameters
        ----------
        brake : sequence of float
            Its two edges after the command [s]; empty: no brake.

        Returns
        -------
        edges_a, edges_b : tuple of float
            Edges of solenoid A and of solenoid B [s].

        Examples
        --------
        >>> task = Task(Machine(), 50e-3, "closing", ONLY_A)
        >>> edges_a, edges_b = task.edges([8e-3, 12e-3])
        >>> [round(edge, 6) for edge in edges_a], edges_b
        ([0.058, 0.062], ())
        """
        times = tuple(self.command + edge for edge in brake)
        before_a, before_b = self.before
        switched_a, switched_b = self.solenoids != ONLY_B, self.solenoids != ONLY_A
        return before_a + times * switched_a, before_b + times * switched_b

    def run(self, brake: Edges = (), until: float | None = None, sample: float = 1e-4) -> BenchRun:
        """Run the bench with a brake.

        Parameters
        ----------
        brake : sequence of float
            Its two edges after the command [s]; empty: no brake.
        until : float, optional
            End of the run [s]; the end of the closing if left out.
        sample : float
            Time between two rows of the trace [s].

        Returns
        -------
        BenchRun
            March of the bench.

        Examples
        --------
        >>> run = Task(Machine(), 50e-3, "opening").run(until=20e-3)
        >>> run.trace.shape, round(float(run.trace[-1, 0]), 6)  # the valve is open [m]
        ((201, 6), 0.009)
        """
        edges_a, edges_b = self.edges(brake)
        return run_bench(self.machine, self.dwell, until, sample=sample, brakes=edges_a, brakes_b=edges_b)


def _landing_of(log: np.ndarray, stroke: str, command: float, until: float) -> Landing:
    """Judge how a stroke ends, by the log of a bench run from its command edge to the end of its dwell [s].

    The columns 3 and 4 of the log are position and speed, see `apesim.march.adaptive.march`.
    """
    log = log[(log[:, 0] >= command) & (log[:, 0] <= until)]
    time, code, sign, speed = log[:, 0], log[:, 1], log[:, 2], np.abs(log[:, LOG_HEAD + 1])
    near_closed, near_open = ((code == ZERO_CROSSING + crossing) for crossing in (ONE_PERCENT, NEAR_OPEN))
    if stroke == OPENING:
        begins, leaves, met = near_closed & (sign > 0.0), near_open & (sign < 0.0), MET_OPEN
    else:
        begins, leaves, met = near_open & (sign < 0.0), near_closed & (sign > 0.0), MET_CLOSED
    contacts = time[code == met]
    if not len(contacts):
        return Landing()
    hardest = speed[(code == MET_OPEN) | (code == MET_CLOSED)].max()
    stays = not np.any(leaves & (time > contacts[0]))
    return Landing(float(time[begins][0] - command), float(contacts[0] - command), float(hardest), stays)


def land(task: Task, brake: Edges = (), within: float = inf) -> Landing:
    """Run a stroke to the end of its dwell, or no farther than a time after its command.

    Parameters
    ----------
    task : Task
        Stroke to run.
    brake : sequence of float
        Its two edges after the command [s]; empty: no brake.
    within : float
        Longest time after the command that is run [s].

    Returns
    -------
    Landing
        Contact, highest speed at a contact, and whether the piston stays.

    Examples
    --------
    >>> task = Task(Machine(), 50e-3, "closing")
    >>> plain, braked = land(task), land(task, (8.72e-3, 9.46e-3))
    >>> round(plain.speed, 2), braked.speed < 0.1, braked.stays  # [m/s]
    (1.54, True, True)
    """
    until = task.command + min(task.dwell, within)
    run = task.run(brake, until, sample=until)
    return Landing() if run.status else _landing_of(run.log, task.stroke, task.command, until)


def apart_of(task: Task, brake: Edges) -> float:
    """Find the shortest time between two edges of a solenoid that a brake switches.

    Parameters
    ----------
    task : Task
        Stroke with the brake; its command edges count, too.
    brake : sequence of float
        Its two edges after the command [s].

    Returns
    -------
    float
        Time [s].

    Examples
    --------
    >>> round(1e3 * apart_of(Task(Machine(), 50e-3, "closing"), (8.72e-3, 9.46e-3)), 6)  # [ms]
    0.74
    """
    return round(min(brake[0], brake[1] - brake[0], task.dwell - brake[1]), 9)
