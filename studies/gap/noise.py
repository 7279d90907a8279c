"""The noise of measured channels: its standard deviation, its colour, and hum of the mains.

The colour is that of an autoregressive process of up to `ORDER_MOST` terms (Yule and Walker's equations by Levinson's
recursion, its order by Schwarz's criterion), from the best source there is: what repeats of a run differ by, else what
was recorded before the trigger and in stretches in which the model stands still. Hum is a sine of unknown amplitude and
phase in each run; it joins the covariance of the noise, so that nothing has to be fitted.
"""

from itertools import pairwise
from math import log
from typing import NamedTuple

import numpy as np

ORDER_MOST = 12
LIKE = 1.5
"""Ratio of sampling intervals that count as one."""
ENOUGH = 60
"""Samples that are needed to tell a colour."""
STRETCH = 20
"""Samples of the shortest stretch at rest."""
STILL = 0.005
"""Of the noise: what the model may move by from one sample to the next at rest."""
MAINS = (50.0, 60.0)
"""Frequencies at which hum is looked for [Hz]."""
OF_A_MEAN = 0.01
"""Share of a mean over the cycle that its noise is taken for, where nothing tells it."""
FEWEST_CONTRASTS = 4
TAKEN_FOR_WHITE = "second differences, taken for white"
GUARD = 2e-3
"""Between a motion of the model and a stretch at rest [s]: the measured motion may be that late."""
HUM_EVIDENCE = 4.0
"""Deviations beyond chance by which a sine has to take power from the noise, to be a hum."""
FLOOR = {
    "lift": 1e-8,
    "velocity": 1e-6,
    "pressure_a": 1.0,
    "pressure_b": 1.0,
    "temperature_a": 1e-3,
    "temperature_b": 1e-3,
    "cylinder_pressure": 1.0,
    "receiver_pressure": 1.0,
    "torque": 1e-5,
    "air_flow": 1e-9,
}
"""The simulator's own error, below which no noise is believed [SI]."""


class Noise(NamedTuple):
    """Noise of a channel at a sampling interval."""

    deviation: float
    """[SI]"""
    predictors: tuple
    """For each order 0, 1, ... the weights of the samples before."""
    spread: np.ndarray
    """Standard deviation of each order's error of prediction, over the deviation."""
    source: str
    """Where deviation and colour are from."""
    hum: float = np.nan
    """Frequency [Hz]; NaN: none."""
    hum_deviation: float = 0.0
    """Of the amplitudes of sine and cosine [SI]."""

    @property
    def colour(self):
        """Correlation of neighbours."""
        return (
            float(np.sqrt(max(0.0, 1.0 - self.spread[1] ** 2)) * np.sign(self.predictors[1][0])) if self.order else 0.0
        )

    @property
    def order(self):
        """Terms of the autoregressive process."""
        return len(self.predictors) - 1


def white(deviation, source):
    """Noise without colour."""
    return Noise(deviation, (np.zeros(0),), np.ones(1), source)


def levinson(correlation):
    """Predictors of orders 0 to n of a process with the correlations 1, c_1, ..., c_n, and their errors' deviations."""
    predictors, variance = [np.zeros(0)], [1.0]
    for order in range(1, len(correlation)):
        last = predictors[-1]
        reflection = (correlation[order] - last @ correlation[order - 1 : 0 : -1]) / variance[-1]
        if abs(reflection) >= 1.0:  # estimated correlations need not belong to any process
            break
        predictors.append(np.append(last - reflection * last[::-1], reflection))
        variance.append(variance[-1] * (1.0 - reflection**2))
    return tuple(predictors), np.sqrt(variance)


def autoregressive(segments, source):
    """Noise from stretches of nothing but noise.

    Parameters
    ----------
    segments : list of (n,) float array
    source : str

    Returns
    -------
    Noise
    """
    samples = sum(map(len, segments))
    deviation = float(np.sqrt(sum(s @ s for s in segments) / samples))
    if deviation == 0.0 or samples < ENOUGH:
        return white(deviation, source)
    most = min(ORDER_MOST, min(map(len, segments)) // 4)
    lagged = [
        sum(float(s[lag:] @ s[: len(s) - lag]) for s in segments) / (samples - lag * len(segments))
        for lag in range(most + 1)
    ]
    predictors, spread = levinson(np.array(lagged) / lagged[0])
    criterion = samples * np.log(spread**2) + np.arange(len(spread)) * np.log(samples)
    order = int(np.argmin(criterion))
    return Noise(deviation, predictors[: order + 1], spread[: order + 1], source)


def whitened(noise, columns, times):
    """Columns in standard deviations, the colour of the noise taken off.

    Parameters
    ----------
    noise : Noise
    columns : (n, k) float array
        [SI]
    times : (n,) float array
        Of the samples [s]; without effect but for hum.

    Returns
    -------
    (n, k) float array
    """
    filtered = columns.astype(float)
    for lag, weight in enumerate(noise.predictors[-1], 1):
        filtered[lag:] -= weight * columns[:-lag]
    filtered /= noise.spread[-1]
    for i in range(min(noise.order, len(columns))):
        filtered[i] = (columns[i] - noise.predictors[i] @ columns[:i][::-1]) / noise.spread[i]
    filtered /= noise.deviation
    if np.isnan(noise.hum):
        return filtered
    waves = sines(noise.hum, times) * noise.hum_deviation
    plain = noise._replace(hum=np.nan)
    left, sizes, _ = np.linalg.svd(whitened(plain, waves, times), full_matrices=False)
    return filtered + left @ ((1.0 / np.sqrt(1.0 + sizes**2) - 1.0)[:, None] * (left.T @ filtered))


def sines(frequency, times):
    """Sine and cosine, shape (n, 2)."""
    angle = 2.0 * np.pi * frequency * times
    return np.column_stack([np.sin(angle), np.cos(angle)])


def with_hum(records, source, others=()):
    """Noise from stretches of nothing but noise, and hum where there is evidence of it.

    Parameters
    ----------
    records : list of list of tuple
        For each record its stretches: values [SI] and times [s], (n,) float arrays each; a record's hum has one phase.
    source : str
    others : list of list of tuple
        Further records that may show hum: in what repeats differ by, it is lost where their phases are alike.

    Returns
    -------
    Noise
    """
    plain = autoregressive([values for record in records for values, _ in record], source)
    if plain.deviation == 0.0:
        return plain
    best = None
    for frequency in MAINS:
        left, amplitudes, fall = [], [], 0.0
        for number, record in enumerate([*records, *others]):
            rest, amplitude, taken = _without_sine(record, frequency)
            left += rest if number < len(records) else []
            fall += taken
            amplitudes.append(amplitude)
        if best is None or fall > best[0]:
            best = fall, frequency, left, float(np.sqrt(np.mean(np.square(amplitudes)) / 2.0))
    fall, frequency, left, size = best
    quiet = autoregressive(left, source)
    chance = 2.0 * (len(records) + len(others))
    # Coloured noise has more power at low frequencies than white: by this factor.
    power = quiet.deviation**2 * max(1.0, (quiet.spread[-1] / (1.0 - quiet.predictors[-1].sum())) ** 2)
    if fall < power * (chance + HUM_EVIDENCE * np.sqrt(2.0 * chance)):
        return plain
    return quiet._replace(hum=float(frequency), hum_deviation=size)


def _without_sine(record, frequency):
    """Stretches of a record without the sine that fits them best, its amplitude, and the power that it takes.

    Each stretch is free to drift straight.
    """
    times = np.concatenate([t for _, t in record])
    drift = np.zeros((len(times), 2 * len(record)))
    ends = np.cumsum([0, *(len(t) for _, t in record)])
    for k, (first, end) in enumerate(pairwise(ends)):
        drift[first:end, 2 * k] = 1.0
        drift[first:end, 2 * k + 1] = times[first:end] - times[first:end].mean()
    waves = sines(frequency, times)
    values = np.concatenate([v for v, _ in record])
    straight = values - drift @ np.linalg.lstsq(drift, values, rcond=None)[0]
    weights, *_ = np.linalg.lstsq(np.column_stack([waves, drift]), values, rcond=None)
    left = values - waves @ weights[:2] - drift @ weights[2:]
    taken = float(straight @ straight - left @ left)
    return [left[first:end] for first, end in pairwise(ends)], float(np.linalg.norm(weights[:2])), taken


def noise_of(blocks, predicted, stated):
    """The noise of every channel, at each sampling interval that it comes with.

    Parameters
    ----------
    blocks : list of studies.gap.problem.Block
    predicted : list of (n,) float array
        What the model gives for each.
    stated : dict
        Standard deviations that the user states [SI], by sensor.

    Returns
    -------
    noise : dict of dict of Noise
        By sensor and sampling interval [s], see `noise_for`.
    warnings : list of str
    """
    groups, found, warnings = {}, {}, []
    for block, values in zip(blocks, predicted, strict=True):
        like = round(log(block.interval) / log(LIKE)) if block.interval else 0
        groups.setdefault((block.sensor, like), []).append((block, values))
    for (sensor, _), pairs in groups.items():
        if not pairs[0][0].interval:
            found[sensor] = {0.0: _of_a_mean(sensor, pairs, stated, warnings)}
            continue
        noise = _from_noise(pairs)
        if noise is None:
            noise = white(_by_differences(pairs), TAKEN_FOR_WHITE)
        own = max(noise.deviation, FLOOR[sensor])
        if sensor in stated:
            known = noise.source != TAKEN_FOR_WHITE
            if known and not 0.7 < own / stated[sensor] < 1.4:
                warnings.append(
                    f"{sensor}: the noise is stated as {stated[sensor]:.3g}, but {noise.source} show {own:.3g} (SI)"
                )
            own = max(stated[sensor], FLOOR[sensor])
        interval = float(np.median([block.interval for block, _ in pairs]))
        found.setdefault(sensor, {})[interval] = noise._replace(deviation=own)
    return {sensor: _humming_alike(by_interval) for sensor, by_interval in found.items()}, warnings


def _humming_alike(by_interval):
    """The noise of a sensor: where there is hum at one sampling interval, there is as much at all."""
    loudest = max(by_interval.values(), key=lambda noise: noise.hum_deviation)
    return {
        interval: noise._replace(hum=loudest.hum, hum_deviation=loudest.hum_deviation) if np.isnan(noise.hum) else noise
        for interval, noise in by_interval.items()
    }


def _of_a_mean(sensor, pairs, stated, warnings):
    """Noise of a mean over the cycle: stated, from repeats, or taken for a share of it."""
    if sensor in stated:
        return white(max(stated[sensor], FLOOR[sensor]), "stated")
    contrasts = np.concatenate([[], *(values for record in _contrasts(pairs) for values, _ in record)])
    if len(contrasts) >= FEWEST_CONTRASTS:
        return white(max(float(np.sqrt(np.mean(contrasts**2))), FLOOR[sensor]), "repeats")
    size = float(np.median([abs(block.values[0]) for block, _ in pairs]))
    warnings.append(
        f"{sensor}: the noise is neither stated nor told by repeats; taken for {100.0 * OF_A_MEAN:g} % of the mean; "
        f"state it as [sensor.{sensor}]"
    )
    return white(max(OF_A_MEAN * size, FLOOR[sensor]), "a share of the mean")


def noise_for(noise, block):
    """The noise of a block: that of its sensor, at the nearest sampling interval."""
    known = noise[block.sensor]
    return known[min(known, key=lambda interval: abs(interval - block.interval))]


def _from_noise(pairs):
    """Noise from repeats, else from stretches at rest; None: there is too little of both."""
    contrasts, rest = _contrasts(pairs), _at_rest(pairs)
    for records, source, others in ((contrasts, "repeats", rest), (rest, "stretches at rest", [])):
        if sum(len(values) for record in records for values, _ in record) >= ENOUGH:
            return with_hum(records, source, others)
    return None


def _contrasts(pairs):
    """What repeats of runs differ by: Helmert's contrasts, independent series of the noise's own deviation."""
    groups, records = {}, []
    for block, _ in pairs:
        groups.setdefault((block.run.name, block.run.role, len(block.values), block.times.tobytes()), []).append(block)
    for repeats in groups.values():
        values = np.array([block.values for block in repeats])
        for k in range(1, len(repeats)):
            contrast = (values[:k].sum(axis=0) - k * values[k]) / np.sqrt(k * (k + 1.0))
            records.append([(contrast, repeats[0].times)])
    return records


def _at_rest(pairs):
    """Samples before the trigger and stretches in which the model hardly moves, straight drifts taken off."""
    rough, records = _by_differences(pairs), []
    for block, values in pairs:
        if len(values) < ENOUGH:
            continue
        moving = (np.abs(np.gradient(values)) > STILL * rough) & (block.times > 0.0)
        edges = np.flatnonzero(np.diff(np.concatenate([[True], moving, [True]]).astype(int)))
        record = []
        guard = 1 + int(GUARD / block.interval)
        for first, end in zip(edges[::2] + guard, edges[1::2] - guard, strict=True):
            if end - first >= STRETCH:
                t, s = block.times[first:end], block.values[first:end]
                record.append((s - np.polyval(np.polyfit(t - t[0], s, 1), t - t[0]), t))
        records.append(record)
    return [record for record in records if record]


def is_known(noise):
    """Whether the colour of every channel's noise is known from noise itself."""
    return all(one.source != TAKEN_FOR_WHITE for known in noise.values() for one in known.values())


def from_what_nothing_explains(blocks, noise, left):
    """The noise of channels that are never at rest and never repeated, anew.

    Parameters
    ----------
    blocks : list of studies.gap.problem.Block
    noise : dict
        See `noise_of`; changed.
    left : list of (n,) float array
        For each block what neither the nuisances nor any effect of the library can explain [SI].
    """
    groups = {}
    for block, values in zip(blocks, left, strict=True):
        known = noise_for(noise, block)
        if known.source == TAKEN_FOR_WHITE and len(values) > 1:
            groups.setdefault(id(known), (block, known, []))[2].append(values)
    for block, known, segments in groups.values():
        by_interval = noise[block.sensor]
        interval = next(at for at, one in by_interval.items() if one is known)
        found = autoregressive(segments, "what nothing in the library explains")
        by_interval[interval] = found._replace(deviation=max(found.deviation, known.deviation))


def _by_differences(pairs):
    """White noise from second differences of what the model leaves."""
    bends = np.concatenate([[], *(np.diff(block.values - values, 2) for block, values in pairs)])
    return float(np.median(np.abs(bends)) / 0.6745 / np.sqrt(6.0)) if len(bends) else 0.0
