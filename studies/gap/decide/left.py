"""What a model leaves of each channel, in the unit of the channel, against what it may be off by."""

import numpy as np

from apesim.studies.estimation.model import Model
from apesim.studies.estimation.noise.discrepancy import list_discrepancies
from apesim.studies.gap.decide.windows import split_into_windows


def find_left(model: Model) -> dict[str, float]:
    """Find what a model leaves of each channel, noise averaged out [SI].

    It is the root mean square of the means over windows of each run, of measured less predicted.
    """
    squares: dict[str, list[np.ndarray]] = {}
    for block, predicted in zip(model.residuals.blocks, model.residuals.predicted(model.fitted.x), strict=True):
        means = [window.mean() for window in split_into_windows(block.values - predicted)]
        squares.setdefault(block.sensor, []).append(np.square(means))
    return {sensor: float(np.sqrt(np.mean(np.concatenate(every)))) for sensor, every in squares.items()}


def is_good_enough(model: Model) -> bool:
    """Whether a model leaves no more of each channel than the user lets it be off, who says that of all channels.

    What is left of a real model repeats from stroke to stroke, and would stand out of errors that are independent,
    however small it is.

    >>> from apesim.studies.gap.example_bench import explain_example
    >>> is_good_enough(explain_example().best)
    False
    """
    stated = list_discrepancies(model.residuals.noise)
    if not stated.keys() >= {block.sensor for block in model.residuals.blocks}:
        return False
    return all(size <= stated[sensor] for sensor, size in find_left(model).items())
