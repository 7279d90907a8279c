"""How long operating points and commands take: warm, least of several."""

import os
import subprocess
import sys
import time
from typing import NamedTuple

import numpy as np

from apesim.engine.cycle import rates as cycle
from apesim.engine.cycle import state as cycle_state
from apesim.engine.cycle.operating_point import accuracy_at, cycle_of
from apesim.engine.steady import run_steady
from apesim.march.adaptive import LOG_HEAD, march
from tests.machines import RPM, machine

REPEATS = 30


def min_time(run, repeats=REPEATS):
    """Shortest of several runs [s], and the last result; one run before them is not counted."""
    run()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        result = run()
        times.append(time.perf_counter() - start)
    return min(times), result


def revolution():
    """One noted revolution's time and that of one without a note, at 1000 r/min from the periodic state [s]."""
    speed = 1000.0 * RPM
    p, tables, breakpoints = cycle_of(machine(receiver=1.0), speed)
    orbit = run_steady(machine(receiver=1.0), speed).orbit
    accuracy = accuracy_at(p)
    log, trace = np.empty((0, LOG_HEAD + cycle_state.STATES)), np.empty((0, len(cycle.TRACE)))

    def run():
        y, mode = orbit.y.copy(), orbit.mode.copy()
        return march(p, tables, 0.0, y, mode, breakpoints, accuracy, log, np.empty(0), trace)

    return min_time(run)[0]


def operating_points():
    """Times and cycles of an operating point at 1000 r/min, receiver of 1 L, by intake [s]."""
    rows = {}
    for name in ("epv", "cam", "ideal"):
        a_machine = machine(receiver=1.0, intake=name)
        seconds, run = min_time(lambda a_machine=a_machine: run_steady(a_machine, 1000.0 * RPM), 5)
        assert run.orbit.converged
        rows[name] = seconds, run.orbit.cycles
    return rows


class Command(NamedTuple):
    """A command in a process of its own."""

    seconds: float
    """Shortest time from start to end [s]."""
    memory: int
    """Largest memory in use of its first process [byte]."""
    said: str
    """What it said on standard error."""


def command_time(arguments, cache, repeats, cwd=None):
    """Run a command, with a folder of caches of its own, so many times."""
    times, memory, environment = [], [], os.environ | {"APESIM_CACHE_DIR": str(cache)}
    environment.pop("NUMBA_DISABLE_JIT", None)
    for _ in range(repeats):
        start = time.perf_counter()
        done = subprocess.run(
            [sys.executable, "-c", WITH_MEMORY, *arguments],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
            cwd=cwd,
        )
        times.append(time.perf_counter() - start)
        said, _, kilobytes = done.stderr.rstrip().rpartition("\n")
        memory.append(1024 * int(kilobytes))
    return Command(min(times), max(memory), said)


WITH_MEMORY = """
import sys
from pathlib import Path
from apesim.studies.cli import main
try:
    main()
finally:
    (line,) = (line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
    print("\\n" + line.split()[1], file=sys.stderr)
"""
"""Runs the command line, and says last the most memory that it used [kB], as Linux has it: what `getrusage` gives
counts the process that started this one, too."""


def start_times(cache):
    """The first run ever with an empty folder of caches, what is compiled next, and later runs."""
    run = ["engine", "run", "--speed", "1000 rpm", "--json"]
    rows = {"first run ever: engine run": command_time(run, cache, 1)}
    assert "compiling" in rows["first run ever: engine run"].said
    rows["then the first valve run"] = command_time(["valve", "run", "--json"], cache, 1)
    rows["later: engine run"] = command_time(run, cache, 3)
    assert "compiling" not in rows["later: engine run"].said
    rows["--help"] = command_time(["--help"], cache, 3)
    return rows
