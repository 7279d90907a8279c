"""The n-th call of the system fails, for n = 1, 2, 3, ... to the end of a sweep, of a merge, of ``gap explain``.

So SQLite is tested [1]_: each call that may fail is made to, one at a time. What comes of it is complete, or it is
refused in a line that names what is missing, and done again it is complete and leaves nothing else. A trial whose call
is never reached says so: it ends the row of its kind. `TRIALS` reaches to the end of every row.

References
----------
.. [1] "How SQLite is tested", https://sqlite.org/testing.html, sections 3.1 to 3.3.
"""

import builtins
import contextlib
import errno
import os
import signal
import sys
import threading
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from unittest import mock

import numpy as np

from apesim.archive.file import read
from apesim.archive.inspection import verify
from apesim.studies.gap.example_bench import list_left_out, write_example
from apesim.studies.sweep import completion
from apesim.studies.terminal.console import BAD_INPUT, DONE, INCOMPLETE
from tests.archive_samples import same
from tests.folders import ROOT

from .campaign import WITH_COMPILER, Outcome, trial_folder
from .inputs import run

LONGEST = 300.0
"""That a trial may take [s]: a command twice."""
MEMORY = WITH_COMPILER
UNREACHED = "not reached"
PARTS = "1.h5", "2.h5", "3.h5"
SWEEP = "engine", "sweep", "--speed", "600:1200:300 rpm", "--intake", "cam,ideal", "--no-figures"
EXPLAIN = "gap", "explain", "measured", "--out", "explained"
NAMED = "sweep.h5", "all.h5", "explained", "memory", "--jobs", *PARTS
"""What a refusal names: a file or folder, or what there is too little of."""
LEFT = ".tmp", ".lock", ".shards"
"""Ends of names of what nothing may leave."""
BEFORE, INSIDE, AFTER = "before", "inside", "after"
"""Places in a task at which its worker dies."""
PROGRAM, TESTS = (f"{path}{os.sep}" for path in (ROOT, ROOT / "tests"))
CALLS_INSIDE = 1000
"""Calls of functions after which a worker dies inside a task."""


def trial(seed):
    """Let one call fail while a command runs, and let it run again.

    Parameters
    ----------
    seed : int

    Returns
    -------
    Outcome
    """
    if seed >= len(TRIALS):
        return Outcome("none: there are no more calls")
    number, command, call = TRIALS[seed]
    kind = f"{command.__name__}, {call.__name__}"
    with trial_folder() as folder, contextlib.chdir(folder):
        first, again, is_whole = command()
        with fail(call, number) as reached, mock.patch.object(completion, "SHARD_SECONDS", 0.0):  # each run is a shard
            code, _, err = run(first)
        if not reached:
            return Outcome(f"{kind}: {UNREACHED}", is_void=True)
        word, what = judge(code, err, is_whole), f"call {number}: {code}: {err.strip()[-300:]}"
        if word:
            return Outcome(f"{kind}: {word}", True, what)
        second, _, more = run(again)
        if second != DONE or not is_whole():
            return Outcome(f"{kind}: not whole when done again", True, f"{what}; then {second}: {more.strip()[-300:]}")
        if left := [path.name for path in folder.iterdir() if path.name.endswith(LEFT)]:
            return Outcome(f"{kind}: something is left", True, f"{what}; {left}")
        return Outcome(f"{kind}: {'complete' if code == DONE else 'named, and complete when done again'}")


def judge(code, err, is_whole):
    """What is wrong with how a command ended; "" where nothing is.

    Parameters
    ----------
    code : int or str
        Exit code, or what was raised.
    err : str
    is_whole : callable

    Returns
    -------
    str
    """
    if code not in (DONE, BAD_INPUT, INCOMPLETE) or "Traceback" in err:
        return f"ends with {code}"
    if code == DONE:
        return "" if is_whole() else "done, and not whole"
    return "" if any(word in err for word in NAMED) else "the refusal names nothing"


# --- commands: the words, the words of doing it again, and whether it is whole ---


def sweep():
    """A sweep in this process."""
    return SWEEP, (*SWEEP, "--resume"), lambda: is_sweep("sweep.h5")


def sweep_of_two():
    """A sweep in two processes."""
    return (*SWEEP, "--jobs", "2"), (*SWEEP, "--resume"), lambda: is_sweep("sweep.h5")


def merge():
    """The parts of a sweep joined."""
    for name, content in parts().items():
        Path(name).write_bytes(content)
    words = "archive", "merge", *PARTS, "--out", "all.h5"
    return words, (*words, "--overwrite"), lambda: is_sweep("all.h5")


def explain(jobs=1):
    """A search for a missing effect, with its report."""
    Path("measured").mkdir()
    write_example(Path("measured"))
    words = *EXPLAIN, "--jobs", f"{jobs}", *(word for name in list_left_out() for word in ("--without", name))
    return words, (*words, "--overwrite"), is_explained


def explain_of_two():
    """A search for a missing effect in two processes."""
    return explain(2)


def is_sweep(path):
    """Whether a file has all runs of the sweep, with the same bits."""
    return Path(path).exists() and not verify(path) and same(read(path), whole())


def is_explained():
    """Whether a folder has all that belongs to an explanation, each file as it ends."""
    ends = {"verdict.json": "}\n", "report.html": "</html>", "machine.toml": "\n"}
    paths = {Path("explained", name): end for name, end in ends.items()}
    return all(path.exists() and path.read_text(encoding="utf-8").endswith(end) for path, end in paths.items())


@cache
def whole():
    """The sweep as it is if nothing fails."""
    with trial_folder() as folder, contextlib.chdir(folder):
        assert run(SWEEP)[0] == DONE
        return read("sweep.h5")


@cache
def parts():
    """Files of the sweep's parts, by name."""
    with trial_folder() as folder, contextlib.chdir(folder):
        for number, name in enumerate(PARTS, 1):
            assert run((*SWEEP, "--shard", f"{number}/{len(PARTS)}", "--out", name))[0] == DONE
        return {name: Path(name).read_bytes() for name in PARTS}


# --- calls: what is replaced, and the error that it raises ---


def opening(fails):
    """A file cannot be opened for writing."""

    def refuse(call, *how, **options):
        fails(errno.EACCES)
        return call(*how, **options)

    return watch_writers(refuse)


def writing(fails):
    """A write to a file takes half of what it is given, and fails."""
    return watch_writers(lambda call, *how, **options: Half(call(*how, **options), fails))


def watch_writers(opens):
    """Let a function open what is opened for writing in the folder of the trial; it gets what opens otherwise first."""
    call = builtins.open

    def watched(file, mode="r", *more, **options):
        if set(mode) & set("wax+") and is_here(file):
            return opens(call, file, mode, *more, **options)
        return call(file, mode, *more, **options)

    return [mock.patch("builtins.open", watched), mock.patch("io.open", watched)]


class Half:
    """A file one of whose writes fails half way."""

    def __init__(self, opened, fails):
        self._opened, self._fails = opened, fails

    def write(self, content):
        try:
            self._fails(errno.ENOSPC)
        except OSError:
            self._opened.write(content[: len(content) // 2])
            raise
        return self._opened.write(content)

    def __getattr__(self, name):
        return getattr(self._opened, name)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._opened.close()

    def __iter__(self):
        return iter(self._opened)


def syncing(fails):
    """A file or folder cannot be brought to the disk."""
    return [watch(os, "fsync", fails, errno.EIO)]


def renaming(fails):
    """A file cannot be renamed."""
    return [watch(os, name, fails, errno.EXDEV) for name in ("replace", "rename")]


def removing(fails):
    """A file or folder cannot be removed."""
    return [watch(os, name, fails, errno.EPERM) for name in ("unlink", "remove", "rmdir")]


def making(fails):
    """A folder cannot be made."""
    return [watch(os, "mkdir", fails, errno.EACCES)]


def allocating(fails):
    """There is no memory for an array; each place that takes some is counted once, with the lines that led there."""
    places = set()

    def fail_at_new_place(error):
        place = find_place()
        if place not in places:
            places.add(place)
            fails(error)

    return [watch(np, name, fail_at_new_place, None) for name in ("empty", "zeros", "concatenate", "column_stack")]


def find_place():
    """Lines of the program that led here, the last one first."""
    frame, lines = sys._getframe(), []
    while frame := frame.f_back:
        file = frame.f_code.co_filename
        if file.startswith(PROGRAM) and not file.startswith(TESTS):
            lines.append((file, frame.f_lineno))
    return tuple(lines)


def submitting(fails):
    """A worker process cannot be given a task."""
    return [watch(ProcessPoolExecutor, "submit", fails, errno.EAGAIN)]


def dying(fails):
    """A worker process dies before, inside or after a task."""
    submit = ProcessPoolExecutor.submit

    def watched(executor, task, item):
        for place in (BEFORE, INSIDE, AFTER):
            try:
                fails(errno.EIO)
            except OSError:
                task, item = die, (place, task, item)
        return submit(executor, task, item)

    return [mock.patch.object(ProcessPoolExecutor, "submit", watched)]


def die(order):
    """Kill this process before, inside or after a task."""
    place, task, item = order
    if place == INSIDE:
        left = iter(range(CALLS_INSIDE))

        def count(*_):
            if next(left, None) is None:
                kill()

        threading.setprofile(count)
        sys.setprofile(count)
    if place != BEFORE:
        task(item)
    kill()


def kill():
    """Kill this process, as the system does where memory is short."""
    os.kill(os.getpid(), signal.SIGKILL)


def damaging(fails):
    """A shard loses its second half once it is written, and the archive cannot be renamed: shards are read again."""
    replace, damaged = os.replace, []

    def watched(source, target):
        path = Path(target)
        is_shard = path.parent.name.endswith(".shards")
        if damaged and not is_shard:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        replace(source, target)
        if is_shard:
            try:
                fails(errno.EIO)
            except OSError:
                path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
                damaged.append(path)

    return [mock.patch.object(os, "replace", watched)]


def watch(owner, name, fails, error):
    """A function that may fail before it does anything."""
    call = getattr(owner, name)

    def watched(*arguments, **options):
        fails(error)
        return call(*arguments, **options)

    return mock.patch.object(owner, name, watched)


def is_here(file):
    """Whether a file lies in the folder of the trial."""
    return not isinstance(file, int) and Path(file).absolute().is_relative_to(Path.cwd())


@contextlib.contextmanager
def fail(call, number):
    """Let the call of a kind with this number fail, once; gives a list that is empty as long as it has not."""
    counted, reached = [], []

    def fails(error):
        counted.append(error)
        if len(counted) == number:
            reached.append(number)
            raise MemoryError if error is None else OSError(error, os.strerror(error))

    with ExitStack() as stack:
        for patch in call(fails):
            stack.enter_context(patch)
        yield reached


ROWS = {
    sweep: {opening: 10, writing: 10, syncing: 16, renaming: 9, removing: 10, making: 9, allocating: 44, damaging: 9},
    merge: {opening: 4, writing: 4, syncing: 4, renaming: 3, removing: 3, making: 3, allocating: 26},
    explain: {opening: 19, writing: 19, syncing: 36, renaming: 19, removing: 2, making: 6, allocating: 390},
    sweep_of_two: {submitting: 9, dying: 24},
    explain_of_two: {submitting: 32, dying: 92},
}
"""Commands, what fails in them, and how many calls are let fail: a few more than there are."""
TRIALS = sorted(
    (
        (number, command, call)
        for command, row in ROWS.items()
        for call, length in row.items()
        for number in range(1, length + 1)
    ),
    key=lambda one: one[0],
)
"""Number of the call that fails, command, and what fails, by seed: the first calls of all first."""
