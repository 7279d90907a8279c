"""Levels, noise and edges of a signal, so that neither noise nor single samples decide."""

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from apesim.studies.measured.plausibility import thresholds as limits
from apesim.studies.measured.runs import MeasuredRun

WIDTH = 5
"""Samples of the running median: spikes of two samples do not pass it."""
LASTING = 3
"""Samples that a signal stays beyond a level, to have crossed it."""
GAUSSIAN = 1.4826
"""Standard deviation over the median of the absolute values, of Gaussian noise."""


class Edges(NamedTuple):
    """When a signal that leaves its rest and comes back crosses half of its span."""

    leaves: float
    """First crossing [s]; NaN: it does not cross, or in a gap, or stands beyond at its first known sample."""
    returns: float
    """Last crossing back [s], as a chamber's pressure dips while the piston flies; NaN: it does not stay back, or
    comes back in a gap."""
    begins: float
    """When it begins to leave its rest [s]; NaN: never."""
    starts_away: bool
    """Whether it is away from its rest at its first known sample."""


def select_judged(run: MeasuredRun) -> dict[str, np.ndarray]:
    """Channels of a run that something can be judged by: enough samples are known, and they differ.

    Values (n,) by sensor [SI], NaN where a sample is missing.

    >>> channels = {"lift": np.arange(9.0), "velocity": np.zeros(9), "pressure_a": np.full(9, np.nan)}
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 5e-3, "fit", np.arange(9) * 1e-3, channels)
    >>> list(select_judged(run))
    ['lift']
    """
    return {
        name: values
        for name, values in run.channels.items()
        if np.isfinite(values).sum() >= limits.MIN_SAMPLES and find_span(values) > 0.0
    }


def fill(values: np.ndarray) -> np.ndarray:
    """Values (n,) with missing ones (NaN) interpolated; one at least must be known."""
    known = np.isfinite(values)
    places = np.arange(len(values))
    return values if known.all() else np.interp(places, places[known], values[known])


def smooth(values: np.ndarray) -> np.ndarray:
    """Running median of a signal (n,), over missing samples as if they were interpolated; NaN where one is missing."""
    half = WIDTH // 2
    smoothed = np.median(sliding_window_view(np.pad(fill(values), half, mode="edge"), WIDTH), axis=1)
    return np.where(np.isfinite(values), smoothed, np.nan)


def find_span(values: np.ndarray) -> float:
    """Difference between the largest and the smallest known value of a signal (n,), NaN where missing; 0 if all are."""
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) if len(known) else 0.0


def find_levels(values: np.ndarray) -> tuple[float, float]:
    """Lowest and highest level of a signal (n,), in its unit; NaN where a sample is missing."""
    low, high = np.nanquantile(smooth(values), (limits.LEVEL_SHARE, 1.0 - limits.LEVEL_SHARE))
    return float(low), float(high)


def find_noise(values: np.ndarray) -> float:
    """Standard deviation of the noise of a signal, taken for white, by its fourth differences.

    It is in the signal's unit; 0 below five known samples.

    >>> noise = np.random.default_rng(1).normal(0.0, 0.03, 4000)
    >>> round(find_noise(noise + np.linspace(0.0, 9.0, 4000)), 2)
    0.03
    """
    for differences in (np.diff(values, 4), np.diff(values[np.isfinite(values)], 4)):
        known = differences[np.isfinite(differences)]
        if len(known):
            return float(_of_differences(known))
    return 0.0


def find_noises(signals: np.ndarray) -> np.ndarray:
    """Standard deviations of the noise (m,) of many signals (m, n) without missing samples, see `find_noise`."""
    return _of_differences(np.diff(signals, 4))


def _of_differences(differences: np.ndarray) -> np.ndarray:
    """Standard deviations of white noise by fourth differences (…, n)."""
    return GAUSSIAN * np.median(np.abs(differences), axis=-1) / np.sqrt(70.0)


def find_edges(times: np.ndarray, values: np.ndarray, *, rises: bool, noise: float = 0.0) -> Edges:
    """Find when a signal leaves its rest and comes back to it, at `times` [s].

    `rises` tells that the signal is low at rest; `noise` is the standard deviation of its noise, in its unit.

    >>> times = np.arange(0.0, 10.0)
    >>> find_edges(times, np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]), rises=True)
    Edges(leaves=2.5, returns=6.5, begins=3.0, starts_away=False)
    """
    known = np.isfinite(values)
    times, smoothed = times[known], smooth(values)[known] * (1.0 if rises else -1.0)
    low, high = np.quantile(smoothed, (limits.LEVEL_SHARE, 1.0 - limits.LEVEL_SHARE))
    away = smoothed - low
    leaves = _crossing(times, away - 0.5 * (high - low))
    beyond = leaves is not None and leaves == times[0] and away[0] > 0.5 * (high - low)
    returns = None if leaves is None else _last_return(times, away - 0.5 * (high - low))
    begun = _lasting(away > max(limits.MOVED * (high - low), limits.MIN_NOISES_MOVED * noise))
    return Edges(
        np.nan if leaves is None or beyond else leaves,
        np.nan if returns is None else returns,
        np.nan if begun is None else float(times[begun]),
        begun == 0,
    )


def find_correlation(values: np.ndarray, others: np.ndarray) -> float:
    """Correlation of two signals where both are known; 0 where one of them is constant."""
    known = np.isfinite(values) & np.isfinite(others)
    if not known.any():
        return 0.0
    one, other = values[known] - values[known].mean(), others[known] - others[known].mean()
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    return float(one @ other) / size if size > 0.0 else 0.0


def _lasting(beyond: np.ndarray) -> int | None:
    """Place from which something holds for `LASTING` samples; None: nowhere."""
    if len(beyond) < LASTING:
        return None
    found = np.flatnonzero(sliding_window_view(beyond, LASTING).all(axis=1))
    return int(found[0]) if len(found) else None


def _crossing(times: np.ndarray, values: np.ndarray) -> float | None:
    """When a signal rises above zero for `LASTING` samples; its first time where it is above from there.

    None: it does not, or in a gap.
    """
    place = _lasting(values > 0.0)
    if place is None:
        return None
    if place == 0:
        return float(times[0])
    step = times[place] - times[place - 1]
    if step > max(limits.MIN_GAP * np.median(np.diff(times)), limits.MIN_BLIND):
        return None
    below, above = values[place - 1], values[place]
    return float(times[place - 1] + step * (-below / (above - below) if above > below else 1))


def _last_return(times: np.ndarray, values: np.ndarray) -> float | None:
    """When a signal falls below zero for good; None: it does not."""
    turned = _crossing(-times[::-1], values[::-1])
    return None if turned is None or -turned == times[-1] else -turned
