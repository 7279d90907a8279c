"""Machine files with one wrong number: what was said of each, from the record of `tests.truth wrong-numbers`."""

from collections import Counter
from statistics import median

from docs.results import Number, Table, Value
from tests.campaigns.campaign import Outcome
from tests.campaigns.record import Line, read_record
from tests.campaigns.wrong_numbers import (
    HEADS,
    HOLDS,
    NAME,
    NAMED,
    NO_INTERVAL,
    OUTCOMES,
    REFUSED,
    Told,
    list_cells,
)
from tests.truth.scoring.tables import rate
from tests.truth.sealed.library import ENGINE, VALVE
from tests.truth.sealed.wrong_numbers import NUMBERS

LIVE = True

FAST = 10.0
"""Processor time that a case is to take at most [s]."""
BENCHES = {number.key: number.bench for number in NUMBERS}


def compute() -> dict[str, Value]:
    """Each case, how many were named, in which time, and the rounds."""
    lines = read_record(NAME)
    cases = [(line, Told.read(line.detail.split(": ", 1)[1])) for line in lines if line.outcome in OUTCOMES]
    rows = [_list_row(line) for line in sorted(lines, key=lambda line: int(line.detail.split(":")[0]))]
    rounds: list[list[str | Number]] = [
        [date, f"`{commit}`", f"{first} to {last}"]
        for date, commit, first, last in dict.fromkeys(line[:4] for line in lines)
    ]
    return {
        "cases": Table(list(HEADS), rows),
        "figures": Table(["of these cases", "count", "share", "95 % interval"], _count(lines, cases)),
        "times": Table(["bench", "cases", "median [s]", "longest [s]"], _list_times(cases)),
        "rounds": Table(["date", "commit", "seeds"], rounds),
        "count": Number(len(lines)),
    }


def _list_row(line: Line) -> list[str | Number]:
    """A case as a row of the table."""
    seed, _, detail = line.detail.partition(": ")
    return list_cells(int(seed), Outcome(f"{line.kind}: {line.outcome}", detail=detail))


def _count(lines: list[Line], cases: list[tuple[Line, Told]]) -> list[list[str | Number]]:
    """Shares of the cases, with the intervals of Clopper and Pearson."""
    counts = Counter(line.outcome for line in lines)
    intervals = Counter(told.interval for _, told in cases if told.interval != NO_INTERVAL)
    fast = sum(float(told.seconds) <= FAST for _, told in cases)
    counted = [
        ("named", counts[NAMED] + counts[REFUSED], len(lines)),
        *((outcome, counts[outcome], len(lines)) for outcome in OUTCOMES if outcome not in (NAMED, REFUSED)),
        ("named, and the interval holds the number", intervals[HOLDS], intervals.total()),
        (f"explained in {FAST:g} s of processor time or less", fast, len(lines)),
    ]
    rows: list[list[str | Number]] = []
    for what, hits, number in counted:
        share, count, interval = rate(hits, number)
        rows.append([what, count, share, interval])
    return rows


def _list_times(cases: list[tuple[Line, Told]]) -> list[list[str | Number]]:
    """Processor times by bench."""
    rows: list[list[str | Number]] = []
    for bench in (VALVE, ENGINE):
        seconds = [float(told.seconds) for line, told in cases if BENCHES[line.kind] == bench]
        rows.append([bench, Number(len(seconds)), f"{median(seconds):.1f}", f"{max(seconds):.1f}"])
    return rows
