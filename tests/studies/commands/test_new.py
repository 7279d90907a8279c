"""`apesim new`: answers of the command line or of a terminal become a machine file, or nothing does."""

import json
import os
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest

from apesim.engine.machine import Machine


def test_answers_of_the_command_line_become_a_machine_file_that_is_good(apesim):
    code, out, err = apesim("new", "mine.toml", "--default", "--answer", "bore=60 mm", "--set", "engine.stroke=50 mm")
    assert (code, out) == (0, "mine.toml: written\n") and "engine run" in err
    assert tomllib.loads(Path("mine.toml").read_text())["engine"]["bore"] == "60 mm"
    assert apesim("machine", "--check", "mine.toml")[1] == "mine.toml: good\n"
    assert Machine.load("mine.toml").engine.stroke == 0.05


def test_without_a_file_it_prints_and_what_it_prints_is_the_default_machine(apesim):
    code, out, err = apesim("new", "--default")
    Path("printed.toml").write_text(out)
    assert (code, err) == (0, "") and Machine.load("printed.toml") == Machine()


def test_json_is_one_object_with_where_each_number_comes_from(apesim):
    code, out, _ = apesim("new", "mine.toml", "--default", "--answer", "valve_stroke=3 mm", "--json")
    data = json.loads(out)
    assert code == 0 and data["file"] == "mine.toml" and data["warnings"]
    assert data["keys"]["valve.stroke"] == {"value": "3 mm", "origin": "answered"}
    assert data["keys"]["valve.moving_mass"]["origin"].startswith("derived")


def test_a_file_that_is_there_stays_unless_it_may_be_replaced(apesim):
    Path("mine.toml").write_text("mine")
    code, _, err = apesim("new", "mine.toml", "--default")
    assert code == 2 and len(err.splitlines()) == 1 and Path("mine.toml").read_text() == "mine"
    assert apesim("new", "mine.toml", "--default", "--overwrite")[0] == 0


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--answer", "bor=20 mm"], "did you mean bore?"),
        (["--answer", "bore"], "--answer"),
        (["--answer", "bore=20"], "--answer bore"),
        (["--answer", "vessel_volume=1 L"], "--answer vessel_volume"),
        (["--figure", "mine.bmp"], "mine.bmp"),
    ],
)
def test_what_cannot_be_used_is_said_in_a_line_and_nothing_is_written(apesim, options, named):
    code, out, err = apesim("new", "mine.toml", "--default", *options)
    assert (code, out) == (2, "") and len(err.splitlines()) == 1 and named in err
    assert not Path("mine.toml").exists()


def test_without_a_terminal_what_is_not_answered_is_named(apesim, monkeypatch):
    monkeypatch.setattr(sys.stdin, "isatty", lambda: False, raising=False)
    code, _, err = apesim("new", "mine.toml", "--answer", "bore=20 mm")
    assert code == 2 and "valve_stroke" in err and " bore" not in err and "--default" in err


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_the_figure_is_written_in_the_format_of_its_ending(apesim, ending):
    assert apesim("new", "mine.toml", "--default", "--figure", f"mine.{ending}")[0] == 0
    start = Path(f"mine.{ending}").read_bytes()[:5]
    assert start.startswith({"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[ending])
    code, out, _ = apesim("machine", "--machine", "mine.toml", "--figure", f"again.{ending}", "--json")
    assert code == 0 and json.loads(out) == {"figure": f"again.{ending}"}
    assert Path(f"again.{ending}").read_bytes() == Path(f"mine.{ending}").read_bytes()


def on_terminal(folder, typed, interrupt=False):
    """Run the command on a terminal of its own; returns its exit code and what the terminal showed."""
    main, other = pytest.importorskip("pty").openpty()
    environment = os.environ | {"COLUMNS": "200"}
    command = [sys.executable, "-m", "apesim.studies.commands.cli", "new", "mine.toml"]
    process = subprocess.Popen(command, cwd=folder, stdin=other, stdout=other, stderr=other, env=environment)
    os.close(other)
    shown = b""
    while b"surroundings" not in shown:  # the first question
        shown += os.read(main, 4096)
    os.write(main, typed)
    if interrupt:
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
    try:
        while part := os.read(main, 4096):
            shown += part
    except OSError:  # the terminal has no other end any more
        pass
    os.close(main)
    return process.wait(), shown.decode()


def test_a_terminal_is_asked_and_enter_takes_what_is_shown(tmp_path):
    code, shown = on_terminal(tmp_path, b"\n\n\n\n\n60\n60 mm\n" + b"\n" * 12)
    assert code == 0 and "has no unit" in shown
    assert Machine.load(tmp_path / "mine.toml").engine.bore == 0.06


@pytest.mark.parametrize(("typed", "interrupt", "expected"), [(b"\n\n\x04", False, 2), (b"\n", True, 130)])
def test_a_dialogue_that_is_left_writes_nothing(tmp_path, typed, interrupt, expected):
    code, shown = on_terminal(tmp_path, typed, interrupt)
    assert code == expected and "Traceback" not in shown
    assert list(tmp_path.iterdir()) == []
