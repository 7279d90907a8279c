"""The factor by which 95 % intervals of strengths would hold 95 % of the truths of sealed cases."""

import numpy as np
from scipy.stats import norm

from .score import ROUNDING
from .tables import rate

HALF = float(norm.isf(0.025))
"""Half the width of a 95 % interval, in standard deviations."""
LEVEL = 0.95
"""Share of the truths that the intervals are to hold, and level of the factor's own interval."""
DRAWS = 2000
"""Draws of cases for the factor's interval: its ends scatter by some per cent of its width."""
HEADS = (
    "cases that count",
    "strengths",
    "cases",
    "within",
    "counts",
    "95 % interval",
    "factor",
    "95 % interval of the factor",
)
HEADS_OF_MISSED = "seed", "strength", "verdict", "hidden", "standard deviations off"


def find_distance(row, true):
    """How far a strength is off, in the standard deviations that its interval has on the side of the truth.

    Parameters
    ----------
    row : dict
        Of ``effects`` or ``sure`` of a verdict.
    true : float
        What the rig has, in the unit of the row.

    Returns
    -------
    float
        0 where the interval goes as far as the parameter may: it holds the truth whatever the factor.
    """
    low, high = row["interval_95"]
    side, end = ("high", high) if true > row["value"] else ("low", low)
    if side in row["open_ends"]:
        return 0.0
    away, half = true - row["value"], abs(end - row["value"])
    if abs(away) <= ROUNDING * abs(row["value"]):
        return 0.0
    return HALF * away / half if half else float(np.copysign(np.inf, away))


def find_factor(distances):
    """The factor of all intervals by which they hold the share `LEVEL` of the truths.

    Parameters
    ----------
    distances : sequence of float
    """
    return float(np.quantile(np.abs(distances), LEVEL, method="inverted_cdf")) / HALF


def bootstrap_factor(by_case, seed=1):
    """Interval of the factor, over cases that are drawn anew from those that are there.

    Parameters
    ----------
    by_case : sequence of sequences of float
        Distances of each case, of which those of one case are drawn together, as an error may be common to them.
    seed : int

    Returns
    -------
    tuple of float
    """
    rng = np.random.default_rng(seed)
    drawn = [
        find_factor(np.concatenate([by_case[place] for place in rng.integers(len(by_case), size=len(by_case))]))
        for _ in range(DRAWS)
    ]
    tail = 0.5 * (1.0 - LEVEL)
    return tuple(np.quantile(drawn, [tail, 1.0 - tail]).tolist())


def list_missed(scored):
    """Cells of the strengths whose intervals do not hold the truth, the farthest first, see `HEADS_OF_MISSED`.

    Parameters
    ----------
    scored : sequence of truth.scoring.score.Scored
    """
    distances = [(one, row, find_distance(row, true)) for one in scored for row, true in one.strengths]
    missed = sorted((each for each in distances if abs(each[2]) > HALF), key=lambda each: -abs(each[2]))
    return [
        [one.answer["seed"], row["name"], one.said, " and ".join(one.hidden), f"{distance:.2f}"]
        for one, row, distance in missed
    ]


def list_rows(scored):
    """Cells of all cases, and of those where nothing is hidden beside what is said, see `HEADS`.

    What is hidden beside a strength and does nearly the same moves it by more than any factor of an interval is for.
    """
    alone = [one for one in scored if set(one.hidden) <= set(one.physics.first)]
    return [["all", *row_of(scored)], ["nothing hidden beside what is said", *row_of(alone)]]


def row_of(scored):
    """Cells of some cases but for their name, see `HEADS`.

    Parameters
    ----------
    scored : sequence of truth.scoring.score.Scored
    """
    by_case = [[find_distance(*strength) for strength in one.strengths] for one in scored]
    by_case = [distances for distances in by_case if distances]
    distances = [distance for distances in by_case for distance in distances]
    cells = [len(distances), len(by_case), *rate(sum(abs(distance) <= HALF for distance in distances), len(distances))]
    if not distances:
        return [*cells, "–", "–"]
    low, high = bootstrap_factor(by_case)
    return [*cells, f"{find_factor(distances):.2f}", f"{low:.2f} – {high:.2f}"]
