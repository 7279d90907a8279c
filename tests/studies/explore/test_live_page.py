"""The page is served until it is interrupted, and what stands against it is said before."""

import json
import signal
import subprocess
import sys
import urllib.request

import pytest

import apesim as package
from apesim.quantities import InputError
from apesim.studies.explore.live_page import listen
from apesim.studies.terminal.console import BAD_INPUT, INTERRUPTED
from tests.processes import ENVIRONMENT

COMMAND = "from apesim.studies.commands.cli import main; main()"


def test_ctrl_c_ends_the_command(tmp_path):
    words = ["explore", "--no-browser", "--json", "--set", "engine.bore=90 mm"]
    process = subprocess.Popen(
        [sys.executable, "-c", COMMAND, *words],
        cwd=tmp_path,
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    address = json.loads(process.stdout.readline())["address"]
    with urllib.request.urlopen(f"{address}start.json", timeout=30) as answer:
        sliders = {slider["key"]: slider for slider in json.load(answer)["sliders"]}
    assert sliders["engine.bore"]["value"] == 90.0
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == INTERRUPTED
    assert "Traceback" not in errors


@pytest.mark.parametrize("missing", ["starlette", "uvicorn", "websockets"])
def test_a_missing_package_is_told_with_the_extra_that_brings_it(monkeypatch, missing):
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(InputError, match=rf"{missing}.*apesim\[explore\]"):
        package.explore(browser=False)


def test_a_port_that_is_in_use_is_told(apesim):
    with listen(0) as taken:
        port = str(taken.getsockname()[1])
        taken.listen()
        code, _, errors = apesim("explore", "--no-browser", "--port", port)
    assert code == BAD_INPUT and "--port" in errors and port in errors


def test_only_this_computer_reaches_the_page():
    with listen(0) as listener:
        assert listener.getsockname()[0] == "127.0.0.1"


WRONG = (
    ("--speed", "fast"),
    ("--port", "0"),
    ("--measured", "nowhere"),
    ("none.toml",),
    ("--set", "engine.bor=1 mm"),
)


@pytest.mark.parametrize("words", WRONG)
def test_what_cannot_be_is_refused_before_anything_is_served(apesim, words):
    code, out, errors = apesim("explore", "--no-browser", *words)
    assert code == BAD_INPUT and errors and not out
