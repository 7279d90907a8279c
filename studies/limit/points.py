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
    """Add a machine's own point, as the last, to a grid that does not hold it; gives the origin of each point, too.

    A point of the grid that agrees within 1e-9 of each coordinate counts as the machine's own.
    """
    kinds = [Point.GRID_AND_OWN if np.allclose(point, own, rtol=1e-9, atol=0.0) else Point.GRID for point in grid]
    if Point.GRID_AND_OWN in kinds:
        return list(grid), kinds
    return [*grid, own], [*kinds, Point.OWN]


def point_column(kinds: Sequence[Point]) -> Variable:
    """Make the column of an archive that says where each point comes from, by the codes of `Point`."""
    return column(kinds, "1", "where the point comes from", POINTS)


def own_run(v: Mapping[str, np.ndarray]) -> int:
    """Find the machine's own point in a map of limits: its place in the columns `v`, from 0."""
    return int(np.flatnonzero(v["point"] != Point.GRID)[0])


def lowest_run(v: Mapping[str, np.ndarray]) -> int | None:
    """Find the point of the grid with the lowest limit in a map of limits: its place in the columns `v`, from 0.

    None where any point of the grid has no limit; the machine's own point beside the grid does not count.

    >>> points = np.array([Point.GRID, Point.GRID_AND_OWN, Point.OWN])
    >>> lowest_run({"point": points, "limit_rpm": np.array([2400.0, 1900.0, 1500.0])})
    1
    """
    runs = np.flatnonzero(v["point"] != Point.OWN)
    limits = v["limit_rpm"][runs]
    return None if np.isnan(limits).any() else int(runs[np.argmin(limits)])
