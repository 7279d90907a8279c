"""Drivetrains against independent solutions: a program in C, Dormand and Prince's pair at a tolerance of 1e-9.

`reference-transient.csv` holds them; the machine is the default one but for what a case names. It shares no code with
ours. Relative error allowed: 1e-5; angles 1e-3 degrees.
"""

import csv
from collections import defaultdict

import numpy as np
import pytest

import apesim
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.drivetrain.preparing import NO_COURSE, NO_GOAL, Course, prepare
from apesim.engine.drivetrain.run import EventKind, air_of, run_drivetrain
from apesim.engine.drivetrain.start import find_intervals, run_start
from apesim.engine.drivetrain.state import FRICTION_WORK, GAS_WORK, SPEED, shaft_ledger, shaft_states
from tests.folders import ACCEPTANCE
from tests.machines import RPM

RELATIVE, ANGLE = 1e-5, 1e-3
FAN = 20.0 / (800.0 * RPM) ** 2
"""Quadratic load of 20 N m at 800 r/min [N m s2]."""
NO_FRICTION = {
    "engine.friction.constant": "0 bar",
    "engine.friction.peak_pressure": 0.0,
    "engine.friction.piston_speed": "0 bar s/m",
    "engine.friction.piston_speed_squared": "0 bar s^2/m^2",
}
TWO_STAGES = {
    "stage_2.bore": "120 mm",
    "stage_2.groove.effective_area": "300 mm^2",
    "stage_2.exhaust.effective_area": "1000 mm^2",
    "inter_receiver.effectiveness": 0.8,
}
CORRECTED = {"command.energise": "-41 deg", "command.release": "16 deg"}
RAMP = np.array([[0.0, 300.0 * RPM], [1.5, 1800.0 * RPM], [3.0, 300.0 * RPM]])
FLOOR = 1160.0


def solutions():
    """Quantity to value, by row."""
    rows = defaultdict(dict)
    with open(ACCEPTANCE / "reference-transient.csv", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            rows[row["row"]][row["quantity"]] = float(row["value"])
    return rows


SOLUTIONS = solutions()


def machine(**values):
    return apesim.Machine().with_(**values)


def fan(share=1.0):
    return {"load.quadratic": (share * FAN, "N m s^2")}


def agree(row, values, relative=RELATIVE):
    """Whether all quantities of a row that stand in the solutions are met."""
    for name, expected in SOLUTIONS[row].items():
        assert values[name] == pytest.approx(expected, rel=relative), name


def of_revolution(run, k=-1):
    """Quantities of a revolution, as the solutions name them; torques are positive in the direction of rotation."""
    r, c = ({name: values[k] for name, values in part.items()} for part in (run.revolutions, run.cylinders))
    turn = np.sign(r["duration"]) * TURN
    values = {
        "torque": r["gas_work"] / turn,
        "brake_torque": (r["gas_work"] - r["friction_work"]) / turn,
        "friction": r["friction_work"] / turn,
        "load": r["load_work"] / turn,
        "torque_min": r["min_torque"],
        "torque_max": r["max_torque"],
        "air_g_per_rev": c["engine_air"].sum() * 1e3,
        "control_g_per_rev": r["control_air"] * 1e3,
        "mean_rpm": 60.0 / r["duration"],
        "min_rpm": r["min_speed"] / RPM,
        "max_rpm": r["max_speed"] / RPM,
        "heat_J_per_rev": r["exchanged_heat"],
    }
    values["gas_torque"] = values["torque"]
    for i in range(len(c["gas_work"])):
        values |= {f"torque_each.{i}": c["gas_work"][i] / turn, f"air_each_g.{i}": c["engine_air"][i] * 1e3}
        values |= {f"receiver{i}_{end}_kPa": c[f"{end}_receiver"][i] / 1e3 for end in ("min", "max")}
        values[f"pmax_kPa.{i}"] = c["max_pressure"][i] / 1e3
    return values


def run(a_machine, angle, duration, course=NO_COURSE, goal=NO_GOAL):
    return run_drivetrain(prepare(a_machine, angle * DEGREE, course, goal), duration)


def at_speed(a_machine, rpm, revolutions):
    """A march at a constant speed, over so many revolutions that it repeats."""
    speeds = np.array([[0.0, rpm * RPM], [1e4, rpm * RPM]])
    return run(a_machine, 20.0, revolutions * 60.0 / abs(rpm), Course(speeds=speeds))


CONSTANT_SPEED = {
    "P01": ({}, -1000.0, 60),
    "P02": ({"engine.cylinders": 2}, 800.0, 90),
    "P03": ({"engine.cylinders": 3}, 800.0, 90),
    "P04": ({"engine.cylinders": 2} | CORRECTED, 1000.0, 90),
    "P16": ({"engine.intake": "cam"} | TWO_STAGES, 600.0, 200),
    "P17": (TWO_STAGES, 600.0, 200),
}


@pytest.mark.parametrize("row", CONSTANT_SPEED)
def test_constant_speed(row):
    values, rpm, revolutions = CONSTANT_SPEED[row]
    agree(row, of_revolution(at_speed(machine(**values), rpm, revolutions)))


@pytest.mark.parametrize(("row", "cylinders"), [("P05", 1), ("P06", 2)])
def test_free_shaft_settles(row, cylinders):
    settled = run(machine(engine_cylinders=cylinders, **fan(cylinders)), 30.0, 15.0)
    agree(row, of_revolution(settled))


STARTS = {
    "P07": (fan(), 30.0, 900.0),
    "P07b": (fan() | {"shaft.breakaway_factor": 1.0}, 30.0, 900.0),
    "P07c": (fan() | NO_FRICTION, 30.0, 900.0),
    "P08": ({"shaft.inertia": "1 kg m^2", "load.constant": "20 N m"}, 30.0, 600.0),
    "P10": (fan() | {"engine.cylinders": 2}, 200.0, 900.0),
    "P11": ({"shaft.inertia": "0.2 kg m^2", "load.constant": "30 N m", "engine.cylinders": 3}, 160.0, 900.0),
}


@pytest.mark.parametrize("row", STARTS)
def test_start(row):
    values, angle, target = STARTS[row]
    start = run_start(machine(**values), angle * DEGREE, target * RPM)
    first = next(event for event in start.run.events if event.kind is EventKind.FIRST_MOTION)
    assert start.starts
    got = {"first_motion_ms": first.time * 1e3, "time_s": start.time, "turns": start.turns}
    agree(row, got | {"air_g": start.engine_air * 1e3, "control_g": start.control_air * 1e3})


def test_kick_back():
    start = run_start(machine(), -4.0 * DEGREE)
    assert not start.starts
    kinds = [event.kind for event in start.run.events]
    assert kinds == [EventKind.FIRST_MOTION, EventKind.HALT, EventKind.REST, EventKind.HELD]
    solution = SOLUTIONS["P09"]
    for k, event in enumerate(start.run.events[:3]):
        assert event.time == pytest.approx(solution[f"events.{k}.1"], rel=RELATIVE)
        assert event.angle / DEGREE - 360.0 == pytest.approx(solution[f"events.{k}.2"], abs=ANGLE)
    air, _ = air_of(prepare(machine(), 0.0).p, start.run.y)
    assert air.sum() * 1e3 == pytest.approx(solution["air_g"], rel=RELATIVE)


EDGES = {
    ("P12", "no_load_low", "no_load_high"): {},
    ("P12", "load20_low", "load20_high"): {"load.constant": "20 N m"},
    ("P12b", "kappa1_one_cylinder_low", None): {"shaft.breakaway_factor": 1.0},
}


@pytest.mark.parametrize("names", EDGES)
def test_angles_from_which_it_starts(names):
    row, low, high = names
    [(begin, end)] = find_intervals(machine(**EDGES[names]))
    assert begin / DEGREE == pytest.approx(SOLUTIONS[row][low], abs=ANGLE)
    if high:
        assert end / DEGREE == pytest.approx(SOLUTIONS[row][high], abs=ANGLE)


def test_three_cylinders_start_from_above_an_angle():
    low = SOLUTIONS["P12b"]["low"]
    three = machine(engine_cylinders=3)
    assert [run_start(three, (low + side * ANGLE) * DEGREE).starts for side in (-1.0, 1.0)] == [False, True]


def test_load_step():
    stepped = run(machine(**fan()), 30.0, 12.0, Course(loads=np.array([[5.0, 10.0]])))
    before, r = run(machine(**fan()), 30.0, 5.0), stepped.revolutions
    rpm, shaft = 60.0 / r["duration"], shaft_states(prepare(machine(), 0.0).p)
    k = int(np.searchsorted(r["start"] + r["duration"], 5.0))
    values = {
        "speed_at_step_rpm": before.y[shaft + SPEED] / RPM,
        "turns_at_step": before.turns,
        "mean_before": rpm[k - 1],
        "lowest_rpm": r["min_speed"][k:].min() / RPM,
        "mean_end": rpm[-1],
        "min_end": r["min_speed"][-1] / RPM,
        "max_end": r["max_speed"][-1] / RPM,
        "air_end_g": r["engine_air"][-1] * 1e3,
        "speed_at_end_rpm": stepped.y[shaft + SPEED] / RPM,
        "turns_at_end": stepped.turns,
    }
    agree("P13", values | {f"rev_after_1to3.{i}": rpm[k + 1 + i] for i in range(3)})


def lead(*rows):
    """Schedules of one cylinder from rows of speed [r/min], energise and release [deg]."""
    return [np.array([[rpm * RPM, energise * DEGREE, release * DEGREE] for rpm, energise, release in rows])]


def constant_times(rpm):
    """Command angles [deg] of the schedule of constant lead times."""
    return rpm, -5.0 - 0.036 * rpm, 70.0 - 0.054 * rpm


RAMPS = {
    "P14": (),
    "P15": lead(constant_times(0.0), constant_times(2500.0)),
    "P15b": lead(constant_times(0.0), (*constant_times(FLOOR)[:2], 7.36), (*constant_times(2500.0)[:2], 22.0)),
}


@pytest.mark.parametrize("row", RAMPS)
def test_ramp(row):
    p = prepare(machine(), 0.0).p
    ramp = run(machine(), 0.0, 3.0, Course(speeds=RAMP, schedules=RAMPS[row]))
    ledger, (engine, control), r = ramp.y[shaft_ledger(p) :], air_of(p, ramp.y), ramp.revolutions
    values = {
        "turns": ramp.turns,
        "work_J": ledger[GAS_WORK],
        "friction_J": ledger[FRICTION_WORK],
        "air_g": engine.sum() * 1e3,
        "control_g": control.sum() * 1e3,
    }
    for k in range(len(r["start"])):
        values |= {f"rev{k}.rpm": 60.0 / r["duration"][k], f"rev{k}.torque": r["gas_work"][k] / TURN}
        values[f"rev{k}.air_g"] = r["engine_air"][k] * 1e3
    agree(row, values)


def test_scattered_dead_times():
    speeds = np.array([[0.0, 1000.0 * RPM], [10.0, 1000.0 * RPM]])
    deviations = np.array([[0.15, -0.10, 0.05, -0.20, 0.0, 0.10]]) * 1e-3
    r = run(machine(), 0.0, 64.0 * 60.0 / 1000.0, Course(speeds=speeds, deviations=deviations)).revolutions
    values = {"mean": r["gas_work"][60:63].mean() / TURN}
    for k in range(3):
        values |= {f"torque3.{k}": r["gas_work"][60 + k] / TURN, f"air3_g.{k}": r["engine_air"][60 + k] * 1e3}
    agree("P18", values)
