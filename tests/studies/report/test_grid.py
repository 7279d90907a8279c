"""Variables over the axes that they have: curves, maps, and what becomes of further axes."""

import json

import numpy as np
import pytest

from apesim.archive import Archive, Variable
from apesim.archive.columns import column, run_axis
from apesim.studies.report.figures.curves import Curves
from apesim.studies.report.figures.maps import Map
from apesim.studies.report.grid import MAX_FRAMES, MAX_LINES, Cubes, find_common_words


def grid(**axes):
    """Archive over a full grid: a number that says its place, and a trace."""
    places = np.indices([len(values) for values in axes.values()]).reshape(len(axes), -1)
    count = places.shape[1]
    variables = {"run": run_axis(count)}
    for place, (name, values) in zip(places, axes.items(), strict=True):
        is_word = isinstance(values[0], str)
        codes = ", ".join(f"{number} {word}" for number, word in enumerate(values)) if is_word else ""
        own = np.arange(len(values), dtype=np.int8) if is_word else np.array(values, dtype=float)
        variables[name] = Variable(("run",), own[place], "1" if is_word else "K", name, codes, coordinate=True)
    weights = 10.0 ** np.arange(len(axes))
    variables["sum"] = column(weights @ places, "W", "its place")
    variables["time"] = Variable(("time",), np.linspace(0.0, 1.0, 1001), "s", "time")
    variables["trace"] = Variable(("run", "time"), np.arange(count)[:, None] + np.zeros(1001), "m", "a trace")
    texts = {name: list(map(str, values)) for name, values in axes.items()}
    return Archive("", {"axes": json.dumps(texts)}, variables)


def test_one_axis_gives_a_curve_in_the_shown_unit():
    figure = Cubes(grid(warmth=[280, 290, 300])).draw("sum")
    assert isinstance(figure, Curves) and figure.x.named == "warmth [K]" and figure.y.unit == "kW"
    assert figure.lines[0].values[0].tolist() == pytest.approx([0.0, 1e-3, 2e-3])


def test_two_axes_of_numbers_give_a_map_or_a_line_each():
    cubes = Cubes(grid(warmth=[280, 290, 300], other=[1, 2, 3, 4]))
    figure = cubes.draw("sum")
    assert isinstance(figure, Map) and (figure.x.label, figure.y.label) == ("other", "warmth")
    assert (1e3 * figure.values[0][2]).tolist() == pytest.approx([2.0, 12.0, 22.0, 32.0])
    lines = cubes.draw("sum", as_map=False).lines
    assert [line.label for line in lines] == ["280 K", "290 K", "300 K"]
    assert (1e3 * lines[1].values[0]).tolist() == pytest.approx([1.0, 11.0, 21.0, 31.0])


def test_words_are_lines_with_the_look_of_their_code_and_the_rest_are_frames():
    cubes = Cubes(grid(valve=["epv", "cam"], warmth=[270, 280, 290, 300, 310], other=list(range(20))))
    figure = cubes.draw("sum", as_map=False)
    assert [(line.label, line.look) for line in figure.lines] == [("epv", 0), ("cam", 1)]
    assert figure.frames.texts == ("270 K", "280 K", "290 K", "300 K", "310 K") and figure.frames.start == 2
    assert 1e3 * figure.lines[1].values[2][3] == pytest.approx(1.0 + 20.0 + 300.0)
    assert cubes.draw("sum").frames.name == "valve"


def test_what_is_left_out_is_said():
    figure = Cubes(grid(first=list(range(30)), second=list(range(20)), third=list(range(15)))).draw("sum")
    assert len(figure.frames.texts) == MAX_FRAMES and f"{MAX_FRAMES} of 15 are shown" in figure.note
    trace = Cubes(grid(warmth=list(range(30)))).draw("trace")
    assert len(trace.lines) == MAX_LINES and len(trace.x_values[0]) == 334
    assert "8 of 30 are shown" in trace.note and "every third of 1001 samples" in trace.note.lower()


def test_a_point_without_a_run_is_missing():
    archive = grid(warmth=[280, 290, 300], other=[1, 2, 3])
    kept = np.array([0, 1, 3, 4, 5, 6, 7, 8])
    variables = {
        name: v
        if v.dims[0] != "run"
        else Variable(v.dims, v.values[kept], v.unit, v.description, v.meanings, coordinate=v.coordinate)
        for name, v in archive.variables.items()
    }
    cubes = Cubes(Archive("", archive.provenance, variables))
    assert np.isnan(cubes.values_of("sum")[0, 2]) and np.isfinite(cubes.values_of("sum")).sum() == 8
    assert cubes.name_run(2) == "warmth 290 K, other 1 K"


def test_runs_without_axes_are_drawn_over_their_numbers_and_one_run_is_not_drawn():
    several = Archive("", {}, {"run": run_axis(3), "power": column([1.0, 2.0, 3.0], "W", "power")})
    assert Cubes(several).draw("power").x.label == "run"
    one = Archive("", {}, {"run": run_axis(1), "power": column([1.0], "W", "power")})
    assert Cubes(one).draw("power") is None


def test_names_in_one_figure_lose_the_words_that_they_share():
    assert find_common_words(["opening lateness", "opening delay"]) == "opening"
    archive = grid(warmth=[280, 290, 300])
    more = archive.variables | {"last_sum": archive.variables["sum"], "first_sum": archive.variables["sum"]}
    figure = Cubes(Archive("", archive.provenance, more)).draw_together(["last_sum", "first_sum"])
    assert figure.y.label == "sum" and [line.label for line in figure.lines] == ["last", "first"]
