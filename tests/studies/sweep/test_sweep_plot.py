"""A sweep over speed and other keys is drawn with a line for each of their values, or says what it leaves out."""

import json
from itertools import product

import matplotlib.pyplot as plt
import numpy as np
import pytest

from apesim.archive import Archive
from apesim.archive.columns import column, run_axis
from apesim.studies.archives.archive_result import variables_of
from apesim.studies.limit.points import Point, point_column
from apesim.studies.limit.valve_limit import ValveLimit
from apesim.studies.limit.valve_map import supply_columns
from apesim.studies.sweep.figures import MAX_LINES
from apesim.studies.sweep.study import Sweep

PRESSURES = ["0.6 MPa gauge", "1 MPa gauge", "1.4 MPa gauge"]
SPEEDS = ["600 r/min", "900 r/min"]


def swept(actuations, **keys):
    """A sweep whose torque tells its actuation, its keys and its speed by its digits."""
    texts = {"actuation": actuations, **keys, "speed_rpm": SPEEDS}
    places = np.array(list(product(*(range(len(values)) for values in texts.values()))))
    columns = {"run": run_axis(len(places))}
    for name, at in zip(texts, places.T, strict=True):
        columns[name] = column(at.astype(np.int8) if name == "actuation" else at.astype(float), "1", name)
    columns["brake_torque_Nm"] = column(places @ 10.0 ** np.arange(places.shape[1]), "N m", "mean brake torque")
    archive = Archive("", {"axes": json.dumps(texts)}, columns)
    return Sweep({}, variables_of(archive), archive=archive)


@pytest.fixture(autouse=True)
def close():
    yield
    plt.close("all")


def drawn(ax):
    return {line.get_label(): line.get_ydata().tolist() for line in ax.lines}


def test_each_pressure_has_its_line():
    ax = swept(["epv"], supply_pressure=PRESSURES).plot()
    lines = drawn(ax)
    assert list(lines) == [f"supply pressure {text}" for text in PRESSURES] and ax.get_title() == "EPV, fixed"
    assert list(lines.values()) == [[0.0, 100.0], [10.0, 110.0], [20.0, 120.0]]


def test_without_a_varied_key_each_actuation_has_its_line():
    ax = swept(["epv", "cam"]).plot()
    assert list(drawn(ax)) == ["EPV, fixed", "cam"] and ax.get_title() == ""


def test_a_key_of_one_value_stands_in_the_title():
    ax = swept(["cam"], supply_pressure=PRESSURES[:1], bore=["80 mm", "90 mm"]).plot()
    assert list(drawn(ax)) == ["bore 80 mm", "bore 90 mm"]
    assert ax.get_title() == "cam, supply pressure 0.6 MPa gauge"


def test_four_actuations_at_three_pressures_are_told_apart_by_colour_and_marker():
    ax = swept(["epv", "epv corrected", "cam", "ideal"], supply_pressure=PRESSURES).plot()
    assert len(ax.lines) == 12 and ax.get_title() == ""
    assert len({(line.get_color().tobytes(), line.get_marker()) for line in ax.lines}) == 12
    named = [text.get_text() for text in ax.get_legend().get_texts()]
    assert named[:2] == ["EPV, fixed", "EPV, corrected"] and named[4:] == [
        f"supply pressure {text}" for text in PRESSURES
    ]


def test_what_is_left_out_is_said():
    many = [f"{number / 10:g} MPa gauge" for number in range(2, 22)]
    ax = swept(["cam", "ideal"], supply_pressure=many).plot()
    assert len(ax.lines) == MAX_LINES and ax.get_title() == "6 of 20 values of supply pressure are drawn"
    ax = swept(["cam", "ideal"], supply_pressure=many, bore=["80 mm", "90 mm"]).plot()
    assert len(ax.lines) == MAX_LINES
    assert ax.get_title() == "6 of 40 values of supply pressure and bore are drawn"


def test_limits_of_the_valve_have_a_line_for_each_temperature_and_duty():
    supplies = [(p, t) for p in (0.5e6, 1.1e6) for t in (250.0, 287.0) for _ in (0.3, 0.5)]
    columns = supply_columns([*supplies, (1.1e6, 287.0)])
    columns["duty"] = column([*([0.3, 0.5] * 4), 0.2], "1", "duty")
    columns["point"] = point_column([*([Point.GRID] * 8), Point.OWN])
    columns["limit_hz"] = column(np.arange(9.0), "Hz", "limit")
    archive = Archive("", {}, columns)
    lines = drawn(ValveLimit({}, variables_of(archive), archive=archive).plot())
    assert lines["250 K, duty 0.3"] == [0.0, 4.0] and lines["287 K, duty 0.5"] == [3.0, 7.0]
    assert len(lines) == 5 and lines["the machine's own: 287 K, duty 0.2"] == [8.0]
