"""Times of the usual work, warm and cold, and memory; on the processor that the page names."""

import datetime
import os
import platform
import tempfile
from importlib.metadata import version
from pathlib import Path

import apesim
from apesim.archive.surroundings import processor
from apesim.studies.timing import corrected
from docs.results import Number, Table
from tests.benchmarks.speed import bench_rows, command_time, min_time, operating_points, revolution, start_times
from tests.machines import RPM, machine

LONG = True
OPTIONAL = True
WORDS = {
    "march, 1e-6": "bench, one cycle of strokes in 100 ms, tolerance 1e-6",
    "march, 1e-07 (default)": "the same at the default tolerance 1e-7",
    "RK4, 0.01 ms, compiled": "the same by Runge-Kutta of order 4 at 0.01 ms, the EPV paper's method, compiled",
    "LSODA (SciPy), 1e-6": "the same by SciPy's LSODA at 1e-6 around the compiled rates",
}
ENGINE = {"epv": "EPV", "cam": "cam", "ideal": "ideal valve"}


def compute():
    """Tables of times side by side, made in one run."""
    bench, turn, points = bench_rows(), revolution(), operating_points()
    commands, _ = min_time(lambda: corrected(machine(receiver=1.0), 1000.0 * RPM), 3)
    ours = bench["march, 1e-6"][0]
    values = {
        "bench": Table(
            ["work", "time", "times ours", "contacts off by [ns]"],
            [
                [WORDS[name], _time(seconds), _two(seconds / ours), _two(1e9 * error)]
                for name, (seconds, error) in bench.items()
            ],
        ),
        "engine": Table(
            ["work, 1000 r/min, receiver of 1 L", "time", "cycles marched"],
            [
                ["one coupled revolution at the default tolerance", _time(turn), Number(1)],
                *([f"operating point, {ENGINE[k]}", _time(s), Number(n)] for k, (s, n) in points.items()),
                ["corrected commands of one operating point", _time(commands), "—"],
            ],
        ),
    }
    return values | _commands() | {"machine": _machine()}


def _commands():
    """Whole commands in processes of their own, from an empty folder of caches on; the main job after them."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        rows = start_times(folder / "cache")
        sweep = ["engine", "sweep", "--overwrite", "--out"]
        warm = command_time([*sweep, "one.h5", "--jobs", "1"], folder / "cache", 2, folder)
        both = command_time([*sweep, "all.h5"], folder / "cache", 2, folder)
        size = (folder / "one.h5").stat().st_size
        points = len(apesim.read_archive(folder / "one.h5").to_pandas())
    rows |= {"the main job, engine sweep, one process": warm, "the main job, as many processes as cores": both}
    return {
        "commands": Table(
            ["command, from its start to its end", "time", "largest memory of its first process"],
            [[name, _time(each.seconds), f"{each.memory / 1e6:.0f} MB"] for name, each in rows.items()],
        ),
        "points": Table(
            ["the main job", ""],
            [
                ["operating points", Number(points)],
                ["time of one process for a point, start and figures included", _time(warm.seconds / points)],
                ["archive", f"{size / 1e6:.1f} MB"],
                ["archive for a point", f"{size / points / 1e3:.0f} kB"],
            ],
        ),
    }


def _machine():
    """What the times were measured on, and when."""
    rows = [
        ["processor", processor()],
        ["cores", f"{os.cpu_count()}"],
        ["system", f"{platform.system()}, Python {platform.python_version()}, Numba {version('numba')}"],
        ["date", datetime.date.today().isoformat()],
        ["other load at the end, mean of 15 minutes", f"{os.getloadavg()[2]:.1f} processes"],
    ]
    return Table(["measured on", ""], rows)


def _two(value):
    """Two digits of a number."""
    return f"{float(f'{value:.2g}'):g}" if value < 10.0 else f"{float(f'{value:.2g}'):.0f}"


def _time(seconds):
    """A time with two digits in the unit that suits it."""
    for factor, unit in ((1.0, "s"), (1e3, "ms"), (1e6, "µs")):
        if seconds * factor >= 1.0 or unit == "µs":
            return f"{_two(seconds * factor)} {unit}"
    raise AssertionError
