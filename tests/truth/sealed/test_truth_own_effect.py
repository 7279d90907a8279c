"""An effect that a user writes: named in data of the simulator that the library explains wrongly, or not at all."""

import json

import pytest

from apesim.engine.effects import ALL_EFFECTS
from apesim.engine.machine import Machine
from apesim.studies.gap.workflow import explain
from tests.late_release import ALIKE, APART, FILE, LEFT_OUT, write_rig

NEAR = "clock_error", "solenoid_a_delay", "coulomb_friction"
FEW = [LEFT_OUT, *(effect.name for effect in ALL_EFFECTS if effect.name not in (*NEAR, LEFT_OUT))]
"""Effects without which an explanation takes seconds."""


def machine_of(folder):
    return Machine.load(folder / "machine.toml")


def assert_found(found, late):
    """The user's effect comes first, and its interval, some per cent wide, holds what was hidden."""
    (row,) = found["effects"]
    low, high = row["interval_95"]
    assert (row["key"], row["unit"]) == ("effects.late_release.time", "ms")
    assert low < late < high
    assert high - low < 0.1 * late


def test_it_is_named_with_its_size(tmp_path):
    folder = write_rig(tmp_path, APART, 0.8)
    found = explain(machine_of(folder).with_effects(FILE), folder, without=FEW).to_dict()
    assert found["verdict"] == "NAMED"
    assert_found(found, 0.8)
    assert found["held_out"]["size_after"] < 0.15 < found["held_out"]["size_before"]


def test_a_clock_error_is_said_to_be_indistinguishable_where_all_pulses_are_alike(tmp_path):
    folder = write_rig(tmp_path, ALIKE, 0.3)
    found = explain(machine_of(folder).with_effects(FILE), folder, without=FEW).to_dict()
    assert (found["verdict"], found["class"]) == ("NAMED_CLASS", ["late_release", "clock_error"])
    assert_found(found, 0.3)
    assert "late release" in found["sentence"]
    assert "clock error" in found["sentence"]


def told_by(apesim, *arguments):
    """What a command tells as JSON."""
    code, out, _ = apesim(*map(str, arguments), "--json", "--quiet")
    assert code == 0
    return json.loads(out)


@pytest.mark.slow
def test_by_the_command_it_is_refused_without_the_file_and_named_with_it(tmp_path, apesim):
    """With the whole library but `release_delay`."""
    folder = write_rig(tmp_path, APART, 0.8)
    command = ["gap", "explain", folder, "--machine", folder / "machine.toml", "--without", LEFT_OUT]
    refused = told_by(apesim, *command, "--out", tmp_path / "without")
    assert (refused["verdict"], refused["effects"]) == ("REFUSED", [])
    named = told_by(apesim, *command, "--effect-file", FILE, "--out", tmp_path / "found")
    assert named["verdict"] == "NAMED"
    assert_found(named, 0.8)
    child = Machine.load(tmp_path / "found" / "machine.toml")
    assert child.effects.late_release.time == pytest.approx(0.8e-3, rel=0.05)


@pytest.mark.slow
def test_a_release_that_the_machine_file_states_is_blamed_first(tmp_path):
    """A number of the machine, known to 0.1 ms, is said to be wrong, and no effect to be missing."""
    folder = write_rig(tmp_path, APART, 0.8)
    machine = machine_of(folder)
    dead_time = machine.valve.solenoid.dead_time
    found = explain(
        machine.with_(**{"valve.solenoid.release_dead_time": dead_time}).with_effects(FILE), folder, without=FEW
    ).to_dict()
    hidden = json.loads((tmp_path / "answer.json").read_text())["nuisances"]["valve.solenoid.dead_time"]
    assert found["verdict"] == "CALIBRATION"
    (row,) = found["effects"]
    low, high = row["interval_95"]
    assert row["key"] == "valve.solenoid.release_dead_time"
    assert low < 1e3 * (dead_time + hidden) + 0.8 < high
