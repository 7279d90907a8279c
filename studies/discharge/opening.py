"""From an effective area to a curve that the valve can be run with: its cut-off, its plateau, its rise."""

from typing import NamedTuple

import numpy as np

from apesim.studies.discharge.area import NORMAL_95, AreaFit, monotone

MIN_KNOTS = 5
"""Knots of the choked part that show a plateau, at least."""
MAX_OUTSIDE = 2.0
"""Distance from the plateau in half bands that an area within it has nowhere: four standard deviations."""
MIN_OUTSIDE = 0.02
"""Share of the plateau by which it has to be off as well: without noise, what smoothing does to a corner is as much."""
MAX_HALF_BAND = 0.2
"""Half the band over the full area, beyond which an area is not reported."""


def find_cut_off(fit: AreaFit, last: float, full_area: float) -> float:
    """Find until when [s] an area is reported: by half its band, and by the pressure, too low after `last` [s].

    It is the last knot at which half the band is at most `MAX_HALF_BAND` of the area of the open valve [m2].

    >>> knots, area = np.linspace(0.0, 4e-3, 5), 1e-6 * np.array([0.0, 3.0, 6.0, 9.0, 9.0])
    >>> half_band = 1e-6 * np.array([0.0, 0.2, 0.2, 0.3, 4.0])
    >>> find_cut_off(AreaFit(knots, area, half_band, np.zeros((5, 5)), np.zeros(1), [], 1.0), 4e-3, 9e-6)
    0.003
    """
    reported = np.flatnonzero((fit.half_band <= MAX_HALF_BAND * max(full_area, 0.0)) & (fit.knots <= last))
    return float(fit.knots[reported[-1]])


class Plateau(NamedTuple):
    """Part of an area that is constant: the valve is open."""

    start: int
    """First knot of it."""
    end: float
    """Time of its last knot [s]."""
    area: float
    """Mean weighted by the bands [m2]."""
    half_band: float
    """Half the width of its own band [m2]."""


def find_plateau(fit: AreaFit, end: float, choked: float) -> Plateau:
    """Find the plateau of an area, while the flow is choked, and beyond where it goes on alike.

    The area is reported until `end` [s], the flow is choked until `choked` [s].
    """
    whole = _find_constant(fit, end)
    if choked >= end or np.sum(fit.knots <= choked) <= MIN_KNOTS:
        return whole
    first = _find_constant(fit, choked)
    agree = abs(whole.area - first.area) <= MAX_OUTSIDE * np.hypot(whole.half_band, first.half_band)
    return whole if agree and not leaves_band(fit, whole) else first


def leaves_band(fit: AreaFit, plateau: Plateau) -> bool:
    """Tell whether an area is anywhere above its plateau, or falls from it, by more than its band allows."""
    last = int(np.searchsorted(fit.knots, plateau.end, side="right"))
    bands = np.hypot(fit.half_band[1:last], plateau.half_band)
    off = (fit.area[1:last] - plateau.area) / np.maximum(MAX_OUTSIDE * bands, MIN_OUTSIDE * abs(plateau.area))
    return bool(np.any(off > 1.0) or np.any(off[plateau.start :] < -1.0))


def _find_constant(fit: AreaFit, end: float) -> Plateau:
    """The part from which on nine of ten bands, else eight, hold the mean of what follows."""
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
    return Plateau(start, float(fit.knots[last - 1]), mean, float(NORMAL_95 * np.sqrt(variance)))


def cut(fit: AreaFit, end: float) -> AreaFit:
    """Take the knots of a fit until a time [s]."""
    last = int(np.searchsorted(fit.knots, end, side="right"))
    return fit._replace(
        knots=fit.knots[:last],
        area=fit.area[:last],
        half_band=fit.half_band[:last],
        covariance=fit.covariance[:last, :last],
    )


def opening_curve(fit: AreaFit, start: int, full_area: float) -> np.ndarray:
    """Make an area monotone (isotonic regression, weighted by the band), divide it by the full area [m2], and trim it.

    Columns are time [s], opening from 0 to 1, effective area, and low and high end of its band [m2]. The opening is 1
    from the knot `start` on, the first of the plateau, and 0 up to the last one before at which the area is not
    positive. The regression is SciPy's (Busing 2022, doi 10.18637/jss.v102.c01).

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
