"""Command `apesim doctor`: what apesim runs on, what its cache holds, and whether its numbers are right."""

import json
import platform

import numba
import pytest

from apesim.studies.run import doctor

compiled_only = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled, nothing is kept")


def test_it_names_all_parts(apesim):
    code, out, _ = apesim("doctor")
    assert code == 0
    packages = ("apesim", "python", "numpy", "numba", "llvmlite", "scipy", "h5py", "matplotlib")
    system = ("platform", "processor", "cores", "free memory", "cache: ")
    for part in (*packages, *system, *doctor.KINDS, *(each.name for each in doctor.REFERENCES)):
        assert part in out
    assert platform.python_version() in out
    assert "self-test passed; a deviation of 0.01% is allowed" in out


def test_its_json_holds_the_same(apesim):
    code, out, _ = apesim("doctor", "--json")
    data = json.loads(out)
    assert code == 0
    assert set(data) == {
        *("versions", "platform", "processor", "cores", "free_memory_B", "cache"),
        *("compiled_now", "self_test", "allowed_deviation", "passed"),
    }
    assert set(data["cache"]) == {"folder", "size_B", "kinds"}
    assert [each["kind"] for each in data["cache"]["kinds"]] == list(doctor.KINDS)
    assert [each["unit"] for each in data["self_test"]] == ["ms", "N m"]
    assert all(abs(each["deviation"]) <= data["allowed_deviation"] and each["passed"] for each in data["self_test"])
    assert data["passed"] is True and data["compiled_now"] == []


@compiled_only
def test_a_second_time_nothing_is_left_to_compile(apesim):
    assert apesim("doctor", "--compile", "--json")[0] == 0
    assert doctor.missing_kinds() == []
    code, out, err = apesim("doctor", "--compile", "--json")
    data = json.loads(out)
    assert (code, data["compiled_now"]) == (0, [])
    assert all(each["compiled"] for each in data["cache"]["kinds"])
    assert "compiling" not in err and "every kind of march is compiled already" in err


def test_only_what_is_missing_is_compiled(apesim, monkeypatch):
    compiled = []
    monkeypatch.setattr(doctor, "missing_kinds", lambda: ["engine", "engine with effects"])
    monkeypatch.setattr(doctor, "compile_march", compiled.append)
    code, out, _ = apesim("doctor", "--compile", "--json")
    assert (code, compiled) == (0, ["engine", "engine with effects"])
    assert json.loads(out)["compiled_now"] == compiled


@pytest.mark.parametrize("share", [1.001, 0.999])
def test_a_number_that_is_off_ends_with_1(apesim, monkeypatch, share):
    good, torque = doctor.REFERENCES
    monkeypatch.setattr(doctor, "REFERENCES", (good, torque._replace(value=torque.value * share)))
    code, out, _ = apesim("doctor")
    assert code == 1
    assert "self-test FAILED" in out
    code, out, _ = apesim("doctor", "--json")
    assert (code, [each["passed"] for each in json.loads(out)["self_test"]]) == (1, [True, False])


@pytest.mark.parametrize(("name", "value"), [("--machine", "mine.toml"), ("--set", "engine.bore=90 mm")])
def test_a_machine_is_refused(apesim, name, value):
    code, out, err = apesim("doctor", name, value)
    assert (code, out) == (2, "")
    assert err.startswith(f"command line: {name}: has no use here")
