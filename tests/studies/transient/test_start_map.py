"""Starts over keys of the machine, and the archives of all starts."""

import json

import matplotlib.pyplot as plt
import numpy as np
import pytest

import apesim
from apesim import InputError
from apesim.studies.transient.figures import draw_start


@pytest.fixture(scope="module")
def rings():
    return apesim.start_engine(apesim.Machine(), angle="all", vary={"engine.cylinders": "1, 2, 4"})


@pytest.fixture(scope="module")
def loaded():
    """Starts of machines of which some do not start, and some do not reach the speed."""
    ranges = {"engine.cylinders": "1, 2", "load.constant": "0:90:30 N m"}
    return apesim.start_engine(apesim.Machine(), until="900 rpm", vary=ranges)


@pytest.mark.parametrize(
    "arguments",
    [
        {"until": "900 rpm"},
        {"angle": "90 deg"},
        {"angle": "all", "cranking_release": "130 deg"},
        {"angle": "all", "machine": apesim.Machine().with_(load_constant="2000 N m")},
    ],
)
def test_an_archive_gives_a_start_back(arguments, tmp_path):
    start = apesim.start_engine(**{"machine": apesim.Machine().with_(engine_cylinders=2)} | arguments)
    again = apesim.read_archive(start.write(tmp_path / "start.h5"))
    assert again == start and again.march is None and again.intervals_deg == start.intervals_deg
    assert json.dumps(again.to_dict()) == json.dumps(start.to_dict())
    figures = [draw_start(one, tmp_path / "figures") for one in (start, again)]
    assert figures[0] == figures[1]


def test_each_machine_starts_as_it_does_alone(loaded):
    for point, cylinders, load in zip(loaded.to_dict()["points"], [1] * 4 + [2] * 4, [0, 30, 60, 90] * 2, strict=True):
        machine = apesim.Machine().with_(engine_cylinders=cylinders, load_constant=f"{load} N m")
        alone = apesim.start_engine(machine, until="900 rpm").to_dict()
        same = {key: point[key] for key in ("starts", "time_s", "turns", "engine_air_kg", "lowest_speed_rpm")}
        assert json.dumps(same) == json.dumps({key: alone[key] for key in same})
    assert dict(loaded.to_xarray()["time"].sizes) == {"engine_cylinders": 2, "load_constant": 4}
    assert loaded.warnings == ("1 of 8 machines do not start: 1 cylinder, load constant 90 N m",)


def test_intervals_of_fewer_are_followed_by_nan(rings):
    low, high = (rings.traces[f"interval_{end}_deg"] for end in ("low", "high"))
    assert low.dims == ("run", "interval") and low.values.shape == (3, 8)
    assert np.isfinite(low.values).sum(axis=1).tolist() == np.isfinite(high.values).sum(axis=1).tolist() == [1, 2, 8]
    widths = np.nansum(high.values - low.values, axis=1) / 360.0
    assert widths == pytest.approx(rings.traces["starting_share"].values)
    alone = apesim.start_engine(apesim.Machine().with_(engine_cylinders=2), angle="all")
    assert rings.to_dict()["points"][1]["intervals_deg"] == alone.to_dict()["intervals_deg"]


def test_processes_find_the_same(loaded, tmp_path):
    ranges = ["engine.cylinders=1, 2", "load.constant=0:90:30 N m"]
    out, told = tmp_path / "starts.h5", []
    more = {"vary": ranges, "jobs": 2, "out": out, "progress": lambda *at: told.append(at)}
    assert apesim.start_engine(apesim.Machine(), until="900 rpm", **more) == loaded
    assert apesim.read_archive(out) == loaded and told[-1] == (8, 8)


def test_each_engine_has_a_ring_with_its_name(rings):
    ax = rings.plot()
    texts = [text.get_text().strip() for text in ax.texts]
    assert texts == ["1 cylinder, 19 %", "2 cylinders, 38 %", "4 cylinders, 73 %"]
    assert ax.name == "polar" and len(ax.patches) == 3 + 1 + 2 + 8
    plt.close("all")


def test_curves_show_who_does_not_start(loaded, rings):
    ax = loaded.plot(what="time")
    assert ax.get_xlabel() == "load constant [N m]" and "[s]" in ax.get_ylabel()
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert labels == ["1 cylinder", "2 cylinders", "does not start", "starts, but does not reach the speed"]
    crosses = [line.get_xdata().tolist() for line in ax.lines if line.get_marker() == "x" and len(line.get_xdata())]
    assert crosses == [[90.0]]
    assert rings.plot(what="share").get_ylabel().endswith("[%]")
    with pytest.raises(InputError, match="there is no plot of angles"):
        loaded.plot(what="angles")
    plt.close("all")


def test_words_have_places_of_their_own():
    starts = apesim.start_engine(apesim.Machine(), vary={"engine.intake": "epv, cam", "air.model": "ideal"})
    ax = starts.plot()
    assert [label.get_text() for label in ax.get_xticklabels()] == ["epv", "cam"]
    assert starts.to_dict()["points"][1]["engine_intake"] == "cam"
    plt.close("all")


@pytest.mark.parametrize(
    ("ranges", "right"),
    [
        ({"engine.cylinders": "1:9:1"}, "1 to 8"),
        ({"engine.cylinder": "1, 2"}, "engine.cylinders"),
        ({"command.energise": "-5, 140 deg"}, "140 deg"),
        ({}, "KEY=RANGE"),
    ],
)
def test_wrong_ranges_are_named_with_the_right_form(ranges, right):
    with pytest.raises(InputError) as raised:
        apesim.start_engine(apesim.Machine(), cranking_release="130 deg", vary=ranges)
    assert right in str(raised.value)


def test_the_command_tells_a_row_for_each_machine(apesim, tmp_path):
    call = "engine", "start", "--vary", "engine.cylinders=1, 2", "--vary", "load.constant=0, 90 N m"
    code, out, err = apesim(*call)
    assert code == 0 and [line.split()[:3] for line in out.splitlines() if " N" not in line][-5][:2] == ["1", "0"]
    assert "do not start" in err
    code, out, _ = apesim(*call, "--json", "--out", "starts.h5", "--figures", "figures")
    data = json.loads(out)
    assert [point["starts"] for point in data["points"]] == [True, False, True, True]
    assert len(data["content_sha256"]) == 64 and data["figures"] == ["figures/start.png", "figures/start.pdf"]
    code, out, _ = apesim("engine", "start", "--angle", "all", "--vary", "engine.cylinders=1, 2", "--figures", "rings")
    assert code == 0 and "37.6%" in out and "182.29-250.00" in out
    assert {path.name for path in (tmp_path / "rings").glob("*.png")} == {"starting_angles.png", "starting_share.png"}


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--vary", "engine.cylinders"], "KEY=RANGE"),
        (["--vary", "engine.cylinders=1:9:1"], "1 to 8"),
        (["--vary", "engine.cylinders=1, 2", "--csv", "start.csv"], "--csv"),
        (["--angle", "all", "--csv", "start.csv"], "--csv"),
        (["--out", "nowhere/start.h5"], "its folder does not exist"),
        (["--out", "there.h5"], "exists already"),
    ],
)
def test_a_fault_is_one_line(apesim, tmp_path, options, told):
    (tmp_path / "there.h5").write_bytes(b"mine")
    code, out, err = apesim("engine", "start", *options)
    assert code == 2 and out == "" and told in err and len(err.splitlines()) == 1
