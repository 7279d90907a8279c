"""Brakes: solenoids switched back for a while in mid-stroke, so that the piston lands softly.

Two numbers make a brake of given solenoids, when it begins and when it is released. The landscape over them has cliffs,
where the piston turns back or falls off its stop again. So all brakes of a grid are run on the bench, then those around
the best ones on ever finer grids: a scan sees a cliff, where a descent would end on it.
"""

from collections.abc import Sequence
from math import ceil, inf

import numpy as np

from apesim.studies.soft_landing.landing import SOLENOIDS, Lander, Landing, Task, apart_of
from apesim.valve.solenoid import solenoid_curves

RESOLUTION = 0.01e-3
"""Resolution of the edges [s]."""
COARSE = 32
"""Step of the first grid, in units of the resolution; a power of two."""
MIN_ADDED = 3e-3
"""Shortest added time up to which brakes are sought [s]."""
FRONT_STEP = 0.05e-3
"""The front is refined at one brake for each such step of added time [s]."""
SPACINGS = np.arange(1, 19) * 0.25e-3
"""Times between edges, for each of which the best brake is sought [s]."""
SOFT = 0.5
"""A landing at this share of the unbraked seating speed, a quarter of its energy, counts as soft."""
BRAKE, RELEASE, ADDED, SPEED, APART, SWITCHED = range(6)
"""Columns of brakes: its two edges after the command [s], time added to the stroke [s], seating speed [m/s], shortest
time between two edges of a solenoid [s], number in `SOLENOIDS` of those it switches."""


def front_of(brakes: np.ndarray, apart: float = 0.0, max_added: float = inf) -> np.ndarray:
    """Select the brakes that no other beats in both added time and seating speed.

    `brakes` are (n, 6) with the columns from `BRAKE` on; `apart` is the shortest time between two edges, `max_added`
    the longest added time that is allowed [s]. Added time ascends in the rows (m, 6), seating speed falls; the softest
    is the last.

    >>> brakes = np.array(
    ...     [
    ...         [8.72e-3, 9.46e-3, 0.9e-3, 0.04, 0.74e-3, 0],
    ...         [8.08e-3, 12.4e-3, 0.9e-3, 0.27, 4.31e-3, 1],
    ...         [7.00e-3, 11.6e-3, 2.0e-3, 0.30, 4.60e-3, 1],
    ...     ]
    ... )
    >>> front_of(brakes)[:, SPEED].tolist(), front_of(brakes, apart=4e-3)[:, SPEED].tolist()
    ([0.04], [0.27])
    """
    allowed = brakes[(brakes[:, APART] >= apart) & (brakes[:, ADDED] <= max_added)]
    allowed = allowed[np.lexsort((allowed[:, SPEED], allowed[:, ADDED]))]
    lowest = np.minimum.accumulate(np.append(inf, allowed[:, SPEED]))
    return allowed[allowed[:, SPEED] < lowest[:-1]]


def widest_soft(brakes: np.ndarray, unbraked: Landing, cost: float) -> np.ndarray:
    """Select the brake whose edges are farthest apart, of those that land softly (see `SOFT`) at a cost.

    `brakes` are (n, 6) with the columns from `BRAKE` on, `unbraked` is the landing without one, `cost` the longest
    added time that is allowed [s]. The result is (1, 6), or (0, 6) where none lands softly.
    """
    soft = brakes[(brakes[:, ADDED] <= cost) & (brakes[:, SPEED] <= SOFT * unbraked.speed)]
    return soft[np.argsort(soft[:, APART])[-1:]]


def search(task: Task, unbraked: Landing, spacing: float, cost: float) -> np.ndarray:
    """Search brakes of a task's solenoids that complete the stroke and lower its seating speed.

    `unbraked` is the landing of the task without a brake; `spacing` the shortest time between two edges of a solenoid
    for which the search is refined [s], closer edges are tried, too; `cost` the longest added time that is allowed [s].
    Returns (n, 6) with the columns from `BRAKE` on: all that were met, refined along the fronts for the given spacing,
    for none and for `SPACINGS`.

    >>> from apesim.engine.machine import Machine
    >>> from apesim.studies.soft_landing.landing import land
    >>> task = Task(Machine(), 50e-3, "closing")
    >>> unbraked = land(task)
    >>> softest = front_of(search(task, unbraked, spacing=0.6e-3, cost=1e-3), max_added=1e-3)[-1]
    >>> round(unbraked.speed, 2), bool(softest[SPEED] < 0.1 * unbraked.speed)  # [m/s]
    (1.54, True)
    """
    max_added, lander = max(MIN_ADDED, cost), Lander(task)
    points = _first_grid(task, unbraked, spacing, max_added)
    tried: set[tuple[int, int]] = set()
    completed: list[tuple[float, ...]] = []
    unit, brakes = COARSE, np.empty((0, 6))
    while points:
        completed += [row for point in sorted(points) if (row := _attempt(lander, unbraked, max_added, point))]
        tried |= points
        brakes = np.array(completed).reshape(-1, 6)
        softest = [front_of(brakes, apart, cost)[-1:] for apart in (spacing, 0.0)]
        if unit > 1:
            unit //= 2
            moves = [-unit, 0, unit]
            fronts = [_thinned(front_of(brakes, apart, max_added)) for apart in (spacing, 0.0)]
            spaced = [front_of(brakes, apart, cost)[-1:] for apart in SPACINGS]
            rows = np.concatenate((*softest, *fronts, *spaced, widest_soft(brakes, unbraked, cost)))
        else:  # until all around the softest have been tried
            rows, moves = np.concatenate(softest), [-2, -1, 0, 1, 2]
        centres = np.round(rows[:, (BRAKE, RELEASE)] / RESOLUTION).astype(int).tolist()
        points = {(i + a, j + b) for i, j in centres for a in moves for b in moves} - tried
    return brakes


def _first_grid(task: Task, unbraked: Landing, spacing: float, max_added: float) -> set[tuple[int, int]]:
    """Choose the edges to begin with, in units of the resolution.

    A brake that has fully acted before the motion only delays it, and one that acts after contact lowers nothing. If
    the stroke is completed after the release, a late one costs too much; if before, an earlier one is better.
    """
    curves = solenoid_curves(task.machine.valve.solenoid)
    dead, followed = min(curve[0, 0] for curve in curves), max(curve[-1, 0] for curve in curves)
    earliest = max(unbraked.delay - followed, 0.0) / RESOLUTION
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


def _attempt(
    lander: Lander, unbraked: Landing, max_added: float, point: tuple[int, int]
) -> tuple[float, float, float, float, float, int] | None:
    """Run a brake with edges in units of the resolution, see `BRAKE` for what is returned.

    None is returned where the stroke is not completed in time, or not softer than unbraked.
    """
    brake, release = _edges_of(point)
    task = lander.task
    apart = apart_of(task, (brake, release))
    if apart <= 0.0:
        return None
    flight = lander.fly((brake, release))
    soon = max(unbraked.contact + max_added, release) + COARSE * RESOLUTION
    for within in (soon, inf):  # most fail soon
        landing = flight.land(min(task.dwell, within))
        added = landing.contact - unbraked.contact
        if not (landing.stays and added <= max_added and landing.speed < unbraked.speed):
            return None
    return brake, release, added, landing.speed, apart, SOLENOIDS.index(task.solenoids)


def _thinned(front: np.ndarray) -> np.ndarray:
    """Last brake of a front for each step of added time."""
    steps = np.floor(front[:, ADDED] / FRONT_STEP)
    return front[np.append(steps[1:] != steps[:-1], True)] if len(front) else front


def sturdiest(
    conditions: Sequence[tuple[Task, Landing]], brakes: np.ndarray, spacing: float, cost: float
) -> tuple[tuple[float, float] | None, float]:
    """Find the brake with the lowest worst seating speed over several conditions, costing no more in any.

    It starts from the best of the given brakes, (n, 6) with the columns from `BRAKE` on, that begin on a grid, and
    moves by ever smaller steps for as long as the worst speed falls. `conditions` are tasks of the same solenoids, each
    with its unbraked landing; `spacing` is the shortest time between two edges of a solenoid, `cost` the longest added
    time that is allowed [s]. Returns the edges after the command [s], None where no brake completes the stroke in every
    condition at that cost, and the worst seating speed [m/s].

    >>> from apesim.engine.machine import Machine
    >>> from apesim.studies.soft_landing.landing import land
    >>> task = Task(Machine(), 50e-3, "closing")
    >>> brakes = np.array([[8.72e-3, 9.46e-3, 0.91e-3, 0.036, 0.74e-3, 0]])
    >>> brake, worst = sturdiest([(task, land(task))], brakes, spacing=0.6e-3, cost=1e-3)
    >>> round(1e3 * brake[0], 1), worst < 0.1  # [ms], [m/s]
    (8.7, True)
    """
    ordered, unit = [(Lander(task), unbraked) for task, unbraked in conditions], COARSE // 8
    points = np.round(brakes[:, (BRAKE, RELEASE)] / RESOLUTION).astype(int)
    start = (brakes[:, APART] >= spacing) & (brakes[:, ADDED] <= cost) & (points[:, 0] % unit == 0)
    best: tuple[int, int] | None = None
    lowest, around = inf, [(first, last) for first, last in points[start].tolist()]
    while True:
        moved = False
        for point in around:
            brake = _edges_of(point)
            if apart_of(conditions[0][0], brake) < max(spacing, RESOLUTION):
                continue
            speed = _worst_speed(ordered, brake, cost, lowest)
            if speed < lowest:
                best, lowest, moved = point, speed, True
        if best is None:
            return None, inf
        unit = unit if moved else unit // 2
        if not unit:
            return _edges_of(best), lowest
        moves = range(-2 * unit, 2 * unit + 1, unit)
        around = [(best[0] + a, best[1] + b) for a in moves for b in moves if a or b]


def _edges_of(point: tuple[int, int]) -> tuple[float, float]:
    """Edges of a brake [s], from units of the resolution."""
    return round(point[0] * RESOLUTION, 9), round(point[1] * RESOLUTION, 9)


def _worst_speed(
    conditions: list[tuple[Lander, Landing]], brake: tuple[float, float], cost: float, bound: float = inf
) -> float:
    """Find the highest seating speed of a brake over conditions [m/s]; inf where it reaches a bound or a stroke fails.

    The condition that shows it is moved to the front of the list: it is likely to show it for the next brake as well.
    """
    worst = 0.0
    for number, (lander, unbraked) in enumerate(conditions):
        landing = lander.land(brake)
        if not (landing.stays and landing.contact - unbraked.contact <= cost and landing.speed < bound):
            conditions.insert(0, conditions.pop(number))
            return inf
        worst = max(worst, landing.speed)
    return worst
