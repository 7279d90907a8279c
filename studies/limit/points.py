"""Points of a map of limits: those of its grid, and the machine's own."""

from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import Any

import numpy as np

from apesim.archive import Variable
from apesim.archive.columns import column


class Point(IntEnum):
    """Origin of a point of a map of limits: the grid, the machine's own conditions, or both."""

    GRID = 0
    GRID_AND_OWN = 1
    OWN = 2


POINTS = (
    f"{Point.GRID:d} of the grid, {Point.GRID_AND_OWN:d} of the grid and the machine's own, "
    f"{Point.OWN:d} the machine's own beside the grid"
)


def with_own(grid: Sequence[tuple[Any, ...]], own: tuple[Any, ...]) -> tuple[list[Any], list[Point]]:
    """Add a machine's own point to a grid that does not hold it.

    Parameters
    ----------
    grid : sequence of tuple of float
        Coordinates of the points, in any units.
    own : tuple of float
        Coordinates of the machine's own point; a point that agrees within 1e-9 of each counts as the same.

    Returns
    -------
    points : list of tuple of float
        Points of the grid, with the machine's own as the last where it was added.
    kinds : list of Point
        Origin of each point.

    Examples
    --------
    >>> points, kinds = with_own([(1.0, 2.0)], (1.0, 3.0))
    >>> points, [kind.name for kind in kinds]
    ([(1.0, 2.0), (1.0, 3.0)], ['GRID', 'OWN'])
    """
    kinds = [Point.GRID_AND_OWN if np.allclose(point, own, rtol=1e-9, atol=0.0) else Point.GRID for point in grid]
    if Point.GRID_AND_OWN in kinds:
        return list(grid), kinds
    return [*grid, own], [*kinds, Point.OWN]


def point_column(kinds: Sequence[Point]) -> Variable:
    """Make the column of an archive that says where each point comes from.

    Parameters
    ----------
    kinds : sequence of Point
        Origin of each point.

    Returns
    -------
    Variable
        Codes of `Point`, over the runs.

    Examples
    --------
    >>> point_column([Point.GRID, Point.OWN]).values.tolist()
    [0, 2]
    """
    return column(kinds, "1", "where the point comes from", POINTS)


def own_run(v: Mapping[str, np.ndarray]) -> int:
    """Find the machine's own point in a map of limits.

    Parameters
    ----------
    v : mapping of str to array
        Columns of the map, by name.

    Returns
    -------
    int
        Place of the point in the columns, from 0.

    Examples
    --------
    >>> own_run({"point": np.array([Point.GRID, Point.GRID, Point.OWN])})
    2
    """
    return int(np.flatnonzero(v["point"] != Point.GRID)[0])


def lowest_run(v: Mapping[str, np.ndarray]) -> int | None:
    """Find the point of the grid with the lowest limit in a map of limits.

    Parameters
    ----------
    v : mapping of str to array
        Columns of the map, by name.

    Returns
    -------
    int or None
        Place of the point in the columns, from 0; None where any point of the grid has no limit.

    Examples
    --------
    >>> points = np.array([Point.GRID, Point.GRID_AND_OWN, Point.OWN])
    >>> lowest_run({"point": points, "limit_rpm": np.array([2400.0, 1900.0, 1500.0])})
    1
    """
    runs = np.flatnonzero(v["point"] != Point.OWN)
    limits = v["limit_rpm"][runs]
    return None if np.isnan(limits).any() else int(runs[np.argmin(limits)])
