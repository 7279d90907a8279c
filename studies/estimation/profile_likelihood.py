"""The ends of an interval by profile likelihood: how far a parameter may go, all others fitted anew, until it shows."""

from collections.abc import Iterable, Sequence
from enum import Enum
from math import inf
from typing import Any, NamedTuple

import numpy as np

DEVIATIONS = 1.959964
"""Half the width of a 95 % interval, in standard deviations."""
SHARP = 0.01
"""Share of half an interval at which its end is sought no further."""
CLOSE = 0.01
"""Deviations from those of an end, within which a point is the end."""
BETTER = 0.05
"""Fall of the sum of squares from which a point counts as better than the optimum."""
MAX_POINTS = 20
"""Largest number of points of a profile on one side."""
NEAR_NOTHING = 1e-3
"""Scaled parameter, up to which it does not change as a power of another."""
FACTOR = 1.5
"""Logarithm of the largest factor by which a guess changes a parameter."""
INSIDE = 0.1
"""Share of a bracket that the next point stays away from its ends."""


class Likelihood(NamedTuple):
    """A sum of squares around its minimum, as far as a profile needs it."""

    best: np.ndarray
    """Parameters at which the cost is lowest, (p,)."""
    cost: float
    """Sum of squares there."""
    covariance: np.ndarray
    """Covariance of the parameters, by the curvature there, (p, p)."""
    bounds: np.ndarray
    """Least and largest parameters, (2, p)."""
    hold: Any
    """``hold(guess, j)``: least squares from a guess with parameter j held; gives point, sum of squares, and whether it
    was reached."""
    is_spent: Any = lambda: False
    """Whether there are to be no further simulations."""
    close: float = CLOSE
    """Deviations from those of an end, within which a point is the end."""


class EndKind(Enum):
    """What an interval's end is."""

    CLOSED = "the data hold the parameter here"
    OPEN = "the bound of the parameter: the data do not hold it on this side"
    FROM_CURVATURE = "by the curvature at the optimum alone"
    FROM_CURVATURE_OPEN = "the bound of the parameter, by the curvature at the optimum alone"
    NONE = "a point of a smaller sum of squares was met: what was taken for the optimum is none"


class End(NamedTuple):
    """One end of an interval."""

    at: float
    kind: EndKind
    point: np.ndarray
    """All parameters there or next to it, (p,); of no end the point of a smaller sum of squares."""

    @property
    def is_open(self) -> bool:
        """Whether the interval goes to the parameter's bound."""
        return self.kind in (EndKind.OPEN, EndKind.FROM_CURVATURE_OPEN)

    @property
    def is_cut(self) -> bool:
        """Whether the end is from the curvature at the optimum alone."""
        return self.kind in (EndKind.FROM_CURVATURE, EndKind.FROM_CURVATURE_OPEN)


def first_better(ends: Iterable[End]) -> np.ndarray | None:
    """The first point, (p,), of a smaller sum of squares met on the way to one of several ends; None: none.

    >>> ends = [End(1.0, EndKind.CLOSED, np.array([1.0])), End(2.0, EndKind.NONE, np.array([2.4]))]
    >>> first_better(ends).tolist()
    [2.4]
    """
    return next((end.point for end in ends if end.kind is EndKind.NONE), None)


def find_end(likelihood: Likelihood, j: int, side: int) -> End:
    """Find one end of the 95 % interval of parameter number `j` by profile likelihood; `side` -1 is the lower.

    It is where the least sum of squares with the parameter held is 1.96^2 above that of the optimum (Venzon and
    Moolgavkar 1988, doi 10.2307/2347496); where it stays below as far as the parameter's bound, the end is open. Its
    ``kind`` says whether the data hold the parameter there, or whether a point of a smaller sum of squares was met.

    One parameter, known as 1.0 with a standard deviation of 0.5, and nothing beside it to fit anew:

    >>> def hold(guess, j):
    ...     return guess, float(((guess[j] - 1.0) / 0.5) ** 2), True
    >>> bounds = np.array([[0.5], [10.0]])
    >>> likelihood = Likelihood(np.array([1.0]), 0.0, np.array([[0.25]]), bounds, hold)
    >>> upper, lower = find_end(likelihood, 0, 1), find_end(likelihood, 0, -1)
    >>> round(float(upper.at), 3), upper.is_open, round(float(lower.at), 3), lower.is_open
    (1.98, False, 0.5, True)
    """
    best, cost, covariance = likelihood.best, likelihood.cost, likelihood.covariance
    limit = likelihood.bounds[(side + 1) // 2, j] - best[j]
    away = linear = side * DEVIATIONS * np.sqrt(covariance[j, j])
    slopes = covariance[:, j] / covariance[j, j]
    inner, outer, known = (0.0, 0.0), (inf, inf), [best]  # away from the optimum, deviations there
    for _ in range(MAX_POINTS):
        # Without further simulations, the curvature at the optimum has to say where the end is.
        if likelihood.is_spent():
            if abs(linear) >= abs(limit):
                return End(best[j] + limit, EndKind.FROM_CURVATURE_OPEN, best)
            return End(best[j] + linear, EndKind.FROM_CURVATURE, best)

        # The next point of the profile, no farther than the bound. A smaller sum of squares there ends the search.
        if abs(away) >= abs(limit):
            away = limit
        point, other, is_reached = _held(likelihood, known, slopes, j, best[j] + away)
        if other < cost - BETTER:
            return End(best[j], EndKind.NONE, point)
        deviations = np.sqrt(max(other - cost, 0.0))
        if abs(deviations - DEVIATIONS) < likelihood.close:
            break

        # It narrows the bracket from inside or from outside. A point that was not reached has too large a sum of
        # squares: its deviations are no guide to the next one.
        if is_reached:
            known.append(point)
        if deviations < DEVIATIONS:
            if away == limit:
                return End(best[j] + limit, EndKind.OPEN, point)
            inner = abs(away), deviations
        else:
            outer = abs(away), deviations if is_reached else inf

        # The next place: in proportion to the deviations until a point lies outside, then along the straight line
        # across the bracket, or in its middle where there is no such line.
        if outer[0] == inf:
            size = abs(away) * min(DEVIATIONS / max(deviations, 1e-3), 10.0)
        elif outer[0] - inner[0] < SHARP * outer[0]:  # it jumps here
            away = side * outer[0]
            break
        else:
            share = (DEVIATIONS - inner[1]) / (outer[1] - inner[1]) if outer[1] < inf else 0.5
            size = inner[0] + min(max(share, INSIDE), 1.0 - INSIDE) * (outer[0] - inner[0])
        away = side * size
    return End(best[j] + away, EndKind.CLOSED, point)


def _held(likelihood: Likelihood, known: Sequence[np.ndarray], slopes: np.ndarray, j: int, target: float) -> Any:
    """Least squares with parameter j held at a target, from the nearest known points of the profile, carried on.

    `known` are points (p,) from the optimum on, `slopes` (p,) those of all parameters along the profile at the optimum.
    Gives the point, its cost, and whether it is reached; where it is not from there, it is tried from the nearest known
    point as it is, too.
    """
    near, *others = sorted(known, key=lambda point: abs(point[j] - target))
    if others:
        slopes = (others[0] - near) / (others[0][j] - near[j])
    found = None
    for guess in (_along(near, slopes, j, target), _along(near, np.zeros_like(near), j, target)):
        again = likelihood.hold(np.clip(guess, *likelihood.bounds), j)
        found = again if found is None or again[1] < found[1] else found
        if again[2]:
            break
    return found


def _along(point: np.ndarray, slopes: np.ndarray, j: int, target: float) -> np.ndarray:
    """A point with parameter j moved to a target, the others as the slopes say: as powers of it where that holds."""
    guess = point + slopes * (target - point[j])
    if point[j] > NEAR_NOTHING and target > NEAR_NOTHING:
        powers = point > NEAR_NOTHING
        exponents = slopes[powers] * point[j] / point[powers]
        guess[powers] = point[powers] * np.exp(np.clip(exponents * np.log(target / point[j]), -FACTOR, FACTOR))
    guess[j] = target
    return guess
