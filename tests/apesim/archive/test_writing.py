"""Files that users get: complete or absent; what is there and is no regular file stays what it is."""

import os
import shutil
import signal
import socket
import subprocess
import sys

import h5py
import pytest

from apesim.archive import ArchiveError, find_target, write, write_file
from apesim.archive.lock import lock
from tests.archive_samples import sample
from tests.processes import ENVIRONMENT

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")


def make_socket(path):
    with socket.socket(socket.AF_UNIX) as opened:
        opened.bind(str(path))


def link_to_pipe(path):
    os.mkfifo(path.with_name("pipe"))
    path.symlink_to("pipe")


def link_in_a_circle(path):
    path.symlink_to(path.name)


REFUSED = {
    "pipe": (os.mkfifo, "is a pipe"),
    "socket": (make_socket, "is a pipe, a socket"),
    "link to a pipe": (link_to_pipe, "is a pipe"),
    "link in a circle": (link_in_a_circle, "cannot be written"),
    "folder": (os.mkdir, "is a folder"),
}
WRITERS = {
    "file": lambda path: write_file(path, "new"),
    "archive": lambda path: write(sample(), path),
    "lock": lambda path: lock(path).__enter__(),
}


@pytest.mark.parametrize("case", REFUSED)
@pytest.mark.parametrize("writer", WRITERS)
def test_what_is_no_regular_file_is_refused_and_stays(tmp_path, monkeypatch, case, writer):
    monkeypatch.chdir(tmp_path)  # the path of a socket has to be short
    path = tmp_path / "a.h5"
    make, message = REFUSED[case]
    make(path.relative_to(tmp_path))
    before = {each.name: each.lstat().st_mode for each in tmp_path.iterdir()}
    with pytest.raises(ArchiveError, match=message):
        WRITERS[writer](path)
    assert {each.name: each.lstat().st_mode for each in tmp_path.iterdir()} == before


@pytest.mark.parametrize("is_there", [True, False])
def test_a_link_is_followed_and_stays(tmp_path, is_there):
    folder, link = tmp_path / "store", tmp_path / "a.txt"
    folder.mkdir()
    if is_there:
        (folder / "b.txt").write_text("old")
    link.symlink_to("store/b.txt")
    write_file(link, "new")
    assert link.is_symlink() and (folder / "b.txt").read_text() == "new"
    assert len(list(tmp_path.rglob("*"))) == 3
    assert find_target(link) == (folder / "b.txt").resolve()


def test_two_links_to_a_file_hold_one_lock(tmp_path):
    for name in ("a.h5", "b.h5"):
        (tmp_path / name).symlink_to("sweep.h5")
    message = "b.h5: is being written"
    with lock(tmp_path / "a.h5"), pytest.raises(ArchiveError, match=message), lock(tmp_path / "b.h5"):
        pass


@pytest.mark.parametrize("make", [os.mkfifo, link_to_pipe, lambda path: path.write_text("a user's notes")])
def test_what_is_no_lock_is_neither_emptied_nor_removed(tmp_path, make):
    make(tmp_path / "a.h5.lock")
    before = (tmp_path / "a.h5.lock").lstat()
    message = r"a.h5.lock: (cannot be locked|has the name of a lock)"
    with pytest.raises(ArchiveError, match=message), lock(tmp_path / "a.h5"):
        pass
    after = (tmp_path / "a.h5.lock").lstat()
    assert (after.st_ino, after.st_size, after.st_mode) == (before.st_ino, before.st_size, before.st_mode)


def test_a_lock_that_a_killed_process_left_is_taken_over(tmp_path):
    for left in ("", "process 1 since 2024"):
        (tmp_path / "a.h5.lock").write_text(left)
        with lock(tmp_path / "a.h5"):
            pass


@pytest.mark.parametrize("length", [242, 250, 255, 256, 5000])
def test_a_name_that_is_too_long_for_what_stands_beside_it_is_told(tmp_path, length):
    path = tmp_path / ("a" * (length - 3) + ".h5")
    for writer in WRITERS.values():
        with pytest.raises(ArchiveError, match=r"File name too long.*; choose another name"):
            writer(path)
    assert not list(tmp_path.iterdir())


def test_a_name_that_no_file_can_have_is_told(tmp_path):
    with pytest.raises(ArchiveError, match="cannot be written"):
        find_target(tmp_path / "a\0b")
    (tmp_path / "a").touch()
    with pytest.raises(ArchiveError, match="cannot be written"):
        find_target(tmp_path / "a" / "b.h5")


def test_a_longest_name_is_written(tmp_path):
    write_file(tmp_path / ("a" * 241), "new")
    with lock(tmp_path / ("a" * 241)):
        pass
    assert [len(path.name) for path in tmp_path.iterdir()] == [241]


@pytest.mark.skipif(not hasattr(signal, "SIGXFSZ"), reason="no limit of file sizes here")
def test_a_full_disk_leaves_the_older_file_and_nothing_else(tmp_path):
    (tmp_path / "a.txt").write_text("old")
    script = """
import resource
from apesim.archive import ArchiveError, write_file
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
try:
    write_file("a.txt", "new" * 1000)
except ArchiveError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True)
    assert done.stdout == "a.txt: could not be written (File too large); make room or choose another folder\n"
    assert [path.read_text() for path in tmp_path.iterdir()] == ["old"]


def test_texts_are_such_as_octave_reads(tmp_path):
    """Octave reads no file with a text of fixed length that HDF5 labels UTF-8; the bytes are UTF-8 all the same."""
    found = []
    with h5py.File(write(sample(), tmp_path / "a.h5")) as file:
        file.visititems(lambda name, item: found.append(item) if isinstance(item, h5py.Dataset) else None)
        texts = [item for item in found if item.dtype.kind == "S"]
        assert {item.name for item in texts} == {"/about/machine", "/about/provenance", "/about/digests", "/warning"}
        assert {item.id.get_type().get_cset() for item in texts} == {h5py.h5t.CSET_ASCII}
        assert {item.attrs["_Encoding"] for item in texts} == {b"utf-8"}
        assert file["about/machine"][0].decode() == sample().machine


@pytest.mark.skipif(not shutil.which("octave-cli"), reason="Octave is not installed here")
def test_octave_loads_an_archive(tmp_path):
    write(sample(), tmp_path / "a.h5")
    script = "a = load('a.h5'); printf('%s', a.about.machine), printf('%g ', a.speed)"
    done = subprocess.run(["octave-cli", "--eval", script], cwd=tmp_path, capture_output=True, text=True)
    assert sample().machine in done.stdout and "0.1 100.1 200.1" in done.stdout
