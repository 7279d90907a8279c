"""From an effective area to a curve that the valve can be run with: until when it is told, its plateau, its rise."""

import numpy as np

from apesim.studies.discharge.area import DEVIATIONS, monotone

WIDEST = 0.2
"""Half the band over the full area, beyond which an area is not told."""


def told_until(fit, last, full_area):
    """Until when an area is told [s]: by half its band, and by the pressure, which is too low after `last` [s]."""
    told = np.flatnonzero((fit.half_band <= WIDEST * max(full_area, 0.0)) & (fit.knots <= last))
    return float(fit.knots[told[-1]])


def plateau(fit, end):
    """From where on the area is constant within its bands.

    Parameters
    ----------
    fit : AreaFit
    end : float
        Until when the area is told [s].

    Returns
    -------
    start : int
        The first knot at the mean of what follows, after one from which on nine of ten bands (else eight)
        hold that mean.
    mean, half_band : float
        Weighted by the bands [m2].
    """
    last = int(np.searchsorted(fit.knots, end, side="right"))

    def mean_from(start):
        weights = 1.0 / fit.half_band[start:last] ** 2
        weights /= weights.sum()
        return weights @ fit.area[start:last], weights

    half = max(2, int(np.searchsorted(fit.knots, end / 2.0)))
    searches = [(share, start) for share, to in ((0.9, half), (0.8, half), (0.9, last)) for start in range(1, to)]
    for share, start in searches:  # the second half of what is told, only if the first has no such knot
        mean, weights = mean_from(start)
        if np.mean(np.abs(fit.area[start:last] - mean) <= fit.half_band[start:last]) >= share:
            break
    start += int(np.argmax(fit.area[start:last] >= mean))  # the first of them may still rise
    mean, weights = mean_from(start)
    variance = weights @ fit.covariance[start:last, start:last] @ weights
    return start, float(mean), float(DEVIATIONS * np.sqrt(variance))


def opening_curve(fit, start, full_area):
    """The area made monotone (isotonic regression, weighted by the band), over the full area, and trimmed.

    The regression is SciPy's [1]_.

    Parameters
    ----------
    fit : AreaFit
    start : int
        First knot of the plateau, from which on the opening is 1. It is 0 up to the last one before at which the area
        is not positive.
    full_area : float
        [m2]

    Returns
    -------
    (m, 5) float array
        Time [s], opening from 0 to 1, effective area, low and high end of its band [m2].

    References
    ----------
    .. [1] F. M. T. A. Busing, "Monotone regression: a simple and fast O(n) PAVA implementation", J. Statist. Softw.
       102, 2022, code snippet 1, doi 10.18637/jss.v102.c01.
    """
    first = int(np.flatnonzero(fit.area[:start] <= 0.0)[-1])
    area = np.append(0.0, monotone(fit.area[1:], fit.half_band[1:]))
    opening = np.minimum(area / full_area, 1.0)
    opening[: first + 1], opening[start:] = 0.0, 1.0
    kept = slice(first, int(np.argmax(opening == 1.0)) + 1)
    area = opening * full_area
    low, high = (np.clip(fit.area + sign * fit.half_band, 0.0, None) for sign in (-1.0, 1.0))
    columns = fit.knots, opening, area, np.minimum(low, area), np.maximum(high, area)
    return np.column_stack([column[kept] for column in columns])
