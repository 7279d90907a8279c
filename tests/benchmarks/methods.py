"""One opening and closing of the default valve in 100 ms, by several methods, measured in turns.

They are the program in C, our march, the fixed step of the EPV paper (doi 10.1631/jzus.A0820373: Runge-Kutta of order 4
at 0.01 ms, contacts met to a step), and a general solver of SciPy around the compiled rates.
``python -m tests.benchmarks.methods`` prints the table.
"""

import tempfile
import time
from typing import NamedTuple

import numba
import numpy as np
from scipy.integrate import solve_ivp

from apesim.march.adaptive import EVENTS, LOG_HEAD, LOG_ROWS, NO_CARRY, TOLERANCE, march
from apesim.march.hybrid_system import events, handle_event, rates, start_segment
from apesim.valve import actuator, bench
from apesim.valve.motion import CORNER, FLOW, MET_CLOSED, MET_OPEN
from apesim.valve.solenoid_flow import FLOWS
from tests.benchmarks.c_program import COMPILER, CProgram
from tests.machines import machine

PULSE, END = 50e-3, 100e-3
FIXED_STEP = 0.01e-3
COMPARED = 1e-6
"""Tolerance at which the methods are compared."""
TRUE = 1e-12
"""Tolerance of the march whose times of contact the others are judged by."""
NO_LOG, NO_TRACE = np.empty((0, LOG_HEAD + actuator.STATES)), np.empty((0, len(bench.TRACE)))
IN_C, OURS = "in C, tolerance 1e-6", "march, tolerance 1e-6"


class Method(NamedTuple):
    """A method, and what it takes."""

    words: str
    """What it is."""
    seconds: float
    """Shortest time [s]."""
    evaluations: int | None
    """Number of evaluations of the rates; None: not counted."""
    off: float
    """Largest error of a time of contact [s]."""

    @property
    def per_evaluation(self):
        """Time for an evaluation of the rates, with all that is around it [s]; NaN where they were not counted."""
        return self.seconds / self.evaluations if self.evaluations else np.nan


class BenchCycle:
    """The opening and closing, in three ways."""

    def __init__(self):
        self.p, self.tables = bench.bench_of(machine(), [0.0, PULSE])
        self.breakpoints = self.tables.breakpoints(0.0, END)
        self.closed, self.modes = bench.closed_at_start(self.p)
        self.accuracy = bench.accuracy_of(self.p)

    def start(self):
        """State and modes at the start."""
        return self.closed.copy(), self.modes.copy()

    def march(self, tolerance, log=NO_LOG):
        """Our march; without a log nothing is looked up."""
        y, mode = self.start()
        accuracy = self.accuracy._replace(tolerance=tolerance)
        return march(
            self.p, self.tables, 0.0, y, mode, self.breakpoints, accuracy, log, np.empty(0), NO_TRACE, NO_CARRY
        )

    def contacts(self, tolerance):
        """Times of both contacts by our march [s]."""
        log = np.empty((LOG_ROWS, NO_LOG.shape[1]))
        outcome = self.march(tolerance, log)
        code, at = log[: outcome.logged, 1], log[: outcome.logged, 0]
        return at[(code == MET_OPEN) | (code == MET_CLOSED)]

    def fixed(self):
        """Times of both contacts by Runge-Kutta of order 4, compiled [s]."""
        y, mode = self.start()
        return fixed_steps(self.p, self.tables, y, mode, self.breakpoints)

    def lsoda(self, tolerance):
        """Times of both contacts by SciPy's LSODA from event to event, around the compiled rates [s]."""
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


def least_time(run, repeats):
    """Shortest of several runs [s]."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)


def compare(turns=3):
    """Every method, all of them in each turn; that in C where there is a compiler.

    Returns
    -------
    list of Method
    """
    one = BenchCycle()
    true = one.contacts(TRUE)
    steps = round(END / FIXED_STEP)
    ways = {
        OURS: (lambda: one.march(COMPARED), 1000, one.march(COMPARED).evaluations, one.contacts(COMPARED)),
        f"march, tolerance {TOLERANCE:g}, the default": (
            lambda: one.march(TOLERANCE),
            1000,
            one.march(TOLERANCE).evaluations,
            one.contacts(TOLERANCE),
        ),
        "Runge-Kutta of order 4, 0.01 ms, compiled": (one.fixed, 50, 4 * steps, one.fixed()),
        "SciPy's LSODA, tolerance 1e-6": (lambda: one.lsoda(COMPARED), 1, None, one.lsoda(COMPARED)),
    }
    with tempfile.TemporaryDirectory() as folder:
        program = CProgram(folder) if COMPILER else None
        in_c, times = [], {words: [] for words in ways}
        for _ in range(turns):
            if program:
                in_c.append(program.run(PULSE, END, COMPARED))
            for words, (run, repeats, _, _) in ways.items():
                times[words].append(least_time(run, repeats))
    found = [
        Method(words, min(times[words]), evaluations, float(np.abs(contacts - true).max()))
        for words, (_, _, evaluations, contacts) in ways.items()
    ]
    if in_c:
        seconds, evaluations, contacts = min(in_c)
        found.insert(0, Method(IN_C, seconds, evaluations, float(np.abs(contacts - true).max())))
    return found


def table(found):
    """Lines of the table, times also as shares of the first row's."""
    lines = [f"{'bench, one stroke cycle of 100 ms':44s}{'time':>10s}{'ratio':>8s}{'evaluation':>13s}{'off by':>14s}"]
    for each in found:
        shares = (
            f"{each.seconds * 1e3:7.3f} ms{each.seconds / found[0].seconds:8.2f}{each.per_evaluation * 1e9:10.1f} ns"
        )
        lines.append(f"  {each.words:42s}{shares}{each.off * 1e6:11.4f} us")
    return lines


if __name__ == "__main__":
    print(*table(compare()), sep="\n")
