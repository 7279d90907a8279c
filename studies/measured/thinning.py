"""Thinning of long records to what the model resolves, by means, so that nothing above it folds into the record."""

from collections.abc import Mapping

import numpy as np

from apesim.engine.angles import DEGREE

RESOLVED = {"time": 2e-5, "crank_angle": 0.1 * DEGREE}
"""Span of a mean by the column that the traces stand over [s, rad]: a stroke takes about 5 ms, and a mean over so short
a span leaves a lift that bends at a contact off by less than 0.01 mm."""
MAX_ROWS = 100_000
"""Longest record that is used as it is: more than a stroke at 1 MHz, and what a fit works through in seconds."""


def thin(columns: Mapping[str, np.ndarray], axis: str) -> tuple[dict[str, np.ndarray], list[str]]:
    """Thin a long record, by means over spans that the model does not resolve; returns hints of what was done, too.

    Columns [SI] have NaN where a cell has no number; `axis` is the one that rises, "time" or "crank_angle". They stay
    as they are where they are no longer than `MAX_ROWS`, or not finer than `RESOLVED`. A span ends at 0, so that none
    has rows before and after the command. Spans of evenly spaced rows have equally many.
    """
    places = columns[axis]
    if len(places) <= MAX_ROWS:
        return dict(columns), []
    interval = (places[-1] - places[0]) / (len(places) - 1)
    number = int(RESOLVED[axis] / interval * (1.0 + 1e-6))
    if number < 2:
        return dict(columns), []
    edge = places[min(int(np.searchsorted(places, 0.0)), len(places) - 1)] - 0.5 * interval
    spans = np.floor((places - edge) / (number * interval)).astype(np.int64)
    firsts = np.flatnonzero(np.append(True, np.diff(spans) > 0))
    counts = np.diff(np.append(firsts, len(spans)))
    is_full = np.ones(len(firsts), dtype=bool)
    is_full[[0, -1]] = counts[[0, -1]] >= np.median(counts)  # a part of a span at an end has another noise
    thinned = {name: _means(values, firsts, counts)[is_full] for name, values in columns.items()}
    said = f"{len(places)} rows are thinned to {is_full.sum()} means of {number} rows; a stated noise is that of a mean"
    return thinned, [said]


def _means(values: np.ndarray, firsts: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Means of spans, (m,), over the cells that have a number; NaN where a span has none."""
    is_number = ~np.isnan(values)
    if is_number.all():
        return np.add.reduceat(values, firsts) / counts
    numbers = np.add.reduceat(is_number.astype(np.int64), firsts)
    sums = np.add.reduceat(np.where(is_number, values, 0.0), firsts)
    return np.where(numbers > 0, sums / np.maximum(numbers, 1), np.nan)
