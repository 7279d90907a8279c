from dataclasses import replace

import numpy as np
import pytest

from apesim.archive import Variable, validate
from tests.archive_samples import sample

ONES = np.ones(3)


@pytest.mark.parametrize(
    ("name", "variable", "message"),
    [
        ("x", Variable(("run",), ONES.astype(np.float32), "m", "x"), "float32"),
        ("x", Variable(("run",), ONES.astype(">f8"), "m", "x"), "type >f8"),
        ("x", Variable(("run",), ONES.astype(bool), "1", "x"), "bool"),
        ("x", Variable(("run",), np.array([None] * 3), "1", "x"), "object"),
        ("x", Variable(("run",), np.array([b"a"] * 3), "1", "x"), r"S1"),
        ("x", Variable(("run",), [1.0, 2.0, 3.0], "m", "x"), "list"),
        ("x", Variable(("run",), ONES, "", "x"), "no unit"),
        ("x", Variable(("run",), ONES, " ", "x"), "no unit"),
        ("x", Variable(("run",), ONES, "m\n", "x"), "unit"),
        ("x", Variable(("run",), ONES, "m", "a\x1b[2J"), "description"),
        ("x", Variable(("run",), ONES, "m" * 40_000, "x"), "unit"),
        ("x", Variable(("run",), np.ones(4), "m", "x"), "4 values along 'run' of 3"),
        ("x", Variable(("run",), np.ones((3, 2)), "m", "x"), "shape"),
        ("x", Variable(("run", "run"), np.ones((3, 3)), "m", "x"), "shape"),
        ("x", Variable(("crank_angle", "run"), np.ones((5, 3)), "m", "x"), "begin with 'run'"),
        ("x", Variable((), np.array(1.0), "m", "x"), "begin with 'run'"),
        ("x", Variable(("run", "time"), np.ones((3, 2)), "m", "x"), "no variable for its axis 'time'"),
        ("x", Variable(("run", "speed"), np.ones((3, 3)), "m", "x"), "no variable for its axis 'speed'"),
        ("x", Variable(("run",), np.array([1.0, np.nan, 1.0]), "m", "x", finite=True), "finite"),
        ("crank_angle", Variable(("crank_angle",), np.array([0, 1, 2, 3, np.nan]), "deg", "x"), "finite"),
        ("x", Variable(("run",), np.array(["a", "b\0c", ""]), "1", "x"), "NUL"),
        ("x", Variable(("run",), np.array(["a", "\ud800", ""]), "1", "x"), "UTF-8"),
        ("x", Variable(("run",), np.array([0, 1, 2], np.int8), "1", "x", "0 epv, 1 cam"), "code 2"),
        ("x", Variable(("run",), np.array([0, 1, 1], np.int8), "1", "x", "epv, cam"), "meanings"),
        ("x", Variable(("run",), ONES, "1", "x", "1 cam"), "meanings"),
        ("../x", Variable(("run",), ONES, "m", "x"), "no name"),
        ("about", Variable(("run",), ONES, "m", "x"), "no name"),
        ("", Variable(("run",), ONES, "m", "x"), "no name"),
        ("run", Variable(("run",), np.array([0, 2, 1]), "1", "x"), "increasing"),
        ("run", Variable(("run",), np.array([0, 1, 1]), "1", "x"), "increasing"),
        ("run", Variable(("run",), np.array([-1, 0, 1]), "1", "x"), "not negative"),
        ("run", Variable(("run",), ONES, "1", "x"), "int64"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(name, variable, message):
    archive = sample()
    validate(archive)
    archive.variables[name] = variable
    with pytest.raises(ValueError, match=message) as caught:
        validate(archive)
    assert name in str(caught.value)


def test_runs_texts_and_provenance_are_demanded():
    with pytest.raises(ValueError, match="run"):
        validate(replace(sample(), variables={}))
    with pytest.raises(ValueError, match="machine"):
        validate(replace(sample(), machine="a\0b"))
    with pytest.raises(ValueError, match="provenance 'n': 1 is not text"):
        validate(replace(sample(), provenance={"n": 1}))
