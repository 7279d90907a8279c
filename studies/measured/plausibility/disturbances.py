"""Disturbances of single samples, found in a record by itself: spikes, a held value, an end of a range, a code.

They are masked, as cells without a number are, so that they enter no fit. What is masked is short, far beyond noise and
neighbours, and reported. Whatever takes more than a small share of a record stays, and refuses it.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from apesim.studies.measured.plausibility import thresholds as limits
from apesim.studies.measured.plausibility.sample_and_hold import find_repeated
from apesim.studies.measured.plausibility.signals import WIDTH, fill, find_levels, find_noise, find_noises, smooth
from apesim.studies.measured.runs import Disturbance, Masked

ROUNDING = 1e-9
"""Share of a span that two equal values may differ by, once they were converted."""
MIN_QUIET = 1e-4
"""Noise over the span below which a record counts as one without noise: a simulator's."""
WINDOW = 8
"""Samples of a window in which noise is looked for."""
MAX_STILL = 0.15
"""Share of the span that a window without motion covers: noise of a fortieth of it, and less than a stroke does."""


def mask_disturbances(
    columns: Mapping[str, np.ndarray], axis: str, channels: Mapping[str, object]
) -> tuple[dict[str, np.ndarray], list[Masked]]:
    """Mask the samples of a record that a disturbance made, where they are few, by NaN.

    `columns` (n,) are [SI], NaN where a cell has no number; `axis`, "time" or "crank_angle", is the one that rises, and
    `channels` are those that are sensors' traces. What was masked is told as of run 0.

    >>> times = np.arange(200) * 1e-4
    >>> lift = np.random.default_rng(1).normal(0.0, 1e-5, 200)
    >>> lift[100] = 30e-3
    >>> columns, masked = mask_disturbances({"time": times, "lift": lift}, "time", {"lift": None})
    >>> [(str(each.disturbance), each.places.tolist()) for each in masked], int(np.isnan(columns["lift"]).sum())
    ([('spikes', [0.01])], 1)
    """
    result, masked = dict(columns), []
    for channel in channels:
        values = columns.get(channel)
        if values is None:
            continue
        # What hides everything else comes first: a code by its size, a slow sampler by its repeated values.
        codes = find_impossible(values, find_code_limits(channel))
        found = [(Disturbance.IMPOSSIBLE, codes)] if codes.any() else []
        known = np.where(codes, np.nan, values)
        repeated = find_repeated(known)
        if repeated.any():
            found.append((Disturbance.REPEATED, repeated))
            known = np.where(repeated, np.nan, known)
        for disturbance, flags in [*found, *find_disturbances(columns[axis], known, axis)]:
            share = float(np.mean(flags))
            if disturbance == Disturbance.REPEATED or is_short(columns[axis], flags, axis):
                masked.append(Masked(0, channel, disturbance, columns[axis][flags], values[flags], share))
                result[channel] = np.where(flags, np.nan, result[channel])
    return result, masked


def find_impossible(values: np.ndarray, bounds: tuple[float, float]) -> np.ndarray:
    """Find the samples (n,) that lie at bounds, or beyond them, which nothing can reach; never a NaN.

    `bounds` are low and high, in the unit of the values.
    """
    low, high = bounds
    return (values <= low) | (values >= high)  # NaN: neither


def find_code_limits(channel: str) -> tuple[float, float]:
    """Find the limits [SI] beyond which a number of a channel is a code of its recorder, whatever the machine.

    They are infinite for a channel that has none.
    """
    return next((bounds for part, bounds in limits.CODES.items() if part in channel), (-np.inf, np.inf))


def find_disturbances(
    places: np.ndarray, values: np.ndarray, axis: str, noise: float = 0.0
) -> Iterator[tuple[Disturbance, np.ndarray]]:
    """Find the samples of a channel that a disturbance made: its kind, and flags (n,) that are not all False.

    `places` (n,) are times [s] or crank angles [rad], ascending, by `axis`, "time" or "crank_angle"; `values` (n,) are
    NaN where a sample is missing. `noise` is the standard deviation that is known [SI]; the greater of it and that of
    the record counts.
    """
    known = np.isfinite(values)
    sampled = places[known] if 2 * known.sum() < len(values) else places  # of a slow sampler, its own
    if known.sum() < limits.MIN_SAMPLES or np.median(np.diff(sampled)) > limits.MAX_RESOLVED[axis]:
        return
    is_fine = np.median(np.diff(places)) <= limits.MAX_FINE[axis] and has_noise(values, np.zeros(len(values), bool))
    spikes = find_spikes(values, max(noise, find_noise(values)), is_fine=bool(is_fine))
    if spikes.any():
        yield Disturbance.SPIKES, spikes
    for disturbance, flags in _find_stretches(np.where(spikes, np.nan, values)):
        if flags.any():
            yield disturbance, flags


def is_short(places: np.ndarray, flags: np.ndarray, axis: str) -> bool:
    """Whether samples are so few, and their stretches so short, that they can be masked.

    `places` (n,) are times [s] or crank angles [rad], ascending, by `axis`, "time" or "crank_angle"; `flags` (n,) mark
    the samples.
    """
    longest = max((places[end - 1] - places[first] for first, end in find_runs(flags)), default=0.0)
    return bool(np.mean(flags) <= limits.MAX_MASKED and longest <= limits.MAX_STRETCH[axis])


def find_spikes(values: np.ndarray, noise: float, *, is_fine: bool = False) -> np.ndarray:
    """Find single samples, or pairs of them, that lie far from those on both sides.

    `values` (n,) are NaN where a sample is missing. Far is `MIN_SPIKE_NOISES` of the noise, a standard deviation in the
    unit of the values, and `MIN_SPIKE_SHARE` of the span; for single samples of a fine record `MIN_SINGLE_SHARE` of it
    is enough, as nothing true is as short as one of them. A record is fine where its samples are at most `MAX_FINE`
    apart, and have noise.

    >>> find_spikes(np.array([0.0, 0.0, 0.0, 0.0, 9.0, 0.0, 0.0, 0.0, 1.0, 1.0]), 0.0).nonzero()[0].tolist()
    [4]
    """
    known = np.isfinite(values)
    filled = fill(values)
    low, high = find_levels(values)
    height = np.where(known, np.abs(filled - fill(smooth(values))), 0.0)
    flags = np.zeros(len(values), bool)
    found = [(height, limits.MIN_SPIKE_SHARE)]
    if is_fine:
        found.append((_find_single_heights(filled, known), limits.MIN_SINGLE_SHARE))
    for heights, share in found:
        limit = max(limits.MIN_SPIKE_NOISES * noise, share * (high - low))
        for place in np.flatnonzero((heights > limit) & ~flags):
            flags[place] = _is_spike(filled, int(place), 0.5 * limit)
    return flags


def has_noise(values: np.ndarray, is_left_out: np.ndarray) -> bool:
    """Whether a record (n,) has noise: in its stillest windows there is some, and no value repeated.

    A record without noise, or in steps coarser than its noise, has windows without any, or repeats its values there. No
    window holds samples that are left out.

    >>> noise = np.random.default_rng(1).normal(size=80)
    >>> has_noise(noise, np.zeros(80, bool)), has_noise(np.round(noise), np.zeros(80, bool))
    (True, False)
    """
    number = len(values) // WINDOW
    windows, left_out = (each[: number * WINDOW].reshape(number, WINDOW) for each in (values, is_left_out))
    windows = windows[~left_out.any(axis=1)]
    if not len(windows):
        return False

    # Windows of whole samples at once, as a long record has very many; the others one by one.
    is_whole = np.isfinite(windows).all(axis=1)
    noises = np.empty(len(windows))
    noises[is_whole] = find_noises(windows[is_whole])
    noises[~is_whole] = [find_noise(window) for window in windows[~is_whole]]
    repeats = float(np.mean(np.mean(np.diff(windows) == 0.0, axis=1)))
    return bool(np.quantile(noises, 0.1) > MIN_QUIET * np.ptp(values) and repeats < limits.MAX_REPEATS)


def find_runs(flags: np.ndarray) -> list[tuple[int, int]]:
    """Stretches in which flags (n,) are set, each as the first index and the one behind the last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]])))
    return [(int(first), int(end)) for first, end in zip(edges[::2], edges[1::2], strict=True)]


def _find_single_heights(values: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Height of each sample over a cubic through the two on either side, 0 where one beside it is higher.

    It is a sixth of the fourth difference, which a smooth peak hardly has, and a kink a third of what its slope changes
    by.
    """
    heights = np.zeros(len(values))
    if len(values) > 4:
        heights[2:-2] = np.where(known[2:-2], np.abs(np.diff(values, 4)) / 6.0, 0.0)
    beside = np.maximum(np.append(heights[1:], 0.0), np.append(0.0, heights[:-1]))
    return np.where(heights > beside, heights, 0.0)


def _is_spike(values: np.ndarray, place: int, limit: float) -> bool:
    """Whether a sample lies farther beyond the samples on both sides than these lie from each other.

    At a jump it lies between them; while the valve flies the sides differ, and a spike still stands out.
    """
    half = WIDTH // 2 + 1
    before, after = values[max(place - half, 0) : place], values[place + 1 : place + half + 1]
    if len(before) < half or len(after) < half:
        return False
    sides = np.median(before), np.median(after)
    return min(abs(values[place] - side) for side in sides) > max(limit, abs(sides[0] - sides[1]))


def _is_held_seldom(values: np.ndarray, held: np.ndarray) -> bool:
    """Whether a record is as still elsewhere for as long as it is held, without being held there.

    Coarse steps hold whatever is still, and leave only what moves.
    """
    starts = range(0, len(values) - WINDOW + 1, WINDOW)
    free = [start for start in starts if not held[start : start + WINDOW].any()]
    still = sum(np.ptp(values[start : start + WINDOW]) < MAX_STILL * np.ptp(values) for start in free)
    return bool(still >= len(starts) - len(free))


def _find_stretches(values: np.ndarray) -> Iterator[tuple[Disturbance, np.ndarray]]:
    """Stretches of one value, at an end of the values and elsewhere."""
    known = np.flatnonzero(np.isfinite(values))
    there = values[known]
    span = np.ptp(there) if len(there) else 0.0
    if span == 0.0:
        return
    held = np.zeros(len(there), bool)
    for first, end in find_runs(np.abs(np.diff(there)) <= ROUNDING * span):
        held[first : end + 1] = end + 1 - first >= limits.MIN_STUCK
    if not held.any() or not has_noise(there, held) or not _is_held_seldom(there, held):
        return
    is_clipped = np.zeros(len(there), bool)
    for rail in (there.min(), there.max()):
        is_at_rail = np.abs(there - rail) <= ROUNDING * span
        if (is_at_rail & held).any():
            is_clipped |= is_at_rail
    widened = np.convolve(is_clipped, np.ones(2 * limits.BESIDE_CLIPPED + 1), mode="same") > 0.5
    for disturbance, flags in (
        (Disturbance.CLIPPED, widened),
        (Disturbance.STUCK, held & ~widened),
    ):
        whole = np.zeros(len(values), bool)
        whole[known[flags]] = True
        yield disturbance, whole
