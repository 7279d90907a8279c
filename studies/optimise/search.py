"""The best commands at one speed: most torque, least specific air, and the Pareto front between both."""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import NonlinearConstraint, direct, minimize

from apesim.studies.optimise.landscape import Goal, Landscape, Point, point_of
from apesim.studies.timing.solve import SKETCH

SKETCHES = 80
"""With which a range of two dimensions is searched for each goal; a third takes three times as many."""
RADII, STRIDE, FINE = (0.02, 0.005), 0.01, 3e-4
"""Trust region of an optimum at first, and once more from there, as it may lie where the piston just meets its stop, a
breakpoint; of a step along the front; and of all at the end; shares of the ranges."""
LEVELS = 8
"""Torques at which the front is searched; through what is found there a curve is laid."""
ON_THE_CURVE = 40
"""Points computed on that curve."""


class Optimum(NamedTuple):
    """The best commands at one speed."""

    speed: float
    """[rad/s]"""
    own: Point
    """With the machine's own commands."""
    best: dict
    """The best `Point` of each goal; None where no commands give brake work."""
    front: list
    """Points of the Pareto front, from least air to most torque; empty without both goals."""
    sketches: int
    runs: int
    """Computed, their states followed roughly and fully."""


def optimise(machine, speed, goals, pressures=None):
    """The best commands at one speed.

    DIRECT searches the whole range by sketches of the periodic state, COBYQA (both SciPy's) follows the best of them to
    the optimum by full ones. The front is searched from the least air on: at several torques the least air with that
    torque or more, again by COBYQA, and on a curve through what is found. Nothing in it is random.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
        With an electro-pneumatic intake.
    speed : float
        [rad/s]
    goals : sequence of Goal
    pressures : pair of float, optional
        Between which the supply pressure is free [Pa abs].

    Returns
    -------
    Optimum
    """
    landscape = Landscape(machine, speed, pressures)
    for goal in goals:
        start = _overview(landscape, goal)
        for radius in RADII:
            _climb(landscape, goal, start, radius)
            found = landscape.best(goal)
            start = found.place if found else start
    front = []
    if len(goals) > 1 and landscape.best(Goal.AIR):
        meant = _along_the_front(landscape)
        front = [point for point in undominated(landscape.settled.values()) if point.place in meant]
    best = {goal: landscape.best(goal) for goal in goals}
    own = point_of(machine, speed)
    return Optimum(speed, own, best, front, len(landscape.sketched), 1 + len(landscape.settled))


def _overview(landscape, goal):
    """Find where the best of a search by sketches lies."""
    dimensions = len(landscape.low)
    found = direct(
        lambda x: -landscape.at(x, SKETCH).merit[goal],
        [(0.0, 1.0)] * dimensions,
        maxfun=SKETCHES * 3 ** (dimensions - 2),
    )
    return found.x


def _climb(landscape, goal, start, radius, min_torque=None):
    """Follow a goal from a start to its optimum, with a torque of at least some value [N m]."""
    scale = abs(landscape.at(start).merit[goal])
    scale = scale if 0.0 < scale < np.inf else 1.0
    constraints = ()
    if min_torque is not None:
        span = landscape.best(Goal.TORQUE).merit[Goal.TORQUE]
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


def _along_the_front(landscape):
    """Compute points on the front: at torques from that of least air to the most, and on the curve through them.

    Returns
    -------
    set of tuple
        Their places, and those of the optima; the search leaves others beside the front.
    """
    first, last = (landscape.best(goal) for goal in (Goal.AIR, Goal.TORQUE))
    low, high = (point.merit[Goal.TORQUE] for point in (first, last))
    path = [np.array(first.place)]
    for share in np.sin(0.5 * np.pi * np.arange(1, LEVELS + 1) / (LEVELS + 1)):
        level = low + share * (high - low)
        ahead = 2.0 * path[-1] - path[-2] if len(path) > 1 else path[-1]
        _climb(landscape, Goal.AIR, np.clip(ahead, 0.0, 1.0), STRIDE, level)
        slack = 1e-4 * (high - low)
        path.append(np.array(landscape.best(Goal.AIR, level - slack).place))
    path = np.array([*path, last.place])
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    way = np.concatenate(([0.0], np.cumsum(steps[steps > 0.0])))
    curve = PchipInterpolator(way, path[np.concatenate(([True], steps > 0.0))])
    meant = [landscape.at(x) for x in (*path, *curve(np.linspace(0.0, way[-1], ON_THE_CURVE + 2)[1:-1]))]
    return {point.place for point in (*meant, landscape.best(Goal.AIR), landscape.best(Goal.TORQUE))}


def undominated(points):
    """Points with brake work than which no other is better in one goal and as good in the other.

    Parameters
    ----------
    points : iterable of Point

    Returns
    -------
    list of Point
        Torque and specific air both rise.
    """
    front = []
    for point in sorted(points, key=lambda point: point.merit, reverse=True):
        if point.merit[Goal.TORQUE] > 0.0 and (not front or point.merit[Goal.AIR] > front[-1].merit[Goal.AIR]):
            front.append(point)
    return front[::-1]
