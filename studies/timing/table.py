"""Tables over speed, pressure and temperature: linear interpolation between their points, and its measured error."""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np


class Axes(NamedTuple):
    """Axes of a table's points, each ascending."""

    speeds: np.ndarray
    """Speeds of the crankshaft [rad/s], (i,)"""
    pressures: np.ndarray
    """Pressures of the supply [Pa abs], (j,)"""
    temperatures: np.ndarray
    """Temperatures of the supply [K], (k,)"""

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of speeds, pressures and temperatures, (i, j, k)."""
        return tuple(len(axis) for axis in self)


class InterpolationError(NamedTuple):
    """Error of interpolation: interpolated less solved angles, at centres of cells of a table."""

    points: int
    """Number of centres that were compared."""
    centres: int
    """Number of centres that the table has."""
    seed: int
    """Seed of the choice among the centres, where not all were compared."""
    max_advance_error: float
    """Largest error of the advance [rad]; NaN: no centre could be compared."""
    advance_error_rms: float
    """Root mean square error of the advance [rad]."""
    max_release_error: float
    """Largest error of the release's advance [rad]."""
    release_error_rms: float
    """Root mean square error of the release's advance [rad]."""


def interpolated(axes: Axes, values: np.ndarray, point: Sequence[float]) -> float:
    """Interpolate a table (speeds, pressures, temperatures) between its points, linearly along each axis.

    Multilinear interpolation (Press et al. 2007, "Numerical Recipes", 3rd ed., section 3.6) at `point`: speed [rad/s],
    pressure [Pa abs], temperature [K]. NaN outside of the axes, as nothing is extrapolated, and where a neighbour that
    counts is NaN.
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


def centres(axes: Axes, max_centres: int, seed: int) -> tuple[list[tuple[float, ...]], int]:
    """Find the centres of the cells of a table, or a random choice of at most `max_centres`, and their number in all.

    A centre is speed [rad/s], pressure [Pa abs] and temperature [K]; along an axis with one point it stands on that
    point. A table of a single point has none.
    """
    middles = [0.5 * (axis[1:] + axis[:-1]) if len(axis) > 1 else axis for axis in axes]
    points = [tuple(float(x) for x in point) for point in product(*middles)]
    if max(axes.shape) < 2:
        return [], 0
    if len(points) <= max_centres:
        return points, len(points)
    chosen = np.sort(np.random.default_rng(seed).choice(len(points), max_centres, replace=False))
    return [points[number] for number in chosen], len(points)


def interpolation_error(
    axes: Axes,
    advance: np.ndarray,
    release_advance: np.ndarray,
    solved: Sequence[tuple[Sequence[float], float, float]],
    number: int,
    seed: int,
) -> InterpolationError:
    """Compare a table with what is solved between its points: largest and rms errors [rad], NaN with no centre left.

    Both tables [rad] are (speeds, pressures, temperatures), NaN out of reach; `solved` has centres of cells: point,
    advance [rad], release advance [rad]. Centres where an angle is NaN, here or interpolated, are left out. `number` of
    centres of the table and `seed` of their choice are noted in the result.
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
