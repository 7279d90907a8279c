"""The error is the tolerance's: measured against 1e-13, no model has to be believed."""

import numpy as np

from tests.acceptance.convergence import convergence_table

MAX_ERROR = 30.0
"""Error over tolerance: the errors of some hundred steps add up."""
LOCATED = 1e-9
"""What is left at the tightest tolerances: events are located to 1e-12 s, a thousandth of a millionth of a cycle."""


def worst(results):
    return np.max(list(results.values()), axis=0)


def slopes(tolerances, errors):
    return {name: np.polyfit(np.log(tolerances), np.log(worst(each)), 1)[0] for name, each in errors.items()}


def test_error_stays_within_thirty_tolerances():
    tolerances, errors = convergence_table()
    for name, results in errors.items():
        assert np.all(worst(results) <= MAX_ERROR * tolerances + LOCATED), name


def test_error_is_proportional_to_the_tolerance():
    """The fifth order result of an error estimate that is held to the tolerance has slope 1.

    Without the longest step, which holds the error at loose tolerances far below them and so lowers the slope. A
    breakpoint or contact that is stepped over has at best slope 1/2, and one that is located to a fixed error none.
    """
    for name, slope in slopes(*convergence_table(longest_step=1.0)).items():
        assert 0.75 < slope < 1.15, (name, slope)
