"""Means of residuals over windows, in which a gap shows that is far below the noise of a sample."""

import numpy as np

from apesim.studies.gap.thresholds import WINDOWS


def split_into_windows(values: np.ndarray) -> list[np.ndarray]:
    """The parts of an array (n,) over `WINDOWS` windows; fewer values are windows of their own."""
    return np.array_split(values, min(WINDOWS, len(values)))


def average_over_windows(values: np.ndarray) -> np.ndarray:
    """Average the residuals of one channel over `WINDOWS` windows, in standard deviations of such a mean.

    `values` (n,) are whitened [standard deviations]; the result (m,) are sums over windows over the root of their
    lengths, each of variance one for white noise. Fewer than `WINDOWS` values are windows of their own.

    >>> average_over_windows(np.ones(200)).tolist() == [2.0] * 50
    True
    """
    return np.array([part.sum() / np.sqrt(len(part)) for part in split_into_windows(values)])
