"""Figures of pages as inline SVG: what is drawn, and where."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from apesim.studies.report.figures.bars import Bars
from apesim.studies.report.figures.curves import Curves, Line
from apesim.studies.report.figures.drawing import find_ticks, thin_path, write_path
from apesim.studies.report.figures.labels import Axis, Frames, format_number, shorten_name, spread_ranges
from apesim.studies.report.figures.maps import Map, find_colour
from apesim.studies.report.figures.packing import ArrayPool
from apesim.studies.report.figures.rings import Rings

X, Y, Z = Axis("speed", "r/min"), Axis("torque", "N·m"), Axis("air", "g/s")
SPEEDS, TORQUES = np.array([300.0, 600.0, 900.0]), np.array([30.0, np.nan, 10.0])
HOSTILE = "<b>&\"'"


def parts(svg, tag):
    return ElementTree.fromstring(svg).iter(tag)


@pytest.mark.parametrize("ends", [(0.0, 1.0), (-3e-7, 2e-7), (101.0, 109.0), (0.0, 3.3e6)])
def test_ticks_are_round_and_within_the_ends(ends):
    ticks, decimals = find_ticks(*ends, 5)
    assert 3 <= len(ticks) <= 11 and ends[0] <= ticks[0] + 1e-12 and ticks[-1] <= ends[1] * (1 + 1e-12)
    assert [round(tick, decimals) for tick in ticks] == pytest.approx(ticks, abs=1e-9 * (ends[1] - ends[0]))


def test_a_thinned_path_stays_within_its_tolerance():
    x = np.linspace(0.0, 400.0, 2001)
    points = np.column_stack([x, 10.0 * np.sin(x / 30.0)])
    thinned = thin_path(points, 0.25)
    assert len(thinned) < 200
    assert np.abs(np.interp(x, *thinned.T) - points[:, 1]).max() < 0.27  # upright, where it slopes by a third


def test_a_missing_number_breaks_a_line():
    assert write_path(SPEEDS, TORQUES) == "M300 30M900 10"


def test_curves_bear_their_names_units_and_a_look_each():
    figure = Curves("Torque", X, Y, [Line("epv", [TORQUES]), Line("cam", [2 * TORQUES], look=1)], [SPEEDS])
    svg = figure.write_still()
    texts = [text.text for text in parts(svg, "text")]
    assert {"speed [r/min]", "torque [N·m]", "epv", "cam"} <= set(texts)
    looks = {(path.get("class"), path.get("stroke-dasharray")) for path in parts(svg, "path") if path.get("class")}
    assert {("l k0", None), ("l k1", "8 4")} <= looks


def test_a_figure_without_numbers_says_so():
    figure = Curves("Torque", X, Y, [Line("epv", [np.full(3, np.nan)])], [SPEEDS])
    assert "no numbers" in figure.write_still() and figure.data(ArrayPool())["series"][0]["label"] == "epv"


def test_a_map_has_a_cell_for_each_number_and_its_value():
    values = np.array([[1.0, 2.0, np.nan], [4.0, 5.0, 6.0]])
    svg = Map("Map", X, Y, Z, SPEEDS, np.array([1.0, 2.0]), [values]).write_still()
    [cells] = [group for group in parts(svg, "g") if group.get("class") == "cells"]
    assert [cell.get("fill") for cell in cells] == [find_colour((v - 1.0) / 5.0) for v in values[np.isfinite(values)]]
    assert [text.text for text in parts(svg, "text") if text.get("class") == "in"] == ["1", "2", "4", "5", "6"]
    lows = [float(cell.get("y")) for cell in cells]
    assert lows[0] > lows[-1]  # the second row stands above the first


def test_bars_are_as_long_as_their_parts_and_say_their_share():
    svg = Bars("Exergy", "J", [("epv", {"work": 30.0, "lost": 70.0, "gained": -5.0})]).write_still()
    bars = [bar for bar in parts(svg, "rect") if bar.find("title") is not None]
    widths = [float(bar.get("width")) for bar in bars]
    assert widths[1] / widths[0] == pytest.approx(7 / 3, rel=1e-2)
    assert [bar.find("title").text for bar in bars] == ["epv, work: 30 J, 30 %", "epv, lost: 70 J, 70 %"]


def test_rings_draw_whole_circles_and_arcs_through_zero():
    svg = Rings("Angles", [("one", [(350.0, 370.0)]), ("all", [(0.0, 360.0)])]).write_still()
    arcs = [path.get("d") for path in parts(svg, "path") if path.find("title") is not None]
    assert len(arcs) == 2 and " 0 1 1 " in arcs[1] and " 0 0 1 " in arcs[0]


@pytest.mark.parametrize(
    "figure",
    [
        Curves(HOSTILE, Axis(HOSTILE), Axis(HOSTILE), [Line(HOSTILE, [SPEEDS])], [SPEEDS]),
        Map(HOSTILE, Axis(HOSTILE), Y, Z, SPEEDS, SPEEDS, [np.eye(3)]),
        Bars(HOSTILE, "J", [(HOSTILE, {HOSTILE: 1.0})]),
        Rings(HOSTILE, [(HOSTILE, [(0.0, 10.0)])]),
    ],
    ids=["curves", "map", "bars", "rings"],
)
def test_a_hostile_text_is_escaped(figure):
    svg = figure.write_still()
    assert HOSTILE in "".join(ElementTree.fromstring(svg).itertext()) and "<b>" not in svg


def test_frames_share_the_ends_of_the_axes():
    frames = Frames("speed", ("a", "b"), 1)
    figure = Curves("Torque", X, Y, [Line("epv", [SPEEDS, 10.0 * SPEEDS])], [SPEEDS], frames=frames)
    assert figure.data(ArrayPool())["y"]["range"][1] > 9000.0 and "8000" in figure.write_still()


def test_arrays_are_packed_once_and_long_ones_with_seven_digits():
    pool = ArrayPool()
    assert pool.add(SPEEDS) == pool.add(SPEEDS.copy()) == 0 and pool.add(np.linspace(0.0, 1.0, 721)) == 1
    assert [next(iter(each)) for each in pool.arrays] == ["f8", "f4"] and pool.samples == 724
    assert len(pool.arrays[1]["f4"]) < 6 * 721


@pytest.mark.parametrize(("value", "text"), [(np.nan, "–"), (-1e-9, "−1e−09"), (123456.0, "123456"), (0.0, "0")])
def test_numbers_are_written_short_with_a_true_minus(value, text):
    assert format_number(value) == text


def test_names_lose_their_units_and_equal_numbers_get_an_axis():
    assert [shorten_name(name) for name in ("peak_lift_m", "turns", "limit_rpm")] == ["peak lift", "turns", "limit"]
    low, high = spread_ranges(np.full(3, 5.0))
    assert low < 5.0 < high and spread_ranges(np.full(2, np.nan)) is None
    assert re.search(r"\d", format_number(high))
