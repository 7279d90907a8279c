"""What is said of compiling, and what is noted of how long it took."""

import json
import os
import subprocess
import sys

import numba
import pytest

from apesim.compiling import (
    TIMES_FILE,
    compile_times,
    kind_of_march_types,
    note_compile_time,
    tell_of_compiling,
    when_compiling,
)
from apesim.engine.cycle.operating_point import cycle_of
from apesim.engine.drivetrain.preparing import prepare
from apesim.engine.machine import Machine
from tests.folders import ROOT

compiled_only = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled, nothing is kept")


@pytest.fixture
def times_file(tmp_path, monkeypatch):
    monkeypatch.setenv("APESIM_CACHE_DIR", str(tmp_path))
    return tmp_path / TIMES_FILE


def test_the_last_time_of_each_kind_is_kept(times_file):
    for kind, seconds in (("engine", 31.0), ("valve", 12.5), ("engine", 16.2)):
        note_compile_time(kind, seconds)
    assert compile_times() == {"engine": 16.2, "valve": 12.5}
    assert [path.name for path in times_file.parent.iterdir()] == [TIMES_FILE]


@pytest.mark.parametrize(
    "content", [b"", b"{", b"[1, 2]", b"\xff\xfe", b"7", b"[" * 100_000, b'{"engine": "16"}', b'{"engine": NaN}']
)
def test_a_damaged_file_says_nothing_and_is_replaced(times_file, content):
    times_file.write_bytes(content)
    assert compile_times() == {}
    note_compile_time("engine", 16.2)
    assert compile_times() == {"engine": 16.2}


def test_where_no_time_can_be_noted_none_is(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("APESIM_CACHE_DIR", str(tmp_path / "file"))
    note_compile_time("engine", 16.2)
    assert compile_times() == {}


def test_the_outermost_listener_alone_is_told_and_none_after_its_end(times_file):
    outer, inner = [], []
    with when_compiling(outer.append):
        with when_compiling(inner.append):
            tell_of_compiling("engine")
        tell_of_compiling("engine with effects")
    tell_of_compiling("valve")
    times = "takes 15 to 60 s"
    assert outer == [
        f"compiling the {kind} for this processor, once: {times}" for kind in ("engine", "engine with effects")
    ]
    assert inner == []


@pytest.mark.parametrize(
    ("keys", "kind"),
    [
        ({}, "engine"),
        ({"engine.exhaust_2.effective_area": "200 mm^2"}, "engine with 2 exhausts"),
        ({"effects.blow_by.area": "1 mm^2"}, "engine with effects"),
        (
            {"engine.exhaust_2.effective_area": "200 mm^2", "effects.blow_by.area": "1 mm^2"},
            "engine with 2 exhausts and effects",
        ),
    ],
)
def test_a_second_exhaust_valve_is_a_kind_of_its_own(keys, kind):
    """Else its march would count as the engine's, which is not compiled by it."""
    cycle, _, _ = cycle_of(Machine().with_(**keys), 100.0)
    assert kind_of_march_types([numba.typeof(cycle)]) == kind


@pytest.mark.parametrize(
    ("keys", "kind"),
    [
        ({}, "drivetrain"),
        ({"engine.cylinders": 3}, "drivetrain"),
        ({"engine.exhaust_2.effective_area": "200 mm^2"}, "drivetrain with 2 exhausts"),
        ({"effects.blow_by.area": "1 mm^2"}, "drivetrain with effects"),
    ],
)
def test_a_drivetrain_is_a_kind_of_its_own_whatever_its_number_of_cylinders(keys, kind):
    """Else a warm cache of steady runs would be taken for one of transients."""
    assert kind_of_march_types([numba.typeof(prepare(Machine().with_(**keys), 0.5).p)]) == kind


@compiled_only
@pytest.mark.slow
def test_a_call_from_python_says_once_that_it_compiles_and_nothing_when_it_loads(times_file):
    def said():
        code = "import apesim; apesim.run_valve(apesim.Machine()); apesim.run_valve(apesim.Machine())"
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        run = subprocess.run([sys.executable, "-P", "-c", code], env=environment, capture_output=True, text=True)
        assert (run.returncode, run.stdout) == (0, "")
        return run.stderr

    times_file.write_text(json.dumps({"valve": 16.2}))
    assert said() == "compiling the valve for this processor, once: took 16 s last time\n"
    assert compile_times().keys() == {"valve"} and compile_times() != {"valve": 16.2}
    assert said() == ""


@pytest.mark.parametrize(("option", "lines"), [([], 1), (["--quiet"], 0)])
def test_a_command_says_it_once_though_it_calls_a_public_function(apesim, monkeypatch, option, lines):
    from apesim.studies.run import valve_run

    run_bench = valve_run.run_bench
    run_bench(Machine(), 10e-3)  # so that nothing else is compiled below

    def compiles(*arguments, **options):
        if len(arguments) > 2:  # the run itself, not what compiles before it
            tell_of_compiling("valve")
        return run_bench(*arguments, **options)

    monkeypatch.setattr(valve_run, "run_bench", compiles)
    code, _, err = apesim("valve", "run", *option)
    assert (code, err.count("compiling the valve for this processor")) == (0, lines)
