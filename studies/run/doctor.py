"""The installation: versions, processor, cache, and a self-test against numbers that are known."""

import os
import platform
from collections.abc import Callable, Iterator
from contextlib import suppress
from math import isinf
from pathlib import Path
from typing import Any, NamedTuple

from apesim.archive.memory import available_memory
from apesim.archive.surroundings import PACKAGES, processor, version_of
from apesim.compiling import compile_times
from apesim.engine.machine import Machine
from apesim.engine.steady import run_steady
from apesim.kernel import cache_folder, kept_kinds
from apesim.march.adaptive import march
from apesim.quantities.trees import with_value
from apesim.studies.run.compiling import QUICK, march_shortly
from apesim.studies.run.engine_run import run_engine
from apesim.studies.run.valve_run import run_valve
from apesim.valve.bench import run_bench

ALLOWED = 1e-4
"""Deviation that the self-test allows, relative. The references have six digits. Processors and versions of libraries
differ in rounding alone, a marched number far less than this; what is wrong with compiled code shows more."""


class Reference(NamedTuple):
    """Number of the embedded machine that the self-test computes again."""

    name: str
    """What it is, and of which run."""
    value: float
    """The number that is known, in the unit."""
    unit: str
    """Unit."""
    compute: Callable[[Machine], float]
    """Computes it, in the unit."""


def _opening_delay(machine: Machine) -> float:
    """Opening delay of the valve on its bench [ms]."""
    return 1e3 * run_valve(machine, supply="0.4 MPa gauge", temperature="287 K")["opening_delay"]


def _brake_torque(machine: Machine) -> float:
    """Brake torque of the engine [N m]."""
    return run_engine(machine, "1000 rpm")["brake_torque"]


REFERENCES = (
    Reference("opening delay, valve at 0.4 MPa gauge and 287 K", 5.59512, "ms", _opening_delay),
    Reference("brake torque, engine at 1000 r/min", 29.3777, "N m", _brake_torque),
)
"""Numbers of the self-test: one of the bench, one of the engine."""


class SelfTest(NamedTuple):
    """Outcome of a number of the self-test."""

    name: str
    """What it is, and of which run."""
    unit: str
    """Unit."""
    reference: float
    """The number that is known."""
    computed: float
    """The number as computed here."""
    deviation: float
    """Deviation from the reference, relative to it."""
    passed: bool
    """Whether the deviation is at most `ALLOWED`."""


def run_self_test() -> Iterator[SelfTest]:
    """Compute the references of the embedded machine again, and yield each outcome in the order of `REFERENCES`."""
    for name, value, unit, compute in REFERENCES:
        computed = compute(Machine())
        deviation = (computed - value) / value
        yield SelfTest(name, unit, value, computed, deviation, abs(deviation) <= ALLOWED)


def _march_valve(machine: Machine) -> None:
    """March the valve on its bench for a moment."""
    run_bench(machine, 10e-3)


def _march_engine(machine: Machine) -> None:
    """March the engine for a cycle."""
    run_steady(machine, QUICK, max_cycles=1)


MARCHES = {"valve": _march_valve, "engine": _march_engine, "drivetrain": march_shortly}
"""Short marches by kind."""
EFFECTS = " with effects"
"""What follows the kind where laws of effects are compiled in, see `apesim.compiling`."""
KINDS = *(f"{layer}{effects}" for layer in ("valve", "engine") for effects in ("", EFFECTS)), "drivetrain"
"""Kinds of march that are compiled ahead."""


def compile_march(kind: str) -> None:
    """Compile a march of one of `KINDS`, or load it from the cache."""
    machine = Machine()
    if kind.endswith(EFFECTS):  # any effect: the laws of all are compiled in with it
        machine = with_value(machine, "effects.side_force.force", 1.0)
    MARCHES[kind.removesuffix(EFFECTS)](machine)


def missing_kinds() -> list[str]:
    """Return those of `KINDS` of march that the cache does not hold, which have to be compiled yet."""
    kept = kept_kinds(march)
    return [kind for kind in KINDS if kind not in kept]


def describe_installation() -> dict[str, Any]:
    """Describe what apesim runs on, and what its cache holds.

    Keys are ``versions`` by package, ``platform``, ``processor``, ``cores``, ``free_memory_B`` (None where the system
    does not tell it), and ``cache`` with its ``folder``, ``size_B`` and ``kinds``: whether each kind of march is
    compiled, and the seconds that it took last time.
    """
    versions = {package: version_of(package) for package in (*PACKAGES, "matplotlib")}
    folder, times, missing, memory = cache_folder(), compile_times(), missing_kinds(), available_memory()
    kinds = [{"kind": kind, "compiled": kind not in missing, "compile_time_s": times.get(kind)} for kind in KINDS]
    return {
        "versions": {"apesim": versions.pop("apesim"), "python": platform.python_version(), **versions},
        "platform": platform.platform(),
        "processor": processor(),
        "cores": os.cpu_count(),
        "free_memory_B": None if isinf(memory) else int(memory),
        "cache": {"folder": str(folder.parent), "size_B": _size_of(folder.parent), "kinds": kinds},
    }


def _size_of(folder: Path) -> int:
    """Size of all files in a folder [B]; files that vanish meanwhile are left out."""
    size = 0
    for path in folder.rglob("*"):
        with suppress(OSError):
            size += path.lstat().st_size
    return size
