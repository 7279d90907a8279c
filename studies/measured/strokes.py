"""Strokes of a cylinder that a drive moves to and fro: cut at the turning points, and averaged over cells.

The strokes of a record are repeats of each other. Each is averaged over the same cells, so that they can be compared;
what is near a turning point is left out, as the piston may stick there and the sign of its velocity is uncertain.
"""

from collections.abc import Iterator
from os import PathLike
from pathlib import Path

import numpy as np

from apesim.quantities import Fault, InputError
from apesim.studies.measured.runs import CYLINDER, MeasuredRun

HALF_WINDOW = 0.1
"""Time on either side of an instant over which the velocity is estimated [s]: a drive is steady over it, and at 100 Hz
it has twenty samples."""
MIN_SAMPLES = 4
"""Samples in such a window: with fewer there is no estimate, as two points are always on a line."""
MIN_SHARE_OF_SPEED = 0.2
"""Share of the median speed below which the sign of a velocity does not count: the piston is turning."""
MIN_SHARE_OF_LONGEST = 0.9
"""Share of the longest stroke that a whole one covers: a drive turns at one place to some per cent; records begin and
end on the way."""
MIN_TURNING = 2.0e-3
"""Least way that is left out at each turning point [m], for the yielding of seals, which is some tenths of a
millimetre. A drive faster than 20 mm/s moves farther in `HALF_WINDOW`, and that way is left out."""
CELL_LENGTH = 1.0e-3
"""Length of a cell [m]: some seven samples at 15 mm/s and 100 Hz."""
MIN_CELLS = 8
"""Cells of a stroke: with fewer no noise can be estimated."""
RIGHT = "give a record with a stroke in and a stroke out, longer than 10 mm and from turning point to turning point"


def estimate_velocity(times: np.ndarray, stroke: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Estimate the velocity [m/s] of a stroke [m] by straight lines through neighbouring samples, on any clock [s].

    It is the local linear fit of least squares over `HALF_WINDOW` on either side, cut at the ends of the record: a
    Savitzky-Golay filter where the clock is even (Savitzky and Golay 1964, doi 10.1021/ac60214a047). NaN where the
    window has fewer than `MIN_SAMPLES`. Returns each value's standard deviation [m/s], too, from what its line leaves.
    """
    places = stroke - stroke.mean()
    first, last = np.searchsorted(times, times - HALF_WINDOW), np.searchsorted(times, times + HALF_WINDOW, "right")

    def add_up(values: np.ndarray) -> np.ndarray:
        sums = np.append(0.0, np.cumsum(values))
        return sums[last] - sums[first]

    counts = (last - first).astype(float)
    mean_time, mean_place = add_up(times) / counts, add_up(places) / counts
    spread = add_up(times**2) - counts * mean_time**2
    products = add_up(times * places) - counts * mean_time * mean_place
    counts[counts < MIN_SAMPLES] = np.nan
    velocity = products / np.where(spread > 0.0, spread, np.nan) + 0.0 * counts
    misses = np.maximum(0.0, add_up(places**2) - counts * mean_place**2 - velocity * products)
    return velocity, np.sqrt(misses / (counts - 2.0) / spread)


def find_strokes(stroke: np.ndarray, velocity: np.ndarray) -> list[tuple[slice, slice]]:
    """Find the ways to and fro of a record: two whole strokes, one after the other, between turning points.

    From `stroke` (n,) [m] and `velocity` (n,) [m/s], see `estimate_velocity`; the slices are without the samples at
    which the piston turns.

    >>> phase = np.linspace(0.5, 3.5, 3001) * np.pi  # begins and ends on the way, turns three times
    >>> ((first, second),) = find_strokes(np.sin(phase + 0.8), np.cos(phase + 0.8))
    >>> first.start > 745, first.stop < 1745 < second.start, second.stop < 2745
    (True, True, True)
    """
    moving = np.flatnonzero(np.abs(velocity) > MIN_SHARE_OF_SPEED * np.nanmedian(np.abs(velocity)))
    turns = np.flatnonzero(np.diff(np.sign(velocity[moving])))
    firsts, lasts = np.append(0, turns + 1), np.append(turns, len(moving) - 1)
    strokes = [slice(int(moving[a]), int(moving[b]) + 1) for a, b in zip(firsts, lasts, strict=True) if b > a]
    lengths = [float(np.ptp(stroke[part])) for part in strokes]
    pairs, number = [], 1
    while number < len(strokes):
        is_whole = min(lengths[number - 1 : number + 1]) >= MIN_SHARE_OF_LONGEST * max(lengths)
        if is_whole:
            pairs.append((strokes[number - 1], strokes[number]))
        number += 1 + is_whole
    return pairs


def split_record(run: MeasuredRun, folder: str | PathLike[str] = "") -> list[MeasuredRun]:
    """Split the record of a cylinder into its ways to and fro, which are repeats of one another.

    `run` has all samples of the record, ``stroke`` and ``pressure`` as given; rows without a number are left out. One
    of another bench stays as it is. Each way has means over cells, ``velocity`` among what is given, and the same
    times: the mean time since the way began [s]. Raises InputError, which names `folder`, where the record has no way
    to and fro.
    """
    if run.bench != CYLINDER:
        return [run]

    # A row counts in all columns or in none: each mean of a cell is of the same samples.
    samples = {"time": run.times, **run.given, **run.channels}
    is_whole = np.all([np.isfinite(values) for values in samples.values()], axis=0)
    times, *_ = columns = [values[is_whole] for values in samples.values()]
    samples = dict(zip(samples, columns, strict=True))
    if len(times) < MIN_CELLS:
        wrong = f"{len(times)} rows with time, stroke, pressure and force"
        raise InputError([Fault(str(Path(folder, run.data)), "stroke", wrong, RIGHT)])

    # The ways to and fro, and the cells that all of them cover: by those alone can they be compared.
    samples["velocity"], _ = estimate_velocity(times, samples["stroke"])
    pairs = find_strokes(samples["stroke"], samples["velocity"])
    edges = _divide_stroke(samples["stroke"], samples["velocity"], pairs)
    if len(edges) <= MIN_CELLS:
        wrong = f"{len(pairs)} ways to and fro, with {max(0, len(edges) - 1)} mm that all of them cover"
        raise InputError([Fault(str(Path(folder, run.data)), "stroke", wrong, RIGHT)])

    # Cells in which any way lacks a mean are left out of all ways, for each half by itself.
    ways = [list(_average_over_cells(samples, pair, edges)) for pair in pairs]
    whole = [np.all([np.isfinite(way[half]["velocity"]) for way in ways], axis=0) for half in (0, 1)]
    parts = [
        {name: np.concatenate([way[half][name][whole[half]] for half in (0, 1)]) for name in way[0]} for way in ways
    ]

    # All repeats get the same times, the mean of theirs, and their samples in the order of these.
    times = np.mean([part["time"] for part in parts], axis=0)
    order = np.argsort(times)
    return [
        run._replace(
            times=times[order],
            channels={name: part[name][order] for name in run.channels},
            given={name: part[name][order] for name in (*run.given, "velocity")},
        )
        for part in parts
    ]


def _divide_stroke(stroke: np.ndarray, velocity: np.ndarray, pairs: list[tuple[slice, slice]]) -> np.ndarray:
    """Ends of the cells that all strokes go through, without what is near a turning point [m]."""
    if not pairs:
        return np.empty(0)
    parts = [part for pair in pairs for part in pair]
    turning = max(MIN_TURNING, HALF_WINDOW * max(float(np.median(np.abs(velocity[part]))) for part in parts))
    low = max(float(stroke[part].min()) for part in parts) + turning
    high = min(float(stroke[part].max()) for part in parts) - turning
    return np.arange(low, high, CELL_LENGTH)


def _average_over_cells(
    samples: dict[str, np.ndarray], pair: tuple[slice, slice], edges: np.ndarray
) -> Iterator[dict[str, np.ndarray]]:
    """Means over the cells of both strokes of a way, with the time since it began; NaN in a cell without a sample."""
    columns = samples | {"time": samples["time"] - samples["time"][pair[0].start]}
    for part in pair:
        cells = np.digitize(columns["stroke"][part], edges) - 1
        inside = (cells >= 0) & (cells < len(edges) - 1)
        counts = np.bincount(cells[inside], minlength=len(edges) - 1)
        with np.errstate(invalid="ignore"):
            yield {
                name: np.bincount(cells[inside], values[part][inside], len(edges) - 1) / counts
                for name, values in columns.items()
            }
