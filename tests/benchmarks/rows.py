"""What is measured: calls, operating points, warm commands and first runs; a row of a table each."""

import shlex
from collections.abc import Callable
from typing import NamedTuple

from tests.benchmarks.calls import CALLS, SPEEDS
from tests.benchmarks.environments import Cost, Environment

CALL, POINT, COMMAND, FIRST = "calls", "operating points", "commands", "first runs ever"
SECONDS = 1.0
"""Time for which a call is repeated in a turn [s]."""


class Row(NamedTuple):
    """A piece of work that every release is timed at."""

    name: str
    """Name for the option ``--only``."""
    group: str
    """Table that it stands in."""
    words: str
    """What it is."""
    is_long: bool
    """Whether it takes more than 5 s."""
    measure: Callable[[Environment], Cost]
    """Measures it once."""


def time_of(group: str, cost: Cost) -> float:
    """Time that a table shows [s]: processor time of first runs, as what runs beside them hardly changes it."""
    return cost.processor if group == FIRST else cost.seconds


def describe(seconds: float) -> str:
    """A time with two digits in the unit that suits it; a dash where there is none."""
    for factor, unit in ((1.0, "s"), (1e3, "ms"), (1e6, "µs")):
        if seconds * factor >= 1.0:
            digits = float(f"{seconds * factor:.2g}")
            return f"{digits:g} {unit}" if digits < 1000.0 else f"{digits:.0f} {unit}"
    return "—"


def _call(name):
    words = CALLS[name].__doc__
    return Row(name, CALL, words, False, lambda environment: environment.call(name, SECONDS))


def _point(speed):
    name, words = f"point_{speed}", f"operating point, {speed} r/min"
    return Row(name, POINT, words, False, lambda environment: environment.call(str(speed), SECONDS))


def _command(name, line, *, is_long=False):
    return Row(name, COMMAND, f"`apesim {line}`", is_long, lambda environment: environment.command(shlex.split(line)))


def _first_run(name, line):
    return Row(name, FIRST, f"`apesim {line}`", True, lambda environment: environment.first_run(shlex.split(line)))


ENGINE_RUN = 'engine run --speed "1000 rpm"'
ROWS = (
    *map(_call, CALLS),
    *map(_point, SPEEDS),
    _command("help", "--help"),
    _command("valve_run", "valve run"),
    _command("engine_run", ENGINE_RUN),
    _command("engine_sweep", "engine sweep --overwrite --jobs 1", is_long=True),
    _command("engine_sweep_two", "engine sweep --overwrite --jobs 2", is_long=True),
    _command("engine_timing", "engine timing --overwrite", is_long=True),
    _command("engine_limit", "engine limit --overwrite", is_long=True),
    _command("engine_optimise", "engine optimise --overwrite", is_long=True),
    _command("engine_assess", "engine assess --overwrite", is_long=True),
    _command("valve_map", "valve map --overwrite", is_long=True),
    _command("valve_limit", "valve limit --overwrite", is_long=True),
    _command("valve_soft_landing", "valve soft-landing --overwrite", is_long=True),
    _command("paper", "paper --overwrite --out paper", is_long=True),
    _first_run("first_valve_run", "valve run"),
    _first_run("first_engine_run", ENGINE_RUN),
)
"""All rows, in the order of the tables; those that compile for others stand before them."""
