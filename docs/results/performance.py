"""Times of the usual work beside those of older releases, from the record that `python -m tests.benchmarks` keeps."""

from docs.results import Number, Table
from tests.benchmarks.record import NOW, read_record
from tests.benchmarks.rows import CALL, COMMAND, FIRST, POINT, describe
from tests.benchmarks.sweeps import COSTS, LARGE, read_rows

LIVE = True

METHODS = "methods"
GROUPS = {"calls": CALL, "points": POINT, "commands": COMMAND, "first_runs": FIRST}
"""Tables by their names in the page."""
LARGE_HEADS = {
    "points": "operating points",
    "seconds": "time [s]",
    "milliseconds_each": "time for each [ms]",
    "first_process_mb": "memory of the first process [MB]",
    "largest_worker_mb": "of the largest worker [MB]",
    "archive_mb": "archive [MB]",
}
COST_HEADS = {
    "sweep": "intake",
    "computing": "computing its points [s]",
    "one_process": "in one process [s]",
    "percent_more": "more than computing [%]",
    "two_processes": "in 2 processes [s]",
    "times_as_fast": "times as fast",
}
"""Columns of the records of sweeps, with their heads in the page."""


def compute():
    """Tables of times side by side, and what they were measured on."""
    lines = read_record()
    tables = {name: _compare([line for line in lines if line["group"] == group]) for name, group in GROUPS.items()}
    return {
        "machine": _machine(lines),
        "methods": _methods([line for line in lines if line["group"] == METHODS]),
        **tables,
        **_describe_sweeps(),
    }


def _describe_sweeps():
    """Time and memory of large sweeps, and what archives and a second process cost and save."""
    large, costs = read_rows(LARGE), read_rows(COSTS)
    return {
        "large_sweeps": _tabulate(large, LARGE_HEADS),
        "largest": Number(max(float(row["points"]) for row in large)),
        "memory": Number(max(float(row["first_process_mb"]) for row in large), "MB"),
        "sweep_costs": _tabulate(costs, COST_HEADS),
        "costs_points": Number(float(costs[0]["points"])),
        "costs_turns": Number(float(costs[0]["turns"])),
    }


def _tabulate(rows, heads):
    """Columns of a record with their units; commits as code."""
    return Table(
        [*heads.values(), "date", "commit"],
        [[*(row[key] for key in heads), row["date"], f"`{row['commit']}`"] for row in rows],
    )


def _machine(lines):
    """What the times were measured on, when, and of which commit."""
    whats = {"processor": "processor", "cores": "cores", "date": "date", "commit": "commit"}
    rows = [[what, ", ".join(sorted({line[key] for line in lines}))] for key, what in whats.items()]
    loads = [float(line["load"]) for line in lines]
    return Table(["measured on", ""], [*rows, ["other load before it, processes", f"{max(loads):.1f}"]])


def _methods(lines):
    """Methods for the bench: times as shares of the first's, time of an evaluation, error of the contacts."""
    heads = ["one stroke cycle of 100 ms", "time", "ratio", "for an evaluation of the rates", "contacts off by"]
    rows = []
    for line in lines:
        seconds, evaluations = float(line["seconds"]), line["evaluations"]
        rows.append(
            [
                line["words"],
                describe(seconds),
                _two(seconds / float(lines[0]["seconds"])),
                f"{_two(1e9 * seconds / int(evaluations))} ns" if evaluations else "—",
                f"{_two(1e9 * float(line['contacts_off']))} ns",
            ]
        )
    return Table(heads, rows or [_not_yet(heads)])


def _compare(lines):
    """Times of all releases by row, and how many times as long the older ones took."""
    codes = [*(code for code in dict.fromkeys(line["code"] for line in lines) if code != NOW), NOW]
    rows = {}
    for line in lines:
        rows.setdefault(line["words"], {})[line["code"]] = line
    heads = ["work", *codes, *(f"{code} : {NOW}" for code in codes[:-1])]
    return Table(heads, [[words, *_cells(by_code, codes)] for words, by_code in rows.items()] or [_not_yet(heads)])


def _not_yet(heads):
    """The row of a table whose rows are still to be measured."""
    return ["not measured yet", *["—"] * (len(heads) - 1)]


def _cells(by_code, codes):
    """Times with the cycles of operating points, then ratios; a dash where a release has no such thing."""
    times = [_seconds(by_code.get(code)) for code in codes]
    cycles = [by_code[code]["cycles"] if code in by_code else "" for code in codes]
    yield from (
        describe(time) + (f", {number} cycles" if number else "") for time, number in zip(times, cycles, strict=True)
    )
    yield from ("—" if time != time or times[-1] != times[-1] else _two(time / times[-1]) for time in times[:-1])


def _seconds(line):
    """The time that a line tells: processor time of first runs; NaN where there is none."""
    key = "processor_seconds" if line and line["group"] == FIRST else "seconds"
    return float(line[key]) if line and line[key] else float("nan")


def _two(value):
    """Two digits of a number."""
    rounded = float(f"{value:.2g}")
    return f"{rounded:g}" if rounded < 1000.0 else f"{rounded:.0f}"
