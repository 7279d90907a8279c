"""Fixtures, and the mark of tests that pass without compiling: ``NUMBA_DISABLE_JIT=1 python -m pytest -m plain``."""

import sys

import pytest

from apesim.studies.cli import app
from apesim.studies.console import main_of

PLAIN = {
    *("test_air", "test_effect", "test_adaptive", "test_periodic", "test_solenoid", "test_chamber", "test_groove"),
    *("test_piston", "test_ledger", "test_motion", "test_measures", "test_bench", "test_valve_effects"),
    *("test_solenoid_effects", "test_chamber_effects", "test_piston_effects", "test_bounce", "test_scratch"),
    "test_tabulated_effects",
    *(
        "test_kinematics",
        "test_breathing",
        "test_friction",
        "test_rates",
        "test_operating_point",
        "test_engine_effects",
    ),
    *("test_reference_valve",),
}

COMPILED = "converge", "no_bit", "runs_with_each_correlation", "takes_mass_and_all", "counts_as_engine_air"
"""Parts of the names of tests that take long without compiling, or are about what is compiled."""


def pytest_collection_modifyitems(items):
    for item in items:
        if item.path.stem in PLAIN and not any(part in item.name for part in COMPILED):
            item.add_marker(pytest.mark.plain)
    # The longest first, so that no process waits for it at the end.
    items.sort(key=lambda item: item.path.stem not in ("test_plain_python", "test_truth_blind"))


@pytest.fixture
def apesim(monkeypatch, capsys, tmp_path):
    """Runs a command in an empty folder; returns exit code, standard output and standard error."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["apesim", *arguments])
        code = main_of(app)
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run
