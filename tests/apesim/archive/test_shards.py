import os
import signal
import subprocess
import sys
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import apesim
from apesim.archive import ArchiveError, read, write
from apesim.archive.shards import (
    lock,
    merge,
    missing_runs,
    plan_hash,
    read_shards,
    remove_shards,
    shards_folder,
    write_shard,
)
from tests.archive_samples import same, sample
from tests.folders import ROOT

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(apesim.__file__).parents[1])}
PREAMBLE = f"""
import sys, time
sys.path.insert(0, {str(ROOT)!r})
from tests.archive_samples import sample
from apesim.archive.shards import lock, shards_folder, write_shard
"""


def child(script, folder):
    return subprocess.Popen(
        [sys.executable, "-c", PREAMBLE + script],
        cwd=folder,
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        text=True,
    )


@pytest.mark.parametrize("shards", [1, 4, 11])
def test_killed_sweep_loses_nothing_that_was_reported(tmp_path, shards):
    folder = shards_folder(tmp_path / "F.h5")
    with child(
        """
with lock("F.h5"):
    for i in range(10_000):
        write_shard(shards_folder("F.h5"), sample([2 * i, 2 * i + 1], angles=721))
        print(i, flush=True)
""",
        tmp_path,
    ) as process:
        for _ in range(shards):
            last = int(process.stdout.readline())
        os.kill(process.pid, signal.SIGKILL)
        last = int(([str(last), *process.stdout.read().split()])[-1])
    assert process.returncode == -signal.SIGKILL
    (folder / ".runs_000900-000901.h5.abcd.tmp").write_bytes(b"half")

    found = read_shards(folder, "p")
    assert found.damaged == [] and set(range(2 * last + 2)) <= set(found.done)
    with lock(tmp_path / "F.h5"):
        whole = merge(found.parts)
        assert same(whole, sample(found.done, angles=721))
        write(whole, tmp_path / "F.h5")
        remove_shards(folder)
    assert not folder.exists() and read(tmp_path / "F.h5").runs.tolist() == found.done


def test_no_shards_yet(tmp_path):
    assert read_shards(tmp_path / "none", "p") == ([], [], [])
    remove_shards(tmp_path / "none")


def test_damaged_shards_are_reported_and_left_out(tmp_path):
    paths = [write_shard(tmp_path, sample([i])) for i in range(4)]
    assert [path.name for path in paths][:2] == ["runs_000000-000000.h5", "runs_000001-000001.h5"]
    content = bytearray(paths[1].read_bytes())
    place = content.index(np.float64(100.1).tobytes())
    content[place] ^= 1
    paths[1].write_bytes(content)
    paths[2].write_bytes(paths[2].read_bytes()[:5000])
    found = read_shards(tmp_path, "p")
    assert found.done == [0, 3] and len(found.parts) == 2
    assert (
        len(found.damaged) == 2
        and str(paths[1]) in found.damaged[0]
        and "speed: a checksum is wrong" in found.damaged[0]
    )
    assert write_shard(tmp_path, sample([1])) == paths[1]
    assert read_shards(tmp_path, "p").done == [0, 1, 3]


def test_shards_of_another_sweep_are_refused(tmp_path):
    write_shard(tmp_path, sample([0]))
    write_shard(tmp_path, sample([1], plan_hash="q"))
    with pytest.raises(ArchiveError, match=r"runs_000001-000001.h5: is part of another sweep"):
        read_shards(tmp_path, "p")


def test_shards_are_named_by_their_runs(tmp_path):
    parts = [[1, 2, 3], [1, 3], [1, 2, 4], [1, 3, 4]]
    assert len({write_shard(tmp_path, sample(part)).name for part in parts}) == 4
    assert read_shards(tmp_path, "p").done == [1, 2, 3, 4]
    with pytest.raises(ValueError, match="at least one run"):
        write_shard(tmp_path, sample([]))
    with pytest.raises(ValueError, match="plan_hash"):
        write_shard(tmp_path, replace(sample(), provenance={}))
    (tmp_path / "file").write_text("")
    with pytest.raises(ArchiveError, match="cannot be made"):
        write_shard(tmp_path / "file", sample())


def test_remove_keeps_what_is_not_ours(tmp_path):
    write_shard(tmp_path / "s", sample([0]))
    (tmp_path / "s" / "notes.txt").write_text("mine")
    remove_shards(tmp_path / "s")
    assert os.listdir(tmp_path / "s") == ["notes.txt"]
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "runs_1.h5").write_text("mine")
    (tmp_path / "link").symlink_to(tmp_path / "real")
    remove_shards(tmp_path / "link")
    assert os.listdir(tmp_path / "real") == ["runs_1.h5"]


def test_plan_hash_depends_on_machine_and_settings_only():
    assert plan_hash("m", {"a": 1, "b": [2.0]}) == plan_hash("m", {"b": [2.0], "a": 1})
    assert len({plan_hash("m", {"a": 1}), plan_hash("n", {"a": 1}), plan_hash("m", {"a": 2})}) == 3


def test_two_sweeps_never_hold_the_same_target(tmp_path):
    with child(
        """
with lock("F.h5"):
    print("held", flush=True)
    time.sleep(20)
""",
        tmp_path,
    ) as process:
        assert process.stdout.readline() == "held\n"
        for _ in range(2):
            message = f"written by process {process.pid} since 20.*F.h5.lock"
            with pytest.raises(ArchiveError, match=message), lock(tmp_path / "F.h5"):
                pass
        with lock(tmp_path / "G.h5"):
            pass
        process.kill()
    message = f"process {os.getpid()}"
    with lock(tmp_path / "F.h5"), pytest.raises(ArchiveError, match=message), lock(tmp_path / "F.h5"):
        pass
    with lock(tmp_path / "F.h5"):
        pass
    with pytest.raises(ArchiveError, match="its folder does not exist"), lock(tmp_path / "none" / "F.h5"):
        pass
    assert not (tmp_path / "none").exists()
    (tmp_path / "H.h5.lock").mkdir()
    with pytest.raises(ArchiveError, match=r"H.h5.lock: cannot be locked"), lock(tmp_path / "H.h5"):
        pass


def test_a_lock_leaves_no_file_behind(tmp_path):
    with lock(tmp_path / "F.h5"):
        assert [path.name for path in tmp_path.iterdir()] == ["F.h5.lock"]
    assert not list(tmp_path.iterdir())


def test_a_lock_file_that_was_removed_after_it_was_opened_gives_no_lock(tmp_path, monkeypatch):
    fcntl = pytest.importorskip("fcntl")
    held, flock = ExitStack(), fcntl.flock
    held.enter_context(lock(tmp_path / "F.h5"))

    def released_first(descriptor, operation):
        if operation & fcntl.LOCK_EX:
            held.close()
        return flock(descriptor, operation)

    monkeypatch.setattr(fcntl, "flock", released_first)
    with pytest.raises(ArchiveError, match="is being written"), lock(tmp_path / "F.h5"):
        pass
    with lock(tmp_path / "F.h5"):
        pass


@settings(max_examples=50)
@given(st.lists(st.lists(st.integers(0, 40), unique=True).map(sorted), min_size=1, max_size=5))
def test_merge_is_the_whole_whatever_the_parts(parts):
    whole = merge([sample(part) for part in parts])
    assert same(whole, sample(sorted({run for part in parts for run in part})))


def test_contradicting_runs_are_an_error():
    other = sample([1, 2])
    other.variables["cylinder_pressure"].values[0, 3] += 1e-9
    with pytest.raises(ArchiveError, match=r"b.h5: run 1 contradicts a.h5 in cylinder_pressure"):
        merge([sample([0, 1]), other], names=["a.h5", "b.h5"])
    signed = sample([0])
    signed.variables["torque"].values[0] = -0.0
    with pytest.raises(ArchiveError, match="part 2: run 0 contradicts part 1 in torque"):
        merge([sample([0]), signed])


def test_parts_must_belong_together():
    def other(name, **fields):
        archive = sample([5])
        archive.variables[name] = replace(archive.variables[name], **fields)
        return archive

    less = sample([5])
    del less.variables["speed"]
    machine = sample().machine
    for part, message in (
        (
            replace(sample([5]), machine=machine.replace("2 ms", "3 ms")),
            "another machine .valve.solenoid.dead_time",
        ),
        (replace(sample([5]), machine=machine + "# x"), "another machine .in its comments"),
        (sample([5], plan_hash="q"), "plan_hash"),
        (less, "only one of them has speed"),
        (other("speed", unit="1/min"), "speed has unit '1/min', not 'rpm'"),
        (other("cycles", values=np.array([1.0])), "cycles has kind 'float64', not 'int64'"),
        (sample([5], angles=6), "axis crank_angle differs"),
        (other("crank_angle", values=np.linspace(0, 720.1, 5)), "axis crank_angle differs"),
    ):
        with pytest.raises(ArchiveError, match=f"b.h5: does not fit a.h5: .*{message}"):
            merge([sample([0]), part], names=["a.h5", "b.h5"])
    with pytest.raises(ArchiveError, match="no parts"):
        merge([])


def test_merged_provenance_keeps_what_differs(tmp_path):
    merged = merge([sample([0], command="--shard 1/2"), sample([1], command="--shard 2/2", created="later")])
    assert merged.provenance == {"plan_hash": "p", "command": "--shard 1/2; --shard 2/2"}
    files = [write(sample([i]), tmp_path / f"{i}.h5") for i in (1, 0)]
    assert same(merge([read(file) for file in files], files), sample([0, 1]))


def test_missing_runs_are_given_as_gaps():
    assert missing_runs(sample([0, 1, 2])) == []
    assert missing_runs(sample([2, 3, 6])) == [(0, 1), (4, 5)]
    assert missing_runs(sample([2, 3, 6]), total=10) == [(0, 1), (4, 5), (7, 9)]
    assert missing_runs(sample([0], runs_planned="3")) == [(1, 2)]
    assert missing_runs(sample([]), total=2) == [(0, 1)]
    assert missing_runs(sample([]), total=0) == missing_runs(sample([])) == []
    assert missing_runs(sample([1, 5]), total=3) == [(0, 0), (2, 2)]
    assert missing_runs(sample([2**62])) == [(0, 2**62 - 1)]
