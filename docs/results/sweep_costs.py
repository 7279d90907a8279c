"""What archives add to the time of sweeps, and what a second process saves."""

import itertools
import tempfile
import time
from unittest.mock import patch

import numpy as np

from apesim.engine.cylinder import EPV, IDEAL_VALVE, INTAKES
from apesim.engine.machine import Machine
from apesim.studies.sweep import run as sweeping
from apesim.studies.sweep.compute import compute as compute_points
from apesim.studies.sweep.run import run_sweep
from docs.results import Number, Table, describe_code
from tests.machines import RPM

RECORD = True
POINTS = 3000
ROUNDS = 4
JOBS = 2
BOTH = EPV, IDEAL_VALVE
"""Intakes: points of the second take the shortest time, so that archives add most to it."""


def compute():
    """Times of sweeps in one process and in several, by intake, with and without traces."""
    speeds = list(np.linspace(1000.0, 2400.0, POINTS) * RPM)
    for intake in BOTH:
        _times(speeds[:1], intake, True, 1)  # compiles before anything is measured
    return {
        "costs": _compare(speeds),
        "points": Number(POINTS),
        "rounds": Number(ROUNDS),
        "made": Table(["what", "value"], describe_code()),
    }


def _compare(speeds):
    """What archives add to the time that computing takes, and what a second process saves.

    Sweeps of one and of several processes take turns, as the machine's speed drifts by a tenth within minutes. Of their
    times the least is taken: what disturbs only adds. The share of the archive is the median of those of each sweep,
    against the computing inside it.
    """
    rows = []
    for intake, traces in itertools.product(BOTH, (False, True)):
        times = np.array([_times(speeds, intake, traces, jobs) for _ in range(ROUNDS) for jobs in (1, JOBS)])
        times = times.reshape(ROUNDS, 2, 2)
        (one, computing), (several, _) = times.min(axis=0)
        more = np.median(times[:, 0, 0] / times[:, 0, 1]) - 1.0
        name = f"{INTAKES[intake]}, {'with' if traces else 'without'} traces"
        row = name, f"{computing:.1f} s", f"{one:.1f} s", f"{100.0 * more:.1f} %"
        rows.append([*row, f"{several:.1f} s", f"{one / several:.2f}"])
    columns = ["intake", "computing its points", "in one process", "more than computing"]
    return Table([*columns, f"in {JOBS} processes", "times as fast"], rows)


def _times(speeds, intake, traces, jobs):
    """Times of a sweep, and of computing in this process [s]."""
    computing = 0.0

    def timed(*arguments, **options):
        nonlocal computing
        start = time.perf_counter()
        results = compute_points(*arguments, **options)
        computing += time.perf_counter() - start
        return results

    with (
        tempfile.TemporaryDirectory() as folder,
        patch.object(sweeping, "compute", timed if jobs == 1 else compute_points),
    ):
        start = time.perf_counter()
        run_sweep(Machine(), speeds, [intake], f"{folder}/sweep.h5", traces=traces, jobs=jobs)
        return time.perf_counter() - start, computing
