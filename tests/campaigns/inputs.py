"""Inputs that are spoilt: machine files, measured folders, archives, effect files.

Whatever a file holds, a command does its work or refuses it: with exit code 2, or 3 for an archive, and a line that
names the file; or it ends with 3 where a machine cannot be simulated. It does not end in a traceback, hang, or eat the
memory.
"""

import contextlib
import io
import json
import random
import sys
import tempfile
from functools import cache
from pathlib import Path

import numpy as np

from apesim.archive.file import write
from apesim.engine.machine import Machine
from apesim.quantities.settings import dumps
from apesim.studies.commands.cli import app
from apesim.studies.measured import MeasuredRun
from apesim.studies.measured.prediction import predict, run_of
from apesim.studies.terminal.console import BAD_INPUT, DONE, INCOMPLETE, main_of
from tests.archive_samples import VERSION_1, VERSION_2, VERSION_2_SWEEP, sample
from tests.folders import ROOT

from .campaign import Outcome, trial_folder
from .mutations import spoil_bytes, spoil_toml

EXAMPLES = ROOT / "docs" / "examples" / "data"
PRESSURES = "pressure_a", "pressure_b"
EFFECTS = "late_release.py", "tapered_bore.py"
MACHINE_FILE = "machine file"
CODES = {DONE: "done", BAD_INPUT: "refused", INCOMPLETE: "not complete"}


def trial(seed):
    """Spoil an input, and give it to a command.

    Parameters
    ----------
    seed : int

    Returns
    -------
    Outcome
    """
    rng = random.Random(seed)
    make = MAKERS[seed % len(MAKERS)]
    with trial_folder() as folder, contextlib.chdir(folder):
        kind, arguments, names = make(folder, rng)
        return judge(kind, arguments, names, *run(arguments))


def run(arguments):
    """Run a command in this process; returns exit code, standard output and standard error."""
    out, err, argv = io.StringIO(), io.StringIO(), sys.argv
    sys.argv = ["apesim", *arguments]
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main_of(app)
    except BaseException as error:
        return type(error).__name__, out.getvalue(), f"{err.getvalue()}\n{error}"
    finally:
        sys.argv = argv
    return code, out.getvalue(), err.getvalue()


def judge(kind, arguments, names, code, out, err):
    """The outcome of a command by what it has shown.

    Parameters
    ----------
    kind : str
        Kind of the input.
    arguments : sequence of str
    names : sequence of str
        Names of what was spoilt; a refusal has to have one of them.
    code : int or str
        Exit code, or what was raised.
    out, err : str

    Returns
    -------
    Outcome
    """
    line = f"apesim {' '.join(arguments)}"
    last = next(reversed(err.strip().splitlines()), "")
    if code not in CODES:
        return Outcome(f"{kind}: ends with {code}", True, f"{line}: {last}")
    if "Traceback" in err:
        return Outcome(f"{kind}: traceback", True, f"{line}: {last}")
    if any(not one.isprintable() and one not in "\n\t" for one in err + ("" if "--json" in arguments else out)):
        return Outcome(f"{kind}: control characters are shown", True, line)
    is_refused = code == BAD_INPUT or (code == INCOMPLETE and kind != MACHINE_FILE)
    if is_refused and not any(name in out + err for name in names):
        return Outcome(f"{kind}: the refusal names no file", True, f"{line}: {last}")
    if code == DONE and "--json" in arguments:
        try:
            json.loads(out, parse_constant=_refuse)
        except ValueError as error:
            return Outcome(f"{kind}: no JSON", True, f"{line}: {error}")
    return Outcome(f"{kind}: {CODES[code]}")


def _refuse(constant):
    raise ValueError(f"{constant} in the JSON")


def spoil(text, rng):
    """Bytes of a TOML file that is spoilt, in what it means or in its bytes."""
    return spoil_toml(text, rng).encode() if rng.random() < 0.7 else spoil_bytes(text.encode(), rng)


@cache
def whole_machine():
    """Machine file with each key in a line."""
    lines = dumps(Machine(), Path()).splitlines()
    return "\n".join(line.partition(" # ")[0] for line in lines if line and not line.startswith("#"))


def make_machine(folder, rng):
    """A machine file."""
    text = whole_machine()
    if rng.random() < 0.5:  # with a few keys alone
        kept = set(rng.sample(range(text.count("\n") + 1), 12))
        text = "\n".join(line for n, line in enumerate(text.splitlines()) if line.startswith("[") or n in kept)
    (folder / "machine.toml").write_bytes(spoil(text, rng))
    commands = (
        ("machine",),
        ("machine", "--json"),
        ("valve", "run", "--json", "--quiet"),
        ("engine", "run", "--speed", "1000 rpm", "--json", "--quiet"),
    )
    return MACHINE_FILE, [*rng.choice(commands), "--machine", "machine.toml"], ["machine.toml"]


@cache
def list_recordings():
    """Three repeats of a stroke, 4 kHz: times [ms], lifts [mm] and chamber pressures [kPa abs]."""
    times = np.arange(-2e-3, 60e-3, 0.25e-3)
    nothing = dict.fromkeys(("lift", *PRESSURES), 0.0 * times)
    one = MeasuredRun("p040", "p040.csv", 501325.0, 287.0, 30e-3, "fit", times, nothing)
    channels = predict(run_of(Machine(), one), one).channels
    rng = np.random.default_rng(1)
    true = np.column_stack([1e3 * times, 1e3 * channels["lift"], *(1e-3 * channels[name] for name in PRESSURES)])
    return [true + rng.normal(0.0, 1.0, true.shape) * (0.0, 0.03, 1.5, 1.5) for _ in range(3)]


DIALECTS = (  # separator, decimal sign, header, [read]
    (",", ".", "time [ms],lift [mm],pressure_a [kPa abs],pressure_b [kPa abs]", ""),
    (";", ",", "time [ms];lift [mm];pressure_a [kPa abs];pressure_b [kPa abs]", ""),
    (
        "\t",
        ".",
        "t (ms)\tWeg\tpA\tpB",
        'columns = { time = "t (ms)", lift = "Weg", pressure_a = "pA", pressure_b = "pB" }',
    ),
    (" ", ".", "", "header = false\ncolumns = { time = 1, lift = 2, pressure_a = 3, pressure_b = 4 }"),
    (";", ",", "Zeit;x;y;z", 'columns = { time = 1, lift = 2 }\nignore = ["y", "z"]\nignore_lines = ["#"]'),
)
UNITS = 'unit.time = "ms"\nunit.lift = "mm"\nunit.pressure_a = "kPa abs"\nunit.pressure_b = "kPa abs"\n'


def make_measured(folder, rng):
    """A folder of measured data in one of some dialects, of which one file is spoilt."""
    separator, sign, header, read = rng.choice(DIALECTS)
    toml = 'bench = "valve"\n' + (f"[read]\n{read}\n{UNITS}" if read else "")
    for number in range(3):
        toml += f'[[run]]\nname = "p040"\ndata = "run{number}.csv"\nsupply = "0.40 MPa gauge"\n'
        toml += 'temperature = "287 K"\npulse = "30 ms"\nrole = "fit"\n'
    spoils_toml = rng.random() < 0.5
    about = spoil(toml, rng) if spoils_toml else toml.encode()
    (folder / "rig").mkdir()
    (folder / "rig" / "measured.toml").write_bytes(about)
    for number, values in enumerate(list_recordings()):
        rows = [separator.join(f"{value:.4f}".replace(".", sign) for value in row) for row in values]
        data = ("\n".join([header, *rows] if header else rows) + "\n").encode()
        spoilt = number == 1 and not spoils_toml
        (folder / "rig" / f"run{number}.csv").write_bytes(spoil_bytes(data, rng) if spoilt else data)
    # What measured.toml says of all files may show in the first of them; what contradicts a file stands in its table.
    names = ["measured.toml", "run0.csv", "run1.csv", "run2.csv"] if spoils_toml else ["run1.csv", '"run 2.']
    return "measured folder", ["measured", "check", "rig", "--json", "--quiet"], names


@cache
def archives():
    """Bytes of archives, old and new."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "new.h5")
        write(sample(), path)
        return [each.read_bytes() for each in (VERSION_1, VERSION_2, VERSION_2_SWEEP, path)]


def make_archive(folder, rng):
    """An archive whose bytes are spoilt."""
    (folder / "f.h5").write_bytes(spoil_bytes(rng.choice(archives()), rng))
    commands = (
        ("archive", "info", "f.h5", "--json"),
        ("archive", "verify", "f.h5"),
        ("archive", "export", "f.h5", "--out", "out", "--quiet"),
        ("archive", "diff", "f.h5", "f.h5", "--json"),
    )
    return "archive", list(rng.choice(commands)), ["f.h5"]


def make_effect(folder, rng):
    """A file with an effect of a user's own."""
    own = (EXAMPLES / rng.choice(EFFECTS)).read_bytes()
    (folder / "own.py").write_bytes(spoil_bytes(own, rng))
    return "effect file", ["gap", "effects", "--effect-file", "own.py", "--json"], ["own.py"]


MAKERS = make_machine, make_measured, make_archive, make_effect
