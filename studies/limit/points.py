"""Points of a map of limits: those of its grid, and the machine's own."""

from enum import IntEnum

import numpy as np

from apesim.archive.columns import column


class Point(IntEnum):
    """Origin of a point of a map."""

    GRID = 0
    GRID_AND_OWN = 1
    OWN = 2


POINTS = (
    f"{Point.GRID:d} of the grid, {Point.GRID_AND_OWN:d} of the grid and the machine's own, "
    f"{Point.OWN:d} the machine's own beside the grid"
)


def with_own(grid, own):
    """Add a machine's own point to a grid that does not hold it.

    Parameters
    ----------
    grid : sequence of tuple of float
    own : tuple of float

    Returns
    -------
    points : list of tuple of float
    kinds : list of Point
    """
    kinds = [Point.GRID_AND_OWN if np.allclose(point, own, rtol=1e-9, atol=0.0) else Point.GRID for point in grid]
    if Point.GRID_AND_OWN in kinds:
        return list(grid), kinds
    return [*grid, own], [*kinds, Point.OWN]


def point_column(kinds):
    """Column of an archive that says where each point comes from."""
    return column(kinds, "1", "where the point comes from", POINTS)


def own_run(v):
    """Number of the machine's own point among the columns of a map."""
    return int(np.flatnonzero(v["point"] != Point.GRID)[0])


def lowest_run(v):
    """Number of the point of the grid with the lowest limit; None where one of them has no limit."""
    runs = np.flatnonzero(v["point"] != Point.OWN)
    limits = v["limit_rpm"][runs]
    return None if np.isnan(limits).any() else int(runs[np.argmin(limits)])
