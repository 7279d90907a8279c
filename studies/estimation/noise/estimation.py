"""The noise of measured channels, from the best source there is.

That is what repeats of a run differ by, else what was recorded before the trigger and in stretches in which the model
stands still, else what nothing in the library explains.
"""

from math import log

import numpy as np

from apesim.studies.estimation.noise.hum import Records, going_on, mains_in, with_hum
from apesim.studies.estimation.noise.process import ENOUGH, STRETCH, noise_for, white

LIKE = 1.5
"""Ratio of sampling intervals that count as one."""
STILL = 0.005
"""Share of the noise that the model may move by from one sample to the next at rest."""
OF_A_MEAN = 0.01
"""Share of a mean over the cycle that its noise is taken for, where nothing tells it."""
FEWEST_CONTRASTS = 4
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
}
"""The simulator's own error, below which no noise is believed [SI]."""


def noise_of(blocks, predicted, stated):
    """The noise of every channel, at each sampling interval that it comes with.

    Parameters
    ----------
    blocks : list of apesim.studies.estimation.residuals.Block
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
    told = {key: _records(pairs, stated.get(key[0], np.nan)) for key, pairs in groups.items() if pairs[0][0].interval}
    mains = mains_in([records for records in told.values() if records])
    for (sensor, like), pairs in groups.items():
        if not pairs[0][0].interval:
            found[sensor] = {0.0: _of_a_mean(sensor, pairs, stated, warnings)}
            continue
        records = told[sensor, like]
        noise = with_hum(records, mains) if records else white(_by_differences(pairs), TAKEN_FOR_WHITE)
        own = max(noise.deviation, FLOOR[sensor])
        if sensor in stated:
            known = noise.source != TAKEN_FOR_WHITE
            if known and not 0.7 < own / stated[sensor] < 1.4:
                warnings.append(
                    f"{sensor}: the noise is stated as {stated[sensor]:.3g}, but {noise.source} show {own:.3g} (SI)"
                )
            own, noise = max(stated[sensor], FLOOR[sensor]), noise._replace(is_stated=True)
        interval = float(np.median([block.interval for block, _ in pairs]))
        found.setdefault(sensor, {})[interval] = noise._replace(deviation=own)
    return found, warnings


def _of_a_mean(sensor, pairs, stated, warnings):
    """Noise of a mean over the cycle: stated, from repeats, or taken for a share of it."""
    if sensor in stated:
        return white(max(stated[sensor], FLOOR[sensor]), "stated")
    contrasts = np.concatenate([[], *(values for record in _contrasts(pairs) for values, _ in record)])
    if len(contrasts) >= FEWEST_CONTRASTS:
        return white(max(float(np.sqrt(np.mean(contrasts**2))), FLOOR[sensor]), "repeats", float(len(contrasts)))
    size = float(np.median([abs(block.values[0]) for block, _ in pairs]))
    warnings.append(
        f"{sensor}: the noise is neither stated nor told by repeats; taken for {100.0 * OF_A_MEAN:g} % of the mean; "
        f"state it as [sensor.{sensor}]"
    )
    return white(max(OF_A_MEAN * size, FLOOR[sensor]), "a share of the mean")


def _records(pairs, stated):
    """What tells the noise of a channel: repeats, else stretches at rest; None: there is too little of both."""
    contrasts, rest = _contrasts(pairs), _at_rest(pairs)
    for found in (
        Records(contrasts, "repeats", rest, False, stated),
        Records(rest, AT_REST, [], True, stated),
    ):
        if sum(len(values) for record in found.noise for values, _ in record) >= ENOUGH:
            return found
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
    """Samples before the trigger and stretches in which the model hardly moves, records of them."""
    rough = _by_differences(pairs)
    records = [_stretches_at_rest(block, values, rough) for block, values in pairs]
    return [record for record in records if record]


def _stretches_at_rest(block, values, rough):
    """Those of one block, where the model gives the values and its noise is roughly so much."""
    if len(values) < ENOUGH:
        return []
    moving = (np.abs(np.gradient(values)) > STILL * rough) & (block.times > 0.0)
    edges = np.flatnonzero(np.diff(np.concatenate([[True], moving, [True]]).astype(int)))
    guard = 1 + int(GUARD / block.interval)
    ends = zip(edges[::2] + guard, edges[1::2] - guard, strict=True)
    return [(block.values[first:end], block.times[first:end]) for first, end in ends if end - first >= STRETCH]


def is_known(noise):
    """Whether the colour of every channel's noise is known from noise itself."""
    return all(one.source != TAKEN_FOR_WHITE for known in noise.values() for one in known.values())


def may_hum(noise):
    """Whether channels known from stretches at rest may hum more faintly than those tell: none does, all are white."""
    known = [one for by_interval in noise.values() for one in by_interval.values()]
    return any(one.source == AT_REST for one in known) and not any(one.hums or one.order for one in known)


def from_what_nothing_explains(blocks, noise, left, explained):
    """The noise of channels that are never at rest and never repeated, anew.

    Where there is nothing left of a channel at a sampling interval, as of gate runs, its colour is that at the nearest.

    Parameters
    ----------
    blocks : list of apesim.studies.estimation.residuals.Block
    noise : dict
        See `noise_of`.
    left : list of (n,) float array
        For each block what neither the nuisances nor any effect of the library can explain [SI].
    explained : list of (n, k) float array
        For each block its rows of the columns that were taken off, in proportion to [SI].

    Returns
    -------
    dict
        The noise of all channels, as `noise_of` has it; the one given stays as it is.
    """
    noise = {sensor: dict(by_interval) for sensor, by_interval in noise.items()}
    groups = _by_noise(blocks, noise, left, TAKEN_FOR_WHITE)
    rows = {id(block): columns for block, columns in zip(blocks, explained, strict=True)}
    channels = [
        _unexplained(group)._replace(explained=tuple(rows[id(block)] for block, _ in group)) for _, group in groups
    ]
    elsewhere = {f for by_interval in noise.values() for one in by_interval.values() for f, _ in one.hums}
    mains = tuple(sorted(elsewhere)) or mains_in(channels)
    for (known, group), records in zip(groups, channels, strict=True):
        by_interval = noise[group[0][0].sensor]
        interval = next(at for at, one in by_interval.items() if one is known)
        found = with_hum(records, mains)
        by_interval[interval] = found._replace(deviation=max(found.deviation, known.deviation))
    for by_interval in noise.values():
        told = {interval: one for interval, one in by_interval.items() if one.source != TAKEN_FOR_WHITE}
        for interval in set(by_interval) - set(told) if told else ():
            near = told[min(told, key=lambda other: abs(log(other / interval)))]
            own = by_interval[interval].deviation
            by_interval[interval] = near._replace(deviation=max(near.deviation, own))
    return noise


def hum_of_what_nothing_explains(blocks, noise, predicted, left):
    """Hum that is too faint to be told from stretches at rest, but goes on in them.

    A sensor that hums does so at all its sampling intervals.

    Parameters
    ----------
    blocks : list of apesim.studies.estimation.residuals.Block
    noise : dict
        See `noise_of`; one that `may_hum`.
    predicted, left : list of (n,) float array
        For each block what the model gives, and what of the measured is more than anything in the library can explain
        [SI].

    Returns
    -------
    dict or None
        The noise of all channels with their hum; None: there is none.
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
        noise[sensor] = {interval: one._replace(hums=hums) for interval, one in noise[sensor].items()}
    return noise


def _by_noise(blocks, noise, left, source):
    """Noise from a source, and the blocks that have it with what is left of each; means apart."""
    groups = {}
    for block, values in zip(blocks, left, strict=True):
        known = noise_for(noise, block)
        if known.source == source and len(values) > 1:
            groups.setdefault(id(known), (known, []))[1].append((block, values))
    return list(groups.values())


def _unexplained(group):
    """What is left of the blocks of a group as records of noise."""
    return Records([[(values, block.times)] for block, values in group], UNEXPLAINED, [], False, np.nan)


def _by_differences(pairs):
    """White noise from second differences of what the model leaves."""
    bends = np.concatenate([[], *(np.diff(block.values - values, 2) for block, values in pairs)])
    return float(np.median(np.abs(bends)) / 0.6745 / np.sqrt(6.0)) if len(bends) else 0.0
