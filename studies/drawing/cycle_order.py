"""Order of a cycle's rows for figures over the crank angle."""

import numpy as np

TRACE_START = -90.0
"""Crank angle at which a cycle is drawn from [deg]: before all intakes open, so that none is cut in two."""


def order_of_cycle(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Order the rows of a closed cycle from `TRACE_START` on, and give their crank angles [deg], (n,) each.

    The last row of the cycle is the first one, a turn later; so is that of what is given.

    >>> order, angles = order_of_cycle(np.array([0.0, 90.0, 180.0, 270.0, 360.0]))
    >>> order.tolist(), angles.tolist()
    ([3, 0, 1, 2, 3], [-90.0, 0.0, 90.0, 180.0, 270.0])
    """
    order = np.argsort((angles[:-1] - TRACE_START) % 360.0, kind="stable")
    ordered = (angles[order] - TRACE_START) % 360.0 + TRACE_START
    return np.append(order, order[0]), np.append(ordered, ordered[0] + 360.0)
