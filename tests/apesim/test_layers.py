"""The four packages import in one direction only, and importing the face loads none of the upper ones."""

import os
import shutil
import subprocess
import sys

import pytest

from tests.folders import ROOT, TESTS
from tests.links import LAYERS, make_links


def run_python(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT).stdout


def lint_imports(folder):
    """What import-linter says of the package that a folder holds."""
    code = "from importlinter.cli import lint_imports_command; lint_imports_command()"
    command = [sys.executable, "-P", "-c", code, "--config", ROOT / "pyproject.toml", "--no-cache"]
    environment = os.environ | {"PYTHONPATH": str(folder)}
    return subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment)


def test_imports_run_in_one_direction(tmp_path):
    done = lint_imports(make_links(tmp_path))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "2 kept, 0 broken" in done.stdout


@pytest.mark.parametrize(
    "planted, wrong",
    [
        ("valve/planted.py", "import apesim.engine.steady\n"),
        ("air.py", "from apesim.valve import bench\n"),
        ("engine/planted.py", "from apesim.archive import read\n"),
        ("planted.py", ""),  # belongs to no layer
    ],
)
def test_an_import_in_the_wrong_direction_is_found(tmp_path, planted, wrong):
    copy = tmp_path / "copy"
    shutil.copytree(make_links(tmp_path / "links") / "apesim", copy / "apesim")  # what the links point to
    with (copy / "apesim" / planted).open("a") as file:
        file.write(wrong)
    assert lint_imports(copy).returncode != 0


def test_importing_the_face_loads_no_upper_layer():
    loaded = set(run_python("import sys, apesim; print(*sys.modules)").split())
    assert "apesim" in loaded
    assert not {"apesim.valve", "apesim.engine", "apesim.studies", "numba", "h5py", "matplotlib"} & loaded


def test_every_name_of_the_face_is_fetched():
    assert run_python("import apesim\nfor name in apesim.__all__: assert callable(getattr(apesim, name))\nprint('all')")
    failed = "import apesim\ntry: apesim.nothing\nexcept AttributeError as error: print(error)"
    assert run_python(failed).strip() == "apesim has no nothing"


def test_physics_loads_neither_files_nor_figures_nor_processes():
    loaded = run_python("import sys, apesim.engine.indicators, apesim.engine.steady; print(*sys.modules)").split()
    assert not {"h5py", "matplotlib", "typer", "concurrent.futures.process"} & set(loaded)


def test_a_process_that_computes_points_starts_without_what_few_need():
    loaded = set(run_python("import sys, apesim.studies.sweep.compute; print(*sys.modules)").split())
    assert not {"scipy.interpolate", "scipy.optimize", "matplotlib"} & loaded


def test_the_tests_stand_in_folders_named_as_those_of_the_packages():
    tested = {path.parent.relative_to(TESTS) for path in TESTS.glob("*/**/test_*.py")}
    assert {
        folder for folder in tested if folder.parts[0] in ("apesim", *LAYERS) and not (ROOT / folder).is_dir()
    } == set()


def test_importing_quantities_is_light():
    code = "import apesim.quantities, sys; print({'pint', 'pydantic', 'scipy', 'tomlkit'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_importing_settings_of_quantities_is_light():
    code = "import apesim.quantities.settings, sys; print({'pint', 'pydantic', 'scipy'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
