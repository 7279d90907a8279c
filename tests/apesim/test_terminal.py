"""What a command shows: no control characters of strangers' files, in any encoding, and no traceback."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import typer

from apesim.archive import write
from apesim.studies.terminal.console import BAD_INPUT, main_of
from apesim.terminal import visible
from tests.archive_samples import sample
from tests.folders import ROOT

PROGRAM = [sys.executable, "-c", "from apesim.studies.commands.cli import main; main()"]
HOSTILE = "\x1b[2J\x1b]0;title\x07\x9b8m\x7f\u202e\nwhole"
MEASURED = """bench = "valve"
[[run]]
data = "a.csv"
name = "%s"
supply = "0.40 MPa gauge"
pulse = "4 ms"
role = "gate"
"""


def run_program(*arguments, **environment):
    """A command in a process of its own; its output as bytes."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **environment}
    return subprocess.run([*PROGRAM, *arguments], capture_output=True, env=environment, check=False)


def test_what_does_not_print_is_shown_as_an_escape():
    assert visible("a\x1b[31mb\u202e\r\n°") == "a\\x1b[31mb\\u202e\\r\\n°"
    assert visible("a\x1b\n\tb", keep="\n\t") == "a\\x1b\n\tb"


@pytest.mark.parametrize("form", [(), ("--json",)])
def test_no_escape_of_an_archive_reaches_the_terminal(apesim, form):
    write(sample(command=HOSTILE, created=HOSTILE), "a.h5")
    write(sample(command="another", evil=HOSTILE), "b.h5")
    for arguments in (("info", "a.h5"), ("verify", "a.h5"), ("diff", "a.h5", "b.h5")):
        _, out, err = apesim("archive", *arguments, *form)
        shown = (out + err).replace("\n", "")
        assert shown.isprintable() and "whole" not in (out + err).split("\n"), arguments


def test_no_escape_of_a_measured_folder_reaches_the_terminal(apesim):
    name = "".join(f"\\u{ord(c):04x}" for c in HOSTILE)
    Path("measured.toml").write_text(MEASURED % name)
    Path("a.csv").write_text("time [ms],lift [mm]\n" + "".join(f"{i},0.01\n" for i in range(10)))
    code, out, err = apesim("valve", "fit", ".", "--free", "valve.viscous_friction")
    assert code == 2 and (out + err).replace("\n", "").isprintable()


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp1252"])
@pytest.mark.parametrize(
    "arguments", [("gap", "effects"), ("machine",), ("archive", "info", "ü.h5"), ("machine", "-ü")]
)
def test_an_encoding_that_lacks_characters_ends_in_no_traceback(tmp_path, monkeypatch, encoding, arguments):
    monkeypatch.chdir(tmp_path)
    write(sample(command="größer → α"), "ü.h5")
    done = run_program(*arguments, PYTHONIOENCODING=encoding)
    assert done.returncode == (2 if "-ü" in arguments else 0)
    assert b"Traceback" not in done.stderr and (done.stdout + done.stderr).decode(encoding)


def test_json_is_whole_in_any_encoding(tmp_path):
    write(sample(command="größer → α"), tmp_path / "a.h5")
    done = run_program("archive", "info", str(tmp_path / "a.h5"), "--json", PYTHONIOENCODING="ascii")
    assert json.loads(done.stdout)["provenance"]["command"] == "größer → α"


def test_too_little_memory_is_told_with_a_remedy(monkeypatch, capsys):
    app = typer.Typer()

    @app.command()
    def greedy():
        bytearray(2**62)

    monkeypatch.setattr(sys, "argv", ["apesim"])
    assert main_of(app) == BAD_INPUT
    [line] = capsys.readouterr().err.splitlines()
    assert "memory" in line and "fewer points" in line
