import os
import signal
from dataclasses import replace

import numpy as np
import pytest

from apesim.archive import ArchiveError, read, write
from apesim.archive.lock import lock
from apesim.archive.merge import merge
from apesim.archive.shards import plan_hash, read_shards, remove_shards, shards_folder, write_shard
from tests.archive_samples import same, sample
from tests.processes import start_python


@pytest.mark.parametrize("shards", [1, 4, 11])
def test_killed_sweep_loses_nothing_that_was_reported(tmp_path, shards):
    folder = shards_folder(tmp_path / "F.h5")
    with start_python(
        """
from apesim.archive.lock import lock
from apesim.archive.shards import shards_folder, write_shard
from tests.archive_samples import sample
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
