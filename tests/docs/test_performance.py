"""Measured times: what is kept, and the tables that the page makes of it."""

import pytest

from docs.results import performance
from tests.benchmarks import record
from tests.benchmarks.environments import Cost
from tests.benchmarks.rows import CALL, COMMAND, FIRST, POINT, ROWS, describe, time_of

RUN = {"date": "2026-01-02", "commit": "abc1234", "processor": "a processor", "cores": "2", "load": "0.1"}
LINES = [
    {"name": "c", "group": "methods", "words": "in C", "code": "now", "seconds": 1e-4, "evaluations": 1000},
    {"name": "march", "group": "methods", "words": "march", "code": "now", "seconds": 3e-4, "evaluations": 1000},
    {"name": "run", "group": CALL, "words": "a call", "code": "0.1.0", "seconds": 4e-3},
    {"name": "run", "group": CALL, "words": "a call", "code": "now", "seconds": 1e-3},
    {"name": "new", "group": CALL, "words": "a new call", "code": "0.1.0", "why": "is not in apesim"},
    {"name": "new", "group": CALL, "words": "a new call", "code": "now", "seconds": 1e-3},
    {"name": "point", "group": POINT, "words": "a point", "code": "now", "seconds": 0.02, "cycles": 28},
    {"name": "first", "group": FIRST, "words": "a run", "code": "0.1.0", "seconds": 60.0, "processor_seconds": 30.0},
    {"name": "first", "group": FIRST, "words": "a run", "code": "now", "seconds": 20.0, "processor_seconds": 15.0},
]


@pytest.fixture
def kept(tmp_path, monkeypatch):
    file = tmp_path / "performance.csv"
    record.update_record([line | RUN | {"contacts_off": 1e-9} for line in LINES], file)
    monkeypatch.setattr(performance, "read_record", lambda: record.read_record(file))
    return file


def test_times_of_releases_stand_beside_each_other_with_their_ratio(kept):
    tables = performance.compute()
    assert tables["calls"].columns == ["work", "0.1.0", "now", "0.1.0 : now"]
    assert tables["calls"].rows == [["a call", "4 ms", "1 ms", "4"], ["a new call", "—", "1 ms", "—"]]
    assert tables["points"].rows == [["a point", "20 ms, 28 cycles"]]
    assert tables["first_runs"].rows == [["a run", "30 s", "15 s", "2"]]  # processor time
    assert tables["methods"].rows[1] == ["march", "300 µs", "3", "300 ns", "1 ns"]
    assert ["commit", "abc1234"] in tables["machine"].rows


def test_what_was_not_measured_is_said(kept):
    assert performance.compute()["commands"].rows == [["not measured yet", "—"]]


def test_a_row_that_is_measured_again_takes_its_place(kept):
    record.update_record([LINES[3] | RUN | {"seconds": 2e-3}], kept)
    assert performance.compute()["calls"].rows[0] == ["a call", "4 ms", "2 ms", "2"]
    assert len(record.read_record(kept)) == len(LINES)


def test_every_row_has_a_name_and_a_table_of_its_own():
    assert len({row.name for row in ROWS}) == len(ROWS)
    assert {row.group for row in ROWS} == {CALL, POINT, COMMAND, FIRST}


def test_first_runs_are_told_in_processor_time():
    cost = Cost(seconds=60.0, processor=30.0)
    assert (time_of(FIRST, cost), time_of(COMMAND, cost)) == (30.0, 60.0)
    assert [describe(s) for s in (123.0, 0.0456, 3.14e-4, float("nan"))] == ["120 s", "46 ms", "310 µs", "—"]
