"""Sample and hold: a channel that was sampled more slowly than the rows of its file come, each value repeated.

The value of such a row was measured when its sampler last looked, up to its whole period before. Taken as if it was
measured at its row it looks like a lag of half of that period, which a fit takes for a dead time and a search for the
lag of a sensor. The rows in which the sampler looked tell its place and its value.
"""

import numpy as np

from apesim.studies.measured.plausibility.thresholds import (
    MAX_OFF_GRID,
    MAX_OFF_GRID_ROWS,
    MIN_CHANGE_SIZES,
    MIN_CHANGES,
    MIN_ON_GRID,
)

MIN_SKIPPED = 1.5
"""Periods above which a change has skipped one: two samples were equal."""


def find_repeated(values: np.ndarray) -> np.ndarray:
    """Find the rows in which a slower sampler's value is only repeated: all False where each row is sampled.

    Such a channel changes at one period alone, by amounts that differ. Coarse steps change by one step, at any row. NaN
    in `values` (n,) is a missing sample.
    """
    known = np.flatnonzero(np.isfinite(values))
    amounts = np.diff(values[known])
    changes = known[1:][amounts != 0.0]
    none = np.zeros(len(values), bool)
    if len(changes) < MIN_CHANGES or 2 * len(changes) > len(known):
        return none
    # The period, from neighbours; behind a long rest without noise many samples were equal.
    gaps = np.diff(changes)
    period = float(np.mean(gaps[gaps < MIN_SKIPPED * np.median(gaps)]))
    if period < 2.0 or not _differs(amounts[amounts != 0.0]):
        return none
    # The samples on a grid of that period: all changes stand on it, or something else made them.
    numbers = np.append(0, np.cumsum(np.rint(gaps / period)))
    if numbers[-1] < MIN_CHANGES - 1:
        return none
    period, start = np.polyfit(numbers, changes, 1)
    off = np.abs(changes - start - period * numbers)
    if np.mean(off <= min(MAX_OFF_GRID * period, MAX_OFF_GRID_ROWS)) < MIN_ON_GRID:
        return none
    # A row of the grid without a change has a sample that is equal to the one before.
    grid = np.rint(start + period * np.arange(numbers[0], (len(values) - 1 - start) / period)).astype(int)
    sampled = none.copy()
    after = np.clip(np.searchsorted(changes, grid), 1, len(changes) - 1)
    nearest = np.minimum(np.abs(grid - changes[after]), np.abs(grid - changes[after - 1]))
    sampled[grid[nearest > 0.5 * period]] = True
    sampled[changes] = True
    return np.isfinite(values) & ~sampled


def _differs(amounts: np.ndarray) -> bool:
    """Whether changes are of many sizes, as those of a signal are, and not of one or two steps of a recorder."""
    sizes = np.sort(np.abs(amounts))
    return bool(np.sum(np.diff(sizes) > 1e-3 * sizes[-1]) >= MIN_CHANGE_SIZES)
