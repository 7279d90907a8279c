"""Numbers in the text: what moved is found and what may move is not."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from docs import results
from docs.extensions import results as extension
from docs.results import Number, Result, Table, Text


def result(**values):
    """A result with these values, made by no code."""
    return Result("torques", "Torques.", "2026-01-31", 2.5, "3.11", {}, "", "0123abc", values)


def moves(before, after):
    return list(results.find_moves(result(torque=before), result(torque=after)))


@pytest.mark.parametrize(
    ("value", "error", "digits"),
    [
        (29.3777, 0.005, "29.38"),
        (29.3777, 0.05, "29.4"),
        (29.3777, 0.5, "29"),
        (29.3777, 0.01, "29.38"),
        (2939.7, 5.0, "2940"),
        (-0.004, 0.005, "0.00"),
        (-0.006, 0.005, "-0.01"),
        (27.0, 0.0, "27"),
    ],
)
def test_the_error_of_a_number_decides_its_digits(value, error, digits):
    assert Number(value, "N·m", error).digits == digits


def test_a_unit_stands_behind_its_number_and_no_line_ends_between_both():
    assert Number(29.3777, "N·m", 0.005).text == "29.38\u00a0N·m"
    assert Number(35.12, "°", 0.05).text == "35.1°"
    assert Number(21.9, "%", 0.05).text == "21.9\u202f%"


def test_a_number_may_move_by_its_error_and_not_by_more():
    before = Number(29.38, "N·m", error=0.005)
    assert moves(before, replace(before, value=29.3845)) == []
    [line] = moves(before, replace(before, value=29.3855))
    assert line.startswith("torques.torque: 29.38 N·m became 29.3855 N·m")
    assert len(moves(before, replace(before, value=float("nan")))) == 1
    assert len(moves(before, replace(before, unit="J"))) == 1


def test_a_count_may_not_move():
    assert moves(Number(27), Number(27)) == []
    assert len(moves(Number(27), Number(28))) == 1


def test_a_cell_of_a_table_that_moved_is_named():
    before = Table(
        ["intake", "torque [N·m]"], [["cam", Number(29.95, error=0.005)], ["ideal", Number(38.97, error=0.005)]]
    )
    other_number = Table(before.columns, [before.rows[0], ["ideal", Number(39.5, error=0.005)]])
    other_text = Table(before.columns, [["cams", before.rows[0][1]], before.rows[1]])
    assert moves(before, before) == []
    [line] = moves(before, other_number)
    assert "row 2, torque [N·m]: 38.97" in line
    [line] = moves(before, other_text)
    assert line == "torques.torque, row 1, intake: 'cam' became 'cams'"
    assert moves(before, Table(before.columns, before.rows[:1])) == ["torques.torque: another table"]


PRINTED = Text("  brake torque  29.378 N m\n ─────\nclosure 9.9e-16; 88 runs", error=1e-3)


def test_words_of_a_text_may_not_change_and_its_numbers_by_their_relative_error():
    assert moves(PRINTED, replace(PRINTED, text=PRINTED.text.replace("29.378", "29.401"))) == []
    [line] = moves(PRINTED, replace(PRINTED, text=PRINTED.text.replace("29.378", "29.421")))
    assert line == "torques.torque: 29.378 became 29.421 (relative error 0.001)"
    [line] = moves(PRINTED, replace(PRINTED, text=PRINTED.text.replace("brake", "shaft")))
    assert line == "torques.torque: other words, 'brake' became 'shaft'"
    assert len(moves(PRINTED, replace(PRINTED, text=PRINTED.text + " and more"))) == 1
    assert len(moves(PRINTED, replace(PRINTED, text=PRINTED.text.replace("29", "-29")))) == 1


def test_rounding_and_spaces_of_a_text_are_not_compared():
    assert moves(PRINTED, replace(PRINTED, text=PRINTED.text.replace("9.9e-16", "1.2e-15"))) == []
    assert moves(PRINTED, replace(PRINTED, text=PRINTED.text.replace(" ─────", "────────").replace("  ", "   "))) == []


def test_what_appeared_went_or_became_something_else_is_a_move():
    one, two = result(torque=Number(1.0)), result(power=Number(1.0))
    assert list(results.find_moves(one, two)) == ["torques.power: new", "torques.torque: gone"]
    assert moves(Number(1.0), Text("1")) == ["torques.torque: a Number became a Text"]


def test_what_is_saved_is_read_again(tmp_path, monkeypatch):
    monkeypatch.setattr(results, "HERE", tmp_path)
    (tmp_path / "torques.py").touch()
    table = Table(["intake", "torque [N·m]"], [["cam", Number(29.95, "N·m", 0.005)]])
    saved = result(torque=Number(29.378, "N·m", 0.005), table=table, printed=PRINTED)
    assert results.save(saved) == tmp_path / "torques.json"
    assert results.load("torques") == saved


@pytest.mark.parametrize("is_fresh", [False, True])
def test_a_fresh_build_shows_short_numbers_as_they_are_now_and_tells_what_moved(is_fresh, monkeypatch, capsys):
    monkeypatch.setattr(extension, "LOADED", {})
    monkeypatch.setattr(results, "names", lambda: ["valve_bench", "timing_map"])  # a short one, a long one
    monkeypatch.setattr(results, "load", lambda name: result(torque=Number(1.0)))
    monkeypatch.setattr(results, "compute", lambda name: result(torque=Number(2.0)))
    extension.compute_results(SimpleNamespace(config=SimpleNamespace(apesim_fresh_results=is_fresh)))
    assert ({"valve_bench": result(torque=Number(2.0))} if is_fresh else {}) == extension.LOADED
    assert ("torques.torque: 1  became 2" in capsys.readouterr().err) == is_fresh


def test_every_file_of_results_was_computed_and_says_what_it_is():
    kept = {path.stem for path in results.HERE.glob("*.json")}
    assert kept == {name for name in results.names() if not results.is_live(name)}
    for name in kept:
        stored = results.load(name)
        assert stored.name == name and stored.what.endswith(".") and stored.values
