"""Brakes: both solenoids switched back for a while in mid-stroke, so that the piston lands softly.

Two numbers make a brake, when it begins and when it is released. The landscape over them has cliffs, where the piston
turns back or falls off its stop again. So all brakes of a grid are run on the bench, then those around the best ones on
ever finer grids: a scan sees a cliff, where a descent would end on it.
"""

from math import ceil, inf
from typing import NamedTuple

import numpy as np

from apesim.march import LOG_HEAD, WATCH
from valve.bench import run_bench
from valve.measures import NEVER
from valve.motion import MET_CLOSED, MET_OPEN, NEAR_OPEN, ONE_PERCENT
from valve.solenoid import opening_curve

OPENING, CLOSING = STROKES = ("opening", "closing")
RESOLUTION = 0.01e-3
"""Of the edges [s]."""
COARSE = 32
"""Step of the first grid, in units of the resolution; a power of two."""
ADDED_LEAST = 3e-3
"""Added time up to which brakes are sought, at least [s]."""
FRONT_STEP = 0.05e-3
"""The front is refined at one brake for each such step of added time [s]."""
SPACINGS = np.arange(1, 19) * 0.25e-3
"""Times between edges, for each of which the best brake is sought [s]."""
SOFT = 0.5
"""A landing at this share of the unbraked seating speed, a quarter of its energy, counts as soft."""
BRAKE, RELEASE, ADDED, SPEED, APART = range(5)
"""Columns of brakes: its two edges after the command [s], time added to the stroke [s], seating speed [m/s], shortest
time between two edges [s]."""


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

    machine: object
    """`engine.machine.Machine`"""
    dwell: float
    """From each command edge to the next [s]."""
    stroke: str
    """One of `STROKES`."""
    before: tuple = ()
    """Edges of the brake in the opening that goes before a closing [s]."""

    @property
    def command(self):
        """The command edge of the stroke [s]."""
        return 0.0 if self.stroke == OPENING else self.dwell

    def edges(self, brake):
        """All edges of brakes in a run, for a brake of this stroke [s]."""
        return (*self.before, *(self.command + edge for edge in brake))


def landing_of(log, stroke, command, until):
    """How a stroke ends.

    Parameters
    ----------
    log : (l, 3 + n) float array
        Of a bench run, see `apesim.march.march`; columns 3 and 4 are position and speed.
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
    near_closed, near_open = ((code == WATCH + watch) for watch in (ONE_PERCENT, NEAR_OPEN))
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
    run = run_bench(task.machine, task.dwell, until, sample=until, brakes=task.edges(brake))
    return Landing() if run.status else landing_of(run.log, task.stroke, task.command, until)


def front_of(brakes, apart=0.0, added_most=inf):
    """The brakes that no other beats in both added time and seating speed.

    Parameters
    ----------
    brakes : (n, 5) float array
        See `BRAKE`.
    apart : float
        Least time between two edges [s].
    added_most : float
        [s]

    Returns
    -------
    (m, 5) float array
        Added time ascending, seating speed falling; the softest is the last.
    """
    allowed = brakes[(brakes[:, APART] >= apart) & (brakes[:, ADDED] <= added_most)]
    allowed = allowed[np.lexsort((allowed[:, SPEED], allowed[:, ADDED]))]
    lowest = np.minimum.accumulate(np.append(inf, allowed[:, SPEED]))
    return allowed[allowed[:, SPEED] < lowest[:-1]]


def widest_soft(brakes, unbraked, cost):
    """The brake whose edges are farthest apart of those that land softly (see `SOFT`) at a cost; shape (0 or 1, 5)."""
    soft = brakes[(brakes[:, ADDED] <= cost) & (brakes[:, SPEED] <= SOFT * unbraked.speed)]
    return soft[np.argsort(soft[:, APART])[-1:]]


def search(task, unbraked, spacing, cost):
    """Brakes that complete the stroke and lower its seating speed.

    Parameters
    ----------
    task : Task
    unbraked : Landing
        Of the same task.
    spacing : float
        Between two edges of a solenoid, at least; brakes with closer edges are found too [s].
    cost : float
        Added time allowed [s].

    Returns
    -------
    (n, 5) float array
        See `BRAKE`; of each front all that were met, refined for the given spacing, for none and for `SPACINGS`.
    """
    most = max(ADDED_LEAST, cost)
    points, tried, found = first_grid(task, unbraked, spacing, most), set(), []
    unit, brakes = COARSE, np.empty((0, 5))
    while points:
        found += [row for point in sorted(points) if (row := attempt(task, unbraked, most, point))]
        tried |= points
        brakes = np.array(found).reshape(-1, 5)
        softest = [front_of(brakes, apart, cost)[-1:] for apart in (spacing, 0.0)]
        if unit > 1:
            unit //= 2
            moves = (-unit, 0, unit)
            fronts = [_thinned(front_of(brakes, apart, most)) for apart in (spacing, 0.0)]
            spaced = [front_of(brakes, apart, cost)[-1:] for apart in SPACINGS]
            rows = np.concatenate((*softest, *fronts, *spaced, widest_soft(brakes, unbraked, cost)))
        else:  # until all around the softest have been tried
            rows, moves = np.concatenate(softest), (-2, -1, 0, 1, 2)
        centres = np.round(rows[:, (BRAKE, RELEASE)] / RESOLUTION).astype(int).tolist()
        points = {(i + a, j + b) for i, j in centres for a in moves for b in moves} - tried
    return brakes


def first_grid(task, unbraked, spacing, most):
    """Edges to begin with, in units of the resolution.

    A brake that has fully acted before the motion only delays it, and one that acts after contact lowers nothing. If
    the stroke is completed after the release, a late one costs too much; if before, an earlier one is better.
    """
    followed = opening_curve(task.machine.valve.solenoid)[:, 0]
    dead = followed[0]
    earliest = max(unbraked.delay - followed[-1], 0.0) / RESOLUTION
    latest, end = ((unbraked.contact + added - dead) / RESOLUTION for added in (0.0, most))
    least, *spacings = (ceil(apart / RESOLUTION - 1e-9) for apart in (spacing, *SPACINGS))
    starts = {*range(COARSE * (int(earliest) // COARSE + 1), int(latest) + 1, COARSE), least}
    lengths = {*range(COARSE, int(end), COARSE), *spacings, least}
    return {
        (start, start + length)
        for start in starts
        for length in lengths
        if start <= latest and length <= max(end - start, least)
    }


def attempt(task, unbraked, most, point):
    """Run a brake.

    Parameters
    ----------
    task : Task
    unbraked : Landing
        Of the same task.
    most : float
        Added time allowed [s].
    point : pair of int
        Its edges, in units of the resolution.

    Returns
    -------
    tuple of float or None
        A row of brakes, see `BRAKE`; None: the stroke is not completed in time, or not softer than unbraked.
    """
    brake, release = (round(edge * RESOLUTION, 9) for edge in point)
    apart = apart_of(task, (brake, release))
    if apart <= 0.0:
        return None
    soon = max(unbraked.contact + most, release) + COARSE * RESOLUTION
    for within in (soon, inf):  # most fail soon
        landing = land(task, (brake, release), within)
        added = landing.contact - unbraked.contact
        if not (landing.stays and added <= most and landing.speed < unbraked.speed):
            return None
    return brake, release, added, landing.speed, apart


def _thinned(front):
    """The last brake of a front for each step of added time."""
    steps = np.floor(front[:, ADDED] / FRONT_STEP)
    return front[np.append(steps[1:] != steps[:-1], True)] if len(front) else front


def sturdiest(conditions, brakes, spacing, cost):
    """The brake with the lowest worst seating speed over several conditions, costing no more in any.

    The best of the given brakes that lie on a grid, moved by ever smaller steps for as long as its worst speed falls.

    Parameters
    ----------
    conditions : sequence of (Task, Landing)
        Each with its unbraked landing.
    brakes : (n, 5) float array
        See `BRAKE`.
    spacing, cost : float
        [s]

    Returns
    -------
    pair of float, or None
        Its edges after the command [s]; None: no brake completes the stroke in every condition at that cost.
    """
    conditions, unit = list(conditions), COARSE // 8
    points = np.round(brakes[:, (BRAKE, RELEASE)] / RESOLUTION).astype(int)
    start = (brakes[:, APART] >= spacing) & (brakes[:, ADDED] <= cost) & np.all(points % unit == 0, axis=1)
    best, lowest, around = None, inf, list(map(tuple, points[start].tolist()))
    while unit:
        moved = False
        for point in around:
            brake = tuple(round(edge * RESOLUTION, 9) for edge in point)
            if apart_of(conditions[0][0], brake) < max(spacing, RESOLUTION):
                continue
            speed = worst_speed(conditions, brake, cost, lowest)
            if speed < lowest:
                best, lowest, moved = point, speed, True
        if best is None:
            return None
        unit = unit if moved else unit // 2
        moves = range(-2 * unit, 2 * unit + 1, unit or 1)
        around = [(best[0] + a, best[1] + b) for a in moves for b in moves if a or b]
    return tuple(round(edge * RESOLUTION, 9) for edge in best)


def apart_of(task, brake):
    """Shortest time between two edges of a task with a brake [s]."""
    return round(min(brake[0], brake[1] - brake[0], task.dwell - brake[1]), 9)


def worst_speed(conditions, brake, cost, bound=inf):
    """Highest seating speed of a brake over conditions [m/s]; inf where it reaches a bound or a stroke fails.

    The condition that shows it is moved to the front of the list: it is likely to show it for the next brake as well.
    """
    worst = 0.0
    for number, (task, unbraked) in enumerate(conditions):
        landing = land(task, brake)
        if not (landing.stays and landing.contact - unbraked.contact <= cost and landing.speed < bound):
            conditions.insert(0, conditions.pop(number))
            return inf
        worst = max(worst, landing.speed)
    return worst
