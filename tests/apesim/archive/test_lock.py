import os
from contextlib import ExitStack

import pytest

from apesim.archive import ArchiveError
from apesim.archive.lock import lock
from tests.processes import start_python


def test_two_sweeps_never_hold_the_same_target(tmp_path):
    with start_python(
        """
import time
from apesim.archive.lock import lock
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
