"""Runs trials in processes of their own, ends those that hang, and keeps every outcome."""

import importlib
import json
import multiprocessing
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from contextlib import contextmanager
from multiprocessing.connection import wait
from pathlib import Path
from typing import NamedTuple

LONGEST = 20.0
"""That a trial may take once its process has started [s]."""
START = 120.0
"""That the first trial of a process may take: it imports, and may compile [s]."""
MEMORY = 1_000_000_000
"""That a process may hold at once during a trial [bytes]."""
WITH_COMPILER = 2_000_000_000
"""Memory of a process whose trials may compile: 1.2 GB are what the compiler leaves behind [bytes]."""
RETIRED = 500
"""Trials after which a process is replaced: what one leaves behind does not pile up for ever."""
HANGS, DIES, EATS, RAISES = "hangs", "process ends", "memory", "raises"
"""Outcomes that a trial cannot tell of itself."""


class Outcome(NamedTuple):
    """What became of a trial."""

    word: str
    """Kind of outcome; trials with the same word are counted together."""
    is_broken: bool = False
    """Whether a promise is broken."""
    detail: str = ""
    """What tells of it: a command line, the last line of an error."""
    is_void: bool = False
    """Whether it tried nothing of what is promised: it does not count in the bound."""


def run_campaign(name, seeds, out, jobs=1, longest=None, tell=None):
    """Run the trials of a campaign that have no outcome yet.

    Parameters
    ----------
    name : str
        Name of a module with a function ``trial(seed)`` that returns an `Outcome`, and perhaps with its own `LONGEST`
        and `MEMORY`.
    seeds : sequence of int
    out : path
        Folder that gets one JSON line for each trial.
    jobs : int
        Trials at a time.
    longest : float, optional
        That a trial may take [s]; the module's own if left out.
    tell : function, optional
        Called with how many trials are done, and how many there were to do.

    Returns
    -------
    dict of Outcome
        By seed, of all the seeds.
    """
    longest = longest or getattr(importlib.import_module(name), "LONGEST", LONGEST)
    path = Path(out) / f"{name.rpartition('.')[2]}.jsonl"
    path.parent.mkdir(parents=True, exist_ok=True)
    found = read_outcomes(path)
    missing = [seed for seed in seeds if seed not in found]
    waiting, workers, done = iter(missing), [], 0
    with path.open("a", encoding="utf-8") as file:
        try:
            workers = [worker for worker in (Worker(name).take(waiting) for _ in range(jobs)) if worker]
            while workers:
                wait([worker.pipe for worker in workers], timeout=min(worker.left(longest) for worker in workers))
                for worker in list(workers):
                    outcome = worker.outcome(longest)
                    if outcome is None:
                        continue
                    found[worker.seed] = outcome
                    file.write(json.dumps([worker.seed, *outcome]) + "\n")
                    file.flush()
                    done += 1
                    if tell:
                        tell(done, len(missing))
                    workers.remove(worker)
                    following = (worker if worker.is_fit() else Worker(name)).take(waiting)
                    workers += [following] if following else []
        finally:
            for worker in workers:
                worker.end()
    return {seed: found[seed] for seed in seeds}


def start_clock():
    """A function that is told how many trials are done, of how many, and writes it with the time that is left."""
    start = time.monotonic()

    def tell(done, number):
        left = (time.monotonic() - start) / done * (number - done)
        print(f"\r{done} of {number}, some {left / 60.0:.0f} min left ", end="", file=sys.stderr, flush=True)

    return tell


def read_outcomes(path):
    """Outcomes of a file by seed; a last line that was cut off counts for nothing."""
    found = {}
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        try:
            seed, *outcome = json.loads(line)
        except ValueError:
            continue
        found[seed] = Outcome(*outcome)
    return found


@contextmanager
def trial_folder():
    """A folder for one trial, which is removed after it."""
    folder = Path(tempfile.mkdtemp(prefix="apesim_trial_"))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


class Worker:
    """A process that runs one trial after the other."""

    def __init__(self, name):
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=serve, args=(name, theirs))
        self.seed = self.started = None
        self.done = 0
        self._theirs = theirs

    def take(self, seeds):
        """Begin with the next of some seeds; returns the worker, None where there is none."""
        self.seed = next(seeds, None)
        if self.seed is None:
            self.end()
            return None
        if not self.process.pid:
            self.process.start()
            self._theirs.close()
        self.started = time.monotonic()
        self.pipe.send(self.seed)
        return self

    def left(self, longest):
        """Time that the trial still has [s]."""
        return max(0.0, self.started + (longest if self.done else max(START, longest)) - time.monotonic())

    def outcome(self, longest):
        """The outcome of the trial; None while it goes on."""
        try:
            if self.pipe.poll():
                self.done += 1
                return Outcome(*self.pipe.recv())
        except EOFError:
            self.process.join()
            return Outcome(DIES, True, describe_end(self.process.exitcode))
        if self.left(longest) > 0.0:
            return None
        self.process.kill()
        self.process.join()
        return Outcome(HANGS, True, f"longer than {longest:g} s")

    def is_fit(self):
        """Whether the process can go on."""
        if self.process.is_alive() and self.done < RETIRED:
            return True
        self.end()
        return False

    def end(self):
        """End the process."""
        self.pipe.close()
        if self.process.pid:
            self.process.kill()
            self.process.join()


def describe_end(code):
    """How a process ended, in words."""
    return f"signal {signal.Signals(-code).name}" if code and code < 0 else f"exit code {code}"


def serve(name, pipe):
    """Run the trials whose seeds come through a pipe, and send their outcomes back."""
    module = importlib.import_module(name)
    memory = getattr(module, "MEMORY", MEMORY)
    while True:
        try:
            seed = pipe.recv()
        except EOFError:
            return
        forget_most_memory()
        try:
            outcome = module.trial(seed)
        except Exception as error:
            outcome = Outcome(RAISES, True, f"{type(error).__name__}: {error}")
        most = find_most_memory()
        if most > memory and not outcome.is_broken:
            outcome = Outcome(EATS, True, f"{most / 1e6:.0f} MB: {outcome.detail}")
        pipe.send(tuple(outcome))


def forget_most_memory():
    """Let the kernel count anew how much memory this process has held at once; Linux alone does."""
    if sys.platform == "linux":
        Path("/proc/self/clear_refs").write_text("5")


def find_most_memory():
    """Memory that this process has held at once since then [bytes]; 0 where it is not known."""
    if sys.platform != "linux":
        return 0
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


def summarise(found):
    """Counts of outcomes by word, the broken ones first, with the first seeds of each."""
    counts = Counter((not one.is_broken, one.word) for one in found.values())
    return [
        (word, number, [seed for seed, one in sorted(found.items()) if one.word == word][:5], not sound)
        for (sound, word), number in sorted(counts.items(), key=lambda item: (item[0][0], -item[1]))
    ]
