"""The noise of measured channels, from the best source there is.

That is what repeats of a run differ by, else what was recorded before the trigger and in stretches in which the model
stands still, else what nothing in the library explains.
"""

from collections.abc import Mapping, Sequence
from math import log
from typing import Any

import numpy as np

from apesim.studies.estimation.noise.hum import Record, Records, going_on, mains_in, with_hum
from apesim.studies.estimation.noise.process import ENOUGH, SAME, STRETCH, Noise, noise_for, take_deviation, white

Pair = tuple[Any, np.ndarray]
"""A block, `apesim.studies.estimation.residuals.Block`, with an array of as many samples."""
Changes = Mapping[int, np.ndarray]
"""What may differ between repeats, (n, k) array of the samples of a block, by the identity of the block."""
AllNoise = dict[str, dict[float, Noise]]
"""Noise of every channel, by sensor and sampling interval [s]."""

LIKE = 1.5
"""Ratio of sampling intervals that count as one."""
MAX_REST_MOTION = 0.005
"""Share of the noise that the model may move by from one sample to the next at rest."""
OF_A_MEAN = 0.05
"""Share of a mean over the cycle that its noise is taken for, where nothing tells it: more than a usual brake or flow
meter has, as what is only assumed must not make a gap, nor a fault of a file."""
HARDLY_ANY = 0.1
"""Share of a noise that is stated, below which what the data show is not that noise."""
FEWEST_CONTRASTS = 4
MIN_FAULT, CLEAR_FAULT = 0.2, 5.0
"""Energy of a fault in what repeats differ by, from which it is taken off: over that of the noise, and over what noise
itself would give it. A fainter one makes the noise a tenth larger at most."""
TAKEN_FOR_WHITE = "second differences, taken for white"
AT_REST = "stretches at rest"
UNEXPLAINED = "what nothing in the library explains"
GUARD = 2e-3
"""Between a motion of the model and a stretch at rest [s]: the measured motion may be that late."""
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
    "force": 1e-6,
}
"""The simulator's own error, below which no noise is believed [SI]."""


def noise_of(
    blocks: Sequence[Any],
    predicted: Sequence[np.ndarray],
    stated: Mapping[str, float],
    changes: Sequence[np.ndarray] = (),
) -> tuple[AllNoise, list[str]]:
    """Estimate the noise of every channel, by sensor and sampling interval [s] that it comes with, and give warnings.

    Given are the model's prediction for each block [SI] and the standard deviations that the user states [SI], by
    sensor; `changes`, (n, k) for each block, is what may differ between repeats of a run beside noise, in proportion;
    without them, what a fault of a file does.
    """
    groups: dict[tuple[str, int], list[Pair]] = {}
    found: AllNoise = {}
    warnings: list[str] = []

    # Samples at about the same interval have one noise; means over the cycle have no interval, and stand apart.
    for block, values in zip(blocks, predicted, strict=True):
        like = round(log(block.interval) / log(LIKE)) if block.interval else 0
        groups.setdefault((block.sensor, like), []).append((block, values))

    # All records come before any noise: the mains are one for all channels, and one alone may not tell their frequency.
    by_block = {id(block): columns for block, columns in zip(blocks, changes, strict=bool(changes))}
    known_by = {
        key: _records(pairs, stated.get(key[0], np.nan), by_block)
        for key, pairs in groups.items()
        if pairs[0][0].interval
    }
    mains = mains_in([records for records in known_by.values() if records])

    # The noise of each group. A mean over the cycle has no neighbours that could tell a colour.
    for (sensor, like), pairs in groups.items():
        if not pairs[0][0].interval:
            found[sensor] = {0.0: _of_a_mean(sensor, pairs, stated, warnings)}
            continue
        records = known_by[sensor, like]
        noise = with_hum(records, mains) if records else white(_by_differences(pairs), TAKEN_FOR_WHITE)
        deviation = max(noise.deviation, FLOOR[sensor])

        # A stated deviation is believed, and the records tell the colour beside it; where they clearly show another
        # one, that is a warning.
        if sensor in stated:
            known = noise.source != TAKEN_FOR_WHITE
            if known and not 0.7 < deviation / stated[sensor] < 1.4:
                shown = f"{noise.source} show {deviation:.3g} (SI)"
                warnings.append(f"{sensor}: the noise is stated as {stated[sensor]:.3g}, but {shown}")
            if deviation < HARDLY_ANY * stated[sensor]:  # the colour of something else, as of the simulator's own error
                noise = white(stated[sensor], "stated")
            deviation = max(stated[sensor], FLOOR[sensor])
            noise = noise if noise.is_stated else take_deviation(noise, deviation)
        interval = float(np.median([block.interval for block, _ in pairs]))
        found.setdefault(sensor, {})[interval] = noise._replace(deviation=deviation)
    return found, warnings


def _of_a_mean(sensor: str, pairs: Sequence[Pair], stated: Mapping[str, float], warnings: list[str]) -> Noise:
    """Noise of a mean over the cycle: stated, from repeats, or taken for a share of it."""
    if sensor in stated:
        return white(max(stated[sensor], FLOOR[sensor]), "stated")
    records, _ = _contrasts(pairs, {})
    contrasts = np.concatenate([[], *(values for record in records for values, _ in record)])
    if len(contrasts) >= FEWEST_CONTRASTS:
        return white(max(float(np.sqrt(np.mean(contrasts**2))), FLOOR[sensor]), "repeats", float(len(contrasts)))
    size = float(np.median([abs(block.values[0]) for block, _ in pairs]))
    warnings.append(
        f"{sensor}: the noise is neither stated nor seen between repeats; taken for {100.0 * OF_A_MEAN:g} % of the "
        f"mean; state it as [sensor.{sensor}]"
    )
    return white(max(OF_A_MEAN * size, FLOOR[sensor]), "a share of the mean")


def _records(pairs: Sequence[Pair], stated: float, changes: Changes) -> Records | None:
    """What tells the noise of a channel: repeats, else stretches at rest; None: there is too little of both."""
    (contrasts, taken), rest = _contrasts(pairs, changes), _at_rest(pairs)
    for found in (
        Records(contrasts, "repeats", rest, False, stated, taken=tuple(taken)),
        Records(rest, AT_REST, [], True, stated),
    ):
        if sum(len(values) for record in found.noise for values, _ in record) >= ENOUGH:
            return found
    return None


def _contrasts(pairs: Sequence[Pair], changes: Changes) -> tuple[list[Record], list[np.ndarray]]:
    """Find what repeats of runs differ by: Helmert's contrasts, independent series of the noise's own deviation.

    Beside the records are the orthonormal columns, (n, k), that were taken off each, see `_take_changes_off`.
    """
    groups: dict[tuple[Any, ...], list[Pair]] = {}
    records: list[Record] = []
    taken: list[np.ndarray] = []
    for block, predicted in pairs:
        key = block.run.name, block.run.role, len(block.values), block.times.tobytes()
        groups.setdefault(key, []).append((block, predicted))
    for repeats in groups.values():
        values, (first, _) = np.array([block.values for block, _ in repeats]), repeats[0]
        for k in range(1, len(repeats)):
            contrast = (values[:k].sum(axis=0) - k * values[k]) / np.sqrt(k * (k + 1.0))
            columns = np.empty((len(contrast), 0))
            # What two parts of one file differ by is no fault of a file.
            if repeats[k][0].run.file != first.run.file:
                contrast, columns = _take_changes_off(contrast, first.times, values[: k + 1], changes.get(id(first)))
            records.append([(contrast, first.times)])
            taken.append(columns)
    return records, taken


def _take_changes_off(
    contrast: np.ndarray, times: np.ndarray, repeats: np.ndarray, changes: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """A contrast of repeats without what a fault of one of them does, and other changes, where there clearly are some.

    The second array has the orthonormal columns that were taken off, (n, k).

    An offset, a gain, a late trigger and a fast clock change a record in proportion to 1, x, dx/dt and t dx/dt, and a
    slow stroke to x dx/dt. Were they taken for noise, they would hide themselves, and all that is as slow. The mean of
    the repeats is x: it has the noise of none of their contrasts, and a model may be far away.
    """
    none = np.empty((len(contrast), 0))
    if len(contrast) < ENOUGH:
        return contrast, none
    mean = repeats.mean(axis=0)
    slope = np.gradient(mean, times)
    others = np.empty((len(times), 0)) if changes is None else changes
    shapes = np.column_stack([np.ones(len(times)), mean, slope, times * slope, mean * slope, others])
    shapes = shapes[:, np.linalg.norm(shapes, axis=0) > 0.0]
    shapes = shapes / np.linalg.norm(shapes, axis=0)
    base, sizes, _ = np.linalg.svd(shapes, full_matrices=False)
    base = base[:, sizes > SAME * sizes[0]]
    left = contrast - base @ (base.T @ contrast)
    energy = float(left @ left)
    if energy == 0.0:
        return contrast, none
    colour = float(np.clip(left[1:] @ left[:-1] / energy, 0.0, 0.99))
    by_noise = base.shape[1] * (1.0 + colour) / (1.0 - colour) / len(contrast)
    is_clear = float(contrast @ contrast) / energy - 1.0 > max(MIN_FAULT, CLEAR_FAULT * by_noise)
    return (left, base) if is_clear else (contrast, none)


def _at_rest(pairs: Sequence[Pair]) -> list[Record]:
    """Samples before the trigger and stretches in which the model hardly moves, records of them."""
    rough = _by_differences(pairs)
    records = [_stretches_at_rest(block, values, rough) for block, values in pairs]
    return [record for record in records if record]


def _stretches_at_rest(block: Any, values: np.ndarray, rough: float) -> Record:
    """Stretches at rest of one block, where the model gives the values and its noise is roughly so much."""
    if len(values) < ENOUGH:
        return []
    moving = (np.abs(np.gradient(values)) > MAX_REST_MOTION * rough) & (block.times > 0.0)
    edges = np.flatnonzero(np.diff(np.concatenate([[True], moving, [True]]).astype(int)))
    guard = 1 + int(GUARD / block.interval)
    ends = zip(edges[::2] + guard, edges[1::2] - guard, strict=True)
    return [(block.values[first:end], block.times[first:end]) for first, end in ends if end - first >= STRETCH]


def is_known(noise: AllNoise) -> bool:
    """Tell whether the colour of every channel's noise is known from noise itself.

    >>> is_known({"lift": {5e-5: white(3e-5, AT_REST)}, "torque": {0.0: white(0.3, TAKEN_FOR_WHITE)}})
    False
    """
    return all(each.source != TAKEN_FOR_WHITE for known in noise.values() for each in known.values())


def may_hum(noise: AllNoise) -> bool:
    """Tell whether channels known from stretches at rest may hum more faintly than those show.

    They may where none is seen to hum, and all are white.
    """
    known = [each for by_interval in noise.values() for each in by_interval.values()]
    return any(each.source == AT_REST for each in known) and not any(each.hums or each.order for each in known)


def from_what_nothing_explains(
    blocks: Sequence[Any], noise: AllNoise, left: Sequence[np.ndarray], explained: Sequence[np.ndarray]
) -> AllNoise:
    """Estimate the noise of channels that are never at rest and never repeated, anew; `noise` stays as it is.

    `left` is the part of each block that neither the nuisances nor any effect of the library can explain [SI],
    `explained` the rows, (n, k), of the columns that were taken off it, in proportion to [SI]. Where nothing is left of
    a channel at a sampling interval, as of gate runs, its colour is that at the nearest.
    """
    noise = {sensor: dict(by_interval) for sensor, by_interval in noise.items()}
    groups = _by_noise(blocks, noise, left, TAKEN_FOR_WHITE)
    rows = {id(block): columns for block, columns in zip(blocks, explained, strict=True)}
    channels = [
        _unexplained(group)._replace(explained=tuple(rows[id(block)] for block, _ in group)) for _, group in groups
    ]
    elsewhere = {f for by_interval in noise.values() for each in by_interval.values() for f, _ in each.hums}
    mains = tuple(sorted(elsewhere)) or mains_in(channels)
    for (known, group), records in zip(groups, channels, strict=True):
        by_interval = noise[group[0][0].sensor]
        interval = next(at for at, each in by_interval.items() if each is known)
        found = with_hum(records, mains)
        is_less = known.is_stated and found.deviation < known.deviation
        by_interval[interval] = (
            take_deviation(found, known.deviation)
            if is_less
            else found._replace(deviation=max(found.deviation, known.deviation))
        )
    for by_interval in noise.values():
        sure = {interval: each for interval, each in by_interval.items() if each.source != TAKEN_FOR_WHITE}
        for interval in set(by_interval) - set(sure) if sure else ():
            near = sure[min(sure, key=lambda other: abs(log(other / interval)))]
            by_interval[interval] = near._replace(deviation=max(near.deviation, by_interval[interval].deviation))
    return noise


def hum_of_what_nothing_explains(
    blocks: Sequence[Any], noise: AllNoise, predicted: Sequence[np.ndarray], left: Sequence[np.ndarray]
) -> AllNoise | None:
    """Find hum that is too faint to be seen in stretches at rest, but goes on in them; None: there is none.

    Given are noise that `may_hum`, the model's prediction for each block [SI], and the part of it that nothing in the
    library can explain [SI]. The result is the noise of all channels with their hum; a sensor that hums does so at all
    its sampling intervals.
    """
    groups = _by_noise(blocks, noise, left, AT_REST)
    channels = [_unexplained(group) for _, group in groups]
    mains = mains_in(channels)
    if not mains:
        return None
    rest = {
        id(block): _stretches_at_rest(block, values, _by_differences([(block, values)]))
        for block, values in zip(blocks, predicted, strict=True)
    }
    fall = 0.0
    for (known, group), records in zip(groups, channels, strict=True):
        rests = [rest[id(block)] for block, _ in group]
        fall += going_on(records.noise, rests, mains) / known.deviation**2
    if fall <= 0.0:
        return None
    noise = dict(noise)
    for (_, group), records in zip(groups, channels, strict=True):
        sensor, hums = group[0][0].sensor, with_hum(records, mains).hums
        noise[sensor] = {interval: each._replace(hums=hums) for interval, each in noise[sensor].items()}
    return noise


def _by_noise(
    blocks: Sequence[Any], noise: AllNoise, left: Sequence[np.ndarray], source: str
) -> list[tuple[Noise, list[Pair]]]:
    """Noise from a source, and the blocks that have it with what is left of each; means apart."""
    groups: dict[int, tuple[Noise, list[Pair]]] = {}
    for block, values in zip(blocks, left, strict=True):
        known = noise_for(noise, block)
        if known.source == source and len(values) > 1:
            groups.setdefault(id(known), (known, []))[1].append((block, values))
    return list(groups.values())


def _unexplained(group: Sequence[Pair]) -> Records:
    """What is left of the blocks of a group as records of noise."""
    return Records([[(values, block.times)] for block, values in group], UNEXPLAINED, [], False, np.nan)


def _by_differences(pairs: Sequence[Pair]) -> float:
    """White noise from second differences of what the model leaves."""
    bends = np.concatenate([[], *(np.diff(block.values - values, 2) for block, values in pairs)])
    return float(np.median(np.abs(bends)) / 0.6745 / np.sqrt(6.0)) if len(bends) else 0.0
