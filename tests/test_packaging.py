"""The installed program finds its own packages, whatever lies in the user's folder."""

import os
import re
import subprocess
import sys
import tomllib
from itertools import chain
from pathlib import Path

from packaging.version import Version

ROOT = Path(__file__).resolve().parent.parent
DECOYS = ("engine.py", "valve.py", "studies.py", "march.py", "steady.py")


def test_the_wheel_works_in_a_folder_that_holds_an_engine_py(tmp_path):
    source = tmp_path / "source"
    tracked = ("pyproject.toml", "README.md", "LICENSE", "apesim", "valve", "engine", "studies")
    source.mkdir()
    subprocess.run(["cp", "-r", *(ROOT / name for name in tracked), source], check=True)
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "wheel", "--no-deps", "--wheel-dir", tmp_path / "wheel", source], check=True)
    [wheel] = (tmp_path / "wheel").glob("*.whl")
    installed = tmp_path / "installed"
    subprocess.run([*pip, "install", "--no-deps", "--target", installed, wheel], check=True)
    folder = tmp_path / "work"
    folder.mkdir()
    for name in DECOYS:
        (folder / name).write_text("raise SystemExit('the wrong module was imported')\n")
    environment = os.environ | {"PYTHONPATH": str(installed), "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, installed / "bin" / "apesim", "valve", "run", "--pulse", "20 ms", "--json"]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert '"control_air_kg"' in done.stdout
    where = "import sys; sys.path.remove(''); import engine; print(engine.__file__)"
    assert (
        str(installed)
        in subprocess.run(
            [sys.executable, "-c", where], cwd=folder, env=environment, capture_output=True, text=True, check=True
        ).stdout
    )


def test_every_package_is_listed():
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["packages"]
    layers = ("apesim", "valve", "engine", "studies")
    there = [path.parent.relative_to(ROOT) for layer in layers for path in (ROOT / layer).rglob("__init__.py")]
    assert sorted(listed) == sorted(".".join(path.parts) for path in there)


def declared():
    """All packages that are asked for, with their lowest versions."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = chain(project["dependencies"], *project["optional-dependencies"].values())
    return [each.split(">=") for each in wanted if not each.startswith("apesim")]


def test_the_lock_file_holds_a_version_of_every_package_and_nothing_else():
    lines = (ROOT / "docs" / "lock-python3.11.txt").read_text(encoding="utf-8").splitlines()
    locked = {}
    for line in [line for line in lines if not line.startswith("#")]:
        name, version = re.fullmatch(r"([\w.-]+)==([\w.+]+)", line).groups()
        locked[re.sub(r"[._]", "-", name.lower())] = version
    for name, lowest in declared():
        assert Version(locked[name]) >= Version(lowest), name


def test_the_lowest_versions_of_all_packages_are_tried():
    done = subprocess.run([sys.executable, ROOT / ".ci" / "lowest"], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["==".join(each) for each in declared()]
