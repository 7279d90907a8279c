"""Noise as a process: its standard deviation, its colour, and hum of the mains, taken off by `whitened`.

The colour is that of an autoregressive process of up to `MAX_ORDER` terms (Yule and Walker's equations by Levinson's
recursion, its order by Schwarz's criterion). Hum is a sine of unknown amplitude and phase in each run; it joins the
covariance of the noise, so that nothing has to be fitted; `apesim gap explain` alone looks for it.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import toeplitz

MAX_ORDER = 12
ENOUGH = 60
"""Samples that are needed to tell a colour."""
STRETCH = 20
"""Samples of the shortest stretch at rest."""
DOUBT = 10.0
"""Factor on the doubt of orders that may come from the drifts taken off."""
SAME = 1e-8
"""Size of a column over the largest below which others say all of it."""
BEHIND_GAPS = 4
"""Samples over the order from which one behind a gap is predicted: with twice the order 0.9 % of the covariance is left
where three of ten samples are missing, with four times less than 0.001 %."""
FORGOTTEN = 10_000
"""Samples after which noise has forgotten, so that what came before a longer gap says nothing."""
UNEVEN = 0.01
"""Spread of the sampling intervals over their median, from which they are not one."""
LONG_ORDER = 48
"""Samples from which one is predicted where noise has a colour and a part without: such a sum has no end of them."""
PIECES, PIECES_ALIKE = 50, 10.0
"""Pieces of a record over which a model's own error is constant, and over how many of them it stays alike: a fifth of
the record, as a phase of a stroke or a cycle does."""
CORRELATIONS = np.linspace(-0.9, 0.97, 188)
"""Correlations of neighbours, among which the most probable is chosen."""
Group = Sequence[tuple[np.ndarray, np.ndarray]]
"""Stretches (n,) that share the weights of some columns (n, k), each with its own."""


class Noise(NamedTuple):
    """Noise of a channel at a sampling interval, as an autoregressive process."""

    deviation: float
    """Standard deviation [SI]."""
    predictors: tuple[np.ndarray, ...]
    """Weights of the samples before, the last one first, in the best prediction of a sample: one array for each order
    0, 1, ..."""
    spread: np.ndarray
    """Standard deviation of each order's error of prediction, over the deviation."""
    source: str
    """Source of deviation and colour."""
    hums: tuple[tuple[float, float], ...] = ()
    """Frequency [Hz] of each hum, and the standard deviation of the amplitudes of its sine and cosine [SI]."""
    samples: float = np.inf
    """Number of independent samples from which deviation and colour are; inf: they are taken for known."""
    is_stated: bool = False
    """Whether the deviation is known, and the colour the one that samples show then."""
    discrepancy: float = 0.0
    """Standard deviation by which the model may be off besides [SI]: half of the variance from sample to sample, half
    slowly, see `list_slow_columns`."""

    @property
    def order(self) -> int:
        """Number of terms of the autoregressive process."""
        return len(self.predictors) - 1

    @property
    def colour(self) -> float:
        """Correlation of neighbours."""
        return float(self.predictors[1][0]) if self.order else 0.0


def white(deviation: float, source: str, samples: float = np.inf) -> Noise:
    """Make white noise, without colour and without hum, of a standard deviation [SI] and its source for reports.

    The deviation is from so many independent `samples`; inf: it is taken for known.
    """
    return Noise(deviation, (np.zeros(0),), np.ones(1), source, samples=samples)


def levinson(correlation: np.ndarray) -> tuple[tuple[np.ndarray, ...], np.ndarray]:
    """Find the best linear predictors of all orders of a stationary process, by Levinson's recursion.

    From the correlations 1, c_1, ..., c_n of samples 0 to n apart it gives for each order m the weights of the m
    samples before, the last one first, and the standard deviation of the error of prediction over that of the process.
    They solve Yule and Walker's equations (Levinson 1946, doi 10.1002/sapm1946251261) by ``k_m = (c_m - sum(w_i
    c_(m-i))) / v_(m-1)``, ``v_m = v_(m-1) (1 - k_m^2)``, and end where the correlations belong to no process;
    `scipy.linalg.solve_toeplitz` solves for one order, and does not tell.

    >>> predictors, spread = levinson(np.array([1.0, 0.5, 0.5]))
    >>> [weights.round(3).tolist() for weights in predictors], spread.round(3).tolist()
    ([[], [0.5], [0.333, 0.333]], [1.0, 0.866, 0.816])
    """
    predictors, variance = [np.zeros(0)], [1.0]
    for order in range(1, len(correlation)):
        last = predictors[-1]
        reflection = (correlation[order] - last @ correlation[order - 1 : 0 : -1]) / variance[-1]
        if abs(reflection) >= 1.0:  # estimated correlations need not belong to any process
            break
        predictors.append(_lengthen(last, reflection))
        variance.append(variance[-1] * (1.0 - reflection**2))
    return tuple(predictors), np.sqrt(variance)


def _lengthen(weights: np.ndarray, reflection: float) -> np.ndarray:
    """Weights of the next order, by Levinson's step."""
    return np.append(weights - reflection * weights[::-1], reflection)


def _predict_by(reflections: np.ndarray) -> tuple[tuple[np.ndarray, ...], np.ndarray]:
    """Predictors of all orders, and the standard deviations of their errors, as `levinson` has them."""
    predictors = accumulate(reflections, _lengthen, initial=np.zeros(0))
    return tuple(predictors), np.sqrt(np.cumprod(np.append(1.0, 1.0 - reflections**2)))


def autoregressive(
    segments: Sequence[np.ndarray], source: str, fitted: Sequence[np.ndarray] = (), doubt: float = 0.0
) -> Noise:
    """Estimate noise as an autoregressive process from stretches of nothing but noise [SI]; `source` is for reports.

    The order m is that of the least ``n ln(v_m) + m ln(n)`` (Schwarz 1978, doi 10.1214/aos/1176344136), with n samples
    and the variance v_m of the error of prediction, see `levinson`; `doubt` is a further price of an order beyond the
    first. Fewer than `ENOUGH` samples tell no colour. `fitted` are for each stretch the rows, (n, k), of the
    orthonormal columns that were fitted and taken off (none: nothing was), whose correlations are added again.
    """
    samples = sum(map(len, segments))
    free = max(samples - _lagged(fitted, 0), 1.0)  # orthonormal columns: as many as were fitted
    deviation = float(np.sqrt(sum(s @ s for s in segments) / free))
    if deviation == 0.0 or samples < ENOUGH:
        return white(deviation, source, free)
    most = min(MAX_ORDER, min(map(len, segments)) // 4)
    lagged = [
        (_lagged(segments, lag) / deviation**2 + _lagged(fitted, lag)) / (samples - lag * len(segments))
        for lag in range(most + 1)
    ]
    predictors, spread = levinson(np.array(lagged) / lagged[0])
    criterion = samples * np.log(spread**2) + np.arange(len(spread)) * np.log(samples)
    criterion[2:] += doubt
    order = int(np.argmin(criterion))
    return Noise(deviation, predictors[: order + 1], spread[: order + 1], source, samples=free)


def take_deviation(noise: Noise, deviation: float) -> Noise:
    """Take a standard deviation [SI] that is known for noise whose colour samples tell; the order stays.

    Samples tell how far each is from its prediction much better than how far slow noise wanders. So the weights are
    those that are most probable at the deviation d (conditional likelihood, Brockwell and Davis 1991, doi
    10.1007/978-1-4419-0320-4, section 8.7): least is ``s^2 (1 - 2 w'c + w'Cw) / (d^2 v) + ln v``, with the deviation s
    and the correlations c, C of the samples, and the variance v of the error of prediction over that of a process of
    such weights.

    Few samples, which by chance wander farther than noise whose neighbours have a correlation of 0.9:

    >>> seen = Noise(1.11, (np.zeros(0), np.array([0.92])), np.array([1.0, 0.392]), "repeats")
    >>> known = take_deviation(seen, 1.0)
    >>> known.predictors[-1].round(2).tolist(), round(float(known.spread[-1]), 2)
    ([0.9], 0.43)
    >>> round(1.11 * 0.392, 2)  # what the samples show: it stays
    0.44
    """
    if not noise.order:
        return noise._replace(deviation=deviation, is_stated=True)
    from scipy.optimize import minimize

    correlation = _correlation(noise, noise.order)
    among, ahead = toeplitz(correlation[:-1]), correlation[1:]
    energy = (noise.deviation / deviation) ** 2

    def price(bends: np.ndarray) -> float:
        predictors, spread = _predict_by(np.tanh(bends))
        weights, variance = predictors[-1], spread[-1] ** 2
        error = 1.0 - 2.0 * weights @ ahead + weights @ among @ weights
        return float(energy * error / variance + np.log(variance))

    start = np.arctanh([weights[-1] for weights in noise.predictors[1:]])
    predictors, spread = _predict_by(np.tanh(minimize(price, start).x))
    return noise._replace(deviation=deviation, predictors=predictors, spread=spread, is_stated=True)


def _lagged(parts: Iterable[np.ndarray], lag: int) -> float:
    """Sum of the products of all samples with those so much later, within each of the parts."""
    return sum(float(np.sum(part[lag:] * part[: len(part) - lag])) for part in parts)


def drifting(
    stretches: Sequence[np.ndarray], source: str, fitted: Sequence[np.ndarray] = (), stated: float = np.nan
) -> Noise:
    """Estimate noise from stretches of noise, each of which may drift straight; the drifts take no colour off it.

    Levinson's recursion on what is left of the drifts takes slow noise for drift; for noise of the first order the
    correlation of neighbours is the most probable one whatever the drifts are (restricted likelihood, Patterson and
    Thompson 1971, doi 10.1093/biomet/58.3.545). Stretches and the standard deviation that is known (NaN: it is
    estimated) are in SI; `source` is for reports; `fitted` are the orthonormal columns, (n, k), that were fitted to
    each stretch, see `autoregressive`; none: the drifts alone.
    """
    straight = [_straight(len(values)) for values in stretches]
    bare = [values - line @ (line.T @ values) for values, line in zip(stretches, straight, strict=True)]
    return apart(bare, straight, source, fitted, stated)


def apart(
    records: Sequence[np.ndarray],
    columns: Sequence[np.ndarray],
    source: str,
    fitted: Sequence[np.ndarray] = (),
    stated: float = np.nan,
) -> Noise:
    """Estimate noise from what is left of records [SI] of each of which columns of its own were taken off.

    The columns, (n, k), are orthonormal; those that vary slowly take more from slow noise than from white, see
    `drifting`. `fitted` are all that were fitted to each record, where there are more; `stated` is a standard deviation
    that is known [SI], NaN: it is estimated; `source` is for reports.
    """
    groups = [[pair] for pair in zip(records, columns, strict=True)]
    return _coloured(records, groups, source, fitted or columns, stated)


def beside(
    records: Sequence[np.ndarray], columns: Sequence[np.ndarray], source: str, fitted: Sequence[np.ndarray] = ()
) -> Noise:
    """Estimate noise from records of which columns that all share were taken off, by one set of weights.

    For each record, (n,) [SI], `columns` holds its rows of what was taken off, (n, k), and `fitted` the orthonormal
    columns that were fitted to it alone besides, (n, m). The likelihood is that of `drifting`, restricted (Patterson
    and Thompson 1971, doi 10.1093/biomet/58.3.545); columns that vary slowly take more from slow noise than from white.
    """
    base, sizes, _ = np.linalg.svd(np.vstack(columns), full_matrices=False)
    ends = np.cumsum([len(values) for values in records])[:-1]
    rows = np.split(base[:, sizes > SAME * sizes[0]], ends)
    taken = [np.column_stack(own) for own in zip(rows, fitted, strict=True)] if fitted else rows
    return _coloured(records, [list(zip(records, rows, strict=True))], source, taken)


def _coloured(
    stretches: Sequence[np.ndarray],
    groups: Sequence[Group],
    source: str,
    fitted: Sequence[np.ndarray],
    stated: float = np.nan,
) -> Noise:
    """Noise from stretches that something was fitted to; of the first order the most probable, see `_most_probable`."""
    found = autoregressive(stretches, source, fitted, DOUBT)
    if found.order != 1 or found.samples < STRETCH:
        return found
    return _most_probable(groups, source, found.samples, stated)


def _most_probable(groups: Sequence[Group], source: str, free: float, stated: float) -> Noise:
    """Noise of the first order with the correlation that makes stretches most probable.

    It holds whatever the weights of some columns in them are: groups of stretches (n,) that share weights, each with
    its columns (n, k).
    """
    sums = []
    for group in groups:
        wholes = [np.column_stack([columns, values]) for values, columns in group]
        once = sum(whole.T @ whole for whole in wholes)
        lagged = sum(whole[1:].T @ whole[:-1] for whole in wholes)
        twice = sum(whole[1:-1].T @ whole[1:-1] for whole in wholes)
        sums.append((once, lagged + lagged.T, twice, len(group)))
    best = -np.inf, 0.0, 0.0
    for correlation in CORRELATIONS:
        energy = volume = 0.0
        for once, lagged, twice, number in sums:
            whole = once - correlation * lagged + correlation**2 * twice
            inner, across = whole[:-1, :-1], whole[:-1, -1]
            energy += whole[-1, -1] - across @ np.linalg.solve(inner, across)
            volume += np.linalg.slogdet(inner)[1] - number * np.log(1.0 - correlation**2)
        variance = energy / free if np.isnan(stated) else stated**2 * (1.0 - correlation**2)
        likelihood = -0.5 * (energy / variance + free * np.log(variance) + volume)
        if likelihood > best[0]:
            best = likelihood, correlation, energy / free
    _, correlation, variance = best
    spread = np.array([1.0, np.sqrt(1.0 - correlation**2)])
    weights = np.zeros(0), np.array([correlation])
    whole = float(np.sqrt(variance) / spread[1])
    return Noise(whole, weights, spread, source, samples=free, is_stated=not np.isnan(stated))


def _straight(n: int) -> np.ndarray:
    """Orthonormal columns of a constant and a slope, (n, 2)."""
    return np.linalg.qr(np.column_stack([np.ones(n), np.linspace(-1.0, 1.0, n)]))[0]


class Whitening:
    """Whitening of samples at `times` [s]: the noise's standard deviation, its colour and its hum taken off.

    Sample i becomes the error of its best prediction from the m samples before it, over the standard deviation of that
    error, ``(y_i - sum(w_j y_(i-j), j = 1..m)) / (deviation spread_m)``; m is the order of the noise, or i where fewer
    come before (innovations, Brockwell and Davis 1991, doi 10.1007/978-1-4419-0320-4, chapter 5). Hum adds sines W of
    random size to the covariance, which becomes ``1 + W W'``, and so does the slow half of a discrepancy; the result is
    multiplied by ``(1 + W W')^(-1/2)``. Where samples are missing among evenly spaced ones, each is predicted from
    those that are there; at other uneven times the correlation of neighbours falls exponentially with time, and hum is
    left as it is.

    >>> red = Noise(2.0, (np.zeros(0), np.array([0.8])), np.array([1.0, 0.6]), "stated")
    >>> Whitening(red, np.arange(3.0)).whiten(np.array([[2.0], [2.8], [1.04]])).ravel().round(6).tolist()
    [1.0, 1.0, -1.0]
    """

    def __init__(self, noise: Noise, times: np.ndarray) -> None:
        self.noise, self.times = add_fast_half(noise), times
        self.is_even = not noise.order or _is_even(times)
        places = None if self.is_even else _find_places(times)
        self.predictions = None if places is None else list(_predict_at(self.noise, places))
        self.common: tuple[np.ndarray, np.ndarray] | None = None
        waves = [np.empty((len(times), 0))]
        if self.is_even or self.predictions is not None:
            waves += [sines(frequency, times) * deviation for frequency, deviation in noise.hums]
        if noise.discrepancy:
            waves.append(list_slow_columns(len(times), noise.discrepancy * np.sqrt(0.5)))
        whole = np.column_stack(waves)
        if whole.size:
            left, sizes, _ = np.linalg.svd(self._whiten_samples(whole), full_matrices=False)
            self.common = left, 1.0 / np.sqrt(1.0 + sizes**2) - 1.0

    def whiten(self, columns: np.ndarray) -> np.ndarray:
        """Whiten columns, (n, k) [SI], into (n, k) [standard deviations]."""
        filtered = self._whiten_samples(columns)
        if self.common is None:
            return filtered
        left, shares = self.common
        return filtered + left @ (shares[:, None] * (left.T @ filtered))

    def _whiten_samples(self, columns: np.ndarray) -> np.ndarray:
        """Whiten what is not common to many samples, see `whiten`."""
        noise, filtered = self.noise, columns.astype(float)
        if self.is_even:
            for lag, weight in enumerate(noise.predictors[-1], 1):
                filtered[lag:] -= weight * columns[:-lag]
            filtered /= noise.spread[-1]
            for i in range(min(noise.order, len(columns))):
                filtered[i] = (columns[i] - noise.predictors[i] @ columns[:i][::-1]) / noise.spread[i]
            filtered /= noise.deviation
        elif self.predictions is not None:
            for i, (first, weights, deviation) in enumerate(self.predictions):
                filtered[i] = (columns[i] - weights @ columns[first:i]) / deviation
        else:
            return _whitened_uneven(noise, filtered, self.times)
        return filtered


def add_fast_half(noise: Noise) -> Noise:
    """Noise with the half of its discrepancy that differs from sample to sample.

    The sum of a process and of what is independent has the process's covariances but for the variance; its predictors
    follow from these, see `levinson`, up to `LONG_ORDER` samples.

    >>> red = Noise(1.0, (np.zeros(0), np.array([0.8])), np.array([1.0, 0.6]), "stated", discrepancy=2.0**0.5)
    >>> whole = add_fast_half(red)
    >>> round(whole.deviation**2, 3), round(whole.colour, 3)
    (2.0, 0.4)
    """
    if not noise.discrepancy:
        return noise
    variance = noise.deviation**2 + 0.5 * noise.discrepancy**2
    noise, share = noise._replace(deviation=float(np.sqrt(variance))), noise.deviation**2 / variance
    if not noise.order:
        return noise
    correlation = share * _correlation(noise, max(LONG_ORDER, noise.order))
    correlation[0] = 1.0
    predictors, spread = levinson(correlation)
    return noise._replace(predictors=predictors, spread=spread)


def _is_even(times: np.ndarray) -> bool:
    """Whether samples come at one interval."""
    intervals = np.diff(times)
    return len(intervals) < 2 or bool(np.ptp(intervals) < UNEVEN * np.median(intervals))


def _find_places(times: np.ndarray) -> np.ndarray | None:
    """Places of samples on an even grid of which some are missing, (n,) int array; None: they stand on none."""
    intervals = np.diff(times)
    steps = intervals / np.min(intervals)
    whole = np.rint(steps)
    if np.max(np.abs(steps - whole)) > UNEVEN:
        return None
    return np.append(0, np.cumsum(whole)).astype(np.int64)


def _predict_at(noise: Noise, places: np.ndarray) -> Iterator[tuple[int, np.ndarray, float]]:
    """Best prediction of each sample at places of an even grid, from those that are there before it.

    Yields the first sample that it takes, the weights of all from there on, and the standard deviation of its error.
    """
    order = noise.order
    correlation = _correlation(noise, min(int(places[-1]), FORGOTTEN))
    known: dict[bytes, tuple[np.ndarray, float]] = {}
    for i, place in enumerate(places):
        is_whole = i >= order and place - places[i - order] == order
        first = max(0, i - (order if is_whole else BEHIND_GAPS * order))
        lags = place - places[first:i]
        lags = lags[lags < len(correlation)]
        if lags.tobytes() not in known:
            among, to = correlation[np.abs(lags[:, None] - lags)], correlation[lags]
            weights = np.linalg.solve(among, to) if len(lags) else to
            known[lags.tobytes()] = weights, noise.deviation * float(np.sqrt(1.0 - weights @ to))
        yield i - len(lags), *known[lags.tobytes()]


def _correlation(noise: Noise, reach: int) -> np.ndarray:
    """Correlations of samples 0 to reach apart, (reach + 1,) array, of which `levinson` makes the predictors again."""
    correlation = np.ones(reach + 1)
    for lag in range(1, reach + 1):
        weights = noise.predictors[min(lag, noise.order + 1) - 1]
        correlation[lag] = weights @ correlation[lag - 1 :: -1][: len(weights)]
        if lag <= noise.order:
            correlation[lag] += noise.predictors[lag][-1] * noise.spread[lag - 1] ** 2
    return correlation


def _whitened_uneven(noise: Noise, columns: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Whiten columns of samples that come at different intervals: the correlation of neighbours fades with time."""
    intervals = np.diff(times)
    correlation = (max(noise.colour, 0.0) ** (intervals / np.median(intervals)))[:, None]
    innovations = (columns[1:] - correlation * columns[:-1]) / np.sqrt(1.0 - correlation**2)
    return np.vstack([columns[:1], innovations]) / noise.deviation


def list_slow_columns(samples: int, size: float) -> np.ndarray:
    """The columns D, (samples, k), of a slow error of standard deviation `size` [SI]: its covariance is ``D D'``.

    It is constant over each of up to `PIECES` pieces of a record; the correlation of two pieces falls by e over
    `PIECES_ALIKE` of them.

    >>> columns = list_slow_columns(200, 0.3)
    >>> covariance = columns @ columns.T
    >>> covariance[0, [0, 3, 40, 199]].round(3).tolist()
    [0.09, 0.09, 0.033, 0.001]
    """
    pieces = np.arange(min(PIECES, samples))
    correlation = np.exp(-np.abs(pieces[:, None] - pieces) / PIECES_ALIKE)
    lengths = [len(part) for part in np.array_split(np.arange(samples), len(pieces))]
    return size * np.repeat(np.linalg.cholesky(correlation), lengths, axis=0)


def sines(frequency: float, times: np.ndarray) -> np.ndarray:
    """Sine and cosine of a frequency [Hz] at given times (n,) [s], (n, 2)."""
    angle = 2.0 * np.pi * frequency * times
    return np.column_stack([np.sin(angle), np.cos(angle)])


def noise_for(noise: Mapping[str, Mapping[float, Noise]], block: Any) -> Noise:
    """The noise of a block: that of its sensor, at the nearest sampling interval [s].

    `noise` is by sensor and sampling interval [s], `block` an `apesim.studies.estimation.residuals.Block`.
    """
    known = noise[block.sensor]
    return known[min(known, key=lambda interval: abs(interval - block.interval))]
