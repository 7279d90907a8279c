"""Some of many: which runs a figure shows, where it cannot show all."""

import numpy as np


def spread_out(count: int, max_count: int) -> np.ndarray:
    """Numbers of some of many runs, `max_count` at most, evenly spread, the first and the last among them.

    `count` is how many runs there are; the numbers ascend.
    """
    return np.unique(np.linspace(0, count - 1, max_count).round().astype(int))
