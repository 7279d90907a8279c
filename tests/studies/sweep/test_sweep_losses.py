"""A sweep never loses a run in silence: what the disk or a worker's death takes is made good, or named."""

import errno
import json
import multiprocessing
import os
import shutil
import signal
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from apesim.archive import ArchiveError, DamagedError, read, write
from apesim.archive.inspection import verify
from apesim.archive.merge import merge
from apesim.archive.shards import read_shards, shards_folder, write_shard
from apesim.engine.cylinder import CAM, IDEAL_VALVE
from apesim.engine.machine import Machine
from apesim.studies.sweep import completion, run_sweep
from apesim.studies.sweep import run as run_module
from apesim.studies.sweep.compute import compute
from apesim.studies.sweep.plan import FIXED, plan
from apesim.studies.sweep.results import archive_of
from apesim.studies.sweep.variation import Variation
from tests.processes import without_stages

RPM = np.pi / 30.0
SPEEDS = [600.0 * RPM, 900.0 * RPM, 1200.0 * RPM]
INTAKES = [CAM, IDEAL_VALVE]
RUNS = list(range(len(SPEEDS) * len(INTAKES)))
FAST = ["--speed", "600:1200:300 rpm", "--intake", "cam,ideal", "--no-figures"]


@pytest.fixture(autouse=True)
def a_shard_for_each_point(monkeypatch):
    monkeypatch.setattr(completion, "SHARD_SECONDS", 0.0)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return run_sweep(Machine(), SPEEDS, INTAKES, tmp_path_factory.mktemp("whole") / "whole.h5").archive


def sweep(path, **options):
    return run_sweep(Machine(), SPEEDS, INTAKES, path, **options)


def assert_whole(path, whole):
    assert verify(path) == []
    found = read(path)
    for name, variable in whole.variables.items():
        np.testing.assert_array_equal(found.variables[name].values, variable.values, err_msg=name)


def flip_a_bit(shard, random):
    """Damage a shard by one bit that is not in a gap of the file."""
    good = shard.read_bytes()
    while True:
        content = bytearray(good)
        at = int(random.integers(8 * len(content)))
        content[at // 8] ^= 1 << at % 8
        shard.write_bytes(content)
        try:
            read(shard)
        except ArchiveError:
            return


def at_point(number, action):
    """What is reported to; acts once, when so many points are done."""
    acted = []

    def report(done, total):
        if done == number and not acted:
            acted.append(number)
            action()

    return report


def damage(path, random):
    """Damage one of a sweep's shards."""
    flip_a_bit(random.choice(sorted(shards_folder(path).glob("*.h5"))), random)


@pytest.mark.parametrize("at", [1, 4, len(RUNS)])
@pytest.mark.slow
def test_shards_that_are_damaged_or_removed_while_the_sweep_runs_cost_nothing(tmp_path, whole, at):
    path, random = tmp_path / "sweep.h5", np.random.default_rng(at)
    for action in (lambda: damage(path, random), lambda: shutil.rmtree(shards_folder(path))):
        result = sweep(path, report=at_point(at, action), overwrite=True)
        assert result.faults == result.notes == []
        assert_whole(path, whole)
        assert [item.name for item in tmp_path.iterdir()] == ["sweep.h5"]


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 4))])
def test_a_shard_that_was_damaged_is_computed_again_when_the_sweep_goes_on(tmp_path, whole, seed):
    path, random = tmp_path / "sweep.h5", np.random.default_rng(seed)
    at = int(random.integers(1, len(RUNS) + 1))
    with pytest.raises(KeyboardInterrupt):
        sweep(path, report=at_point(at, interrupt))
    damage(path, random)
    told = []
    result = sweep(path, resume=True, report=lambda done, _: told.append(done))
    assert told[0] == at - 1 and result.faults == []
    assert len(result.notes) == 1 and ".shards" in result.notes[0] and "computed again" in result.notes[0]
    assert_whole(path, whole)
    assert [item.name for item in tmp_path.iterdir()] == ["sweep.h5"]


def interrupt():
    raise KeyboardInterrupt


def test_a_sweep_goes_on_from_shards_as_if_it_had_not_been_interrupted(tmp_path, monkeypatch, whole):
    path = tmp_path / "sweep.h5"
    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        patched.setattr("apesim.archive.surroundings.processor", lambda: "another")
        sweep(path, report=at_point(3, interrupt))
    found = sweep(path, resume=True).archive.provenance
    assert found["processor"] == f"another; {whole.provenance['processor']}"
    assert found | {"processor": whole.provenance["processor"]} == whole.provenance


def die(points):
    os._exit(9)


def die_of_two(points):
    if any(point.run in (1, 4) for point in points):
        os._exit(9)
    return compute(points)


def without_warming_up(*_):
    """The tasks of these tests would end this process."""


def without_a_thread(*_):
    """A call for the warming up that is done, as nothing was called."""
    done = Future()
    done.set_result(None)
    return done


def results_of(points, chunk=1, ends_with=None):
    """Points as if they had been computed, some at a time; the last of them may be followed by an error."""

    def run(_):
        for first in range(0, len(points), chunk):
            yield points[first : first + chunk], [None] * len(points[first : first + chunk])
        if ends_with:
            raise ends_with

    return run


def complete_without_computing(folder, run, count, monkeypatch):
    """Complete a sweep of points that take a second each; returns how many were reported, one after the other."""
    variation = Variation((), (Machine(),))
    points = plan(variation, [100.0 + run for run in range(count)], [IDEAL_VALVE]).points
    [(scalars, _)] = compute(points[:1], traces=False)
    monkeypatch.setattr(completion, "SHARD_SECONDS", 1.0)
    monkeypatch.setitem(completion.SECONDS_A_POINT, FIXED, 1.0)
    told = []
    provenance = {"plan_hash": "0" * 64, "runs_planned": str(count)}
    try:
        completion.complete(
            folder,
            points,
            "0" * 64,
            run=run(points),
            to_archive=lambda some, _: archive_of(some, [(scalars, None)] * len(some), variation, "", provenance),
            report=lambda done, _: told.append(done),
        )
    except KeyboardInterrupt:
        told.append("interrupted")
    return told


@pytest.mark.slow
def test_shards_grow_with_what_is_done_and_what_is_told_is_written(tmp_path, monkeypatch):
    folder = tmp_path / "s.h5.shards"
    told = complete_without_computing(folder, results_of, 100, monkeypatch)
    assert told == [0, 1, 2, 3, 5, 8, 12, 18, 27, 41, 61, 81, 100]
    sizes = sorted(len(read(path).runs) for path in folder.iterdir())
    assert sizes == sorted(np.diff(told).tolist())


def test_what_waits_for_its_shard_is_written_when_the_sweep_is_interrupted(tmp_path, monkeypatch):
    def run(points):
        return results_of(points[:21], ends_with=KeyboardInterrupt())

    told = complete_without_computing(tmp_path / "s.h5.shards", run, 60, monkeypatch)
    assert told[-2:] == [18, "interrupted"]
    assert read_shards(tmp_path / "s.h5.shards", "0" * 64).done == list(range(21))


def test_a_point_that_kills_its_worker_takes_no_other_with_it(tmp_path, monkeypatch, whole):
    path = tmp_path / "sweep.h5"
    monkeypatch.setattr(completion, "SHARD_SECONDS", 1.0)
    monkeypatch.setattr(run_module, "compute", die_of_two)
    result = sweep(path, jobs=2, warm_up=without_warming_up)
    assert result.archive.runs.tolist() == [0, 2, 3, 5]
    [fault] = result.faults
    assert fault.startswith("runs 1, 4 are missing, their worker processes died") and "--resume" in fault
    assert "runs 1, 4 of 6 planned are missing" in verify(path)[0]
    assert read_shards(shards_folder(path), result.archive.provenance["plan_hash"]).done == [0, 2, 3, 5]
    monkeypatch.setattr(run_module, "compute", compute)
    assert sweep(path, resume=True).faults == []
    assert_whole(path, whole)


def test_where_every_worker_dies_the_runs_are_named_and_shards_are_kept(apesim, monkeypatch, whole):
    monkeypatch.setattr(run_module, "compute", die)
    monkeypatch.setattr("apesim.studies.sweep.study.call_in_thread", without_a_thread)
    monkeypatch.setattr(completion, "MAX_DEATHS", 2)
    code, _, err = apesim("engine", "sweep", *FAST, "--jobs", "2")
    assert code == 3 and "Traceback" not in err
    assert "sweep.h5: runs 0-5 are missing, their worker processes died; free memory" in err
    assert not Path("sweep.h5").exists()
    shards = shards_folder(Path.cwd() / "sweep.h5")
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
    with pytest.raises(KeyboardInterrupt):
        monkeypatch.setattr(run_module, "compute", compute)
        sweep("sweep.h5", report=at_point(2, lambda: signal.raise_signal(signal.SIGINT)))
    signal.signal(signal.SIGINT, before)
    monkeypatch.setattr(run_module, "compute", die)
    code, out, err = apesim("engine", "sweep", *FAST, "--jobs", "2", "--resume", "--json")
    assert code == 3 and "runs 2-5 are missing" in err
    assert json.loads(out)["runs"] == len(list(shards.glob("*.h5"))) == 2
    monkeypatch.setattr(run_module, "compute", compute)
    assert apesim("engine", "sweep", *FAST, "--resume")[0] == 0
    assert_whole("sweep.h5", whole)


@pytest.mark.parametrize("number", [1, 4, 7])
@pytest.mark.slow
def test_a_write_that_fails_loses_nothing_that_was_written(tmp_path, monkeypatch, whole, number):
    path, calls, replace = tmp_path / "sweep.h5", [], os.replace

    def full_at_last(*paths):
        calls.append(paths)
        if len(calls) >= number:
            raise OSError(errno.ENOSPC, "No space left on device")
        return replace(*paths)

    monkeypatch.setattr(os, "replace", full_at_last)
    with pytest.raises(ArchiveError, match=r"No space left.*what is done is kept, go on with --resume"):
        sweep(path)
    monkeypatch.setattr(os, "replace", replace)
    assert not path.exists()
    assert len(list(shards_folder(path).glob("*.h5"))) == number - 1
    assert sweep(path, resume=True).faults == []
    assert_whole(path, whole)


def refuse_to_remove(*_, **__):
    raise OSError(errno.EPERM, "Operation not permitted")


@pytest.mark.slow
def test_shards_that_cannot_be_removed_take_nothing_from_a_sweep_that_is_done(apesim, monkeypatch, whole):
    with monkeypatch.context() as patched:
        patched.setattr(Path, "unlink", refuse_to_remove)
        code, _, err = apesim("engine", "sweep", *FAST)
        assert code == 0
        assert "all runs are in sweep.h5, but sweep.h5.shards/runs_000000-000000.h5: could not be removed (Oper" in err
        code, out, err = apesim("engine", "sweep", *FAST, "--resume")
        assert code == 0 and "finished already" in out and "all runs are in sweep.h5, but" in err
        code, _, err = apesim("engine", "sweep", *FAST, "--overwrite")
        assert code == 2 and "could not be removed" in err and "Traceback" not in err
    assert_whole("sweep.h5", whole)
    assert apesim("engine", "sweep", *FAST, "--resume")[0] == 0
    assert os.listdir() == ["sweep.h5"]


def killed_at(path, number):
    """In a process of its own: a sweep that is killed at one of its calls that change files."""
    calls = []

    def watched(owner, name):
        call = getattr(owner, name)

        def counted(*arguments, **options):
            calls.append(name)
            if len(calls) == number:
                os.kill(os.getpid(), signal.SIGKILL)
            return call(*arguments, **options)

        setattr(owner, name, counted)

    for owner, name in ((os, "fsync"), (os, "replace"), (Path, "unlink"), (Path, "rmdir")):
        watched(owner, name)
    sweep(path)


WRITES = 3 * len(RUNS)
"""Calls for the shards: each is written, renamed, and its folder written."""
OF_THE_END = range(WRITES + 1, WRITES + 3 + len(RUNS) + 2 + 1)
"""Calls for the archive, for the removal of shards and of their folder, and for the lock."""


@pytest.mark.skipif(os.name != "posix", reason="processes are forked")
@pytest.mark.parametrize(
    "number",
    [
        *np.random.default_rng(14).choice(np.arange(1, WRITES), 3),
        OF_THE_END[0],
        *(pytest.param(number, marks=pytest.mark.slow) for number in OF_THE_END[1:]),
    ],
)
def test_a_sweep_that_is_killed_anywhere_goes_on_and_leaves_only_its_archive(tmp_path, whole, number):
    path = tmp_path / "sweep.h5"
    process = multiprocessing.get_context("fork").Process(target=killed_at, args=(path, number))
    process.start()
    process.join()
    assert process.exitcode == -signal.SIGKILL
    was_there = path.exists()
    assert not was_there or verify(path) == []
    result = sweep(path, resume=True)
    assert result.was_finished == was_there and result.faults == []
    assert_whole(path, whole)
    assert [item.name for item in tmp_path.iterdir()] == ["sweep.h5"]


def test_a_sweep_that_is_finished_says_so_and_ends_with_0(apesim):
    code, first, _ = apesim("engine", "sweep", *FAST, "--json")
    content = Path("sweep.h5").read_bytes()
    part = read("sweep.h5")
    write_shard("sweep.h5.shards", part)
    Path("sweep.h5.lock").touch()
    Path(".sweep.h5.0123abcd.tmp").write_bytes(b"half")
    Path(".sweep.h5.notes.tmp").write_bytes(b"mine")
    code, out, err = apesim("engine", "sweep", *FAST, "--resume")
    assert code == 0 and without_stages(err) == ""
    assert "finished already, its 6 runs checked" in out and json.loads(first)["content_sha256"] in out
    assert Path("sweep.h5").read_bytes() == content
    assert sorted(os.listdir()) == [".sweep.h5.notes.tmp", "sweep.h5"]
    assert json.loads(apesim("engine", "sweep", *FAST, "--resume", "--json")[1])["was_finished"]
    code, _, err = apesim("engine", "sweep", *FAST, "--resume", "--set", "engine.bore=90 mm")
    assert code == 2 and "exists already" in err
    assert Path("sweep.h5").read_bytes() == content


@pytest.mark.slow
def test_a_finished_sweep_is_resumed_without_saying_what_was_swept(apesim):
    assert apesim("engine", "sweep", *FAST, "--out", "finished.h5")[0] == 0
    content = Path("finished.h5").read_bytes()
    code, out, err = apesim("engine", "sweep", "--resume", "--out", "finished.h5", "--no-figures")
    assert (code, err) == (0, "") and "finished already, its 6 runs checked, made by `apesim" in " ".join(out.split())
    assert Path("finished.h5").read_bytes() == content
    code, _, err = apesim("engine", "sweep", "--resume", "--out", "finished.h5", "--speed", "900 rpm")
    assert code == 2 and "exists already" in err
    whole = read("finished.h5")
    write(replace(whole, provenance=whole.provenance | {"runs_planned": "7"}), "finished.h5")
    code, _, err = apesim("engine", "sweep", "--resume", "--out", "finished.h5")
    assert code == 2 and "exists already" in err


def test_a_finished_sweep_with_a_point_out_of_reach_is_finished(apesim):
    point = ["--speed", "2400 rpm", "--intake", "epv,cam", "--set", "command.close_target=-4.5 deg", "--no-figures"]
    assert apesim("engine", "sweep", *point)[0] == 3
    code, out, err = apesim("engine", "sweep", *point, "--resume")
    assert code == 0 and "finished already" in out and "out of reach" in err


def test_a_finished_sweep_leaves_the_shards_of_another(tmp_path):
    path = tmp_path / "sweep.h5"
    finished = sweep(path)
    other = finished.archive.provenance | {"plan_hash": "another"}
    shard = write_shard(shards_folder(path), type(finished.archive)("", other, finished.archive.variables))
    with pytest.raises(ArchiveError, match="part of another sweep"):
        sweep(path, resume=True)
    assert shard.exists()


def test_a_damaged_archive_is_not_taken_for_a_finished_one(tmp_path, whole):
    path = tmp_path / "sweep.h5"
    sweep(path)
    flip_a_bit(path, np.random.default_rng(3))
    with pytest.raises(DamagedError, match=r"is there, but damaged.*--overwrite"):
        sweep(path, resume=True)
    sweep(path, resume=True, overwrite=True)
    assert_whole(path, whole)


@pytest.mark.slow
def test_a_share_of_a_sweep_is_whole_by_itself(apesim, whole):
    for share in ("1/3", "2/3", "3/3"):
        assert apesim("engine", "sweep", *FAST, "--shard", share, "--out", f"{share[0]}.h5")[0] == 0
    assert apesim("archive", "verify", "2.h5")[0] == 0
    assert apesim("archive", "info", "2.h5")[0] == 0
    assert "2 of 6 planned, share 2/3" in apesim("archive", "info", "2.h5")[1]
    assert apesim("archive", "merge", "1.h5", "3.h5", "--out", "two.h5")[0] == 3
    assert apesim("archive", "verify", "two.h5")[0] == 0
    assert apesim("archive", "merge", "two.h5", "2.h5", "--out", "all.h5")[0] == 0
    assert_whole("all.h5", whole)
    write(merge([read("1.h5"), read("1.h5")]), "1.h5")
    assert apesim("engine", "sweep", *FAST, "--shard", "2/3", "--out", "1.h5", "--resume")[0] == 2
