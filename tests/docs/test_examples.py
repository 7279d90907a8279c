"""The examples of the gallery run as they are downloaded: as scripts, and some as notebooks."""

import ast
import json
import os
import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from docs.extensions.gallery import ORDER
from tests.folders import ROOT

EXAMPLES = ROOT / "docs" / "examples"
SCRIPTS = sorted(path.stem for path in EXAMPLES.glob("*.py") if not path.stem.startswith("make_"))
NOTEBOOKS = ["first_run", "own_valve_from_discharge_test", "laboratory_data", "own_effect"]
"""The first runs by default; the others repeat as notebooks what the tests run as scripts."""
OWN_MARCHES = {"own_effect", "own_machine"}
"""Examples that compile marches of their own, a minute in all: slow. By default test_outside_machine marches an effect
from outside and test_adaptive machines of its own; the site's build runs every example."""
LONG = {
    *("what_limits_30_hz", "paper_in_one_page", "sweep_on_a_cluster", "missing_effect_found"),
    *("soft_landing", "sweep_over_pressure", "optimum", "timing_map_to_header", "governor"),
}
"""Examples of studies that the tests of the studies run, a minute in all: slow, too."""
UNIT = re.compile(r"\[[^\[\]]+\]")
"""Unit in a label; that of a dimensionless quantity is [-], [1] or [%]."""


@pytest.fixture
def examples(tmp_path):
    """A copy of the folder of the examples, without what earlier runs left in it."""
    return Path(shutil.copytree(EXAMPLES, tmp_path / "examples", ignore=shutil.ignore_patterns("out", "__pycache__")))


def run_in(folder, runner, script, *options, **variables):
    """Run an example in a process of its own; returns what it reports, and what it writes to standard error."""
    report = folder.parent / "report.json"
    command = [sys.executable, *options, str(Path(__file__).with_name(runner)), script, str(report)]
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    environment = os.environ | {"PYTHONPATH": path, "PYTHONIOENCODING": "utf-8"} | variables
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    return json.loads(report.read_text(encoding="utf-8")), done.stderr


def test_every_example_has_its_place_in_the_gallery():
    assert set(SCRIPTS) == set(ORDER)


def test_an_example_that_reads_data_says_where_they_are():
    reading = [name for name in SCRIPTS if '"data/' in (EXAMPLES / f"{name}.py").read_text(encoding="utf-8")]
    assert len(reading) >= 5
    for name in reading:
        head = ast.get_docstring(ast.parse((EXAMPLES / f"{name}.py").read_text(encoding="utf-8")))
        assert "copy ``docs/examples/data`` of the source code" in head, name


def slow_if(is_slow, name):
    return pytest.param(name, marks=pytest.mark.slow) if is_slow else name


@pytest.mark.parametrize("name", [slow_if(name in OWN_MARCHES | LONG, name) for name in SCRIPTS])
@pytest.mark.slow
def test_an_example_runs_without_warnings_and_its_figures_have_units(name, examples):
    figures, error = run_in(examples, "example_run.py", f"{name}.py", "-W", "error", MPLBACKEND="Agg")
    assert "Warning" not in error
    assert figures
    for labels in figures:
        assert labels
        assert [label for label in labels if not UNIT.search(label)] == []


@pytest.mark.parametrize("name", [slow_if(name != NOTEBOOKS[0], name) for name in NOTEBOOKS])
@pytest.mark.slow
def test_an_example_runs_as_a_notebook_and_shows_its_figures(name, examples, monkeypatch):
    monkeypatch.delenv("MPLBACKEND", raising=False)
    shown, _ = run_in(examples, "notebook_run.py", f"{name}.py")
    assert shown > 0


def test_the_discharge_tests_are_those_that_their_script_makes(examples):
    made = examples / "data" / "discharge"
    shutil.rmtree(made)
    runpy.run_path(str(examples / "data" / "make_discharge.py"), run_name="__main__")
    kept = EXAMPLES / "data" / "discharge"
    names = sorted(path.name for path in kept.iterdir())
    assert names == sorted(path.name for path in made.iterdir())
    for name in names:
        old, new = (np.loadtxt(folder / name, delimiter=",", skiprows=1) for folder in (kept, made))
        np.testing.assert_allclose(new, old, rtol=0.0, atol=0.02)  # two of the last digits that are written
