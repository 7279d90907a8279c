"""Hum of the mains in records of a channel's noise: which frequency, how much, and the noise without it."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.signal import detrend

from apesim.studies.estimation.noise.process import Noise, apart, autoregressive, beside, drifting, sines

MAINS = (50.0, 60.0)
"""Frequencies at which hum is looked for [Hz]."""
TOLD_APART = 15.0
"""Power over that of the noise, by which one frequency has to take more than the other to be the only one."""
Record = list[tuple[np.ndarray, np.ndarray]]
"""Stretches of one record: values [SI] and times [s], (n,) float arrays each."""
EVIDENCE = 4.0
"""Deviations beyond chance by which a sine has to take power from the noise, to be a hum."""


class Records(NamedTuple):
    """What is known of a channel's noise."""

    noise: list[Record]
    """For each record its stretches of nothing but noise: values [SI] and times [s], (n,) float arrays each. The hum of
    a record has one phase."""
    source: str
    others: list[Record]
    """Further records that may show hum: in what repeats differ by, it is lost where their phases are alike."""
    drifts: bool
    """Whether each stretch may drift straight."""
    stated: float
    """Standard deviation that the user states [SI]; NaN: none."""
    explained: tuple[np.ndarray, ...] = ()
    """For each record, of one stretch, its rows of columns that were taken off all of them together, (n, k) float
    arrays; none: nothing was."""
    taken: tuple[np.ndarray, ...] = ()
    """For each record, of one stretch, orthonormal columns that were taken off it alone, (n, k) float arrays; none:
    nothing was."""


def mains_in(channels: Sequence[Records]) -> tuple[float, ...]:
    """Find the frequencies of the mains [Hz] that channels hum with; two where they are too short to tell which.

    Without hum there are none.
    """
    falls: dict[float, list[float]] = {frequency: [] for frequency in MAINS}
    chances: list[float] = []
    for records in channels:
        chances.append(2.0 * (len(records.noise) + len(records.others)))
        for frequency in MAINS:
            left, fitted, _, fall = _without_hum(records, (frequency,))
            quiet = _noise_of_stretches(left, records, fitted)
            # Coloured noise has more power at low frequencies than white: by this factor.
            gain = max(1.0, (quiet.spread[-1] / (1.0 - quiet.predictors[-1].sum())) ** 2)
            falls[frequency].append(fall / max(quiet.deviation**2 * gain, 1e-300))
    most = max(map(sum, falls.values()))
    best = max(MAINS, key=lambda frequency: sum(falls[frequency]))

    def is_seen(fall: float, chance: float) -> bool:
        return fall > chance + EVIDENCE * np.sqrt(2.0 * chance)

    each = zip(falls[best], chances, strict=True)
    if not channels or not (is_seen(most, sum(chances)) or any(is_seen(*pair) for pair in each)):
        return ()
    return tuple(frequency for frequency in MAINS if most - sum(falls[frequency]) < TOLD_APART)


def with_hum(records: Records, frequencies: tuple[float, ...]) -> Noise:
    """Estimate noise from stretches of nothing but noise, and hum of some frequencies [Hz]."""
    if not frequencies:
        return _noise_of_stretches([values for record in records.noise for values, _ in record], records)
    left, fitted, amplitudes, _ = _without_hum(records, frequencies)
    sizes = np.sqrt(np.mean(np.square(amplitudes), axis=0) / 2.0)
    found = _noise_of_stretches(left, records, fitted)
    return found._replace(hums=tuple(zip(frequencies, sizes.tolist(), strict=True)))


def going_on(records: Sequence[Record], rests: Sequence[Record], frequencies: tuple[float, ...]) -> float:
    """Find the power that the sines that fit whole records best take from their stretches at rest [SI squared].

    It is below 0 where the sines add some. Records of one stretch each, see `Records.noise`, and the stretches at rest
    of each, which are free to drift straight, are lists of (values, times); the frequencies of the sines are in Hz.

    A hum that goes on while the model rests, in the last 100 samples:

    >>> times = np.arange(0.0, 0.5, 1e-3)
    >>> values = np.sin(2.0 * np.pi * 50.0 * times)
    >>> round(going_on([[(values, times)]], [[(values[-100:], times[-100:])]], (50.0,)), -1)
    50.0
    """
    fall = 0.0
    for record, rest in zip(records, rests, strict=True):
        ((values, times),), ((left,), *_) = record, _without_sines(record, frequencies)
        for seen, at in rest:
            first = int(np.searchsorted(times, at[0]))
            bare, wave = detrend(seen), detrend((values - left)[first : first + len(seen)])
            fall += float(bare @ bare - (bare - wave) @ (bare - wave))
    return fall


def _noise_of_stretches(stretches: Sequence[np.ndarray], records: Records, fitted: Sequence[np.ndarray] = ()) -> Noise:
    """Estimate the noise of stretches as their records want it."""
    if records.explained:
        return beside(stretches, records.explained, records.source, fitted)
    if any(columns.size for columns in records.taken):
        return apart(stretches, records.taken, records.source, fitted, records.stated)
    if not records.drifts:
        return autoregressive(stretches, records.source, fitted)
    return drifting(stretches, records.source, fitted, records.stated)


def _without_hum(
    records: Records, frequencies: tuple[float, ...]
) -> tuple[list[np.ndarray], list[np.ndarray], list[np.ndarray], float]:
    """Take off all records the sines, of frequencies in Hz, that fit each best.

    Returns the stretches of the noise alone, what was fitted to each of them, (n, k), see `autoregressive`, the
    amplitudes of the sines of each record, and the power that the sines take.
    """
    left: list[np.ndarray] = []
    fitted: list[np.ndarray] = []
    amplitudes, fall = [], 0.0
    for number, record in enumerate([*records.noise, *records.others]):
        rest, columns, amplitude, taken = _without_sines(record, frequencies)
        if number < len(records.noise):
            left += rest
            fitted += columns
        fall += taken
        amplitudes.append(amplitude)
    return left, fitted, amplitudes, fall


def _without_sines(
    record: Record, frequencies: tuple[float, ...]
) -> tuple[list[np.ndarray], list[np.ndarray], np.ndarray, float]:
    """One record without sines, each stretch of which is free to drift straight."""
    times = np.concatenate([t for _, t in record])
    drift = np.zeros((len(times), 2 * len(record)))
    ends = np.cumsum([0, *(len(t) for _, t in record)])
    for k, (first, end) in enumerate(pairwise(ends)):
        drift[first:end, 2 * k] = 1.0
        drift[first:end, 2 * k + 1] = times[first:end] - times[first:end].mean()
    values = np.concatenate([v for v, _ in record])
    straight = values - drift @ np.linalg.lstsq(drift, values, rcond=None)[0]
    columns = np.column_stack([*(sines(frequency, times) for frequency in frequencies), drift])
    weights, *_ = np.linalg.lstsq(columns, values, rcond=None)
    left, sizes = values - columns @ weights, weights[: 2 * len(frequencies)]
    taken = float(straight @ straight - left @ left)
    fitted = np.linalg.qr(columns)[0]
    parts = [[part[first:end] for first, end in pairwise(ends)] for part in (left, fitted)]
    return parts[0], parts[1], np.hypot(sizes[::2], sizes[1::2]), taken
