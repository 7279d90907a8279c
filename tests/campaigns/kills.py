"""Sweeps that are killed at random moments: the whole group of processes, the one that leads, or one of its workers.

What was killed goes on with ``--resume``, may be killed again, and ends with the same bits as a sweep that nothing has
killed. It leaves nothing but its archive, and no process outlives the one that leads.
"""

import os
import random
import signal
import subprocess
import sys
import time
from functools import cache
from pathlib import Path
from typing import NamedTuple

from apesim.archive.file import read
from apesim.archive.inspection import verify
from tests.archive_samples import same

from .campaign import Outcome, trial_folder

LONGEST = 300.0
"""That a trial may take [s]: up to three sweeps."""
SWEEP = "engine", "sweep", "--speed", "300:2400:150 rpm", "--timing", "both", "--no-figures", "--out", "sweep.h5"
"""Valves with and without correction, a cam and an ideal valve."""
GROUP, LEADER, WORKER = "group", "leader", "worker"
STRIKES = [(victim, jobs) for jobs in (1, 2, 3) for victim in (GROUP, LEADER, WORKER) if jobs > 1 or victim != WORKER]
"""What is killed, and in how many processes the sweep computes."""
NOT_STRUCK = "after its end"
"""How far a sweep was that had ended before it was to be killed: no trial of what is promised."""
PATIENCE = 10.0
"""That processes may outlive the one that leads [s]."""


class Undisturbed(NamedTuple):
    """A sweep that nothing has killed."""

    content: bytes
    """The archive's file."""
    first: float
    """When its first shard was there [s]."""
    seconds: float
    """Time that it took [s]."""


def trial(seed):
    """Kill a sweep once or twice, let it go on, and hold it against one that was not killed.

    Parameters
    ----------
    seed : int

    Returns
    -------
    Outcome
    """
    rng = random.Random(seed)
    victim, jobs = STRIKES[seed % len(STRIKES)]
    whole, kind = undisturbed(jobs), f"{victim}, {jobs} process{'es' * (jobs > 1)}"
    with trial_folder() as folder:
        struck, strikes, longest = [], rng.choice((1, 1, 2)), whole.seconds
        left = strikes
        while True:
            process = start(folder, *SWEEP, "--jobs", f"{jobs}", resume=bool(struck))
            begun = time.monotonic()
            while left and wait_until(process, begun + rng.uniform(min(0.8 * whole.first, longest), longest)):
                left -= 1
                progress = describe_progress(folder)
                if strike(process, victim, rng):
                    struck.append(progress)
            end_of_leader, took = process.wait(), time.monotonic() - begun
            if survivors := find_survivors(process.pid):
                os.killpg(process.pid, signal.SIGKILL)
                return Outcome(f"{kind}: a process outlives the sweep", True, str(survivors))
            if (struck and end_of_leader != -signal.SIGKILL) or end_of_leader > 0:
                break
            if not struck:  # it ended before it was to be killed
                left, longest = strikes, 0.9 * took
                (folder / "sweep.h5").unlink()
        (folder / "whole.h5").write_bytes(whole.content)
        return judge(kind, struck, end_of_leader, folder)


def judge(kind, struck, code, folder):
    """The outcome by what a sweep has left.

    Parameters
    ----------
    kind : str
        What was killed, in words.
    struck : list of str
        How far the sweep was at each kill; [] where it ended before the first.
    code : int
        Exit code at its end.
    folder : path
        Folder with ``sweep.h5``, and ``whole.h5`` of a sweep that was not killed.

    Returns
    -------
    Outcome
    """
    errors = (folder / "err.txt").read_text()
    left = sorted({path.name for path in folder.iterdir()} - {"err.txt", "whole.h5"})
    if code or left != ["sweep.h5"]:
        return Outcome(f"{kind}: not whole", True, f"{struck}: exit code {code}, {left}: {errors}")
    if named := verify(folder / "sweep.h5"):
        return Outcome(f"{kind}: damaged", True, f"{struck}: {named}")
    if not same(read(folder / "sweep.h5"), read(folder / "whole.h5")):
        return Outcome(f"{kind}: other bits", True, str(struck))
    return Outcome(f"{kind}: the same bits, struck {struck[-1] if struck else NOT_STRUCK}", is_void=not struck)


def start(folder, *words, resume=False):
    """Start a sweep in a group of its own; what it says on standard error is in ``err.txt``."""
    command = [sys.executable, "-m", "apesim.studies.commands.cli", *words, *["--resume"] * resume]
    with (folder / "err.txt").open("w") as errors:
        return subprocess.Popen(
            command, cwd=folder, stdout=subprocess.DEVNULL, stderr=errors, stdin=subprocess.DEVNULL, process_group=0
        )


def wait_until(process, moment):
    """Wait until a moment has come; False where the process ends before."""
    try:
        process.wait(max(0.0, moment - time.monotonic()))
    except subprocess.TimeoutExpired:
        return True
    return False


def strike(process, victim, rng):
    """Kill the group, the leader, or one of the workers; False where there is none."""
    if victim == GROUP:
        os.killpg(process.pid, signal.SIGKILL)
    elif victim == LEADER:
        process.kill()
    elif workers := find_workers(process.pid):
        try:
            os.kill(rng.choice(workers), signal.SIGKILL)
        except ProcessLookupError:
            return False
    else:
        return False
    return True


def find_workers(leader):
    """Processes that compute for a sweep: copies of its process, or started from scratch."""
    try:
        children = " ".join(path.read_text() for path in Path(f"/proc/{leader}/task").glob("*/children")).split()
        commands = {child: Path(f"/proc/{child}/cmdline").read_bytes() for child in children}
        own = Path(f"/proc/{leader}/cmdline").read_bytes()
        return [int(child) for child, command in commands.items() if command == own or b"spawn_main" in command]
    except FileNotFoundError:  # one has ended meanwhile
        return []


def find_survivors(group):
    """Processes of a group that are still there after `PATIENCE`."""
    until = time.monotonic() + PATIENCE
    while True:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return []
        if time.monotonic() > until:
            return [path.parent.name for path in Path("/proc").glob("[0-9]*/stat") if is_of(path, group)]
        time.sleep(0.02)


def is_of(stat, group):
    """Whether a process is of a group."""
    try:
        return int(stat.read_text().rpartition(")")[2].split()[2]) == group
    except (FileNotFoundError, ProcessLookupError):
        return False


def describe_progress(folder):
    """How far a sweep is, by its files."""
    if (folder / "sweep.h5").exists():
        return "with its archive written"
    return "with shards written" if any((folder / "sweep.h5.shards").glob("*.h5")) else "before its first shard"


@cache
def undisturbed(jobs):
    """The sweep, as it goes if nothing kills it and all is compiled, as it is for those that are killed."""
    with trial_folder() as folder:
        start(folder, *SWEEP, "--jobs", f"{jobs}").wait()
        (folder / "sweep.h5").unlink()
        begun, first = time.monotonic(), None
        process = start(folder, *SWEEP, "--jobs", f"{jobs}")
        while process.poll() is None:
            if first is None and describe_progress(folder) != "before its first shard":
                first = time.monotonic() - begun
            time.sleep(0.01)
        if process.returncode:
            raise RuntimeError((folder / "err.txt").read_text())
        return Undisturbed((folder / "sweep.h5").read_bytes(), first, time.monotonic() - begun)
