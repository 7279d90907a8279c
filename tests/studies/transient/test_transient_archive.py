"""Archives of engines over time: they give back what was computed, and survive a kill."""

import json
import multiprocessing
import os
import signal

import h5py
import matplotlib.pyplot as plt
import numpy as np
import pytest

import apesim
from apesim import ArchiveError, NotConverged
from apesim.archive.shards import shards_folder
from apesim.march.adaptive import Status
from apesim.studies.transient import checkpoints, transient
from apesim.studies.transient.figures import draw_transient
from apesim.studies.transient.march_archive import trace_table
from apesim.studies.transient.transient import PLOTS

OWN = [{}, {"valve.moving_mass": "90 g"}, {}]
MACHINE = apesim.Machine().with_(
    engine_cylinders=3,
    cylinder=OWN,
    **{"ambient.pressure": "0.09 MPa abs", "load.kind": "hoist", "load.constant": "12 N m"},
    **{"supply.control_pressure": "0.6 MPa gauge"},
)
RUN = {"angle": "30 deg", "duration": "1.5 s", "load": "0.7 s: 20 N m", "supply": "0.9 s: 0.8 MPa gauge"}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Run that nothing interrupts."""
    return apesim.run_transient(MACHINE, out=tmp_path_factory.mktemp("whole") / "run.h5", **RUN)


@pytest.fixture
def often(monkeypatch):
    """Write a checkpoint after every piece."""
    monkeypatch.setattr(checkpoints, "SECONDS_BETWEEN", 0.0)
    monkeypatch.setattr(checkpoints, "SHARE_OF_WRITING", np.inf)


class Killed(Exception):
    """What ends a run in its midst."""


def interrupt(path, after, **arguments):
    """Run into an archive until a number of pieces is done."""
    pieces = []

    def report(done, total):
        pieces.append(done)
        if len(pieces) == after:
            raise Killed

    with pytest.raises(Killed):
        apesim.run_transient(MACHINE, out=path, progress=report, **RUN | arguments)


def test_an_archive_gives_back_rows_traces_events_and_figures(whole, tmp_path):
    path = whole.write(tmp_path / "run.h5")
    again = apesim.read_archive(path)
    assert type(again) is type(whole) and again == whole and again.march is None
    assert json.dumps(again.to_dict()) == json.dumps(whole.to_dict())
    assert len(again.to_dict()["revolutions"][3]["cylinders"]) == 3
    assert again.to_dict()["events"][0]["kind"] == "first motion"
    for mine, other in zip(trace_table(whole), trace_table(again), strict=True):
        assert np.array_equal(mine, other)
    for what in PLOTS:
        drawn = [[line.get_xydata() for line in run.plot(what=what).lines] for run in (whole, again)]
        assert len(drawn[0]) == (6 if what == "timing" else 1)
        assert all(np.array_equal(*pair, equal_nan=True) for pair in zip(*drawn, strict=True))
    assert {file.name for file in draw_transient(again, tmp_path / "figures")} == {"transient.png", "transient.pdf"}
    plt.close("all")


def test_what_was_marched_is_in_the_archive_with_units_and_flags(whole, tmp_path):
    march = whole.march
    with h5py.File(whole.write(tmp_path / "run.h5")) as file:
        assert file.attrs["kind"] == b"engine transient"
        lift = file["lift"]
        assert lift.shape == (1, len(march.times), 3) and lift.attrs["axes"] == b"run time cylinder"
        assert file["revolution_mean_speed_rpm"].attrs["units"] == b"min^-1"
        assert np.array_equal(file["revolution_engine_air_kg"][0], march.revolutions["engine_air"])
        assert np.array_equal(file["full_lift"][0], march.cylinders["full_lift"], equal_nan=True)
        assert file["event_kind"].attrs["flag_meanings"].split()[:2] == [b"first_motion", b"speed_zero"]
        assert np.array_equal(file["event_time_s"][0], [event.time for event in march.events])
        assert file["engine_air_kg"][0] == whole["engine_air"]


def test_no_number_hides_a_trace_in_a_dataset(whole):
    assert not set(whole.scalars) & set(whole.traces)
    assert dict(whole.to_xarray()["valve_open_deg"].sizes) == {"revolution": whole["revolutions"], "cylinder": 3}


@pytest.mark.parametrize("after", [1, 4, 7])
def test_a_run_that_was_interrupted_goes_on_to_the_same_bits(whole, tmp_path, often, after):
    path = tmp_path / "run.h5"
    interrupt(path, after)
    assert shards_folder(path).is_dir() == (after > 1) and not path.exists()
    times = []
    resumed = apesim.run_transient(MACHINE, out=path, resume=True, progress=lambda *at: times.append(at), **RUN)
    assert times[0][0] > 0.1 * after and times[-1] == (1.5, 1.5)
    assert resumed == whole and apesim.read_archive(path) == whole
    assert apesim.compare_archives(path, whole.write(tmp_path / "whole.h5"), rtol=0.0).is_same
    assert sorted(file.name for file in tmp_path.iterdir()) == ["run.h5", "whole.h5"]


def test_a_run_from_a_speed_goes_on_to_the_same_bits(tmp_path, often):
    arguments = {"angle": None, "from_speed": "900 rpm"}
    interrupt(tmp_path / "run.h5", 4, **arguments)
    resumed = apesim.run_transient(MACHINE, out=tmp_path / "run.h5", resume=True, **RUN | arguments)
    assert resumed == apesim.run_transient(MACHINE, **RUN | arguments)


def kill(path):
    """Kill this process in the midst of a run."""
    checkpoints.SECONDS_BETWEEN, checkpoints.SHARE_OF_WRITING = 0.0, np.inf

    def report(done, total):
        if done > 0.8:
            os.kill(os.getpid(), signal.SIGKILL)

    apesim.run_transient(MACHINE, out=path, progress=report, **RUN)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks a process to be killed")
def test_a_run_that_is_killed_goes_on_and_leaves_only_its_archive(whole, tmp_path):
    path = tmp_path / "run.h5"
    process = multiprocessing.get_context("fork").Process(target=kill, args=(path,))
    process.start()
    process.join()
    assert process.exitcode == -signal.SIGKILL and shards_folder(path).is_dir()
    assert apesim.run_transient(MACHINE, out=path, resume=True, **RUN) == whole
    assert [file.name for file in tmp_path.iterdir()] == ["run.h5"]


def test_a_short_run_writes_no_checkpoint(tmp_path):
    interrupt(tmp_path / "run.h5", 5)
    assert list(tmp_path.iterdir()) == []


def test_a_finished_run_is_read_and_another_is_not_replaced(whole, tmp_path):
    path = whole.write(tmp_path / "run.h5")
    resumed = apesim.run_transient(MACHINE, out=path, resume=True, **RUN)
    assert resumed.was_finished and resumed == whole
    with pytest.raises(ArchiveError, match="exists already"):
        apesim.run_transient(MACHINE, out=path, resume=True, **RUN | {"duration": "0.3 s"})
    other = apesim.run_transient(MACHINE, out=path, overwrite=True, **RUN | {"duration": "0.3 s"})
    assert apesim.read_archive(path) == other != whole


def test_a_checkpoint_is_not_lost_unasked_nor_joined_to_another_run(whole, tmp_path, often):
    path = tmp_path / "run.h5"
    interrupt(path, 4)
    with pytest.raises(ArchiveError, match="checkpoint of an unfinished run"):
        apesim.run_transient(MACHINE, out=path, **RUN)
    for other in ({"duration": "1.4 s"}, {"supply": "0.9 s: 0.7 MPa gauge"}, {"sample": "1 ms"}):
        with pytest.raises(ArchiveError, match="part of another"):
            apesim.run_transient(MACHINE, out=path, resume=True, **RUN | other)
    assert apesim.run_transient(MACHINE, out=path, overwrite=True, **RUN) == whole


def test_a_damaged_checkpoint_is_told_and_computed_again(whole, tmp_path, often):
    path = tmp_path / "run.h5"
    interrupt(path, 4)
    [shard] = shards_folder(path).iterdir()
    shard.write_bytes(shard.read_bytes()[:-1000])
    resumed = apesim.run_transient(MACHINE, out=path, resume=True, **RUN)
    assert "checkpoint was damaged" in resumed.warnings[-1]
    assert np.array_equal(resumed.traces["lift"].values, whole.traces["lift"].values)


def test_a_march_that_ends_early_leaves_its_archive(tmp_path, monkeypatch):
    def pieces(*arguments):
        yield next(march_pieces(*arguments))._replace(status=Status.STEP_TOO_SMALL)

    march_pieces = transient.march_pieces
    monkeypatch.setattr(transient, "march_pieces", pieces)
    with pytest.raises(NotConverged) as raised:
        apesim.run_transient(MACHINE, out=tmp_path / "run.h5", **RUN)
    again = apesim.read_archive(tmp_path / "run.h5")
    assert again == raised.value.result and not again.converged and again["duration"] < 1.0
    assert "ended early" in again.failed[0] and again.to_dict()["warnings"][0] == again.failed[0]


def test_the_command_says_what_it_wrote_and_what_was_finished(apesim, tmp_path):
    call = "engine", "transient", "--duration", "0.3 s", "--angle", "30 deg", "--out", "run.h5", "--json"
    code, out, _ = apesim(*call)
    assert code == 0 and len(json.loads(out)["content_sha256"]) == 64
    code, out, err = apesim(*call)
    assert code == 2 and out == "" and "exists already" in err and len(err.splitlines()) == 1
    code, out, _ = apesim(*call, "--resume")
    assert code == 0 and json.loads(out)["was_finished"]
    assert apesim("archive", "verify", "run.h5")[0] == 0
    assert "engine transient" in apesim("archive", "info", "run.h5")[1]


def test_what_cannot_be_kept_is_refused_at_once(apesim):
    code, _, err = apesim("engine", "transient", "--duration", "0.3 s", "--resume")
    assert code == 2 and "--out" in err
    code, _, err = apesim("engine", "transient", "--duration", "99999 s", "--sample", "0.01 ms")
    assert code == 2 and "--sample" in err and "GB" in err
