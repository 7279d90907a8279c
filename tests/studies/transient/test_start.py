"""Starts from rest, from Python and from the shell."""

import json
from math import isnan

import matplotlib.pyplot as plt
import pytest

import apesim
from apesim import InputError

FAN = {"load.quadratic": "2.85e-3 N m s^2"}


@pytest.fixture(scope="module")
def started():
    return apesim.start_engine(apesim.Machine().with_(**FAN), angle="30 deg", until="900 rpm")


def test_a_start_says_when_and_with_how_much_air(started):
    data = started.to_dict()
    assert data["starts"] and data["warnings"] == []
    assert data["time_s"] == pytest.approx(0.1259, abs=2e-4)
    assert data["turns"] == pytest.approx(1.185, abs=1e-3)
    assert [event["kind"] for event in data["events"]] == ["first motion", "speed reached", "angle reached"]
    assert started.traces["speed_rpm"].values.max() == data["highest_speed_rpm"] > 900.0
    assert isnan(started.traces["lift"].values[-1, 0]) is False


def test_a_crank_behind_the_release_is_held_and_named():
    start = apesim.start_engine(apesim.Machine(), angle="90 deg")
    assert not start["starts"] and isnan(start["time"])
    [warning] = start.warnings
    assert "held at 90 deg from the start" in warning


def test_a_kick_back_is_told():
    start = apesim.start_engine(apesim.Machine(), angle="-4 deg")
    assert start["lowest_speed_rpm"] < -100.0
    assert "after it has moved" in start.warnings[0]


def test_a_shaft_that_nothing_holds_moves_at_once():
    hoist = apesim.Machine().with_(load_kind="hoist", load_constant="60 N m")
    start = apesim.start_engine(hoist, angle="30 deg", until="100 rpm")
    assert start["first_motion"] == 0.0 and start["lowest_speed_rpm"] < 0.0


def test_a_load_that_the_speed_cannot_be_reached_against_is_no_start_without_turns():
    start = apesim.start_engine(apesim.Machine().with_(load_constant="200 N m"), angle="30 deg")
    assert not start["starts"]


def test_three_cylinders_start_from_every_angle_with_a_longer_window_while_cranking():
    three = apesim.Machine().with_(engine_cylinders=3)
    assert apesim.start_engine(three, angle="100 deg")["starts"] is False
    cranked = apesim.start_engine(three, angle="100 deg", cranking_release="130 deg")
    assert cranked["starts"] is True
    # Behind its first 180 degrees each cylinder has the machine's command again: the air of a turn says so.
    assert cranked.march.run.cylinders["close"][-1].max() < 150.0 * 3.14159 / 180.0


@pytest.mark.parametrize(
    ("arguments", "key", "right"),
    [
        ({"angle": "30"}, "angle", "30 deg"),
        ({"until": "900"}, "until", "rpm"),
        ({"angle": "all", "until": "900 rpm"}, "until", "leave it out"),
        ({"cranking_release": "-20 deg"}, "cranking_release", "after energise"),
    ],
)
def test_wrong_arguments_are_named_with_the_right_form(arguments, key, right):
    with pytest.raises(InputError) as raised:
        apesim.start_engine(apesim.Machine(), **arguments)
    assert any(fault.key == key and right in str(fault) for fault in raised.value.faults), raised.value


def test_the_command_prints_what_the_function_returns(apesim, started):
    code, out, _ = apesim("engine", "start", "--until", "900 rpm", "--set", "load.quadratic=2.85e-3 N m s^2", "--json")
    data = json.loads(out)
    assert code == 0
    assert {**data, "wall_time_s": 0.0} == json.loads(json.dumps({**started.to_dict(), "wall_time_s": 0.0}))


def test_what_the_command_writes_can_be_looked_at(apesim, tmp_path):
    code, _, _ = apesim("engine", "start", "--csv", str(tmp_path / "start.csv"), "--figures", str(tmp_path / "figures"))
    header = (tmp_path / "start.csv").read_text().splitlines()[0].split(",")
    assert code == 0 and header[:3] == ["time [s]", "angle [deg]", "speed [rpm]"]
    assert (tmp_path / "figures" / "start.png").stat().st_size > 5000


def test_angles_of_all_starts_are_drawn_around_a_circle():
    start = apesim.start_engine(apesim.Machine(), angle="all")
    [(low, high)] = start.intervals_deg
    assert (low, high) == (pytest.approx(1.1425, abs=0.01), pytest.approx(70.0, abs=0.01))
    ax = start.plot(what="angles")
    assert ax.name == "polar" and len(ax.patches) == 2
    plt.close("all")
