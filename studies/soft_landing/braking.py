"""Brakes: solenoids switched back for a while in mid-stroke, so that the piston lands softly.

Two numbers make a brake of given solenoids, when it begins and when it is released. The landscape over them has cliffs,
where the piston turns back or falls off its stop again. So all brakes of a grid are run on the bench, then those around
the best ones on ever finer grids: a scan sees a cliff, where a descent would end on it.
"""

from math import ceil, inf

import numpy as np

from apesim.studies.soft_landing.landing import SOLENOIDS, apart_of, land
from apesim.valve.solenoid import opening_curve

RESOLUTION = 0.01e-3
"""Resolution of the edges [s]."""
COARSE = 32
"""Step of the first grid, in units of the resolution; a power of two."""
MIN_ADDED = 3e-3
"""Added time up to which brakes are sought, at least [s]."""
FRONT_STEP = 0.05e-3
"""The front is refined at one brake for each such step of added time [s]."""
SPACINGS = np.arange(1, 19) * 0.25e-3
"""Times between edges, for each of which the best brake is sought [s]."""
SOFT = 0.5
"""A landing at this share of the unbraked seating speed, a quarter of its energy, counts as soft."""
BRAKE, RELEASE, ADDED, SPEED, APART, SWITCHED = range(6)
"""Columns of brakes: its two edges after the command [s], time added to the stroke [s], seating speed [m/s], shortest
time between two edges of a solenoid [s], number in `SOLENOIDS` of those it switches."""


def front_of(brakes, apart=0.0, max_added=inf):
    """The brakes that no other beats in both added time and seating speed.

    Parameters
    ----------
    brakes : (n, 6) float array
        See `BRAKE`.
    apart : float
        Least time between two edges [s].
    max_added : float
        [s]

    Returns
    -------
    (m, 6) float array
        Added time ascending, seating speed falling; the softest is the last.
    """
    allowed = brakes[(brakes[:, APART] >= apart) & (brakes[:, ADDED] <= max_added)]
    allowed = allowed[np.lexsort((allowed[:, SPEED], allowed[:, ADDED]))]
    lowest = np.minimum.accumulate(np.append(inf, allowed[:, SPEED]))
    return allowed[allowed[:, SPEED] < lowest[:-1]]


def widest_soft(brakes, unbraked, cost):
    """The brake whose edges are farthest apart of those that land softly (see `SOFT`) at a cost; shape (0 or 1, 6)."""
    soft = brakes[(brakes[:, ADDED] <= cost) & (brakes[:, SPEED] <= SOFT * unbraked.speed)]
    return soft[np.argsort(soft[:, APART])[-1:]]


def search(task, unbraked, spacing, cost):
    """Brakes of a task's solenoids that complete the stroke and lower its seating speed.

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
    (n, 6) float array
        See `BRAKE`; of each front all that were met, refined for the given spacing, for none and for `SPACINGS`.
    """
    max_added = max(MIN_ADDED, cost)
    points, tried, found = first_grid(task, unbraked, spacing, max_added), set(), []
    unit, brakes = COARSE, np.empty((0, 6))
    while points:
        found += [row for point in sorted(points) if (row := attempt(task, unbraked, max_added, point))]
        tried |= points
        brakes = np.array(found).reshape(-1, 6)
        softest = [front_of(brakes, apart, cost)[-1:] for apart in (spacing, 0.0)]
        if unit > 1:
            unit //= 2
            moves = (-unit, 0, unit)
            fronts = [_thinned(front_of(brakes, apart, max_added)) for apart in (spacing, 0.0)]
            spaced = [front_of(brakes, apart, cost)[-1:] for apart in SPACINGS]
            rows = np.concatenate((*softest, *fronts, *spaced, widest_soft(brakes, unbraked, cost)))
        else:  # until all around the softest have been tried
            rows, moves = np.concatenate(softest), (-2, -1, 0, 1, 2)
        centres = np.round(rows[:, (BRAKE, RELEASE)] / RESOLUTION).astype(int).tolist()
        points = {(i + a, j + b) for i, j in centres for a in moves for b in moves} - tried
    return brakes


def first_grid(task, unbraked, spacing, max_added):
    """Edges to begin with, in units of the resolution.

    A brake that has fully acted before the motion only delays it, and one that acts after contact lowers nothing. If
    the stroke is completed after the release, a late one costs too much; if before, an earlier one is better.
    """
    followed = opening_curve(task.machine.valve.solenoid)[:, 0]
    dead = followed[0]
    earliest = max(unbraked.delay - followed[-1], 0.0) / RESOLUTION
    latest, end = ((unbraked.contact + added - dead) / RESOLUTION for added in (0.0, max_added))
    shortest, *spacings = (ceil(apart / RESOLUTION - 1e-9) for apart in (spacing, *SPACINGS))
    starts = {*range(COARSE * (int(earliest) // COARSE + 1), int(latest) + 1, COARSE), shortest}
    lengths = {*range(COARSE, int(end), COARSE), *spacings, shortest}
    return {
        (start, start + length)
        for start in starts
        for length in lengths
        if start <= latest and length <= max(end - start, shortest)
    }


def attempt(task, unbraked, max_added, point):
    """Run a brake.

    Parameters
    ----------
    task : Task
    unbraked : Landing
        Of the same task.
    max_added : float
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
    soon = max(unbraked.contact + max_added, release) + COARSE * RESOLUTION
    for within in (soon, inf):  # most fail soon
        landing = land(task, (brake, release), within)
        added = landing.contact - unbraked.contact
        if not (landing.stays and added <= max_added and landing.speed < unbraked.speed):
            return None
    return brake, release, added, landing.speed, apart, SOLENOIDS.index(task.solenoids)


def _thinned(front):
    """The last brake of a front for each step of added time."""
    steps = np.floor(front[:, ADDED] / FRONT_STEP)
    return front[np.append(steps[1:] != steps[:-1], True)] if len(front) else front


def sturdiest(conditions, brakes, spacing, cost):
    """The brake with the lowest worst seating speed over several conditions, costing no more in any.

    The best of the given brakes that begin on a grid, moved by ever smaller steps for as long as its worst speed falls.

    Parameters
    ----------
    conditions : sequence of (Task, Landing)
        Each with its unbraked landing, all of the same solenoids.
    brakes : (n, 6) float array
        See `BRAKE`; of those solenoids.
    spacing, cost : float
        [s]

    Returns
    -------
    pair of float or None, float
        Its edges after the command [s]; None: no brake completes the stroke in every condition at that cost. Its worst
        seating speed [m/s].
    """
    conditions, unit = list(conditions), COARSE // 8
    points = np.round(brakes[:, (BRAKE, RELEASE)] / RESOLUTION).astype(int)
    start = (brakes[:, APART] >= spacing) & (brakes[:, ADDED] <= cost) & (points[:, 0] % unit == 0)
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
            return None, inf
        unit = unit if moved else unit // 2
        moves = range(-2 * unit, 2 * unit + 1, unit or 1)
        around = [(best[0] + a, best[1] + b) for a in moves for b in moves if a or b]
    return tuple(round(edge * RESOLUTION, 9) for edge in best), lowest


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
