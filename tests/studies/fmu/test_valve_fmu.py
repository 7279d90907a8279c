"""The valve as an FMU, in hosts that know nothing of it."""

import importlib.util
import json
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from ctypes import c_double, c_int
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import apesim
from apesim.march.adaptive import Status
from apesim.studies.commands.cli import app
from apesim.valve.bench import run_bench

STEP, PULSE, END = 1e-4, 50e-3, 100e-3
STROKE = apesim.Machine().valve.stroke
OLDEST_GLIBC = (2, 17)

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="loads a library of Linux")


def marched(machine, pulse=PULSE, end=END, step=STEP):
    """Lift of `run_valve` at the ends of steps."""
    return run_bench(machine, pulse, end, sample=step * np.arange(1, round(end / step) + 1)).trace[:, 0]


def needs(program):
    return pytest.mark.skipif(not shutil.which(program), reason=f"{program} is not installed")


HOST = Path(__file__).parent / "host.c"


def lift_by_host(host, library, token):
    """Lift that a host in C prints, which runs a library."""
    command = [*host, library, token, str(round(END / STEP)), str(STEP)]
    return np.array(subprocess.run(command, check=True, capture_output=True, text=True).stdout.split(), dtype=float)


@needs("gcc")
def test_a_host_in_c_runs_it_like_run_valve(library, tmp_path):
    subprocess.run(["gcc", "-O2", HOST, "-o", tmp_path / "host", "-ldl"], check=True)
    lift = lift_by_host([tmp_path / "host"], library.binary, library.token)
    assert abs(lift - marched(apesim.Machine())).max() < 1e-6 * STROKE


@pytest.mark.slow
@needs("wine")
@pytest.mark.skipif(not importlib.util.find_spec("ziglang"), reason="ziglang is not installed")
def test_a_host_of_windows_runs_it_like_run_valve(library, tmp_path):
    zig = [sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-windows-gnu", "-O2"]
    subprocess.run([*zig, HOST, "-o", tmp_path / "host.exe"], check=True)
    [binary] = library.folder.glob("binaries/win64/*.dll")
    lift = lift_by_host(["wine", tmp_path / "host.exe"], binary, library.token)
    assert abs(lift - marched(apesim.Machine())).max() < 1e-6 * STROKE


@needs("objdump")
def test_it_asks_for_nothing_but_an_old_c_library_and_shows_its_functions_alone(library):
    symbols = subprocess.run(["objdump", "-T", library.binary], check=True, capture_output=True, text=True).stdout
    asked = [line for line in symbols.splitlines() if "*UND*" in line]
    assert not [line for line in asked if re.search(r"Py|NRT|numba", line)]
    versions = [tuple(map(int, v.split("."))) for line in asked for v in re.findall(r"GLIBC_([0-9.]+)", line)]
    assert versions and max(versions) <= OLDEST_GLIBC
    shown = [line.split()[-1] for line in symbols.splitlines() if ".text" in line]
    assert shown and all(name.startswith("fmi2") for name in shown)


@pytest.mark.parametrize("step", [1e-3, 3.7e-5])
def test_the_length_of_steps_changes_nothing(library, step):
    pulse, end = (step * round(time / step) for time in (20e-3, 30e-3))
    valve = library.instance()
    lift = np.array(valve.lifts(pulse, end, step))
    assert abs(lift - marched(apesim.Machine(), pulse, end, step)).max() < 1e-6 * STROKE
    valve.free()


@pytest.mark.parametrize("fmi", [2, 3])
def test_fmpy_validates_and_simulates_it(valve_fmus, fmi):
    fmpy = pytest.importorskip("fmpy")
    from fmpy.validation import validate_fmu

    path = str(valve_fmus[fmi].path)
    assert validate_fmu(path) == []
    kinds = [("time", float), ("command", np.int32)]
    command = np.array([(0.0, 1), (PULSE, 1), (PULSE, 0), (END, 0)], dtype=kinds)
    run = fmpy.simulate_fmu(path, stop_time=END, output_interval=STEP, input=command)
    assert abs(run["lift_m"][1:] - marched(apesim.Machine())).max() < 1e-6 * STROKE


def test_parameters_are_those_of_another_machine(library):
    changes = {"valve.stroke": "8 mm", "valve.moving_mass": "90 g", "valve.solenoid.dead_time": "2.1 ms"}
    changes |= {
        "valve.piston_area": "1000 mm^2",
        "valve.clearance_volume": "9000 mm^3",
        "valve.spring_rate": "1500 N/m",
    }
    changes |= {
        "valve.solenoid.ramp_time": "1.1 ms",
        "valve.viscous_friction": "80 N s/m",
        "ambient.pressure": "98 kPa abs",
    }
    machine = apesim.Machine().with_(**changes, **{"supply.pressure": "0.8 MPa abs", "supply.temperature": "300 K"})
    keys = {key: float(value(machine)) for key, value in read_keys(changes).items()}
    valve = library.instance(supply_pressure_Pa=0.8e6, supply_temperature_K=300.0, **keys)
    assert valve.get("pressure_a_Pa") == pytest.approx(0.8e6, rel=1e-12)
    lift = valve.lifts(PULSE, END, STEP)
    assert abs(np.array(lift) - marched(machine)).max() < 1e-6 * STROKE
    valve.free()


def read_keys(keys):
    """Functions from a machine to the value of a key, by key."""
    from operator import attrgetter

    return {key: attrgetter(key) for key in keys}


def test_the_supply_can_change_between_steps(library):
    valve, higher = library.instance(supply_pressure_Pa=0.6e6), library.instance(supply_pressure_Pa=0.9e6)
    assert valve.set("supply_pressure_Pa", 0.9e6) == 0
    for _ in range(200):
        assert valve.step(1e-3) == 0
    assert valve.get("pressure_a_Pa") == pytest.approx(0.9e6, rel=1e-6)
    assert valve.get("control_air_kg") > 0.0

    # What is in chamber A is warmer than from rest, as it was filled at once: the lift comes near, and no more.
    lifts = [np.array(each.lifts(PULSE, END, STEP)) for each in (valve, higher)]
    assert 0.0 < abs(lifts[0] - lifts[1]).max() < 0.2 * STROKE
    valve.free()
    higher.free()


def test_two_at_once_know_nothing_of_each_other(library):
    alone = library.instance()
    expected = alone.lifts(PULSE, END, STEP)
    first, second = library.instance(), library.instance(supply_pressure_Pa=0.6e6)
    lifts = []
    for i in range(round(END / STEP)):
        for valve, pulse in ((first, PULSE), (second, 20e-3)):
            valve.set("command", int(i * STEP < pulse - 1e-9))
            assert valve.step(STEP) == 0
        lifts.append(first.get("lift_m"))
    assert lifts == expected
    for valve in (alone, first, second):
        valve.free()


def test_instances_run_in_threads(library):
    valves = [library.instance() for _ in range(4)]
    with ThreadPoolExecutor(4) as threads:
        lifts = list(threads.map(lambda valve: valve.lifts(20e-3, 30e-3, 1e-5), valves))
    assert all(each == lifts[0] for each in lifts) and max(lifts[0]) == STROKE
    for valve in valves:
        valve.free()


def test_reset_begins_anew(library):
    valve = library.instance()
    expected = valve.lifts(20e-3, 30e-3, STEP)
    assert valve.call("Reset") == 0
    valve.initialize()
    assert valve.lifts(20e-3, 30e-3, STEP) == expected
    valve.free()


def test_a_state_is_kept_and_restored_to_the_bit(library):
    valve, other = library.instance(), library.instance()
    valve.lifts(10e-3, 8e-3, STEP)
    state, time = valve.keep(), valve.time
    expected = valve.lifts(5e-3, 30e-3, STEP)
    valve.restore(state, time)
    assert valve.lifts(5e-3, 30e-3, STEP) == expected

    # In another instance, by way of bytes.
    data = valve.serialized(state)
    copy = other.deserialized(data)
    other.restore(copy, time)
    assert other.lifts(5e-3, 30e-3, STEP) == expected
    assert other.deserialized(data[:-1]) is None and "no state" in library.told[-1]
    valve.drop(state)
    other.drop(copy)
    valve.free()
    other.free()


def test_a_late_start_and_a_long_wait_change_nothing(library):
    early, late = library.instance(), library.instance(start=1234.5)
    for _ in range(30):
        assert late.step(1.0) == 0
    late_lifts, lifts = (np.array(valve.lifts(20e-3, 30e-3, STEP)) for valve in (late, early))
    assert abs(late_lifts - lifts).max() < 1e-9 * STROKE
    early.free()
    late.free()


def test_what_is_wrong_is_told_by_the_logger(library):
    valve = library.instance()
    for name, value, said in (
        ("command", 2, "command = 2 is out of its range, 0 to 1"),
        ("supply_pressure_Pa", float("nan"), "supply_pressure_Pa = nan is out of its range"),
        ("valve.stroke", 8e-3, "valve.stroke can be set before the first step only"),
        ("lift_m", 0.0, "is an output, and cannot be set"),
        ("air.gas_constant", 280.0, "is fixed at export"),
    ):
        assert valve.set(name, value) == 3
        assert said in library.told[-1]
    assert valve.call("DoStep", c_double(0.0), c_double(-1.0), c_int(1)) == 3
    assert valve.call("DoStep", c_double(5.0), c_double(STEP), c_int(1)) == 3
    assert "but the FMU is at 0 s" in library.told[-1]
    assert valve.call("EnterInitializationMode") == 3
    assert "may not be called between steps" in library.told[-1]
    valve.free()


def test_parameters_that_contradict_each_other_are_refused(library):
    from tests.studies.fmu.importer import Instance

    valve = Instance(library)
    assert valve.set("groove.lap", 10e-3) == 0
    assert valve.call("EnterInitializationMode") == 0
    assert valve.call("ExitInitializationMode") == 3
    assert "groove.lap and valve.stroke" in library.told[-1]
    assert valve.call("Reset") == 0
    valve.initialize()
    assert valve.step(STEP) == 0
    valve.free()


def test_a_march_that_fails_tells_its_remedy(library):
    valve = library.instance()
    assert valve.step(1e4) == 3
    assert Status.TOO_MANY_EVALUATIONS.remedy in library.told[-1]
    assert valve.step(STEP) == 3 and "after an error" in library.told[-1]
    valve.free()


def test_a_library_takes_no_other_description(library):
    from tests.studies.fmu.importer import Instance

    assert not Instance(library, token="{another}").component
    assert "mixed up" in library.told[-1]


def test_nothing_leaks(library):
    def resident():
        return int(Path("/proc/self/statm").read_text().split()[1])

    def work():
        valve = library.instance()
        valve.lifts(5e-3, 20e-3, STEP)
        state = valve.keep()
        valve.restore(state, valve.time)
        valve.drop(state)
        valve.free()

    for _ in range(20):
        work()
    before = resident()
    for _ in range(200):
        work()
    assert resident() - before < 64  # pages of 4 kB: one that leaks an array a step takes ten times as many


@needs("gcc")
def test_the_same_machine_gives_the_same_bytes(valve_fmus, tmp_path):
    again = apesim.export_fmu(apesim.Machine(), "valve", tmp_path / "again.fmu")
    assert again.path.read_bytes() == valve_fmus[2].path.read_bytes()
    assert again.path.stat().st_size < 1_000_000


def test_the_command_says_what_it_has_written(valve_fmus, tmp_path):
    out = tmp_path / "valve.fmu"
    told = json.loads(CliRunner().invoke(app, ["fmu", "valve", "-o", str(out), "--fmi", "3", "--json"]).stdout)
    assert out.read_bytes() == valve_fmus[3].path.read_bytes()
    assert told == valve_fmus[3].to_dict() | {"file": str(out)}
    assert CliRunner().invoke(app, ["fmu", "valve", "-o", str(out)]).exit_code != 0  # it is not replaced


def test_what_cannot_be_exported_is_refused(tmp_path):
    with pytest.raises(apesim.InputError) as raised:
        apesim.export_fmu(apesim.Machine(), "tank", tmp_path / "tank.fmu", fmi=1)
    assert [fault.key for fault in raised.value.faults] == ["model", "fmi"]
