import json
from dataclasses import replace

import numpy as np
import pytest

from apesim.archive import ArchiveError, write
from apesim.archive.comparison import Difference, diff, machine_differences, provenance_differences, summarise
from tests.archive_samples import MACHINE, sample


@pytest.fixture
def compare(tmp_path):
    def compare(a, b, **tolerances):
        return diff(write(a, tmp_path / "a.h5"), write(b, tmp_path / "b.h5"), **tolerances).differences

    return compare


def changed(name, at=None, value=None, **fields):
    archive = sample()
    variable = archive.variables[name]
    if at is not None:
        values = variable.values.astype("U20") if variable.kind == "text" else variable.values.copy()
        values[at] = value
        fields["values"] = values
    archive.variables[name] = replace(variable, **fields)
    return archive


def test_equal_archives_have_no_difference_and_nan_equals_nan(compare):
    assert compare(sample(), sample(created="later", numpy="0.1")) == []


def test_one_changed_sample_is_found(compare):
    value = np.nextafter(sample().variables["cylinder_pressure"].values[1, 3], np.inf)
    [row] = compare(sample(), changed("cylinder_pressure", (1, 3), value))
    assert row == Difference(
        "variable",
        "cylinder_pressure",
        1,
        "crank_angle = 540.0",
        sample().variables["cylinder_pressure"].values[1, 3],
        value,
        1,
    )


def test_largest_of_several_deviations_is_shown(compare):
    values = sample().variables["cylinder_pressure"].values.copy()
    values[2] += [1.0, 5.0, 0.0, -7.0, 2.0]
    [row] = compare(sample(), changed("cylinder_pressure", values=values))
    assert (row.run, row.where, row.samples) == (2, "crank_angle = 540.0", 4)


@pytest.mark.parametrize(
    ("name", "at", "value", "was"),
    [
        ("torque", 0, np.nan, 0.0),
        ("torque", 0, np.inf, 0.0),
        ("cycles", 1, 99, 8),
        ("intake", 0, 1, 0),
        ("warning", 1, "other", 'größer, "α"'),
    ],
)
def test_each_type_is_compared(compare, name, at, value, was):
    [row] = compare(sample(), changed(name, at, value), rtol=1e-3 if name == "torque" else 0.0)
    assert (row.name, row.run, row.a, row.samples) == (name, at, was, 1)
    assert row.b == value or np.isnan(row.b)


def test_tolerances_are_for_floats_only(compare):
    speed = sample().variables["speed"].values
    assert compare(sample(), changed("speed", 2, speed[2] + 0.01), atol=0.011) == []
    assert compare(sample(), changed("speed", 2, speed[2] * 1.001), rtol=1e-3) == []
    assert len(compare(sample(), changed("speed", 2, speed[2] + 0.01), atol=0.009)) == 1
    assert len(compare(sample(), changed("cycles", 2, 10), atol=5.0, rtol=1.0)) == 1


def test_what_is_nearly_zero_beside_the_largest_value_may_differ(compare):
    torque = sample().variables["torque"].values
    nearly = changed("torque", 0, 1e-9 * np.nanmax(torque))  # 0 there
    assert len(compare(sample(), nearly, rtol=1e-6)) == 1
    assert compare(sample(), nearly, rtol=1e-6, floor=1e-6) == []
    assert len(compare(sample(), changed("torque", 0, 1e-3 * np.nanmax(torque)), rtol=1e-6, floor=1e-6)) == 1


def test_the_summary_has_both_values_of_a_key_of_the_machine(compare):
    other = replace(sample(), machine=MACHINE.replace("2 ms", "3 ms"))
    [row] = summarise(compare(sample(), other))
    assert (row.kind, row.name, row.a, row.b) == ("machine", "valve.solenoid.dead_time", "2 ms", "3 ms")


def test_missing_runs_are_named_and_the_others_matched_by_number(compare):
    rows = compare(sample([0, 1, 4]), sample([1, 2, 4]))
    assert rows == [Difference("run", "run", 0, "", 0, None, 1), Difference("run", "run", 2, "", None, 2, 1)]
    assert [row.kind for row in compare(sample([0]), sample([1]))] == ["run", "run"]


def test_axes_and_forms_are_compared(compare):
    [row] = compare(sample(), sample(angles=6))
    assert (row.kind, row.name, row.a, row.b) == ("axis", "crank_angle", 5, 6)
    [row] = compare(sample(), changed("crank_angle", 1, 181.0))
    assert (row.kind, row.where, row.a, row.b) == ("axis", "crank_angle = 180.0", 180.0, 181.0)
    [row] = compare(sample(), changed("speed", unit="1/min"))
    assert row.a[2] == "rpm" and row.b[2] == "1/min"
    less = sample()
    del less.variables["speed"]
    [row] = compare(sample(), less)
    assert (row.name, row.a, row.b) == ("speed", "rpm", None)


def test_machine_differs_by_dotted_key(compare):
    other = MACHINE.replace("2 ms", "3 ms").replace('stroke = "90 mm"', "flag = true")
    rows = compare(sample(), replace(sample(), machine=other))
    assert [(row.kind, row.name, row.a, row.b) for row in rows] == [
        ("machine", "engine.stroke", "90 mm", None),
        ("machine", "valve.solenoid.dead_time", "2 ms", "3 ms"),
        ("machine", "engine.flag", None, True),
    ]


def test_machine_comments_and_order_do_not_count():
    assert machine_differences("a = 1\nb = 2 # x", "b = 2\na = 1") == []
    assert [row.name for row in machine_differences("a = 1", "a = 1.0")] == ["a"]
    assert [row.name for row in machine_differences("a = nan", "a = nan")] == []
    assert [row.name for row in machine_differences("a = {}", "")] == ["a"]
    assert [row.name for row in machine_differences("no toml", "")] == ["(text)"]


def test_provenance_is_listed_apart(tmp_path):
    a, b = write(sample(), tmp_path / "a.h5"), write(sample(created="later", note="x"), tmp_path / "b.h5")
    assert [(row.name, row.a, row.b) for row in provenance_differences(a, b)] == [
        ("created", "2024-01-01T00:00:00+00:00", "later"),
        ("note", None, "x"),
    ]


def test_unreadable_archives_are_an_error(tmp_path):
    with pytest.raises(ArchiveError):
        diff(write(sample(), tmp_path / "a.h5"), tmp_path / "none.h5")


def grid(speeds, actuations=("fixed", "corrected"), **fields):
    """An archive of a grid, its torque that of the coordinates, whatever the numbers of its runs are."""
    archive = sample(range(len(actuations) * len(speeds)))
    places = [(actuation, speed) for actuation in actuations for speed in speeds]
    codes = np.array([["fixed", "corrected"].index(actuation) for actuation, _ in places], dtype=np.int8)
    intake, speed, torque = (archive.variables[name] for name in ("intake", "speed", "torque"))
    archive.variables["intake"] = replace(intake, values=codes, meanings="0 fixed, 1 corrected")
    archive.variables["speed"] = replace(speed, values=np.array([speed for _, speed in places]))
    archive.variables["torque"] = replace(torque, values=100.0 * codes + np.array([speed for _, speed in places]))
    kept = {name: archive.variables[name] for name in ("run", "intake", "speed", "torque")}
    axes = json.dumps({"intake": list(actuations), "speed": [f"{speed:g} r/min" for speed in speeds]})
    return replace(archive, variables=kept, provenance=archive.provenance | {"axes": axes})


def test_runs_of_grids_are_matched_by_their_coordinates(compare):
    rows = compare(grid([300.0, 400.0, 500.0]), grid([400.0, 500.0, 600.0], ("corrected", "fixed")))
    assert [(row.kind, row.where) for row in rows] == [
        ("run", "intake = fixed, speed = 300.0"),
        ("run", "intake = corrected, speed = 300.0"),
        ("run", "intake = corrected, speed = 600.0"),
        ("run", "intake = fixed, speed = 600.0"),
    ]


def test_a_difference_between_grids_is_told_with_its_coordinates(compare):
    other = grid([400.0, 500.0])
    other.variables["torque"].values[3] *= 1.01
    [row] = compare(grid([300.0, 400.0, 500.0]), other)[2:]
    assert (row.name, row.run, row.where) == ("torque", 5, "intake = corrected, speed = 500.0")
    assert len(compare(grid([300.0, 400.0, 500.0]), other, rtol=0.011)) == 2


def test_an_axis_of_one_archive_only_is_told_and_counts_for_nothing_if_it_has_one_value(compare):
    other = grid([300.0, 400.0], ("corrected",))
    axes = json.loads(other.provenance["axes"])
    del axes["intake"]
    other = replace(other, provenance=other.provenance | {"axes": json.dumps(axes)})
    rows = compare(other, grid([400.0, 500.0], ("corrected",)))
    assert [(row.kind, row.name, row.where) for row in rows] == [
        ("axis", "intake", "in one of them only"),
        ("run", "run", "speed = 300.0"),
        ("run", "run", "speed = 500.0"),
    ]


def test_differences_are_summed_up_by_name_with_the_largest(compare):
    other = grid([300.0, 400.0])
    other.variables["torque"].values[1:3] += [4.0, -1.0]
    [row] = summarise(compare(grid([300.0, 400.0]), other))
    assert row[:4] == ("variable", "torque", 2, 4.0)
    assert row.relative == pytest.approx(4.0 / 404.0)
    assert row.where == row.where_relative == "intake = fixed, speed = 400.0"


def test_the_largest_relative_difference_has_a_place_of_its_own(compare):
    other = grid([300.0, 4000.0])
    other.variables["torque"].values[:2] += [5.0, 8.0]
    [row] = summarise(compare(grid([300.0, 4000.0]), other))
    assert (row.largest, row.where) == (8.0, "intake = fixed, speed = 4000.0")
    assert row.relative == pytest.approx(5.0 / 305.0) and row.where_relative == "intake = fixed, speed = 300.0"


def test_variables_that_agree_and_that_differ_are_counted(tmp_path):
    other = changed("torque", 0, 9.0)
    del other.variables["warning"]
    compared = diff(write(sample(), tmp_path / "a.h5"), write(other, tmp_path / "b.h5"))
    assert (compared.runs, compared.same, compared.different) == (3, 5, 2)


def at_speeds(speeds, **fields):
    """Runs located by a coordinate alone, without named axes; torque is that of the speed."""
    archive = sample(range(len(speeds)))
    kept = {name: archive.variables[name] for name in ("run", "speed", "torque")}
    kept["speed"] = replace(kept["speed"], values=np.array(speeds), coordinate=True)
    kept["torque"] = replace(kept["torque"], values=0.1 * np.array(speeds))
    return replace(archive, variables=kept)


def test_runs_with_coordinates_are_matched_by_them(compare):
    rows = compare(at_speeds([300.0, 400.0, 500.0]), at_speeds([500.0, 400.0]))
    assert [(row.kind, row.run, row.where) for row in rows] == [("run", 0, "speed = 300.0")]


def test_runs_that_coordinates_do_not_tell_apart_are_matched_by_number(compare):
    rows = compare(at_speeds([300.0, 300.0, 500.0]), at_speeds([300.0, 300.0, 600.0]))
    assert [(row.kind, row.name, row.run) for row in rows] == [("variable", "speed", 2), ("variable", "torque", 2)]
