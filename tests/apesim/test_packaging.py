"""The installed program finds its own packages, whatever lies in the user's folder."""

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from itertools import chain
from pathlib import Path

import pytest
from packaging.version import Version

from tests.folders import ROOT

FOLDERS = "apesim", "valve", "engine", "studies"
LAYERS = "apesim", "apesim.valve", "apesim.engine", "apesim.studies"
TRACKED = "pyproject.toml", "README.md", "LICENSE", *FOLDERS
RUN = "valve", "run", "--pulse", "20 ms", "--json"


def pip(*arguments):
    command = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", *map(str, arguments)]
    subprocess.run(command, check=True)


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """A checkout of its own, which a build may litter."""
    folder = tmp_path_factory.mktemp("source")
    subprocess.run(["cp", "-r", *(ROOT / name for name in TRACKED), folder], check=True)
    return folder


@pytest.fixture(scope="module")
def wheel(source, tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    pip("wheel", "--no-deps", "--wheel-dir", folder, source)
    [path] = folder.glob("*.whl")
    return path


class Environment:
    """A virtual environment whose packages are those of this one, without what is installed in an editable way."""

    def __init__(self, folder):
        subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
        self.folder = folder
        [self.packages] = folder.glob("lib/python*/site-packages")
        others = "\n".join(sorted({sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}))
        (self.packages / "others.pth").write_text(others)

    def install(self, *what):
        pip("--python", self.folder / "bin" / "python", "install", "--no-deps", *what)

    def run(self, program, *arguments, folder):
        variables = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"} | {"NUMBA_DISABLE_JIT": "1"}
        command = [self.folder / "bin" / program, *arguments]
        done = subprocess.run(command, cwd=folder, env=variables, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def where(self, *names, folder):
        """Paths at which Python started in a folder finds modules."""
        code = f"import {', '.join(names)}\nfor module in {', '.join(names)}, : print(module.__file__)"
        return [Path(line) for line in self.run("python", "-c", code, folder=folder).split()]


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    environment = Environment(tmp_path_factory.mktemp("installed"))
    environment.install(wheel)
    return environment


def decoys(folder):
    """Files of a user's own with names of our layers and modules, any of which ends a program that imports it."""
    (folder / "studies").mkdir(parents=True)
    for name in ("engine.py", "valve.py", "studies/__init__.py", "march.py", "steady.py"):
        (folder / name).write_text("raise SystemExit('the wrong module was imported')\n")
    return folder


def test_the_wheel_holds_one_package(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    assert {re.sub(r"-.*", "", name.split("/")[0]) for name in names} == {"apesim"}
    assert {"apesim/__init__.pyi", "apesim/py.typed"} <= set(names)
    top = {name.split("/")[1] for name in names if name.startswith("apesim/") and name.count("/") > 1}
    assert top == {"archive", "march", "quantities", "valve", "engine", "studies"}


def test_the_wheel_works_in_a_folder_that_holds_an_engine_py(installed, tmp_path):
    folder = decoys(tmp_path / "own")
    assert '"control_air_kg"' in installed.run("apesim", *RUN, folder=folder)
    assert all(path.is_relative_to(installed.packages) for path in installed.where(*LAYERS, folder=folder))


def test_worker_processes_start_in_a_folder_that_holds_an_engine_py(installed, tmp_path):
    folder = decoys(tmp_path / "own")
    sweep = "--speed 1000rpm --intake ideal --timing fixed --jobs 2 --out sweep.h5 --json".split()
    vary = "--vary", "supply.pressure=0.4 MPa gauge,0.5 MPa gauge"
    soon_periodic = "--set", "engine.receiver.volume=inf"
    said = json.loads(installed.run("apesim", "engine", "sweep", *sweep, *vary, *soon_periodic, folder=folder))
    assert said["faults"] == [] and (folder / "sweep.h5").exists()


def test_python_started_in_a_checkout_finds_the_checkout_after_a_plain_install(installed, source):
    where = installed.where(*LAYERS, folder=source)
    assert where == [source / layer / "__init__.py" for layer in FOLDERS]


@pytest.mark.parametrize("mode", ["lenient", "strict"])
def test_an_editable_install_follows_the_checkout(source, tmp_path, mode):
    environment = Environment(tmp_path / "environment")
    environment.install("--config-settings", f"editable_mode={mode}", "--editable", source)
    folder = decoys(tmp_path / "own")
    assert '"control_air_kg"' in environment.run("apesim", *RUN, folder=folder)
    where = [path.resolve() for path in environment.where(*LAYERS, folder=folder)]
    assert where == [source / layer / "__init__.py" for layer in FOLDERS]


def test_a_package_of_others_that_is_called_valve_stays_apart(installed, tmp_path):
    # As python-valve does, which installs a package `valve` with a module `source` of its own.
    others = installed.packages / "valve"
    (others / "source").mkdir(parents=True)
    (others / "__init__.py").write_text("import valve.source\n")
    (others / "source" / "__init__.py").write_text("")
    try:
        where = installed.where("apesim.valve", "valve", folder=tmp_path)
        assert where == [installed.packages / "apesim" / "valve" / "__init__.py", others / "__init__.py"]
        assert '"control_air_kg"' in installed.run("apesim", *RUN, folder=tmp_path)
    finally:
        shutil.rmtree(others)


def test_every_package_is_listed():
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["packages"]
    there = [path.parent.relative_to(ROOT).parts for layer in FOLDERS for path in (ROOT / layer).rglob("__init__.py")]
    assert sorted(listed) == sorted(".".join(parts if parts[0] == "apesim" else ("apesim", *parts)) for parts in there)


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
