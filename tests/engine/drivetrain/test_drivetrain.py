"""Drivetrains beside steady runs, and the closure of mass, energy and shaft over random transients."""

import numpy as np
import pytest

import apesim
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.drivetrain.closure import closure_of_run
from apesim.engine.drivetrain.corners import find_command, find_corner, pass_command, pass_corner
from apesim.engine.drivetrain.preparing import Course, prepare
from apesim.engine.drivetrain.run import EventKind, run_drivetrain
from apesim.engine.drivetrain.state import (
    COMMAND_HIGH,
    COMMAND_LOW,
    CORNER,
    CORNER_HIGH,
    CORNER_LOW,
    ENERGISE,
    OWN_MODES,
    RELEASE,
)
from apesim.engine.steady import run_steady
from apesim.kernel import entry
from apesim.packed import packed, unpacked
from apesim.views import part_of
from tests.machines import RPM

CLOSED = 1e-9
EFFECTS = {
    "effects.blow_by.area": "1 mm^2",
    "effects.coulomb_friction.force": "10 N",
    "effects.intake_pipe_loss.area": "250 mm^2",
    "effects.intake_pipe_loss.volume": "200 cm^3",
    "effects.supply_droop.feed_area": "20 mm^2",
    "effects.supply_droop.volume": "100 cm^3",
}

SECOND_EXHAUST = {"engine.receiver.volume": "inf", "engine.exhaust_2.effective_area": "100 mm^2"}


def machine(**values):
    return apesim.Machine().with_(**values)


def at_speed(a_machine, rpm, revolutions=60):
    speeds = np.array([[0.0, rpm * RPM], [1e4, rpm * RPM]])
    return run_drivetrain(prepare(a_machine, 20.0 * DEGREE, Course(speeds=speeds)), revolutions * 60.0 / rpm)


@pytest.mark.parametrize(
    ("rpm", "values"),
    [
        (600.0, {}),
        (1400.0, {}),
        (1000.0, {"engine.intake": "cam"}),
        (1000.0, {"engine.intake": "ideal"}),
        (1000.0, {"supply.control_air": "receiver", "engine.pin_offset": "3 mm"}),
        pytest.param(800.0, EFFECTS, marks=pytest.mark.slow),  # each is a kind of march to compile
        pytest.param(1000.0, SECOND_EXHAUST, marks=pytest.mark.slow),
        (1000.0, {"engine.receiver.volume": "inf"}),
    ],
)
def test_one_cylinder_at_a_constant_speed_is_a_steady_run(rpm, values):
    a_machine = machine(**values)
    steady = apesim.run_engine(a_machine, speed=(rpm, "rpm"))
    row = {name: values[-1] for name, values in at_speed(a_machine, rpm).revolutions.items()}
    assert row["gas_work"] / TURN == pytest.approx(steady["indicated_torque"], rel=2e-6)
    assert row["engine_air"] == pytest.approx(steady["engine_air_kg_per_cycle"], rel=2e-6)
    assert (row["gas_work"] - row["friction_work"]) / TURN == pytest.approx(steady["brake_torque"], rel=3e-6)


def random_transient(seed):
    """A run of a random machine from within its first cylinder's window, so that it moves; most lift a hoist's load."""
    rng = np.random.default_rng(seed)
    hoist = seed % 4 != 0
    values = {
        "engine.cylinders": int(rng.integers(1, 4)),
        "shaft.inertia": (float(10.0 ** rng.uniform(-2.0, 0.0)), "kg m^2"),
        "engine.bore": (float(rng.uniform(60.0, 110.0)), "mm"),
        "engine.pin_offset": (float(rng.uniform(-5.0, 5.0)), "mm"),
        "supply.control_air": ["regulator", "receiver"][int(rng.integers(2))],
        "load.kind": "hoist" if hoist else "brake",
        "load.constant": (float(rng.uniform(60.0, 160.0) if hoist else rng.uniform(0.0, 10.0)), "N m"),
    }
    start = prepare(machine(**values), float(rng.uniform(10.0, 60.0)) * DEGREE)
    return start, run_drivetrain(start, float(rng.uniform(0.2, 0.5)))


def close(seeds):
    """The largest closures of random transients, and how many of them reverse."""
    worst, reversals = np.zeros(3), 0
    for seed in seeds:
        start, run = random_transient(seed)
        worst = np.maximum(worst, closure_of_run(start, run.y))
        reversals += any(event.kind in (EventKind.HALT, EventKind.REST) for event in run.events)
    return worst, reversals


def test_random_transients_close():
    worst, reversals = close(range(16))
    assert worst.max() < CLOSED
    assert reversals > 0


@pytest.mark.slow
def test_many_random_transients_close():
    worst, reversals = close(range(1000, 1300))
    print("closure of mass, energy, shaft:", worst, "reversals:", reversals)
    assert worst.max() < CLOSED
    assert reversals > 100


def test_two_stages_close():
    stages = machine(
        **{
            "stage_2.bore": "120 mm",
            "stage_2.groove.effective_area": "300 mm^2",
            "inter_receiver.effectiveness": 0.8,
            "inter_receiver.wall_conductance": "5 W/K",
        }
    )
    start = prepare(stages, 30.0 * DEGREE)
    assert max(closure_of_run(start, run_drivetrain(start, 0.5).y)) < CLOSED


def test_corners_that_are_passed_both_ways_lead_back():
    corners = np.array([0.0, 1.0, 3.0])
    mode = np.zeros(OWN_MODES)
    find_corner(corners, TURN + 0.5, mode)
    assert mode[[CORNER, CORNER_LOW, CORNER_HIGH]].tolist() == pytest.approx([0.0, TURN, TURN + 1.0])
    forward = [pass_corner(corners, True, mode) for _ in range(4)]
    assert forward == [1, 2, 0, 1]
    assert mode[[CORNER_LOW, CORNER_HIGH]].tolist() == pytest.approx([2.0 * TURN + 1.0, 2.0 * TURN + 3.0])
    backward = [pass_corner(corners, False, mode) for _ in range(5)]
    assert backward == [1, 0, 2, 1, 0]
    assert mode[[CORNER, CORNER_LOW, CORNER_HIGH]].tolist() == pytest.approx([2.0, 3.0, TURN])


def test_a_command_holds_in_an_interval_to_both_sides():
    mode = np.zeros(OWN_MODES)
    mode[ENERGISE], mode[RELEASE] = -0.1, 1.2
    assert find_command(TURN + 0.5, mode)
    assert mode[[COMMAND_LOW, COMMAND_HIGH]].tolist() == pytest.approx([TURN - 0.1, TURN + 1.2])
    pass_command(True, mode)
    assert mode[[COMMAND_LOW, COMMAND_HIGH]].tolist() == pytest.approx([TURN + 1.2, 2.0 * TURN - 0.1])
    pass_command(False, mode)
    pass_command(False, mode)
    assert mode[[COMMAND_LOW, COMMAND_HIGH]].tolist() == pytest.approx([1.2, TURN - 0.1])
    assert not find_command(1.2, mode)


@entry
def sum_of(template, rows, index):
    first, (second, _) = unpacked(template, rows, index)
    return first + 10.0 * second


block_of = part_of(2, 2)


@entry
def last_of(array, index):
    part = block_of(array, index)
    part[0] = -1.0
    return part[1]


def test_packed_tuples_and_views_are_in_kernels_what_they_are_in_python():
    tuples = [(1.5, (2, None)), (0.5, (4, None))]
    rows, array = packed(tuples), np.arange(6.0)
    assert [sum_of(tuples[0], rows, i) for i in range(2)] == [21.5, 40.5]
    assert [unpacked(tuples[0], rows, i) for i in range(2)] == tuples
    assert last_of(array, 1) == 3.0 and array[2] == -1.0


def test_a_steady_run_still_refuses_several_cylinders():
    with pytest.raises(apesim.InputError, match=r"engine\.cylinders"):
        run_steady(machine(engine_cylinders=2), 100.0)
