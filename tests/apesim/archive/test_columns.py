"""Columns of archives, and runs told by their coordinates."""

import numpy as np
import pytest

from apesim.archive import Archive, validate
from apesim.archive.columns import column, meanings_of, run_axis, run_text, values_of


def test_flags_and_codes_are_int8_and_numbers_stay():
    assert column([True, False], "1", "x").values.dtype == np.int8
    assert column([1, 0], "1", "x", "0 epv, 1 cam").values.dtype == np.int8
    assert column([3, 4], "1", "x").values.dtype == np.int64
    assert column([3.0, np.nan], "m", "x").values.dtype == np.float64
    assert column(["a", "b"], "1", "x").kind == "text"


def archive():
    variables = {
        "run": run_axis(2),
        "speed_rpm": column([900.0, 1800.0], "r/min", "speed", coordinate=True),
        "supply_pressure": column([0.59e6, 1.01325e6], "Pa abs", "pressure", coordinate=True),
        "intake": column([1, 0], "1", "intake", meanings_of(["epv", "cam"]), coordinate=True),
        "duty": column([0.25, 0.5], "1", "share", coordinate=True),
        "torque": column([1.0, 2.0], "N m", "torque"),
    }
    return Archive("", {}, variables)


@pytest.mark.parametrize(
    ("place", "text"),
    [
        (0, "run 0 (900 r/min, 0.59 MPa abs, intake cam, duty 0.25)"),
        (1, "run 1 (1800 r/min, 1.01325 MPa abs, intake epv, duty 0.5)"),
    ],
)
def test_a_run_is_told_by_its_coordinates(place, text):
    validate(archive())
    assert run_text(archive(), place) == text


def test_values_by_name():
    assert values_of(archive())["torque"].tolist() == [1.0, 2.0]
