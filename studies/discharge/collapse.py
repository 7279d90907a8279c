"""Whether the curves of several discharge tests fall on one another (Fig. 4 of doi 10.1631/jzus.A0820373)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from apesim.studies.discharge.area import NORMAL_95, AreaFit


class Collapse(NamedTuple):
    """How well the curves of several tests fall on one another, where all of them are reported."""

    rms: float
    """Root mean square of the differences from their mean, over the full area."""
    largest_spread: float
    """Between the highest and the lowest, over the full area."""
    expected_spread: float
    """What the noise alone makes of the largest spread, 95 %, over the full area."""
    within_bands: float
    """Share of points at which two curves differ by less than their bands allow, over all pairs; 95 % is due."""
    agree: bool
    """Whether no two differ anywhere by more than the noise does in 95 % of cases (simultaneous)."""


def collapse_of(fits: Sequence[AreaFit], end: float, full_area: float) -> Collapse:
    """Find how well the curves of several tests, at the same knots, fall on one another, as in [EPV, Fig. 4].

    All are reported until `end` [s]; `full_area` [m2] is that of the open valve. The result is the spread of the
    curves, and what their noise alone makes of it.

    Two fits with a standard deviation of 0.1 mm^2 that differ by 0.05 mm^2:

    >>> knots, area, sigma = np.linspace(0.0, 4e-3, 5), 1e-6 * np.array([0.0, 3.0, 6.0, 9.0, 9.0]), 1e-7
    >>> half_band, covariance = np.full(5, 1.96 * sigma), sigma**2 * np.eye(5)
    >>> first = AreaFit(knots, area, half_band, covariance, np.zeros(1), [], 1.0)
    >>> collapse = collapse_of([first, first._replace(area=area + 5e-8)], 4e-3, 9e-6)
    >>> round(collapse.largest_spread, 4), collapse.within_bands, collapse.agree
    (0.0056, 1.0, True)
    """
    part = slice(1, int(np.searchsorted(fits[0].knots, end, side="right")))
    curves, halves = (np.stack([getattr(fit, name)[part] for fit in fits]) for name in ("area", "half_band"))
    random = np.random.default_rng(0)
    noise = []
    for fit in fits:
        values, vectors = np.linalg.eigh(fit.covariance[part, part])
        factor = vectors * np.sqrt(np.clip(values, 0.0, None))
        noise.append(random.standard_normal((1000, len(values))) @ factor.T)
    sigmas = [np.sqrt(np.diag(fit.covariance)[part]) for fit in fits]
    pairs = [(i, j) for i in range(len(fits)) for j in range(i)]
    largest_drawn, within, largest = np.zeros(1000), [], 0.0
    for i, j in pairs:
        both = np.hypot(sigmas[i], sigmas[j])
        largest_drawn = np.maximum(largest_drawn, np.max(np.abs(noise[i] - noise[j]) / both, axis=1))
        wide = np.hypot(halves[i], halves[j])
        within.append(np.abs(curves[i] - curves[j]) <= wide)
        largest = max(largest, np.max(np.abs(curves[i] - curves[j]) / wide) * NORMAL_95)
    spreads = np.ptp(np.stack(noise), axis=0).max(axis=1)
    return Collapse(
        float(np.sqrt(np.mean((curves - curves.mean(axis=0)) ** 2)) / full_area),
        float(np.ptp(curves, axis=0).max() / full_area),
        float(np.quantile(spreads, 0.95) / full_area),
        float(np.mean(within)),
        bool(largest <= np.quantile(largest_drawn, 0.95)),
    )
