import os
import shutil
import stat
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest

from apesim import kernel as module
from apesim.cache import CacheWarning
from apesim.kernel import (
    OUTSIDE_FOLDERS_KEPT,
    by_type,
    cache_folder,
    entry,
    kernel,
    outside_folder,
    sources_hash,
)
from apesim.valve.bench import run_bench
from tests import folders
from tests.valve.test_bench import BenchMachine

ROOT = Path(module.__file__).parents[1]
compiled_only = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled, nothing is kept")


def python(code, path, **environment):
    """What a fresh process prints that finds its modules in a folder first."""
    environment = {**os.environ, "PYTHONPATH": str(path), **environment}
    run = subprocess.run(
        [sys.executable, "-P", "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    return run.stdout.strip()


def copy_of_sources(folder):
    for layer in ("apesim", "valve", "engine"):
        shutil.copytree(ROOT / layer, folder / layer, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


# --- the hash of the sources ---

HASH = "from apesim.kernel import sources_hash; print(sources_hash())"


@pytest.mark.parametrize("edited", ["apesim/air.py", "apesim/quantities/units.py", "valve/effects/bounce.py"])
def test_an_edit_anywhere_in_the_layers_changes_the_hash(tmp_path, edited):
    sources = copy_of_sources(tmp_path)
    before = python(HASH, sources)
    assert python(HASH, sources) == before == sources_hash()
    path = tmp_path / edited
    path.write_text(path.read_text() + "\n")
    assert python(HASH, sources) != before


def test_a_file_added_to_or_renamed_in_the_last_layer_changes_the_hash(tmp_path):
    sources = copy_of_sources(tmp_path)
    before = python(HASH, sources)
    (tmp_path / "engine" / "new_law.py").write_text("")
    added = python(HASH, sources)
    (tmp_path / "engine" / "new_law.py").rename(tmp_path / "engine" / "newer_law.py")
    assert len({before, added, python(HASH, sources)}) == 3


def test_the_hash_is_the_same_where_the_layers_stand_inside_as_in_a_wheel(tmp_path):
    sources = copy_of_sources(tmp_path)
    for layer in ("valve", "engine"):
        shutil.move(sources / layer, sources / "apesim" / layer)
    assert python(HASH, sources) == sources_hash()


@compiled_only
def test_an_edited_callee_in_another_file_changes_the_answer_of_a_cached_caller(tmp_path):
    sources = copy_of_sources(tmp_path / "sources")
    (sources / "valve" / "probe.py").write_text(
        "from apesim.kernel import entry\n"
        "from apesim.air import GasContent\n"
        "from apesim.valve.chamber import chamber_state\n"
        "@entry\n"
        "def temperature(gas):\n"
        "    return chamber_state(gas, GasContent(1.0, 2.0e5), 1.0).temperature\n"
    )
    code = (
        "from apesim.air import Air, gas_of\n"
        "from apesim.valve.probe import temperature\n"
        "print(temperature(gas_of(Air())), sum(temperature.stats.cache_hits.values()))"
    )
    cache = str(tmp_path / "cache")
    temperature, hits = python(code, sources, APESIM_CACHE_DIR=cache).split()
    assert hits == "0"
    assert python(code, sources, APESIM_CACHE_DIR=cache).split() == [temperature, "1"]
    callee = sources / "apesim" / "air.py"
    text = callee.read_text()
    assert text.count("    return t\n") == 1
    callee.write_text(text.replace("    return t\n", "    return 2.0 * t\n"))
    assert float(python(code, sources, APESIM_CACHE_DIR=cache).split()[0]) == 2.0 * float(temperature)


# --- the cache folder ---


@pytest.fixture
def root(tmp_path, monkeypatch):
    """A parent for cache folders; what is made for one process alone stands beside it."""
    (tmp_path / "alone").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "alone"))
    monkeypatch.setenv("APESIM_CACHE_DIR", str(tmp_path / "root"))
    return tmp_path / "root"


def folder_of(root):
    return root / f"kernels-{sources_hash()}"


def is_alone(folder):
    modes = {stat.S_IMODE(path.stat().st_mode) for path in (folder, folder.parent)}
    return folder.parent.parent.name == "alone" and modes == {0o700}


def unkept_folder():
    """The folder of the cache where nothing can be kept, which a warning says with what would help."""
    with pytest.warns(CacheWarning, match="cannot be kept .* set APESIM_CACHE_DIR"):
        return cache_folder.__wrapped__()


def test_the_cache_folder_is_private_whatever_the_umask(root):
    umask = os.umask(0)
    try:
        folder = cache_folder.__wrapped__()
    finally:
        os.umask(umask)
    assert folder == folder_of(root)
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert cache_folder.__wrapped__() == folder


@pytest.mark.parametrize("mode", [0o720, 0o702, 0o777])
def test_a_cache_folder_that_others_may_write_is_not_used(root, mode):
    folder_of(root).mkdir(parents=True)
    folder_of(root).chmod(mode)
    assert is_alone(unkept_folder())


def test_a_cache_folder_of_somebody_else_is_not_used(root, monkeypatch):
    cache_folder.__wrapped__()
    somebody_else = os.getuid() + 1
    monkeypatch.setattr(os, "getuid", lambda: somebody_else)
    assert is_alone(unkept_folder())


def test_a_link_in_place_of_the_cache_folder_is_not_followed(root, tmp_path):
    root.mkdir()
    (tmp_path / "elsewhere").mkdir(mode=0o700)
    folder_of(root).symlink_to(tmp_path / "elsewhere")
    assert is_alone(unkept_folder())


def test_where_no_cache_folder_can_be_made_one_is_made_for_this_process(root):
    root.write_text("a file, not a folder")
    assert is_alone(unkept_folder())


ALONE = """
from apesim.kernel import cache_folder
from apesim.studies.commands import cli
from apesim.studies.execution.pool import Team

if __name__ == "__main__":
    own = cache_folder()
    with Team(2) as team:
        assert team.map(cache_folder, [(), ()]) == [own, own]
    cli.main_of = lambda app: {code}
    cli.main()
"""


@pytest.mark.parametrize("code", [0, 130])
def test_a_temporary_cache_folder_is_shared_with_the_workers_and_removed_at_the_end(tmp_path, code):
    (tmp_path / "alone").mkdir()
    (tmp_path / "file").touch()
    (tmp_path / "alone.py").write_text(ALONE.format(code=code))
    told = {"TMPDIR": str(tmp_path / "alone"), "APESIM_CACHE_DIR": str(tmp_path / "file")}
    told["PYTHONPATH"] = str(ROOT)
    done = subprocess.run([sys.executable, "alone.py"], cwd=tmp_path, env=os.environ | told)
    assert done.returncode == code
    assert not list((tmp_path / "alone").iterdir())


def test_only_the_newest_cache_folders_are_kept(root):
    for age in range(6):
        old = root / f"kernels-{age}"
        old.mkdir(parents=True)
        os.utime(old, (1e9 - age, 1e9 - age))
    new = cache_folder.__wrapped__()
    assert sorted(f.name for f in root.iterdir()) == sorted(["kernels-0", "kernels-1", "kernels-2", new.name])


def test_of_the_folders_of_outside_effects_the_longest_unused_goes_first(root, monkeypatch):
    inner = root / "kernels"
    inner.mkdir(parents=True)
    monkeypatch.setattr(module, "cache_folder", lambda: inner)
    for number in range(OUTSIDE_FOLDERS_KEPT):
        os.utime(outside_folder(f"{number}"), (1e9 + number, 1e9 + number))
    outside_folder("0")  # used again, so that 1 is the oldest
    outside_folder("new")
    kept = {folder.name.removeprefix("outside-") for folder in inner.iterdir()}
    assert len(kept) == OUTSIDE_FOLDERS_KEPT and {"0", "new"} <= kept and "1" not in kept


def test_the_cache_follows_the_xdg_base_directory(tmp_path, monkeypatch):
    monkeypatch.delenv("APESIM_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder.__wrapped__().parent == tmp_path / "apesim"


# --- damaged cache files ---


def cubed(x):
    return x * x * x


def kept_files(folder):
    return {path: path.read_bytes() for path in folder.rglob("*.nb[ci]")}


@compiled_only
@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
@pytest.mark.parametrize(
    "damage",
    [
        "empty",
        "truncated",
        "garbage",
        "text",
        "another pickle",
        "absurd length",
    ],
)
def test_a_damaged_cache_file_is_rebuilt(tmp_path, monkeypatch, suffix, damage):
    monkeypatch.setattr(module, "cache_folder", lambda: tmp_path)
    assert entry(cubed)(3.0) == 27.0
    sound = kept_files(tmp_path)
    (damaged,) = (path for path in sound if path.suffix == suffix)
    whole = sound[damaged]
    damaged.write_bytes(
        {
            "empty": b"",
            "truncated": whole[: len(whole) // 2],
            "garbage": np.random.default_rng(1).bytes(len(whole)),
            "text": b"<html>quota exceeded</html>\n",
            "absurd length": b"\x80\x04\x8e" + (2**50).to_bytes(8, "little"),
            "another pickle": b"\x80\x04}\x94.",
        }[damage]
    )
    again = entry(cubed)
    assert again(3.0) == 27.0
    assert sum(again.stats.cache_misses.values()) == 1
    healed = entry(cubed)
    assert healed(3.0) == 27.0
    assert sum(healed.stats.cache_hits.values()) == 1
    assert kept_files(tmp_path).keys() == sound.keys()


# --- telling that something is compiled ---

TOLD = """
from collections import Counter

from numba.core import event

from apesim.compiling import when_compiling
from apesim.engine.machine import Machine
from apesim.engine.steady import run_steady
from apesim.valve.bench import run_bench

with when_compiling(lambda line: print("told", end=" ")), event.install_recorder("numba:compile") as compiling:
    run_bench(Machine(), 20e-3) if KIND == "bench" else run_steady(Machine(), 100.0, max_cycles=1)
started = [at.data for _, at in compiling.buffer if at.is_start]
functions = [(data["dispatcher"].py_func, str(data["args"])) for data in started]
times = Counter((f"{function.__module__}.{function.__qualname__}", types) for function, types in functions)
assert all(count == 1 or name.startswith("numba.") for (name, _), count in times.items()), times
print(*{name for name, _ in times})
"""


@compiled_only
@pytest.mark.parametrize("kind", ["bench", pytest.param("engine", marks=pytest.mark.slow)])
@pytest.mark.slow
def test_a_march_compiles_what_its_machine_needs_once_and_tells_it(tmp_path, kind):
    def told():
        return python(TOLD.replace("KIND", repr(kind)), ROOT, APESIM_CACHE_DIR=str(tmp_path)).split()

    first, again = told(), told()
    assert again == []
    assert first[0] == "told"
    rates, others = {
        "bench": ("apesim.valve.bench.bench_rates", "apesim.engine."),
        "engine": ("apesim.engine.cycle.rates.cycle_rates", "apesim.valve.bench."),
    }[kind]
    assert {"apesim.march.adaptive.march", rates} <= set(first)
    assert not [name for name in first if name.startswith(others)]


# --- functions chosen by type ---


class Square(NamedTuple):
    side: float


class Disc(NamedTuple):
    radius: float


class Blob(NamedTuple):
    size: float


@by_type
def area(shape, scale):
    """Area of a shape, where it is known."""
    return -1.0 * scale


@area.for_type(Square)
@kernel
def area_of_square(shape, scale):
    return shape.side**2 * scale


@area.for_type(Disc)
@kernel
def area_of_disc(shape, scale):
    return 3.0 * shape.radius**2 * scale


def area_twice(shape, scale):
    return 2.0 * area(shape, scale)


@pytest.mark.parametrize(("shape", "expected"), [(Square(3.0), 9.0), (Disc(2.0), 12.0), (Blob(5.0), -1.0)])
def test_the_type_of_the_first_argument_chooses_the_body(shape, expected):
    assert area(shape, 10.0) == 10.0 * expected
    assert area_twice(shape, 10.0) == 20.0 * expected
    assert numba.njit(area_twice)(shape, 10.0) == 20.0 * expected


UNREGISTERED = """
from apesim.march.adaptive import NO_CARRY, march
from apesim.march.periodic import NO_RECORD
from apesim.engine.machine import Machine
from apesim.engine.cycle.operating_point import accuracy_at, charged_at_rest, cycle_of

p, tables, breakpoints = cycle_of(Machine(), 100.0)
y, mode = charged_at_rest(p)
try:
    march(p, tables, 0.0, y, mode, breakpoints, accuracy_at(p), *NO_RECORD, NO_CARRY)
except TypeError as error:
    print(error)
"""


def test_a_machine_whose_rates_no_module_registered_is_refused_and_not_kept(tmp_path):
    said = python(UNREGISTERED, ROOT, APESIM_CACHE_DIR=str(tmp_path))
    assert said == "nothing is registered as rates of Cycle: import the module that does"
    assert not kept_files(tmp_path)


# --- compiled and plain ---

BITS = """
from tests import folders
from tests.valve.test_bench import BenchMachine
from tests.apesim.test_kernel import bits
print(bits())
"""


def bits():
    """All bits of a run with a contact, and of one with cp(T) that ends in flight."""
    run = run_bench(BenchMachine(), 20e-3, until=15e-3)
    assert run.opening.contact < 15e-3
    perfect = run_bench(BenchMachine.with_(air={"model": 1}), 9e-3, until=9e-3)
    numbers = [run.trace.ravel(), run.opening, [run.control_air, run.steps], perfect.trace.ravel()]
    return np.concatenate([np.asarray(n, dtype=float) for n in numbers]).tobytes().hex()


@compiled_only
def test_plain_python_gives_the_same_bits_as_compiled_code():
    path = os.pathsep.join((str(ROOT), str(folders.ROOT)))
    assert python(BITS, path, NUMBA_DISABLE_JIT="1") == bits()
