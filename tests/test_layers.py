"""The four packages import in one direction only, and importing the face loads none of the upper ones."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def run_python(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT).stdout


def test_imports_run_in_one_direction():
    linter = [sys.executable, "-c", "from importlinter.cli import lint_imports_command; lint_imports_command()"]
    done = subprocess.run([*linter, "--no-cache"], capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "2 kept, 0 broken" in done.stdout


def test_importing_the_face_loads_no_upper_layer():
    loaded = run_python("import sys, apesim; print(*sorted({name.split('.')[0] for name in sys.modules}))").split()
    assert "apesim" in loaded
    assert not {"valve", "engine", "studies", "numba", "h5py", "matplotlib"} & set(loaded)


def test_every_name_of_the_face_is_fetched():
    assert run_python("import apesim\nfor name in apesim.__all__: assert callable(getattr(apesim, name))\nprint('all')")
    failed = "import apesim\ntry: apesim.nothing\nexcept AttributeError as error: print(error)"
    assert "no attribute 'nothing'" in run_python(failed)


def test_physics_loads_neither_files_nor_figures_nor_processes():
    loaded = run_python("import sys, engine.indicators, engine.steady; print(*sys.modules)").split()
    assert not {"h5py", "matplotlib", "typer", "concurrent.futures.process"} & set(loaded)
