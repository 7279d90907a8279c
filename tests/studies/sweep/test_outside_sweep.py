"""Sweeps over the strength of an effect from outside, in several processes, and the archives that they leave."""

import hashlib
import shutil
import sys

import numpy as np
import pytest

from apesim.archive import read
from apesim.archive.comparison import diff
from apesim.archive.inspection import info, verify
from apesim.engine.cylinder import EPV
from apesim.engine.indicators import indicators
from apesim.engine.machine import Machine
from apesim.engine.steady import run_steady
from apesim.studies.sweep import run_sweep, vary
from tests.folders import ROOT

EXAMPLE = ROOT / "docs" / "examples" / "data" / "tapered_bore.py"
SPEED = 1000.0 * np.pi / 30.0
STRENGTHS = (0.0, 60.0, 120.0)


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """A sweep in two processes; the file of its effect is gone when the tests begin."""
    folder = tmp_path_factory.mktemp("outside")
    effect = folder / "bore.py"
    shutil.copy(EXAMPLE, effect)
    settings = [f"effects.files={effect}", "effects.tapered_bore.friction=60 N s/m"]
    variation = vary(["effects.tapered_bore.friction=0:120:60 N s/m"], None, settings)
    machine = Machine.load(None, settings)
    run_steady(machine, SPEED, max_cycles=1)  # compiled once, and not in each of the processes
    done = run_sweep(machine, [SPEED], [EPV], folder / "sweep.h5", variation=variation, jobs=2)
    effect.unlink()
    return done


def test_each_point_is_what_it_is_alone(swept):
    values = swept.archive.variables
    assert values["effects_tapered_bore_friction"].values.tolist() == list(STRENGTHS)
    assert not swept.faults
    machine = Machine().with_effects(EXAMPLE)
    torques = []
    for strength in STRENGTHS:
        one = machine.with_(**{"effects.tapered_bore.friction": strength})
        torques.append(indicators(one, run_steady(one, SPEED))["brake_torque_Nm"])
    assert values["brake_torque_Nm"].values == pytest.approx(torques, rel=1e-9)
    assert len(set(torques)) == 3


def test_the_archive_says_which_file_it_needed_and_reads_without_it(swept, monkeypatch):
    monkeypatch.setattr(sys, "meta_path", [])
    loaded = {name for name in sys.modules if name.startswith("apesim_effects")}
    archive = read(swept.path)
    digest = hashlib.sha256(EXAMPLE.read_bytes()).hexdigest()
    assert info(swept.path)["outside_effects"] == [{"effect": "tapered_bore", "file": "bore.py", "sha256": digest}]
    assert 'friction = "60 N s/m"' in archive.machine and str(swept.path.parent) not in archive.machine
    assert verify(swept.path) == [] and diff(swept.path, swept.path).differences == []
    assert {name for name in sys.modules if name.startswith("apesim_effects")} == loaded


def test_archive_info_prints_it(swept, apesim):
    code, out, _ = apesim("archive", "info", str(swept.path))
    digest = hashlib.sha256(EXAMPLE.read_bytes()).hexdigest()
    assert code == 0 and f"needed        effect tapered_bore of bore.py, sha256 {digest}" in out
