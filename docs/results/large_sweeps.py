"""Time and memory of sweeps of up to 100 000 operating points."""

import json
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
from matplotlib import rc_context

from apesim.engine.cylinder import IDEAL_VALVE
from apesim.engine.machine import Machine
from apesim.studies.drawing.panels import label_axes, open_row
from apesim.studies.drawing.style import BLUE, GREY, RED, STYLE
from apesim.studies.sweep.compute import compute as compute_points
from apesim.studies.sweep.plan import plan
from apesim.studies.sweep.variation import Variation
from docs.results import Number, Table, describe_code
from docs.results._figures import FOLDER
from docs.results._kept import find_kept

RECORD = True
SPEEDS = "600:2580:20 rpm"
"""A hundred speeds."""
PRESSURES = 10, 30, 100, 300, 1000
"""Numbers of supply pressures that each sweep has beside them."""
JOBS = 2
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


def compute():
    """Times and memory by the number of points, and a figure of them."""
    folder = find_kept("large_sweeps")
    compute_points(plan(Variation((), (Machine(),)), [100.0], [IDEAL_VALVE]).points)  # compiles before all
    found = [_measured(number, folder) for number in PRESSURES]
    points, seconds, first, workers, _ = np.array(found, float).T
    _draw(points, seconds, first, workers)
    rows = [
        [Number(int(n)), f"{s:.0f} s", f"{1e3 * s / n:.1f} ms", f"{f:.0f} MB", f"{w:.0f} MB", f"{b:.1f} MB"]
        for n, s, f, w, b in found
    ]
    return {
        "sweeps": Table(
            [
                "operating points",
                "time",
                "time for each",
                "memory of the first process",
                "of the largest worker",
                "archive",
            ],
            rows,
        ),
        "largest": Number(int(points.max())),
        "memory": Number(float(max(first[-1], workers[-1])), "MB", error=0.5),
        "slope": Number(float(np.polyfit(np.log(points[1:]), np.log(seconds[1:]), 1)[0]), error=0.005),
        "made": Table(["what", "value"], describe_code()),
    }


def _measured(number, folder):
    """Points, time [s], memory of the first process and of the largest worker, and archive [MB]; kept once measured."""
    kept = folder / f"{number}.json"
    if kept.exists():
        return json.loads(kept.read_text())
    folder.mkdir(exist_ok=True)
    pressures = f"supply.pressure=0.5:{0.5 + 1e-3 * (number - 1):g}:0.001 MPa gauge"
    words = ["engine", "sweep", "--speed", SPEEDS, "--vary", pressures, "--intake", "ideal", "--no-traces"]
    words += ["--no-figures", "--jobs", f"{JOBS}", "--overwrite", "--quiet", "--out", "sweep.h5"]
    start = time.perf_counter()
    with (folder / "err.txt").open("w+") as errors:
        process = subprocess.Popen(
            [sys.executable, "-c", WITH_MEMORY, *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=errors
        )
        worker = 0.0
        while process.poll() is None:
            worker = max(worker, _largest_child(process.pid))
            time.sleep(0.2)
        seconds = time.perf_counter() - start
        errors.seek(0)
        said = errors.read().split()
    if process.returncode:
        raise RuntimeError(" ".join(said))
    size = (folder / "sweep.h5").stat().st_size
    found = [100 * number, seconds, int(said[-1]) * 1024 / 1e6, worker / 1e6, size / 1e6]
    kept.write_text(json.dumps(found))
    return found


def _largest_child(pid):
    """Most memory that a child of a process has held so far [byte]."""
    largest = 0
    with suppress(FileNotFoundError, ProcessLookupError):
        for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
            for line in Path(f"/proc/{child}/status").read_text().splitlines():
                if line.startswith("VmHWM"):
                    largest = max(largest, 1024 * int(line.split()[1]))
    return largest


def _draw(points, seconds, first, workers):
    """Draw time and memory over the number of points."""
    with rc_context(STYLE):
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
        FOLDER.mkdir(exist_ok=True)
        figure.savefig(FOLDER / "large_sweeps.png")
