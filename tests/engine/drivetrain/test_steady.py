"""Periodic states of drivetrains against those of one cylinder, and of free shafts against constant speed."""

import numpy as np
import pytest
from scipy.optimize import brentq

from apesim.engine.angles import TURN
from apesim.engine.drivetrain.preparing import Course, prepare
from apesim.engine.drivetrain.run import run_drivetrain
from apesim.engine.drivetrain.state import FRICTION_WORK, LOAD_WORK, SHAFT_STATES, shaft_ledger, shaft_states
from apesim.engine.drivetrain.steady import cylinder_runs, gas_work, run_revolution
from apesim.engine.indicators import INDICATORS, indicators
from apesim.engine.machine import Machine
from apesim.engine.steady import run_steady
from apesim.march.adaptive import LOG_HEAD, ZERO_CROSSING, Status

pytestmark = pytest.mark.compiled
"""Many revolutions: without compiling they took two thirds of all tests that run so."""
RPM = TURN / 60.0
FAN = {"load.quadratic": "2.8496e-3 N m s^2"}
OF_ALL = ("exergy", "closure", "change", "cycles", "tolerance", "speed")
"""Parts of the names of indicators that are not of one cylinder."""


@pytest.mark.parametrize(
    ("rpm", "values"),
    [
        (1000.0, {}),
        (600.0, {"engine.intake": "cam"}),
        (1500.0, {"engine.intake": "ideal"}),
        (800.0, {"valve.stroke": "6 mm", "supply.control_pressure": "0.7 MPa gauge", "ambient.temperature": "310 K"}),
        (2400.0, {"command.release": "30 deg"}),
    ],
)
def test_a_cylinder_of_a_drivetrain_has_the_indicators_of_a_steady_run(rpm, values):
    machine = Machine().with_(**values)
    alone = indicators(machine, run_steady(machine, rpm * RPM))
    within = indicators(machine, cylinder_runs(run_revolution(machine, rpm * RPM))[0])
    for name in INDICATORS:
        if not any(part in name for part in OF_ALL):
            assert within[name] == pytest.approx(alone[name], rel=2e-6, abs=1e-9, nan_ok=True), name


def test_cylinders_on_an_infinite_receiver_do_not_know_of_one_another():
    machine = Machine().with_(engine_receiver_volume="inf")
    one = indicators(machine, run_steady(machine, 1000.0 * RPM))
    three = run_revolution(machine.with_(engine_cylinders=3, engine_phases="0, 100, 250 deg"), 1000.0 * RPM)
    assert three.status == Status.DONE
    for run in cylinder_runs(three):
        own = indicators(machine, run)
        for name in (
            "indicated_torque_Nm",
            "valve_open_deg",
            "valve_close_deg",
            "fluctuation",
            "control_air_kg_per_cycle",
        ):
            assert own[name] == pytest.approx(one[name], rel=3e-7), name


@pytest.mark.parametrize("inertia", [0.05, 1.0, 1e4])
def test_a_free_shaft_repeats_and_its_works_balance(inertia):
    machine = Machine().with_(shaft_inertia=f"{inertia} kg m^2", **FAN)
    r = run_revolution(machine, 800.0 * RPM, is_free=True)
    ledger = r.end[shaft_ledger(r.prepared.p) :]
    assert r.status == Status.DONE and r.orbit.converged
    assert gas_work(r.prepared.p, r.end) == pytest.approx(ledger[FRICTION_WORK] + ledger[LOAD_WORK], rel=1e-6)
    assert max(r.closure) < 1e-8


def test_a_free_shaft_differs_from_constant_speed_as_one_over_its_inertia():
    machine = Machine().with_(**FAN)

    def missing(rpm):
        run = run_steady(machine, rpm * RPM)
        return indicators(machine, run)["brake_torque_Nm"] - machine.load.quadratic * (rpm * RPM) ** 2

    limit = brentq(missing, 900.0, 1100.0, xtol=1e-6)
    off = [
        run_revolution(machine.with_(shaft_inertia=f"{J} kg m^2"), 1000.0 * RPM, is_free=True).speed / RPM - limit
        for J in (10.0, 1000.0)
    ]
    assert off[0] == pytest.approx(100.0 * off[1], rel=0.02) and 0.1 < off[0] < 1.0


def test_a_row_of_the_log_within_a_step_has_no_ledgers():
    r = run_revolution(Machine().with_(engine_cylinders=2), 1000.0 * RPM)
    within, ledgers = r.log[:, 1] >= ZERO_CROSSING, LOG_HEAD + shaft_states(r.prepared.p) + SHAFT_STATES
    assert within.any() and np.isnan(r.log[within, ledgers:]).all()
    assert not np.isnan(r.log[~within]).any() and not np.isnan(r.log[:, :ledgers]).any()


def test_rows_of_a_free_shaft_are_at_even_angles():
    machine = Machine().with_(shaft_inertia="0.02 kg m^2", **FAN)
    r = run_revolution(machine, 1000.0 * RPM, is_free=True)
    assert np.allclose(r.trace[:, 0] % 360.0, np.degrees(r.angles) % 360.0, atol=1e-5)
    assert np.ptp(r.trace[:, 1]) > 300.0


def test_friction_follows_the_pressures_of_the_revolution_before_as_in_a_long_march():
    two = {"engine.intake": "cam", "supply.pressure": "3 MPa gauge", "stage_2.bore": "120 mm"}
    machine = Machine().with_(**two, stage_2_groove_effective_area="300 mm^2")
    r = run_revolution(machine, 600.0 * RPM)
    speeds = np.array([[0.0, 600.0 * RPM], [20.0, 600.0 * RPM]])
    long = run_drivetrain(prepare(machine, 0.0, Course(speeds)), 20.0).revolutions
    ledger = r.end[shaft_ledger(r.prepared.p) :]
    assert ledger[FRICTION_WORK] == pytest.approx(long["friction_work"][-1], rel=1e-7)
    assert gas_work(r.prepared.p, r.end) == pytest.approx(long["gas_work"][-1], rel=1e-7)


def test_a_shaft_that_its_load_stops_has_no_periodic_state():
    machine = Machine().with_(load_constant="80 N m", shaft_inertia="0.1 kg m^2")
    r = run_revolution(machine, 600.0 * RPM, is_free=True)
    assert r.status == Status.STOPPED
