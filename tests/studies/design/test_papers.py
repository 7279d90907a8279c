"""Machines of other people's papers: their files are what the rules make of what was stated, and they run."""

import runpy

import pytest

from apesim import Machine, run_engine
from tests.folders import ROOT

FOLDER = ROOT / "docs" / "examples" / "data" / "papers"
MAKE = runpy.run_path(str(FOLDER / "make.py"))


@pytest.mark.parametrize("name", MAKE["PAPERS"])
def test_the_file_is_what_the_rules_make_of_it(name):
    machine = Machine.load(FOLDER / f"{name}.toml")
    assert machine == MAKE["design"](name).machine
    assert machine.find_unscaled_keys() == [] and machine.find_ignored_keys() == {}


def test_every_file_has_its_paper():
    assert {path.stem for path in FOLDER.glob("*.toml")} == set(MAKE["PAPERS"])


@pytest.mark.parametrize(
    ("name", "speed", "published"),
    [("motorcycle", "465 rpm", 9.99), ("prototype_2_mpa", "420 rpm", 56.0), ("fast_solenoid", "1000 rpm", None)],
)
def test_it_runs_and_its_torque_is_of_the_published_size(name, speed, published):
    run = run_engine(Machine.load(FOLDER / f"{name}.toml"), speed=speed)
    assert run.converged and run["brake_torque"] > 0.0
    assert published is None or 0.5 < run["brake_torque"] / published < 2.0
