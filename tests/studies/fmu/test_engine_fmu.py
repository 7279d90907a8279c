"""The engine as an FMU: a minute of compiling."""

import sys

import numpy as np
import pytest

import apesim
from apesim.engine.angles import RPM
from apesim.studies.fmu.library import find_compilers
from tests.studies.fmu.importer import Library

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform != "linux", reason="loads a library of Linux")]

TURNS = 240
"""Turns after which a change has settled to 1e-7."""


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """The default machine's engine, by version of FMI and whether its shaft is free."""
    if not find_compilers():
        pytest.skip("no C compiler is installed")
    folder, made = tmp_path_factory.mktemp("fmu"), {}
    for fmi, free in ((2, False), (2, True), (3, False)):
        out = folder / f"{fmi}{free}.fmu"
        made[fmi, free] = apesim.export_fmu(apesim.Machine(), "engine", out, fmi=fmi, free=free)
    return made


@pytest.fixture(scope="module")
def imposed(fmus, tmp_path_factory):
    return Library(fmus[2, False].path, tmp_path_factory.mktemp("imposed"))


@pytest.fixture(scope="module")
def free(fmus, tmp_path_factory):
    return Library(fmus[2, True].path, tmp_path_factory.mktemp("free"))


def turn(engine, speed, steps=720):
    """Mean torque, air and control air of a turn at a speed [rpm]."""
    before = engine.get("air_kg"), engine.get("control_air_kg")
    torques = []
    for _ in range(steps):
        assert engine.step(60.0 / speed / steps) == 0, engine.library.told
        torques.append(engine.get("torque_Nm"))
    return np.mean(torques), engine.get("air_kg") - before[0], engine.get("control_air_kg") - before[1]


def expected(machine, speed):
    """Mean torque, air and control air of a turn by `run_engine`."""
    run = apesim.run_engine(machine, speed=(speed, "rpm"))
    return run["brake_torque"], run["engine_air"], run["control_air"]


def test_it_begins_in_its_periodic_state(imposed):
    engine = imposed.instance()
    assert turn(engine, 1000.0) == pytest.approx(expected(apesim.Machine(), 1000.0), rel=1e-6)
    assert engine.get("angle_deg") == pytest.approx(360.0, abs=1e-9)
    engine.free()


def test_its_inputs_lead_to_the_states_of_run_engine(imposed):
    machine = apesim.Machine().with_(command_release="60 deg", supply_pressure="0.8 MPa abs")
    engine = imposed.instance()
    for name, value in (
        ("speed_rad_s", 1500.0 * RPM),
        ("release_deg", 60.0),
        ("supply_pressure_Pa", 0.8e6),
    ):
        assert engine.set(name, value) == 0
    for _ in range(TURNS):
        turn(engine, 1500.0, 10)
    assert turn(engine, 1500.0) == pytest.approx(expected(machine, 1500.0), rel=1e-6)
    engine.free()


def test_its_parameters_are_those_of_another_machine(imposed):
    changes = {"valve.moving_mass": "90 g", "valve.stroke": "8 mm", "engine.exhaust.effective_area": "400 mm^2"}
    machine = apesim.Machine().with_(**changes, **{"engine.receiver.volume": "2 L"})
    engine = imposed.instance(
        valve__moving_mass=90e-3,
        valve__stroke=8e-3,
        engine__exhaust__effective_area=400e-6,
        engine__receiver__volume=2e-3,
    )
    for _ in range(TURNS):
        turn(engine, 1000.0, 10)
    assert turn(engine, 1000.0) == pytest.approx(expected(machine, 1000.0), rel=1e-6)
    engine.free()


def test_a_free_shaft_runs_like_a_transient(free):
    run = apesim.run_transient(apesim.Machine(), "0.5 s", from_speed="1000 rpm", load="0 s: 20 N m", sample="0.1 s")
    engine = free.instance(load_torque_Nm=20.0)
    speeds = []
    for _ in range(5):
        for _ in range(100):
            assert engine.step(1e-3) == 0
        speeds.append(engine.get("speed_rad_s") / RPM)
    assert speeds == pytest.approx(run.traces["speed_rpm"].values[1:], rel=1e-6)
    engine.free()


def test_a_state_is_kept_and_restored_to_the_bit(imposed):
    engine = imposed.instance()
    turn(engine, 1000.0, 100)
    state, time = engine.keep(), engine.time
    after = turn(engine, 1000.0, 100)
    engine.restore(state, time)
    assert turn(engine, 1000.0, 100) == after
    engine.drop(state)
    engine.free()


@pytest.mark.parametrize("fmi", [2, 3])
def test_fmpy_validates_and_simulates_it(fmus, fmi):
    fmpy = pytest.importorskip("fmpy")
    from fmpy.validation import validate_fmu

    path = str(fmus[fmi, False].path)
    assert validate_fmu(path) == []
    run = fmpy.simulate_fmu(path, stop_time=0.06, output_interval=1e-4)
    assert run["angle_deg"][-1] == pytest.approx(360.0, abs=1e-6)
    assert run["torque_Nm"][1:].mean() == pytest.approx(expected(apesim.Machine(), 1000.0)[0], rel=1e-4)


def test_it_is_small(fmus):
    assert all(fmu.path.stat().st_size < 1_000_000 for fmu in fmus.values())
