"""Map of the residuals of every signal, over the phases of a stroke or the angles of a cycle, on common columns."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from apesim.engine.angles import TURN
from apesim.studies.gap.report.comparison import ComparedSignal
from apesim.studies.measured import CYLINDER, ENGINE

SECTIONS = (
    ("before", 4),
    ("dead time", 10),
    ("opening", 14),
    ("dwell", 14),
    ("dead time", 10),
    ("closing", 14),
    ("rest", 10),
)
"""Sections of a valve's run, with the columns that each has at most."""
MAX_CYCLE_COLUMNS = 72
"""Most columns of a cycle: one for 5 degrees, as many as can be read."""


class ResidualMap(NamedTuple):
    """Rows are signals of runs, columns parts of the stroke or cycle."""

    rows: list[ComparedSignal]
    """Signal of each row."""
    sections: list[tuple[str, int]]
    """Name and number of columns of each; a cycle has one, from 0 to 360 deg."""
    before: np.ndarray
    """Mean residual of the calibrated machine in each cell, over what noise leaves of such a mean, (rows, columns); NaN
    where there is no sample."""
    after: np.ndarray | None
    """Mean residual of the machine with what was added, (rows, columns); None: nothing was added."""


def map_residuals(compared: Sequence[ComparedSignal]) -> ResidualMap:
    """Average the residuals of all signals over cells; a mean over the cycle fills its row.

    Rows of one sensor stand together.
    """
    sensors = list(dict.fromkeys(signal.block.sensor for signal in compared))
    rows = sorted(compared, key=lambda signal: sensors.index(signal.block.sensor))
    sections, edges = DIVISIONS.get(rows[0].block.run.bench, _divide_stroke)(rows)
    before = np.array([_average_cells(row, row.residuals_before, ends) for row, ends in zip(rows, edges, strict=True)])
    after_rows = [
        _average_cells(row, row.residuals_after, ends)
        for row, ends in zip(rows, edges, strict=True)
        if row.residuals_after is not None
    ]
    after = np.array(after_rows) if after_rows else None
    return ResidualMap(rows, sections, before, after)


def _average_cells(signal: ComparedSignal, residuals: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Means of cells in their own standard deviations."""
    if signal.is_mean:
        return np.full(len(edges) - 1, residuals[0])
    sums, _ = np.histogram(_find_abscissa(signal), edges, weights=residuals)
    counts, _ = np.histogram(_find_abscissa(signal), edges)
    return np.where(counts > 0, sums / np.sqrt(np.maximum(counts, 1)), np.nan)


def _find_abscissa(signal: ComparedSignal) -> np.ndarray:
    """Time of each sample [s], or its angle within the turn [deg]."""
    block = signal.block
    return np.degrees(block.angles % TURN) if block.run.bench == ENGINE else block.times


def _divide_cycle(rows: list[ComparedSignal]) -> tuple[list[tuple[str, int]], list[np.ndarray]]:
    """One section, with no more columns than any trace fills."""
    columns = min([MAX_CYCLE_COLUMNS, *(len(row.block.values) for row in rows if not row.is_mean)])
    return [("crank angle", columns)], [np.linspace(0.0, 360.0, columns + 1)] * len(rows)


def _divide_way(rows: list[ComparedSignal]) -> tuple[list[tuple[str, int]], list[np.ndarray]]:
    """Two sections, the strokes of a cylinder, from the first sample of each to its last."""
    columns = max(1, min(MAX_CYCLE_COLUMNS, min(len(row.block.values) for row in rows)) // 4)
    edges = []
    for row in rows:
        times, first = row.block.times, row.block.run.given["velocity"] > 0.0
        turn = int(np.flatnonzero(first != first[0])[0])
        middle = 0.5 * (times[turn - 1] + times[turn])
        halves = np.linspace(times[0], middle, columns + 1), np.linspace(middle, times[-1] + 1e-9, columns + 1)
        edges.append(np.concatenate([halves[0][:-1], halves[1]]))
    return [("first stroke", columns), ("stroke back", columns)], edges


def _divide_stroke(rows: list[ComparedSignal]) -> tuple[list[tuple[str, int]], list[np.ndarray]]:
    """Sections between the marks of each run, with fewer columns than samples, so that none is empty."""
    knots = [_find_knots(row) for row in rows]
    counts = np.array([_count_samples(row.block.times, ends) for row, ends in zip(rows, knots, strict=True)])
    widths = [
        max(1, int(min([max_columns, *(samples[samples > 0] - 1)])))
        for samples, (_, max_columns) in zip(counts.T, SECTIONS, strict=True)
    ]
    used = [number for number, there in enumerate(np.any(counts, axis=0).tolist()) if there]
    edges = [
        np.concatenate([*(np.linspace(ends[k], ends[k + 1], widths[k] + 1)[:-1] for k in used), ends[-1:]])
        for ends in knots
    ]
    return [(SECTIONS[k][0], widths[k]) for k in used], edges


def _count_samples(times: np.ndarray, knots: np.ndarray) -> list[int]:
    """Number of samples in each section."""
    return [int(np.sum((times >= low) & (times < high))) for low, high in pairwise(knots)]


def _find_knots(signal: ComparedSignal) -> np.ndarray:
    """Ends of the sections; a mark that never comes is where the next one is."""
    times, marks = signal.block.times, signal.marks
    names = ("opening_start", "opening_contact", "release", "closing_start", "closing_contact")
    knots = [min(times[0], 0.0), 0.0, *(marks[name] for name in names), times[-1] + 1e-9]
    for k in range(len(knots) - 2, 1, -1):
        knots[k] = knots[k + 1] if np.isnan(knots[k]) else min(knots[k], knots[k + 1])
    return np.array(knots)


DIVISIONS = {ENGINE: _divide_cycle, CYLINDER: _divide_way}
"""How the runs of a bench are divided; those of the valve by the marks of the model."""
