"""What is left of every signal, over the phases of a stroke or the angles of a cycle, on common columns."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from apesim.engine.angles import TURN
from apesim.studies.measured import ENGINE

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
CYCLE_COLUMNS = 72


class ResidualMap(NamedTuple):
    """Rows are signals of runs, columns parts of the stroke or cycle."""

    rows: list
    """`apesim.studies.gap.report.comparison.Compared`"""
    sections: list
    """Name and number of columns of each; a cycle has one, from 0 to 360 deg."""
    before: np.ndarray
    """Mean of what the calibrated machine leaves in each cell, over what noise leaves of such a mean, shape (rows,
    columns); NaN where there is no sample."""
    after: np.ndarray | None


def residual_map(compared):
    """Average what is left over cells; a mean over the cycle fills its row.

    Parameters
    ----------
    compared : list of apesim.studies.gap.report.comparison.Compared

    Returns
    -------
    ResidualMap
        Rows of one sensor together.
    """
    sensors = list(dict.fromkeys(one.block.sensor for one in compared))
    rows = sorted(compared, key=lambda one: sensors.index(one.block.sensor))
    sections, edges = _cycle(rows) if rows[0].block.run.bench == ENGINE else _stroke(rows)
    before = np.array([_row(one, one.left_before, own) for one, own in zip(rows, edges, strict=True)])
    after = None
    if rows[0].left_after is not None:
        after = np.array([_row(one, one.left_after, own) for one, own in zip(rows, edges, strict=True)])
    return ResidualMap(rows, sections, before, after)


def _row(one, left, edges):
    """Means of cells in their own standard deviations."""
    if one.is_mean:
        return np.full(len(edges) - 1, left[0])
    sums, _ = np.histogram(_place(one), edges, weights=left)
    counts, _ = np.histogram(_place(one), edges)
    return np.where(counts > 0, sums / np.sqrt(np.maximum(counts, 1)), np.nan)


def _place(one):
    """Place of each sample: its time [s], or its angle within the turn [deg]."""
    run = one.block.run
    return np.degrees(run.angles % TURN) if run.bench == ENGINE else one.block.times


def _cycle(rows):
    """One section, with no more columns than any trace fills."""
    columns = min([CYCLE_COLUMNS, *(len(one.block.values) for one in rows if not one.is_mean)])
    return [("crank angle", columns)], [np.linspace(0.0, 360.0, columns + 1)] * len(rows)


def _stroke(rows):
    """Sections between the marks of each run, with fewer columns than samples, so that none is empty."""
    knots = [_knots(one) for one in rows]
    counts = np.array([_counts(one.block.times, own) for one, own in zip(rows, knots, strict=True)])
    widths = [max(1, int(min([most, *(own[own > 0] - 1)]))) for own, (_, most) in zip(counts.T, SECTIONS, strict=True)]
    used = [number for number, there in enumerate(counts.any(axis=0)) if there]
    edges = [
        np.concatenate([*(np.linspace(own[k], own[k + 1], widths[k] + 1)[:-1] for k in used), own[-1:]])
        for own in knots
    ]
    return [(SECTIONS[k][0], widths[k]) for k in used], edges


def _counts(times, knots):
    return [np.sum((times >= low) & (times < high)) for low, high in pairwise(knots)]


def _knots(one):
    """Ends of the sections; a mark that never comes is where the next one is."""
    times, marks = one.block.times, one.marks
    names = ("opening_start", "opening_contact", "release", "closing_start", "closing_contact")
    knots = [min(times[0], 0.0), 0.0, *(marks[name] for name in names), times[-1] + 1e-9]
    for k in range(len(knots) - 2, 1, -1):
        knots[k] = knots[k + 1] if np.isnan(knots[k]) else min(knots[k], knots[k + 1])
    return np.array(knots)
