"""Strokes with a brake: one or both solenoids switched back for a while, and how the piston lands."""

from math import inf
from typing import NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.march.adaptive import LOG_HEAD, ZERO_CROSSING
from apesim.valve.bench import run_bench
from apesim.valve.measures import NEVER
from apesim.valve.motion import MET_CLOSED, MET_OPEN, NEAR_OPEN, ONE_PERCENT

OPENING, CLOSING = STROKES = ("opening", "closing")
BOTH, ONLY_A, ONLY_B = SOLENOIDS = ("both", "a", "b")
"""Which solenoids a brake switches: both at once, A alone, B alone."""


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
    """A stroke that is to land softly."""

    machine: Machine
    dwell: float
    """From each command edge to the next [s]."""
    stroke: str
    """One of `STROKES`."""
    solenoids: str = BOTH
    """Those that a brake of this stroke switches, one of `SOLENOIDS`."""
    before: tuple = ((), ())
    """Edges of the brake in the opening that goes before a closing, of solenoid A and of B [s]."""

    @property
    def command(self):
        """The command edge of the stroke [s]."""
        return 0.0 if self.stroke == OPENING else self.dwell

    def edges(self, brake):
        """All edges of brakes in a run, of solenoid A and of B, for a brake of this stroke; pair of tuples [s]."""
        own = tuple(self.command + edge for edge in brake)
        before_a, before_b = self.before
        switched_a, switched_b = self.solenoids != ONLY_B, self.solenoids != ONLY_A
        return before_a + own * switched_a, before_b + own * switched_b

    def run(self, brake=(), until=None, sample=1e-4):
        """Run the bench with a brake, to the end of the closing unless told otherwise, as a `BenchRun`."""
        edges_a, edges_b = self.edges(brake)
        return run_bench(self.machine, self.dwell, until, sample=sample, brakes=edges_a, brakes_b=edges_b)


def landing_of(log, stroke, command, until):
    """How a stroke ends.

    Parameters
    ----------
    log : (l, 3 + n) float array
        Of a bench run, see `apesim.march.adaptive.march`; columns 3 and 4 are position and speed.
    stroke : str
        One of `STROKES`.
    command, until : float
        Its command edge, and the end of its dwell [s].

    Returns
    -------
    Landing
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


def land(task, brake=(), within=inf):
    """Run a stroke to the end of its dwell, or no farther than a time after its command.

    Parameters
    ----------
    task : Task
    brake : sequence of float
        Its two edges, after the command; none: no brake [s].
    within : float
        [s]

    Returns
    -------
    Landing
    """
    until = task.command + min(task.dwell, within)
    run = task.run(brake, until, sample=until)
    return Landing() if run.status else landing_of(run.log, task.stroke, task.command, until)


def apart_of(task, brake):
    """Shortest time between two edges of a solenoid that a brake switches [s]."""
    return round(min(brake[0], brake[1] - brake[0], task.dwell - brake[1]), 9)
