"""Curves: two columns from a file or a table, and what is refused."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apesim.quantities import NO_CURVE, InvalidValue
from apesim.quantities.files import MAX_BYTES
from tests.apesim.quantities.samples import CURVE


def read_csv(folder, text, curve=CURVE):
    (folder / "curve.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    return curve.read("curve.csv", folder=folder)


@pytest.mark.parametrize(
    "text",
    [
        "time [ms],opening [-]\n0,0\n1.5,1\n",
        "\ufefftime [s], opening [%]\r\n0,0\r\n\r\n0.0015,1e2\r\n",
        "run,opening [-],time [us]\na,0,0\nb,1.0,1500",
    ],
)
def test_curve_of_a_file(tmp_path, text):
    array = read_csv(tmp_path, text)
    assert array.tolist() == [[0.0, 0.0], [0.0015, 1.0]]
    assert array.dtype == np.float64
    assert array.flags.c_contiguous


def test_curve_of_a_table_and_none():
    assert CURVE.read({"opening [%]": [0, 50.0], "time [ms]": [0, 1.5]}).tolist() == [
        [0.0, 0.0],
        [0.0015, 0.5],
    ]
    assert CURVE.read("") is NO_CURVE
    assert CURVE.render(NO_CURVE) == ""


@given(st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=5, unique=True))
def test_a_printed_curve_reads_back_as_itself(values):
    array = np.column_stack([np.sort(np.array(values)), values])
    assert np.array_equal(CURVE.read(CURVE.render(array)), array)


@pytest.mark.parametrize(
    ("text", "wrong", "right"),
    [
        ("", "no CSV", "time [ms],opening [-]"),
        ("time [ms],opening [-]\n", "no CSV", "time [ms],opening [-]"),
        ("time [ms],opening [-]\n0,0\n1\n", "no CSV", "time [ms],opening [-]"),
        ('time [ms],opening [-]\n0,0\n"1,1\n', "no CSV", "time [ms],opening [-]"),
        ("time [ms],time [ms],opening [-]\n0,0,0\n1,1,1\n", "no CSV", "time [ms],opening [-]"),
        ("time [ms],time [s],opening [-]\n0,0,0\n1,1,1\n", "2 columns 'time'", "time [ms],opening [-]"),
        ("time [ms],area [-]\n0,0\n1,1\n", "no columns 'opening'", "time [ms],opening [-]"),
        ("time,opening [-]\n0,0\n1,1\n", "'time' has no unit", "time [ms],opening [-]"),
        ("time [foo],opening [-]\n0,0\n1,1\n", "'foo' is no known unit", "time [ms],opening [-]"),
        ("time [mm],opening [-]\n0,0\n1,1\n", "'mm' is no unit of 'time'", "time [ms],opening [-]"),
        ("time [ms],opening [-]\n0,0\n", "1 and 1 numbers", "2 to 100000"),
        ("time [ms],opening [-]\n0,0\n2,1\n2,1\n", "does not rise in row 3", "sort"),
        ("time [ms],opening [-]\n1,0\n0,1\n", "does not rise in row 2", "sort"),
        ("time [ms],opening [-]\n0,0\n1,nan\n", "'nan' in row 2", "numbers"),
        ("time [ms],opening [-]\n0,0\n1,\n", "'' in row 2", "numbers"),
        ("time [ms],opening [-]\n0,0\ninf,1\n", "'inf' in row 2", "numbers"),
        ("time [ms],opening [-]\n0,0\n1,1e400\n", "'1e400' in row 2", "numbers"),
        (b"time [ms],opening [-]\n0,0\n\xff,1\n", "no text in line 3", "UTF-8"),
        (b"x" * (MAX_BYTES + 1), "larger than 10 MB", "keep fewer rows"),
    ],
)
def test_no_curves(tmp_path, text, wrong, right):
    with pytest.raises(InvalidValue) as caught:
        read_csv(tmp_path, text)
    assert wrong in caught.value.wrong
    assert right in caught.value.right


@pytest.mark.parametrize(
    ("raw", "wrong"),
    [
        (3, "3 is no curve"),
        (True, "True is no curve"),
        ([[0, 0], [1, 1]], "is no curve"),
        ({"time [ms]": 3, "opening [-]": [0, 1]}, "is no curve"),
        ({"time [ms]": [0, 1]}, "1 columns, not 2"),
        ({"time [ms]": [0, 1], "opening [-]": [0, 1], "x [m]": [0, 1]}, "3 columns, not 2"),
        ({"time [ms]": [0, 1], "opening [-]": [0]}, "2 and 1 numbers"),
        ({"time [ms]": [0, 1], "opening [-]": [0, True]}, "True in row 2"),
        ({"time [ms]": [0, 1], "opening [-]": [0, math.nan]}, "nan in row 2"),
        ({"time [ms]": [0, 1], "opening [-]": [0, [1]]}, "[1] in row 2"),
        ("absent.csv", "there is no file"),
        ("/dev/zero", "there is no file '/dev/zero'"),
        ("nul\0", "there is no file"),
        ("a" * 300, "cannot be read: File name too long"),
    ],
)
def test_no_tables(raw, wrong):
    with pytest.raises(InvalidValue) as caught:
        CURVE.read(raw)
    assert wrong in caught.value.wrong
    assert caught.value.right
