"""Tables over speed, pressure and temperature: linear interpolation between their points, and its measured error."""

from itertools import product
from typing import NamedTuple

import numpy as np


class Axes(NamedTuple):
    """Axes of a table's points, each ascending."""

    speeds: np.ndarray
    """[rad/s], (i,)"""
    pressures: np.ndarray
    """Pressures of the supply [Pa abs], (j,)"""
    temperatures: np.ndarray
    """Temperatures of the supply [K], (k,)"""

    @property
    def shape(self):
        """(i, j, k)"""
        return tuple(len(axis) for axis in self)


class InterpolationError(NamedTuple):
    """Interpolated less solved angles, at centres of cells."""

    points: int
    """Centres compared."""
    centres: int
    """Centres there are."""
    seed: int
    """Seed of the choice among them, where not all were compared."""
    advance_most: float
    """[rad]; NaN: no centre could be compared."""
    advance_rms: float
    release_advance_most: float
    release_advance_rms: float


def interpolated(axes, values, point):
    """A table's value between its points, linear along each axis.

    Parameters
    ----------
    axes : Axes
    values : (i, j, k) float array
        NaN: no value. A point next to one has none either.
    point : sequence of float
        Speed, pressure, temperature; nothing is extrapolated.

    Returns
    -------
    float
        NaN outside the axes.
    """
    lows, shares = [], []
    for axis, x in zip(axes, point, strict=True):
        if not axis[0] <= x <= axis[-1]:
            return np.nan
        low = int(np.clip(np.searchsorted(axis, x, side="right") - 1, 0, max(0, len(axis) - 2)))
        lows.append(low)
        shares.append((x - axis[low]) / (axis[low + 1] - axis[low]) if len(axis) > 1 else 0.0)
    value = 0.0
    for corner in product((0, 1), repeat=3):
        weight = np.prod([share if up else 1.0 - share for share, up in zip(shares, corner, strict=True)])
        if weight > 0.0:
            value += weight * values[tuple(low + up for low, up in zip(lows, corner, strict=True))]
    return float(value)


def centres(axes, max_centres, seed):
    """Centres of the cells of a table, or a random choice of them; along an axis with one point they stand on it.

    Parameters
    ----------
    axes : Axes
    max_centres : int
    seed : int

    Returns
    -------
    chosen : list of tuple of float
        Speed, pressure, temperature.
    number : int
        Centres there are.
    """
    middles = [0.5 * (axis[1:] + axis[:-1]) if len(axis) > 1 else axis for axis in axes]
    points = [tuple(float(x) for x in point) for point in product(*middles)]
    if max(axes.shape) < 2:
        return [], 0
    if len(points) <= max_centres:
        return points, len(points)
    chosen = np.sort(np.random.default_rng(seed).choice(len(points), max_centres, replace=False))
    return [points[number] for number in chosen], len(points)


def interpolation_error(axes, advance, release_advance, solved, number, seed):
    """Compare a table with what is solved between its points.

    Parameters
    ----------
    axes : Axes
    advance, release_advance : (i, j, k) float array
        [rad]; NaN out of reach.
    solved : list of tuple
        Point, advance, release advance; NaN out of reach, which is left out.
    number : int
        Centres there are.
    seed : int

    Returns
    -------
    InterpolationError
    """
    errors = np.array(
        [
            (interpolated(axes, advance, point) - a, interpolated(axes, release_advance, point) - r)
            for point, a, r in solved
        ]
    ).reshape(-1, 2)
    errors = errors[~np.isnan(errors).any(axis=1)]
    if not len(errors):
        return InterpolationError(0, number, seed, *4 * (np.nan,))
    largest, rms = np.abs(errors).max(axis=0), np.sqrt((errors**2).mean(axis=0))
    return InterpolationError(
        len(errors), number, seed, *(float(x) for pair in zip(largest, rms, strict=True) for x in pair)
    )
