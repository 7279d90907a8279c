"""Time and memory of sweeps: ``python -m tests.benchmarks.sweeps`` writes their records, an hour on a quiet machine.

`large_sweeps.csv` has sweeps of up to 100 000 operating points in two processes; `sweep_costs.csv` has what archives
add to the time of a sweep, and what a second process saves.
"""

import csv
import datetime
import itertools
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from unittest.mock import patch

import numpy as np
from matplotlib import rc_context

from apesim.engine.cylinder import EPV, IDEAL_VALVE, INTAKES
from apesim.engine.machine import Machine
from apesim.studies.drawing.panels import label_axes, open_row
from apesim.studies.drawing.style import BLUE, GREY, RED, STYLE
from apesim.studies.sweep import run as sweeping
from apesim.studies.sweep.compute import compute as compute_points
from apesim.studies.sweep.run import run_sweep
from tests.folders import ROOT, find_commit
from tests.machines import RPM

LARGE, COSTS = (Path(__file__).with_name(f"{name}.csv") for name in ("large_sweeps", "sweep_costs"))
FIGURE = ROOT / "docs" / "results" / "figures" / "large_sweeps.png"
JOBS = 2
SPEEDS = "600:2580:20 rpm"
"""A hundred speeds."""
PRESSURES = 10, 30, 100, 300, 1000
"""Numbers of supply pressures that each large sweep has beside them."""
POINTS, TURNS = 3000, 4
BOTH = EPV, IDEAL_VALVE
"""Intakes: points of the second take the shortest time, so that archives add most to it."""
WITH_MEMORY = """
import sys
from pathlib import Path
from apesim.studies.commands.cli import main
try:
    main()
finally:
    (line,) = (line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
    print("\\n" + line.split()[1], file=sys.stderr)
"""
"""Runs the command line, and says last the most memory that it used [kB], as Linux has it: what `getrusage` gives
counts the process that started this one, too."""


def main() -> None:
    """Measure, write both records, and draw the large sweeps."""
    made = {"date": datetime.date.today().isoformat(), "commit": find_commit()}
    for intake in BOTH:
        time_sweep([1000.0 * RPM], intake, traces=True, jobs=1)  # compiles before anything is measured
    for file, rows in ((LARGE, map(measure_large_sweep, PRESSURES)), (COSTS, compare_costs())):
        lines = [made | row for row in rows]
        with file.open("w", newline="") as out:
            writer = csv.DictWriter(out, lines[0], lineterminator="\n")
            writer.writeheader()
            writer.writerows(lines)
    with rc_context(STYLE):
        draw_large_sweeps(read_rows(LARGE))


def read_rows(file: Path) -> list[dict[str, str]]:
    """Rows of a record, by column."""
    with file.open(newline="") as lines:
        return list(csv.DictReader(lines))


def measure_large_sweep(number: int) -> dict[str, str]:
    """A row of the large sweeps: a hundred speeds at a number of pressures."""
    pressures = f"supply.pressure=0.5:{0.5 + 1e-3 * (number - 1):g}:0.001 MPa gauge"
    words = ["engine", "sweep", "--speed", SPEEDS, "--vary", pressures, "--intake", "ideal", "--no-traces"]
    words += ["--no-figures", "--jobs", f"{JOBS}", "--quiet", "--out", "sweep.h5"]
    with tempfile.TemporaryDirectory() as name:
        folder, start, worker = Path(name), time.perf_counter(), 0.0
        with (folder / "err.txt").open("w+") as errors:
            command = [sys.executable, "-c", WITH_MEMORY, *words]
            process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=errors)
            while process.poll() is None:
                worker = max(worker, find_largest_child(process.pid))
                time.sleep(0.2)
            seconds = time.perf_counter() - start
        said = (folder / "err.txt").read_text().split()
        if process.returncode:
            raise RuntimeError(" ".join(said))
        size = (folder / "sweep.h5").stat().st_size
    points = 100 * number
    row = {"points": f"{points}", "seconds": f"{seconds:.0f}", "milliseconds_each": f"{1e3 * seconds / points:.1f}"}
    row |= {"first_process_mb": f"{int(said[-1]) * 1024 / 1e6:.0f}", "largest_worker_mb": f"{worker / 1e6:.0f}"}
    return row | {"archive_mb": f"{size / 1e6:.1f}"}


def find_largest_child(pid: int) -> float:
    """Most memory that a child of a process has held so far [byte]."""
    largest = 0
    with suppress(FileNotFoundError, ProcessLookupError):
        for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
            for line in Path(f"/proc/{child}/status").read_text().splitlines():
                if line.startswith("VmHWM"):
                    largest = max(largest, 1024 * int(line.split()[1]))
    return largest


def draw_large_sweeps(rows: list[dict[str, str]]) -> None:
    """Draw time and memory over the number of points."""
    keys = "points", "seconds", "first_process_mb", "largest_worker_mb"
    points, seconds, first, workers = (np.array([float(row[key]) for row in rows]) for key in keys)
    figure, (left, right) = open_row(2)
    left.loglog(points, points * seconds[-1] / points[-1], color=GREY, ls="--", label="in proportion")
    left.loglog(points, seconds, color=BLUE, marker="o", label=f"measured, {JOBS} processes")
    label_axes(left, x=("operating points", "1"), y=("time", "s"), title="Time of a sweep")
    right.semilogx(points, first, color=RED, marker="o", label="first process")
    right.semilogx(points, workers, color=BLUE, marker="s", label="largest worker")
    right.axhline(500.0, color=GREY, ls="--")
    label_axes(right, x=("operating points", "1"), y=("largest memory", "MB"), title="Memory")
    right.set_ylim(0.0, 600.0)
    for axes in (left, right):
        axes.legend()
    figure.savefig(FIGURE)


def compare_costs() -> Iterator[dict[str, str]]:
    """Rows of what archives add to the time that computing takes, and what a second process saves.

    Sweeps of one and of several processes take turns, as the machine's speed drifts by a tenth within minutes. Of their
    times the least is taken: what disturbs only adds. The share of the archive is the median of those of each sweep,
    against the computing inside it.
    """
    speeds = list(np.linspace(1000.0, 2400.0, POINTS) * RPM)
    for intake, traces in itertools.product(BOTH, (False, True)):
        times = np.array(
            [time_sweep(speeds, intake, traces=traces, jobs=jobs) for _ in range(TURNS) for jobs in (1, JOBS)]
        ).reshape(TURNS, 2, 2)
        (one, computing), (several, _) = times.min(axis=0)
        more = 100.0 * (np.median(times[:, 0, 0] / times[:, 0, 1]) - 1.0)
        row = {"points": f"{POINTS}", "turns": f"{TURNS}"}
        row |= {"sweep": f"{INTAKES[intake]}, {'with' if traces else 'without'} traces"}
        row |= {"computing": f"{computing:.1f}", "one_process": f"{one:.1f}", "percent_more": f"{more:.1f}"}
        yield row | {"two_processes": f"{several:.1f}", "times_as_fast": f"{one / several:.2f}"}


def time_sweep(speeds: list[float], intake: int, *, traces: bool, jobs: int) -> tuple[float, float]:
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


if __name__ == "__main__":
    main()
