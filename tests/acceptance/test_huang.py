"""A published engine run on air: C.-Y. Huang et al., Energies 2013, 6, 1731 (doi 10.3390/en6031731).

Little of it is published, so no error is demanded: ``docs/validation/huang.md`` shows what comes out, whatever it is.
"""

import json
import shlex
import sys
from itertools import pairwise
from math import pi

import pytest

from apesim.engine.machine import Machine
from apesim.studies.commands.cli import app
from apesim.studies.terminal.console import main_of
from tests.acceptance.huang import MACHINE, SPEEDS, TORQUE_SPEED, point
from tests.folders import ROOT

PAGE = ROOT / "docs" / "validation" / "huang.md"


def test_the_example_is_the_published_engine_as_far_as_it_is_published():
    machine = Machine.load(MACHINE)
    assert 0.25 * pi * machine.engine.bore**2 * machine.engine.stroke == pytest.approx(100e-6, rel=0.005)
    assert machine.supply.pressure == 9e5
    assert machine.engine.cam.lift == machine.valve.stroke == 2e-3


def test_the_command_of_the_page_runs(monkeypatch, capsys):
    command = f'apesim engine run --machine docs/examples/data/huang.toml --speed "{TORQUE_SPEED:g} rpm"'
    assert command in PAGE.read_text()
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(sys, "argv", [*shlex.split(command), "--json"])
    assert main_of(app) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["brake_torque_Nm"] == pytest.approx(point(TORQUE_SPEED)[0]["brake_torque_Nm"], rel=1e-12)


def test_torque_falls_with_speed_as_in_any_air_engine():
    torques = [point(rpm)[0]["brake_torque_Nm"] for rpm in SPEEDS]
    assert all(later < earlier for earlier, later in pairwise(torques))
