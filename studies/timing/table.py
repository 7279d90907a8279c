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
    """Interpolate a table between its points, linearly along each axis.

    It is multilinear interpolation [1]_.

    Parameters
    ----------
    axes : Axes
        Speeds (i), pressures (j) and temperatures (k) of the table.
    values : (i, j, k) float array
        Values of the table, in any unit; NaN where there is none.
    point : sequence of float
        Speed [rad/s], pressure [Pa abs], temperature [K].

    Returns
    -------
    float
        Value, in the unit of the table. NaN outside of the axes, as nothing is extrapolated, and where one of the
        neighbours that count is NaN.

    References
    ----------
    .. [1] W. H. Press, S. A. Teukolsky, W. T. Vetterling and B. P. Flannery, "Numerical Recipes", 3rd ed., Cambridge
       University Press, 2007, section 3.6.

    Examples
    --------
    >>> axes = Axes(np.array([50.0, 100.0]), np.array([1e6]), np.array([287.0]))
    >>> interpolated(axes, np.array([[[0.2]], [[0.4]]]), (75.0, 1e6, 287.0))
    0.30000000000000004
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
    """Find the centres of the cells of a table, or a random choice of them.

    Parameters
    ----------
    axes : Axes
        Axes of the table; along an axis with one point the centres stand on that point.
    max_centres : int
        Most centres that are chosen.
    seed : int
        Seed of the random choice.

    Returns
    -------
    chosen : list of tuple of float
        Speed [rad/s], pressure [Pa abs] and temperature [K] of each centre.
    number : int
        Number of centres that the table has; 0 for a table of a single point.

    Examples
    --------
    >>> axes = Axes(np.array([50.0, 100.0]), np.array([1e6]), np.array([250.0, 300.0]))
    >>> centres(axes, 10, 0)
    ([(75.0, 1000000.0, 275.0)], 1)
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
    """Compare a table with what is solved between its points.

    Parameters
    ----------
    axes : Axes
        Speeds (i), pressures (j) and temperatures (k) of the table.
    advance, release_advance : (i, j, k) float array
        Both tables [rad]; NaN out of reach.
    solved : sequence of tuple
        Solved centres of cells: point, advance [rad], release advance [rad]. Centres where an angle is NaN, here or
        interpolated, are left out.
    number : int
        Number of centres that the table has, noted in the result.
    seed : int
        Seed by which the centres were chosen, noted in the result.

    Returns
    -------
    InterpolationError
        Largest and root mean square errors [rad]; NaN where no centre is left.

    Examples
    --------
    >>> axes = Axes(np.array([50.0, 100.0]), np.array([1e6]), np.array([287.0]))
    >>> advance, release_advance = np.array([[[0.2]], [[0.4]]]), np.array([[[0.3]], [[0.6]]])
    >>> solved = [((75.0, 1e6, 287.0), 0.29, 0.45)]
    >>> error = interpolation_error(axes, advance, release_advance, solved, 1, 0)
    >>> round(error.max_advance_error, 6), round(error.max_release_error, 6), error.points
    (0.01, 0.0, 1)
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
