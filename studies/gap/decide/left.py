"""What a model leaves of each channel, in the unit of the channel, against what it may be off by."""

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.estimation.noise.discrepancy import list_discrepancies
from apesim.studies.gap.thresholds import WINDOWS


def find_left(model: Model) -> dict[str, float]:
    """Find what a model leaves of each channel, noise averaged out [SI].

    It is the root mean square of the means over `WINDOWS` windows of each run, of measured less predicted.
    """
    squares: dict[str, list[np.ndarray]] = {}
    for block, predicted in zip(model.residuals.blocks, model.residuals.predicted(model.fitted.x), strict=True):
        windows = np.array_split(block.values - predicted, min(WINDOWS, len(block.values)))
        squares.setdefault(block.sensor, []).append(np.array([window.mean() for window in windows]) ** 2)
    return {sensor: float(np.sqrt(np.mean(np.concatenate(every)))) for sensor, every in squares.items()}


def is_good_enough(model: Model) -> bool:
    """Whether a model leaves no more of each channel than the user lets it be off, who says that of all channels.

    What is left of a real model repeats from stroke to stroke, and would stand out of errors that are independent,
    however small it is.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> is_good_enough(explain_example().best)
    False
    """
    stated, left = list_discrepancies(model.residuals.noise), find_left(model)
    return all(sensor in stated and size <= stated[sensor] for sensor, size in left.items())
