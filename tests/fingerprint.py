"""Digests of results, to show that a change of the structure moves none: ``python -m tests.fingerprint > before.json``.

Later ``python -m tests.fingerprint before.json`` names what has moved, and ends with 1 if anything has. Runs, what
commands write as JSON and CSV, a sweep, commands that studies find, and the reference tables are looked at, with the
default machine and with one that differs in its sections. A minute or two; the same processor and libraries are meant.
"""

import hashlib
import io
import json
import sys
import tempfile
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

import apesim
from apesim.studies.commands.cli import app
from apesim.studies.terminal.console import main_of
from tests.acceptance.reference_tables import ENGINE_ROWS, VALVE_ROWS, engine_results, valve_results

PASSING = {"wall_time", "wall_time_s", "content_sha256", "created", "date", "versions", "sources_sha256", "digest"}
"""Keys whose values change from run to run, or with the code."""
OTHER = {
    "air.model": "thermally_perfect",
    "ambient.temperature": "300 K",
    "supply.pressure": "0.8 MPa gauge",
    "supply.control_pressure": "0.7 MPa gauge",
    "valve.stroke": "8 mm",
    "engine.bore": "90 mm",
    "engine.receiver.volume": "1.5 L",
    "effects.ring_leakage.area": "0.2 mm2",
}
"""Values of the machine that differs."""


def machines() -> dict[str, Any]:
    """The machines that are looked at, by name."""
    return {"default": apesim.Machine(), "other": apesim.Machine().with_(**OTHER)}


def told(*arguments: str) -> str:
    """What a command prints on standard output."""
    printed = io.StringIO()
    with patch.object(sys, "argv", ["apesim", *arguments]), redirect_stdout(printed), redirect_stderr(io.StringIO()):
        main_of(app)
    return printed.getvalue()


def lasting(value: Any) -> Any:
    """What of a JSON object stays from run to run."""
    if isinstance(value, dict):
        return {key: lasting(each) for key, each in value.items() if key not in PASSING}
    return [lasting(each) for each in value] if isinstance(value, list) else value


def of_arrays(named: dict[str, Any]) -> str:
    """Digest of arrays by name."""
    whole = hashlib.sha256()
    for name in sorted(named):
        array = np.asarray(named[name])
        whole.update(f"{name} {array.dtype} {array.shape}".encode())
        whole.update(array.tobytes() if array.dtype.kind != "O" else repr(array.tolist()).encode())
    return whole.hexdigest()


def of_text(text: str) -> str:
    """Digest of a text."""
    return hashlib.sha256(text.encode()).hexdigest()


def digests() -> Iterator[tuple[str, str]]:
    """Name and digest of each result."""
    # One run of the valve and of the engine: numbers, traces, and what they are as a dictionary.
    for name, machine in machines().items():
        runs = {"valve": apesim.run_valve(machine)}
        runs |= {f"engine at {rpm} r/min": apesim.run_engine(machine, f"{rpm} rpm") for rpm in (600, 1400)}
        for what, run in runs.items():
            yield f"{name}: {what}, scalars", of_arrays(lasting(dict(run.items())))
            yield f"{name}: {what}, traces", of_arrays(dict(run.traces.items()))
            yield f"{name}: {what}, to_dict", of_text(json.dumps(lasting(run.to_dict()), default=str, sort_keys=True))

    # Commands in an empty folder: their JSON, a sweep, its archive as CSV.
    with tempfile.TemporaryDirectory() as folder:
        settings = [f"--set={key}={value}" for key, value in OTHER.items()]
        out, table = f"{folder}/sweep.h5", f"{folder}/sweep.csv"
        commands = {
            "valve run": ("valve", "run", "--json"),
            "engine run": ("engine", "run", "--speed", "900 rpm", "--json", *settings),
            "engine sweep": ("engine", "sweep", "--speed", "600:2400:600 rpm", "--no-figures", "--out", out, "--json"),
        }
        for name, arguments in commands.items():
            yield name, of_text(json.dumps(lasting(json.loads(told(*arguments))), sort_keys=True).replace(folder, ""))
        yield "sweep.h5", of_arrays({n: v.values for n, v in apesim.read_archive(out).archive.variables.items()})
        tables = [path for path in apesim.export_archive(out, table) if path.suffix == ".csv"]
        yield "sweep.csv", of_text("".join(path.read_text() for path in sorted(tables)))

        # What studies find.
        grid = {"speed": "900 rpm", "pressure": "0.9 MPa gauge", "temperature": "287 K", "jobs": 1}
        found = apesim.correct_timing(apesim.Machine(), **grid, out=f"{folder}/timing.h5")
        yield "timing", of_arrays({name: v.values for name, v in found.archive.variables.items()})
        grid = {"pressure": "0.9 MPa gauge", "temperature": "287 K", "jobs": 1}
        found = apesim.find_valve_limit(apesim.Machine(), **grid, duty=0.5, out=f"{folder}/limit.h5")
        yield "valve limit", of_arrays({name: v.values for name, v in found.archive.variables.items()})

    # Results beside the reference solutions.
    yield "reference, valve", of_text(repr([valve_results(row) for row in VALVE_ROWS]))
    yield "reference, engine", of_text(repr([engine_results(row) for row in ENGINE_ROWS]))


def main() -> int:
    """Print the digests, or what of them has moved since a file was written."""
    found = dict(digests())
    if len(sys.argv) == 1:
        print(json.dumps(found, indent=1))
        return 0
    before = json.loads(Path(sys.argv[1]).read_text())
    moved = [name for name in before | found if before.get(name) != found.get(name)]
    print(*(f"moved: {name}" for name in moved), f"{len(found) - len(moved)} of {len(found)} as before", sep="\n")
    return int(bool(moved))


if __name__ == "__main__":
    sys.exit(main())
