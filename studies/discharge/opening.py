"""From an effective area to a curve that the valve can be run with: its cut-off, its plateau, its rise."""

import numpy as np

from apesim.studies.discharge.area import NORMAL_95, AreaFit, monotone

MAX_HALF_BAND = 0.2
"""Half the band over the full area, beyond which an area is not reported."""


def find_cut_off(fit: AreaFit, last: float, full_area: float) -> float:
    """Find until when an area is reported: by half its band, and by the pressure.

    Parameters
    ----------
    fit : AreaFit
        Effective area over time.
    last : float
        Time after which the pressure is too low [s].
    full_area : float
        Effective area of the open valve [m2].

    Returns
    -------
    float
        Last knot at which half the band is at most `MAX_HALF_BAND` of the full area [s].

    Examples
    --------
    >>> knots, area = np.linspace(0.0, 4e-3, 5), 1e-6 * np.array([0.0, 3.0, 6.0, 9.0, 9.0])
    >>> half_band = 1e-6 * np.array([0.0, 0.2, 0.2, 0.3, 4.0])
    >>> find_cut_off(AreaFit(knots, area, half_band, np.zeros((5, 5)), np.zeros(1), [], 1.0), 4e-3, 9e-6)
    0.003
    """
    reported = np.flatnonzero((fit.half_band <= MAX_HALF_BAND * max(full_area, 0.0)) & (fit.knots <= last))
    return float(fit.knots[reported[-1]])


def find_plateau(fit: AreaFit, end: float) -> tuple[int, float, float]:
    """Find from where on the area is constant within its bands.

    Parameters
    ----------
    fit : AreaFit
        Effective area over time.
    end : float
        Until when the area is reported [s].

    Returns
    -------
    start : int
        First knot at the mean of what follows, after one from which on nine of ten bands (else eight) hold that mean.
    mean, half_band : float
        Mean weighted by the bands, and half the width of its own band [m2].

    Examples
    --------
    >>> knots, area = np.linspace(0.0, 7e-3, 8), 1e-6 * np.array([0.0, 3.0, 6.0, 9.0, 9.0, 9.0, 9.0, 9.0])
    >>> fit = AreaFit(knots, area, np.full(8, 2e-7), 1e-14 * np.eye(8), np.zeros(1), [], 1.0)
    >>> start, mean, half_band = find_plateau(fit, 7e-3)
    >>> start, round(1e6 * mean, 3), round(1e6 * half_band, 2)
    (3, 9.0, 0.09)
    """
    last = int(np.searchsorted(fit.knots, end, side="right"))

    def mean_from(start: int) -> tuple[float, np.ndarray]:
        weights = 1.0 / fit.half_band[start:last] ** 2
        weights /= weights.sum()
        return float(weights @ fit.area[start:last]), weights

    half = max(2, int(np.searchsorted(fit.knots, end / 2.0)))
    searches = [(share, start) for share, to in ((0.9, half), (0.8, half), (0.9, last)) for start in range(1, to)]
    for share, start in searches:  # the second half, only if the first has no such knot
        mean, weights = mean_from(start)
        if np.mean(np.abs(fit.area[start:last] - mean) <= fit.half_band[start:last]) >= share:
            break
    start += int(np.argmax(fit.area[start:last] >= mean))  # the first of them may still rise
    mean, weights = mean_from(start)
    variance = weights @ fit.covariance[start:last, start:last] @ weights
    return start, mean, float(NORMAL_95 * np.sqrt(variance))


def opening_curve(fit: AreaFit, start: int, full_area: float) -> np.ndarray:
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

    Examples
    --------
    >>> knots, area = np.linspace(0.0, 4e-3, 5), 1e-6 * np.array([0.0, -0.1, 4.5, 9.0, 9.0])
    >>> fit = AreaFit(knots, area, np.full(5, 2e-7), np.zeros((5, 5)), np.zeros(1), [], 1.0)
    >>> opening_curve(fit, 3, 9e-6)[:, :2].tolist()
    [[0.001, 0.0], [0.002, 0.5], [0.003, 1.0]]
    """
    first = int(np.flatnonzero(fit.area[:start] <= 0.0)[-1])
    area = np.append(0.0, monotone(fit.area[1:], fit.half_band[1:]))
    opening = np.minimum(area / full_area, 1.0)
    opening[: first + 1], opening[start:] = 0.0, 1.0
    rise = slice(first, int(np.argmax(opening == 1.0)) + 1)
    area = opening * full_area
    low, high = (np.clip(fit.area + sign * fit.half_band, 0.0, None) for sign in (-1.0, 1.0))
    columns = fit.knots, opening, area, np.minimum(low, area), np.maximum(high, area)
    return np.column_stack([column[rise] for column in columns])
