"""Fixtures, and the mark of tests that pass without compiling: ``NUMBA_DISABLE_JIT=1 python -m pytest -m plain``."""

import os
import sys

# As the command line has it: threads of OpenBLAS in two processes wait for one another, and small fits take ten times
# as long. Set before numpy is imported, and handed on to the processes that tests start.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import hypothesis
import pytest

from apesim.studies.commands.cli import app
from apesim.studies.terminal.console import main_of
from tests.folders import TESTS
from tests.plain import LONG, QUICK

pytest_plugins = ["tests.browser"]
"""Modules of fixtures: one browser, as Playwright starts no second one beside it."""
STUDIES = TESTS / "studies"
"""Tests of what uses the physics; some have the names of tests of the physics."""

# On a machine that does other work, too, an example takes longer than Hypothesis grants it.
hypothesis.settings.register_profile("apesim", deadline=None)
hypothesis.settings.load_profile("apesim")

FIRST = (
    *("test_engine_library", "test_workflow", "test_outside_sweep", "test_kernel", "test_balance", "test_packaging"),
    *("test_outside_machine", "test_periodic", "test_adaptive", "test_docstrings", "test_paper", "test_examples"),
)
"""Stems of the files that take longest.

The first compiles the marches of the engine, while the other process compiles those of the valve in the second: none is
compiled twice. The march with the example's effect from outside, of the third, is needed in test_outside_machine, whose
many effects then drive it out of the cache: it begins when the third has ended.
"""


def pytest_collection_modifyitems(items):
    for item in items:
        is_physics = item.path.stem in QUICK | LONG and not item.path.is_relative_to(STUDIES)
        if is_physics and not item.get_closest_marker("compiled"):
            item.add_marker(pytest.mark.plain)
    # So that no process waits for another at the end.
    items.sort(key=lambda item: FIRST.index(item.path.stem) if item.path.stem in FIRST else len(FIRST))


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
