"""How long the usual runs take, and what a fixed step and a general solver take for the same.

Warm, least of several. The fixed step is the method of doi 10.1631/jzus.A0820373: Runge-Kutta of order 4 at 0.01 ms,
contacts met to a step.
"""

import os
import subprocess
import sys
import time
from typing import NamedTuple

import numba
import numpy as np
from scipy.integrate import solve_ivp

from apesim.engine.cycle import rates as cycle
from apesim.engine.cycle import state as cycle_state
from apesim.engine.cycle.operating_point import accuracy_at, cycle_of
from apesim.engine.steady import run_steady
from apesim.march.adaptive import EVENTS, LOG_HEAD, LOG_ROWS, TOLERANCE, march
from apesim.march.hybrid_system import events, handle_event, rates, start_segment
from apesim.valve import actuator, bench
from apesim.valve.motion import CORNER, FLOW, MET_CLOSED, MET_OPEN
from apesim.valve.solenoid_flow import FLOWS
from tests.machines import RPM, machine

PULSE, END = 50e-3, 100e-3
FIXED_STEP = 0.01e-3
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


class BenchCycle:
    """One opening and closing of the default valve in 100 ms, three ways; each returns the times of both contacts."""

    def __init__(self):
        self.p, self.tables = bench.bench_of(machine(), [0.0, PULSE])
        self.breakpoints = self.tables.breakpoints(0.0, END)

    def start(self):
        return bench.closed_at_start(self.p)

    def adaptive(self, tolerance, log_rows=0):
        """Our march; no log: nothing is looked up."""
        y, mode = self.start()
        log = np.empty((log_rows, LOG_HEAD + actuator.STATES))
        accuracy = bench.accuracy_of(self.p, tolerance)
        trace = np.empty((0, len(bench.TRACE)))
        outcome = march(self.p, self.tables, 0.0, y, mode, self.breakpoints, accuracy, log, np.empty(0), trace)
        code, at = log[: outcome.logged, 1], log[: outcome.logged, 0]
        return at[(code == MET_OPEN) | (code == MET_CLOSED)]

    def fixed(self):
        """Runge-Kutta of order 4, compiled."""
        y, mode = self.start()
        return fixed_steps(self.p, self.tables, y, mode, self.breakpoints)

    def lsoda(self, tolerance):
        """SciPy's LSODA from event to event, around the compiled rates."""
        (y, mode), p, contacts, t = self.start(), self.p, [], 0.0
        dy, g = np.empty_like(y), np.full(EVENTS, -1.0)

        def slope(t, y):
            compiled_rates(p, t, y, mode, dy)
            return dy.copy()

        def event(i):
            def value(t, y):
                compiled_events(p, t, y, mode, g)
                return g[i]

            value.terminal, value.direction = True, 1.0
            return value

        watched = {i: event(i) for i in range(FLOW + FLOWS) if i != CORNER}
        atol = tolerance * np.append(np.array([9e-3, 1.0, 1e-5, 1.0, 1e-5, 1.0]), np.ones(bench.SIZE - 6))
        for breakpoint in self.breakpoints:
            start_segment(p, self.tables, t, breakpoint, y, mode)
            while t < breakpoint:
                step = solve_ivp(
                    slope, (t, breakpoint), y, "LSODA", events=[*watched.values()], rtol=tolerance, atol=atol
                )
                t, y = step.t[-1], step.y[:, -1].copy()
                if step.status == 1:
                    (which,) = (i for i, found in zip(watched, step.t_events, strict=True) if len(found))
                    handle_event(p, self.tables, which, t, y, mode)
                    contacts += [t] if which in (MET_OPEN, MET_CLOSED) else []
        return np.array(contacts)


@numba.njit(error_model="numpy")
def compiled_rates(p, t, y, mode, dy):
    rates(p, t, y, mode, dy)


@numba.njit(error_model="numpy")
def compiled_events(p, t, y, mode, g):
    events(p, t, y, mode, g)


@numba.njit(error_model="numpy")
def fixed_steps(p, tables, y, mode, breakpoints):
    n = y.shape[0]
    k, trial, g = np.zeros((4, n)), np.empty(n), np.full(EVENTS, -1.0)
    contacts = np.empty(8)
    met, t = 0, 0.0
    for breakpoint in breakpoints:
        start_segment(p, tables, t, breakpoint, y, mode)
        steps = round((breakpoint - t) / FIXED_STEP)
        h = (breakpoint - t) / max(steps, 1)
        for _ in range(steps):
            rates(p, t, y, mode, k[0])
            for s in range(1, 4):
                c = 1.0 if s == 3 else 0.5
                for i in range(n):
                    trial[i] = y[i] + c * h * k[s - 1, i]
                rates(p, t + c * h, trial, mode, k[s])
            for i in range(n):
                y[i] += h / 6.0 * (k[0, i] + 2.0 * (k[1, i] + k[2, i]) + k[3, i])
            t += h
            events(p, t, y, mode, g)
            for event in range(EVENTS):
                if g[event] > 0.0:
                    if event <= MET_OPEN and met < 8:
                        contacts[met] = t
                        met += 1
                    handle_event(p, tables, event, t, y, mode)
                    break
    return contacts[:met]


def bench_rows():
    one = BenchCycle()
    true = one.adaptive(1e-12, LOG_ROWS)
    found = {
        "march, 1e-6": (lambda: one.adaptive(1e-6), one.adaptive(1e-6, LOG_ROWS), REPEATS),
        f"march, {TOLERANCE:g} (default)": (
            lambda: one.adaptive(TOLERANCE),
            one.adaptive(TOLERANCE, LOG_ROWS),
            REPEATS,
        ),
        "RK4, 0.01 ms, compiled": (one.fixed, one.fixed(), REPEATS),
        "LSODA (SciPy), 1e-6": (lambda: one.lsoda(1e-6), one.lsoda(1e-6), 3),
    }
    return {name: (min_time(run, repeats)[0], np.abs(at - true).max()) for name, (run, at, repeats) in found.items()}


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
