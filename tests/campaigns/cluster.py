"""Sweeps on a dask cluster whose workers are killed, paused and added, and whose scheduler is lost.

Scheduler and workers are processes of their own, reached over TCP on the loopback address. A sweep that lost its
scheduler has to say so and to keep what is done; it goes on with ``--resume`` on a cluster that is started anew, and
ends with the same bits as a sweep that nothing has disturbed.
"""

import json
import os
import random
import signal
import subprocess
import sys
import time
from contextlib import suppress
from functools import cache

from .campaign import Outcome, trial_folder
from .kills import describe_progress, judge, start, wait_until

LONGEST = 300.0
"""That a trial may take [s]."""
SWEEP = "engine", "sweep", "--speed", "300:2400:25 rpm", "--timing", "both", "--no-figures", "--out", "sweep.h5"
"""Valves with and without correction, a cam and an ideal valve: some 18 s of computing."""
WORKERS = 2
"""Workers that a cluster begins with."""
KILL, PAUSE, ADD, LOSE = "worker killed", "worker paused", "worker added", "scheduler lost"
TROUBLES = KILL, PAUSE, ADD, LOSE
MOST = 4
"""Most troubles of a trial."""
EVERY = 1.0, 6.0
"""Time from one trouble to the next [s]."""
PAUSES = 0.5, 8.0
"""How long a worker is paused [s]."""
PATIENCE = 60.0
"""That a scheduler may take to start [s]."""
BAD_INPUT = 2
"""Exit code of a sweep that has lost its scheduler."""


def trial(seed):
    """Disturb a sweep on a cluster some times, and hold it against one that was computed here.

    Parameters
    ----------
    seed : int

    Returns
    -------
    Outcome
    """
    rng = random.Random(seed)
    planned = [TROUBLES[seed % len(TROUBLES)]] + [rng.choice(TROUBLES) for _ in range(rng.randrange(MOST))]
    kind, struck = planned[0], []
    with trial_folder() as folder, trial_folder() as space:
        while True:
            with Cluster(space) as cluster:
                process = start(folder, *SWEEP, "--dask", cluster.address, resume=bool(struck))
                while planned and wait_until(process, time.monotonic() + rng.uniform(*EVERY)):
                    struck.append(describe_progress(folder))
                    if cluster.trouble(planned.pop(0), rng):
                        break
                code = process.wait()
            if not cluster.is_lost or code == 0:
                break
            if not told_how_to_go_on(code, folder):
                return Outcome(f"{kind}: the loss is not told", True, f"{struck}: exit code {code}: {said(folder)}")
        (folder / "whole.h5").write_bytes(computed_here())
        return judge(kind, struck, code, folder)


def told_how_to_go_on(code, folder):
    """Whether a sweep says that its scheduler is gone, or was never there, and what to do."""
    told = ("the scheduler is gone", "--resume"), ("no scheduler answers", "start one")
    return code == BAD_INPUT and any(all(words in said(folder) for words in each) for each in told)


def said(folder):
    """What the sweep has written on standard error."""
    return (folder / "err.txt").read_text()


class Cluster:
    """A scheduler and its workers, each a process of its own.

    Parameters
    ----------
    folder : path
        Folder for what they write.
    """

    def __init__(self, folder):
        self.folder, self.workers, self.is_lost = folder, [], False

    def __enter__(self):
        file = self.folder / "scheduler.json"
        file.unlink(missing_ok=True)
        options = "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", file.name
        self.scheduler = self.run("scheduler", *options)
        until = time.monotonic() + PATIENCE
        while not (address := read_address(file)):
            if time.monotonic() > until or self.scheduler.poll() is not None:
                raise RuntimeError((self.folder / "log.txt").read_text())
            time.sleep(0.05)
        self.address = address
        for _ in range(WORKERS):
            self.add()
        return self

    def __exit__(self, *_):
        for process in (*self.workers, self.scheduler):
            process.kill()
        for process in (*self.workers, self.scheduler):
            process.wait()

    def run(self, what, *options):
        """Start a process of dask."""
        with (self.folder / "log.txt").open("a") as log:
            command = [sys.executable, "-m", "dask", what, *options]
            return subprocess.Popen(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL, cwd=self.folder)

    def add(self):
        """Add a worker; it has no nanny, which would start it anew."""
        options = "--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1", "--local-directory", "."
        self.workers.append(self.run("worker", self.address, *options))

    def trouble(self, what, rng):
        """Let something happen to it; True where it is gone then."""
        worker = rng.choice(self.workers)
        if what == KILL:
            worker.kill()
            worker.wait()
            self.workers.remove(worker)
            self.add()
        elif what == PAUSE:
            os.kill(worker.pid, signal.SIGSTOP)
            time.sleep(rng.uniform(*PAUSES))
            with suppress(ProcessLookupError):
                os.kill(worker.pid, signal.SIGCONT)
        elif what == ADD:
            self.add()
        else:
            self.scheduler.kill()
            self.is_lost = True
        return self.is_lost


def read_address(file):
    """Address of a scheduler by its file; None while that is not written."""
    with suppress(FileNotFoundError, ValueError):
        return json.loads(file.read_text())["address"]
    return None


@cache
def computed_here():
    """The archive's file of the sweep, computed by processes of this machine."""
    with trial_folder() as folder:
        if start(folder, *SWEEP, "--jobs", "2").wait():
            raise RuntimeError(said(folder))
        return (folder / "sweep.h5").read_bytes()
