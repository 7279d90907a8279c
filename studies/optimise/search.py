"""The best commands at one speed: most torque, least specific air, and the Pareto front between both."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import NonlinearConstraint, direct, minimize

from apesim.engine.machine import Machine
from apesim.studies.optimise.landscape import Goal, Landscape, Point, point_of
from apesim.studies.timing.solve import SKETCH

SKETCHES = 80
"""Sketches with which a range of two dimensions is searched for each goal; a third takes three times as many."""
RADII, STRIDE, FINE = (0.02, 0.005), 0.01, 3e-4
"""Trust region of an optimum at first, and once more from there, as it may lie where the piston just meets its stop, a
breakpoint; of a step along the front; and of all at the end; shares of the ranges."""
LEVELS = 8
"""Torques at which the front is searched; through what is found there a curve is laid."""
ON_THE_CURVE = 40
"""Points computed on that curve."""


class Optimum(NamedTuple):
    """Best commands at one speed, and the machine's own."""

    speed: float
    """Speed of the crankshaft [rad/s]."""
    fixed: Point | None
    """Point with the machine's own commands; None where the search failed."""
    best: dict[Goal, Point | None]
    """The best `Point` of each goal; None where no commands give brake work."""
    front: list[Point]
    """Points of the Pareto front, from least air to most torque; empty without both goals."""
    sketches: int
    """Number of points whose states were followed roughly."""
    runs: int
    """Number of points whose states were followed fully."""


def optimise(
    machine: Machine, speed: float, goals: Sequence[Goal], pressures: tuple[float, float] | None = None
) -> Optimum:
    """Find the best commands at one speed [rad/s] of a machine with an electro-pneumatic intake.

    DIRECT searches the whole range by sketches of the periodic state, COBYQA (both SciPy's) follows the best of them to
    the optimum by full ones. With both goals the Pareto front is searched, too, from the least air on: at several
    torques the least air with that torque or more, again by COBYQA, and on a curve through these points. Nothing in it
    is random. The supply is free between `pressures` [Pa abs]; it is the machine's own if left out.

    >>> optimum = optimise(Machine(), 94.0, [Goal.TORQUE])
    >>> before, after = (point.values["brake_torque_Nm"] for point in (optimum.fixed, optimum.best[Goal.TORQUE]))
    >>> round(before), round(after)
    (37, 60)
    """
    landscape = Landscape(machine, speed, pressures)
    for goal in goals:
        start = _overview(landscape, goal)
        for radius in RADII:
            _climb(landscape, goal, start, radius)
            best_so_far = landscape.best(goal)
            start = best_so_far.place if best_so_far else start
    front = []
    if len(goals) > 1 and landscape.best(Goal.AIR):
        meant = _along_the_front(landscape)
        front = [point for point in undominated(landscape.settled.values()) if point.place in meant]
    best = {goal: landscape.best(goal) for goal in goals}
    return Optimum(speed, point_of(machine, speed), best, front, len(landscape.sketched), 1 + len(landscape.settled))


def _overview(landscape: Landscape, goal: Goal) -> tuple[float, ...]:
    """Find where the best of a search by sketches lies."""
    dimensions = len(landscape.low)
    result = direct(
        lambda x: -landscape.at(x, SKETCH).merit[goal],
        [(0.0, 1.0)] * dimensions,
        maxfun=SKETCHES * 3 ** (dimensions - 2),
    )
    return tuple(result.x.tolist())


def _best(landscape: Landscape, goal: Goal, min_torque: float = -np.inf) -> Point:
    """Best of the points so far, where the search has met one with at least that torque [N m]."""
    point = landscape.best(goal, min_torque)
    if point is None:
        raise ValueError("no point of the landscape gives brake work")
    return point


def _climb(
    landscape: Landscape, goal: Goal, start: Sequence[float], radius: float, min_torque: float | None = None
) -> None:
    """Follow a goal from a start to its optimum, with a torque of at least some value [N m]."""
    scale = abs(landscape.at(start).merit[goal])
    scale = scale if 0.0 < scale < np.inf else 1.0
    constraints = ()
    if min_torque is not None:
        span = _best(landscape, Goal.TORQUE).merit[Goal.TORQUE]
        constraints = NonlinearConstraint(
            lambda x: max(landscape.at(x).merit[Goal.TORQUE] / span, -1.0), min_torque / span, np.inf
        )
    minimize(
        lambda x: -landscape.at(x).merit[goal] / scale,
        start,
        method="COBYQA",
        bounds=[(0.0, 1.0)] * len(start),
        constraints=constraints,
        options={"initial_tr_radius": radius, "final_tr_radius": FINE},
    )


def _along_the_front(landscape: Landscape) -> set[tuple[float, ...]]:
    """Compute points on the front: at torques from that of least air to the most, and on the curve through them.

    The places of these points and of the optima are returned; the search leaves others beside the front.
    """
    first, last = (_best(landscape, goal) for goal in (Goal.AIR, Goal.TORQUE))
    low, high = (point.merit[Goal.TORQUE] for point in (first, last))
    path = [np.array(first.place)]
    for share in np.sin(0.5 * np.pi * np.arange(1, LEVELS + 1) / (LEVELS + 1)):
        level = low + share * (high - low)
        ahead = 2.0 * path[-1] - path[-2] if len(path) > 1 else path[-1]
        _climb(landscape, Goal.AIR, np.clip(ahead, 0.0, 1.0), STRIDE, level)
        slack = 1e-4 * (high - low)
        path.append(np.array(_best(landscape, Goal.AIR, level - slack).place))
    places = np.array([*path, last.place])
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    way = np.concatenate(([0.0], np.cumsum(steps[steps > 0.0])))
    curve = PchipInterpolator(way, places[np.concatenate(([True], steps > 0.0))])
    meant = [landscape.at(x) for x in (*places, *curve(np.linspace(0.0, way[-1], ON_THE_CURVE + 2)[1:-1]))]
    return {point.place for point in (*meant, _best(landscape, Goal.AIR), _best(landscape, Goal.TORQUE))}


def undominated(points: Iterable[Point]) -> list[Point]:
    """Select the points with brake work than which no other is better in one goal and as good in the other.

    Along this Pareto front torque and specific air both rise.

    >>> merits = [(60.0, 57e3), (35.0, 89e3), (34.0, 80e3)]  # torque [N m], work over air [J/kg]
    >>> points = [Point((), 0.0, 1.0, 1.1e6, {}, merit, True) for merit in merits]
    >>> [point.merit for point in undominated(points)]
    [(35.0, 89000.0), (60.0, 57000.0)]
    """
    front: list[Point] = []
    for point in sorted(points, key=lambda point: point.merit, reverse=True):
        if point.merit[Goal.TORQUE] > 0.0 and (not front or point.merit[Goal.AIR] > front[-1].merit[Goal.AIR]):
            front.append(point)
    return front[::-1]
