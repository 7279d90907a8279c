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
from tests.benchmarks.methods import OURS, compare
from tests.benchmarks.speed import command_time, min_time, operating_points, revolution, start_times
from tests.machines import RPM, machine

LONG = True
OPTIONAL = True
ENGINE = {"epv": "EPV", "cam": "cam", "ideal": "ideal valve"}


def compute():
    """Tables of times side by side, made in one run."""
    bench, turn, points = compare(), revolution(), operating_points()
    commands, _ = min_time(lambda: corrected(machine(receiver=1.0), 1000.0 * RPM), 3)
    ours = next(each.seconds for each in bench if each.words == OURS)
    values = {
        "bench": Table(
            ["work", "time", "times ours", "contacts off by [ns]"],
            [[each.words, _time(each.seconds), _two(each.seconds / ours), _two(1e9 * each.off)] for each in bench],
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
