"""Steps of 0.1 ms beside the same marches taken at once: ``python -m pytest -n 0 tests/benchmarks/test_steps.py``.

What is printed is measured in turns; nothing here fails on a time.
"""

import time
from itertools import pairwise

import numpy as np
import pytest

import apesim
from apesim.engine.drivetrain.preparing import Course, prepare
from apesim.engine.drivetrain.run import run_drivetrain
from apesim.kernel import compiled_for
from apesim.march.adaptive import LOG_HEAD, NO_CARRY, STOP, begin_carry, march
from apesim.valve.bench import TRACE, accuracy_of, bench_of, closed_at_start, trace_bench
from apesim.valve.edges import FAR
from tests.machines import RPM

STEP, COUNT, TURNS = 1e-4, 1000, 7
PULSE, END = 50e-3, 0.1
NO_ROWS = np.empty((0, LOG_HEAD)), np.empty(0), np.empty((0, len(TRACE)))


def valve_in_steps():
    stepper = apesim.Stepper(apesim.Machine(), "valve")
    begin = time.perf_counter()
    for step in range(1, COUNT + 1):
        stepper.advance(STEP * step, command=int(step <= COUNT // 2))
    return time.perf_counter() - begin


def valve_at_once():
    begin = time.perf_counter()
    trace_bench(apesim.Machine(), PULSE, STEP * np.arange(COUNT + 1))
    return time.perf_counter() - begin


def calls_of_the_march(*, carries):
    """Calls of the march alone, without looking at the types of its arguments."""
    p, tables = bench_of(apesim.Machine(), [0.0, PULSE])
    (y, mode), accuracy, corners = closed_at_start(p), accuracy_of(p), tables.breakpoints(0.0, END)
    carry = begin_carry(accuracy) if carries else NO_CARRY
    called = compiled_for(march, p, tables, 0.0, y, mode, corners, accuracy, *NO_ROWS, carry)
    ends, far = STEP * np.arange(COUNT + 1), np.append(corners, FAR)
    stops = [np.append(corners[(corners > t) & (corners < end)], end) for t, end in pairwise(ends)]
    begin = time.perf_counter()
    for t, end, own in zip(ends, ends[1:], stops, strict=False):
        if carries:
            carry[STOP] = end
        called(p, tables, t, y, mode, far if carries else own, accuracy, *NO_ROWS, carry)
    return time.perf_counter() - begin


def engine_in_steps():
    stepper = apesim.Stepper(apesim.Machine(), "engine", speed="1000 rpm")
    begin = time.perf_counter()
    for step in range(1, COUNT + 1):
        stepper.advance(STEP * step)
    return time.perf_counter() - begin


def engine_at_once():
    speed = 1000.0 * RPM
    prepared = prepare(apesim.Machine(), 0.0, Course(np.array([[0.0, speed], [1.0, speed]])))
    begin = time.perf_counter()
    run_drivetrain(prepared, END)
    return time.perf_counter() - begin


WORK = {
    "valve, in steps": valve_in_steps,
    "valve, at once": valve_at_once,
    "calls that carry": lambda: calls_of_the_march(carries=True),
    "calls that forget": lambda: calls_of_the_march(carries=False),
    "engine, in steps": engine_in_steps,
    "engine, at once": engine_at_once,
}


@pytest.mark.parametrize("names", [list(WORK)[:4], list(WORK)[4:]], ids=["valve", "engine"])
def test_steps_beside_marches_taken_at_once(names, capsys):
    times = {name: [] for name in names}
    for _ in range(TURNS):
        for name in names:
            times[name].append(WORK[name]())
    best = {name: min(each) for name, each in times.items()}
    with capsys.disabled():
        for name, seconds in best.items():
            each = 1e6 * seconds / COUNT
            print(
                f"\n{name}: {1e3 * seconds:.2f} ms, {each:.1f} us a step, {seconds / best[names[1]]:.1f} times", end=""
            )
        print()
    assert all(seconds > 0.0 for seconds in best.values())
