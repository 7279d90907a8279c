"""Order of rows: an angle that wraps is made to go on; what else does not rise is named with what to do."""

from collections.abc import Mapping
from math import pi

import numpy as np

from apesim.engine.angles import DEGREE
from apesim.quantities import InvalidValue

TURNS = 2.0 * pi, 4.0 * pi
"""Angles by which a wrapped angle falls back [rad]: a turn, or a cycle of four strokes."""
MAX_ANGLE_STEP = 30.0 * DEGREE * (1.0 + 1e-9)
"""Usual step of the crank angle from which neither valve nor indicator diagram can be seen: its unit is a wrong one."""
MAX_WRAPPED_STEP = 10.0
"""Largest step over a wrap in usual steps: some rows may be lost there, and another record begins anywhere."""
MIN_RECORD = 8
"""Rows of a record: of fewer nothing is judged, and of several in one file shorter ones are rows in disorder."""
MIN_EQUALS = 0.2
"""Share of rows with the time of the row before them, from which times have too few digits; below, single rows stand
there twice."""
MIN_SORTED_PAIRS = 0.95
"""Share of pairs of rows in which the same one is the larger, from which they are smallest and largest values: pairs of
noise have half of it."""


def unwrap_angle(angles: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, str]:
    """Make a crank angle [rad] that falls back by a turn, or by two, go on; else it stays as it is.

    `angles` (n,) have no NaN; `rows` are the numbers of their rows in the file, from 1. The hint says what was done, ""
    for nothing.

    >>> angles, hint = unwrap_angle(np.radians([358.0, 359.0, 0.0, 1.0]), np.arange(1, 5))
    >>> np.degrees(angles).round(9).tolist(), hint
    ([358.0, 359.0, 360.0, 361.0], 'falls back by 360 deg in row 3; it is read as going on')
    """
    steps = np.diff(angles)
    falls = np.flatnonzero(steps < 0.0)
    if not len(falls) or not np.any(steps > 0.0):
        return angles, ""
    usual = float(np.median(steps[steps > 0.0]))
    for turn in TURNS:
        over = steps[falls] + turn
        if np.all((over > 0.0) & (over <= MAX_WRAPPED_STEP * usual)):
            turns = np.zeros(len(angles))
            turns[falls + 1] = turn
            where = f"{len(falls)} times, first in" if len(falls) > 1 else "in"
            said = f"falls back by {180.0 / pi * turn:.0f} deg {where} row {rows[falls[0] + 1]}; it is read as going on"
            return angles + np.cumsum(turns), said
    return angles, ""


def find_coarse_angle(angles: np.ndarray) -> InvalidValue | None:
    """Find whether a crank angle [rad] goes round too fast, as one in another unit than is said does.

    `angles` (n,) have no NaN. Returns what is wrong, and what to do; None where nothing is.

    >>> find_coarse_angle(np.arange(360.0)).wrong
    'its rows are 57.3 deg apart; is its unit right?'
    """
    steps = np.diff(angles)
    if len(angles) < MIN_RECORD or not np.any(steps > 0.0):
        return None
    step, turns = float(np.median(steps[steps > 0.0])), float(np.ptp(angles)) / TURNS[0]
    right = 'write the unit that the file has, e.g. unit.crank_angle = "deg" in [read]; else record finer'
    if step > MAX_ANGLE_STEP:
        return InvalidValue(f"its rows are {step / DEGREE:.3g} deg apart; is its unit right?", right)
    if turns > len(angles) / turns:
        many = f"{turns:.3g} turns with {len(angles) / turns:.3g} rows each"
        return InvalidValue(f"{many}; is its unit right?", f"{right}, or fewer turns")
    return None


def find_disorder(
    places: np.ndarray, rows: np.ndarray, others: Mapping[str, np.ndarray], shown: np.ndarray, unit: str
) -> InvalidValue | None:
    """Find why the column that traces stand over does not rise, and what to do; None where it rises.

    `places` (n,) are its values without NaN [SI], `rows` the numbers of their rows in the file, from 1, `others` the
    other columns, `shown` its values as the file has them, in `unit`.
    """
    steps = np.diff(places)
    wrong = np.flatnonzero(steps <= 0.0)
    if not len(wrong):
        return None

    # From the surest reason on: too few rows to tell any, then all of them turned round, then equal places.
    falls = np.flatnonzero(steps < 0.0)
    if len(places) < MIN_RECORD:
        return InvalidValue(f"does not rise in row {rows[wrong[0] + 1]}", "sort the rows, one of equals")
    if len(falls) == len(steps):
        return InvalidValue("falls from row to row", "turn the order of the rows round")

    # Times that stand still but never fall: pairs of extremes look like times of too few digits, and are told first.
    if not len(falls) and len(wrong) >= MIN_EQUALS * len(steps):
        if _are_pairs_of_extremes(steps, others):
            right = "record without peak detection, or keep one row of each pair"
            return InvalidValue("stands in two rows, of smallest and largest values", right)
        return InvalidValue(
            "stands in several rows at once",
            'write it with more digits, or sample_interval = "0.02 ms" in [read] if the rows are evenly spaced',
        )

    # Long stretches that each rise are several records in one file; short ones are rows in disorder.
    starts, ends = np.append(0, falls + 1), np.append(falls, len(steps))
    lengths = ends + 1 - starts
    if len(falls) and lengths.min() >= MIN_RECORD and np.all(places[ends[1:]] > places[starts[:-1]]):
        many = f"{len(lengths)} segments of {lengths[0]} rows"
        if len(lengths) == 2 or np.ptp(lengths):
            many = f"{'two' if len(lengths) == 2 else len(lengths)} records, one after the other"
        first = starts[1]
        back = f"falls back to {shown[first]:g} {unit} in row {rows[first]}"
        return InvalidValue(f"{back}: {many}", "save each in a file of its own")
    return InvalidValue(f"does not rise in row {rows[wrong[0] + 1]}", "sort the rows, one of equals")


def _are_pairs_of_extremes(steps: np.ndarray, others: Mapping[str, np.ndarray]) -> bool:
    """Whether rows stand in pairs of equal places, and one row of each pair holds the larger value of a column."""
    firsts = np.arange(int(steps[0] != 0.0), len(steps), 2)
    if np.any(steps[firsts] != 0.0) or not np.all(steps[firsts[1:] - 1] > 0.0):
        return False
    for values in others.values():
        signs = np.sign(values[firsts + 1] - values[firsts])
        larger = [np.sum(signs > 0.0), np.sum(signs < 0.0)]
        if max(larger) >= MIN_SORTED_PAIRS * max(sum(larger), 1):
            return True
    return False
