"""The record of a campaign, ``rounds/NAME.csv``: a line for each outcome of a round, with its day and commit."""

import csv
import datetime
from collections import Counter
from pathlib import Path
from typing import NamedTuple

from scipy.stats import chi2

from tests.folders import find_commit

from .campaign import Outcome

FOLDER = Path(__file__).parent / "rounds"
CONFIDENCE = 0.95


class Line(NamedTuple):
    """How often something became of trials of one kind in a round; what has a detail has a line of its own."""

    date: str
    commit: str
    first: int
    """Seed of the round's first trial; no round has the seeds of another."""
    last: int
    kind: str
    outcome: str
    count: int
    tried: int
    """How many of them tried what is promised."""
    broken: int
    detail: str = ""
    """Seed, and what tells of it."""


def read_record(name: str) -> list[Line]:
    """Lines of a campaign's record; none where it has no round yet."""
    path = FOLDER / f"{name}.csv"
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        types = Line.__annotations__
        return [Line(**{key: types[key](text) for key, text in line.items()}) for line in csv.DictReader(file)]


def find_next_seed(name: str) -> int:
    """The first seed that no round of a campaign has had."""
    return max((line.last + 1 for line in read_record(name)), default=0)


def add_round(name: str, outcomes: dict[int, Outcome]) -> None:
    """Add a round to the record of a campaign: outcomes by seed, of seeds that follow one another."""
    made = datetime.date.today().isoformat(), find_commit(), min(outcomes), max(outcomes)
    groups = Counter(
        (split_word(one.word), f"{seed}: {one.detail}" if one.detail else "", one.is_broken, one.is_void)
        for seed, one in outcomes.items()
    )
    added = [
        Line(*made, *words, count, 0 if is_void else count, count * is_broken, detail)
        for (words, detail, is_broken, is_void), count in sorted(groups.items())
    ]
    lines = [Line._fields, *read_record(name), *added]
    with (FOLDER / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows(lines)


def split_word(word: str) -> tuple[str, str]:
    """What was tried, and what became of it; a trial that was ended cannot tell what it tried.

    Examples
    --------
    >>> split_word("archive: done"), split_word("hangs")
    (('archive', 'done'), ('any', 'hangs'))
    """
    kind, _, what = word.partition(": ")
    return (kind, what) if what else ("any", kind)


def bound(broken: int, tried: int) -> float:
    """Upper bound on the share of trials that break a promise, with 95 % confidence: 3/n if none of n did.

    Examples
    --------
    >>> f"{bound(0, 1000):.4f} {bound(1, 1000):.4f}"
    '0.0030 0.0047'
    """
    return float(chi2.ppf(CONFIDENCE, 2 * (broken + 1))) / (2.0 * tried)
