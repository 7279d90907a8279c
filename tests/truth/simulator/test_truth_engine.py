"""The independent engine: it repeats the published solution, and the packages agree with it at random machines."""

from math import degrees, inf, radians

import numpy as np
import pytest

from apesim.engine.machine import Machine
from tests.acceptance.independent_simulator import ANGLE_ERROR, ERROR, engine_deviations, random_machine
from tests.machines import AMBIENT, RPM, agrees, changed, machine, reference
from tests.truth.simulator.engine import Engine
from tests.truth.simulator.periodic import opening_and_closing, periodic, results
from tests.truth.simulator.reading import engine_of
from tests.truth.simulator.terms import blow_by, wall_heat
from tests.truth.simulator.valve import Bench

ROWS = reference("reference-engine.csv")
QUICK = [row for row in ROWS if (row["case"], row["speed [rpm]"]) in {("epv", "1200"), ("cam", "1000")}]
VARIANTS = {
    "receiver 1 L": {"receiver_volume": 1e-3},
    "control air from it": {"control_from_receiver": True},
    "pin offset 5 mm": {"pin_offset": 5e-3},
    "wall heat 200 W/(m2 K) at 300 K": {"terms": (wall_heat(85e-3, 200.0, 300.0),)},
    "blow-by 0.5 mm2": {"terms": (blow_by(Bench(), 0.5e-6),)},
}
COLUMNS = {
    "indicated torque [N m]": ("indicated_torque", 1.0),
    "engine air [g/cycle]": ("engine_air", 1e3),
    "control air [g/cycle]": ("control_air", 1e3),
    "full open at [deg]": ("full_open", degrees(1.0)),
    "closed at [deg]": ("closed", degrees(1.0)),
    "opening seating speed [m/s]": ("opening_seating_speed", 1.0),
    "closing seating speed [m/s]": ("closing_seating_speed", 1.0),
    "peak lift [mm]": ("peak_lift", 1e3),
    "peak cylinder pressure [kPa abs]": ("peak_cylinder_pressure", 1e-3),
}
OF_THE_VALVE = set(COLUMNS) - {"indicated torque [N m]", "engine air [g/cycle]", "peak cylinder pressure [kPa abs]"}


def engine_of_row(row):
    intake, *variants = row["case"].split("; ")
    values = {"receiver_volume": inf} | {name: v for variant in variants for name, v in VARIANTS[variant].items()}
    valve = Bench(AMBIENT + 1e6 * float(row["supply [MPa gauge]"]), terms=values.pop("terms", ()))
    command = (radians(float(row[name])) for name in ("energise [deg]", "release [deg]"))
    return Engine(valve, intake, None, values.pop("control_from_receiver", False), *command)._replace(**values)


def assert_repeats(row):
    run = periodic(engine_of_row(row), float(row["speed [rpm]"]) * RPM)
    assert run.converged
    found, wrong = results(run), {}
    for column, (name, factor) in COLUMNS.items():
        if column in OF_THE_VALVE and not row["case"].startswith("epv"):
            continue
        by = ANGLE_ERROR if "[deg]" in column else 0.0
        if not agrees(found[name] * factor, row[column], 0.0 if by else ERROR, by):
            wrong[column] = found[name] * factor, row[column]
    assert not wrong


@pytest.mark.parametrize("row", QUICK, ids=lambda row: f"{row['case']}, {row['speed [rpm]']} rpm")
def test_the_engine_repeats_the_published_solution(row):
    assert_repeats(row)


@pytest.mark.slow
@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row['case']}, {row['speed [rpm]']} rpm")
def test_the_engine_repeats_every_row_of_the_published_solution(row):
    assert_repeats(row)


def assert_agree(a_machine, rpm):
    assert engine_deviations(a_machine, rpm).beyond() == {}


def test_the_true_opening_and_closing_are_those_of_the_whole_engine():
    """A receiver that gives no control air does not act on the valve: it is left out, and changes nothing."""
    engine, speed, command = Engine(receiver_volume=0.2e-3), 800.0 * RPM, (radians(-40.0), radians(15.0))
    angles = opening_and_closing(engine, speed, *command)
    whole = results(periodic(engine._replace(energise=command[0], release=command[1]), speed))
    assert angles == pytest.approx((whole["opens"], whole["closes"]), abs=1e-7)
    assert radians(-10.0) < angles[0] < radians(20.0) < angles[1] < radians(80.0)


def test_control_air_from_the_receiver_moves_the_true_opening():
    regulated = Engine(receiver_volume=0.2e-3)
    command = 800.0 * RPM, regulated.energise, regulated.release
    own, fed = (opening_and_closing(regulated._replace(control_from_receiver=b), *command) for b in (False, True))
    assert abs(own[1] - fed[1]) > radians(0.01)


@pytest.mark.slow
def test_a_valve_that_never_lifts_through_the_lap_neither_opens_nor_closes():
    engine = Engine(receiver_volume=inf, release=radians(8.0))
    run = periodic(engine, 600.0 * RPM)
    assert run.converged
    assert 0.0 < results(run)["peak_lift"] < engine.lap
    assert np.isnan(opening_and_closing(engine, 600.0 * RPM, engine.energise, engine.release)).all()


def test_the_default_machine_is_the_default_here_too():
    assert engine_of(Machine()) == Engine(intake_pressure=Machine().supply.pressure)


@pytest.mark.parametrize(
    "name, value",
    [
        ("effects.cylinder_wall_heat.factor", 1.0),
        ("air.model", 1),
        ("groove.area_curve", np.array([[0.0, 0.0], [9e-3, 1e-4]])),
        ("valve.solenoid.opening_curve", np.array([[0.0, 0.0], [2e-3, 1.0]])),
    ],
)
def test_a_machine_with_something_unknown_here_is_refused(name, value):
    with pytest.raises(ValueError, match=name.removeprefix("effects.")):
        engine_of(changed(Machine(), {name: value}))


def test_the_compiled_engine_agrees_with_the_truth_at_a_random_machine():
    assert_agree(*random_machine(6))  # a valve with all effects, an offset, and no receiver, which takes long to settle


@pytest.mark.slow
def test_numbers_in_doubt_are_compared_with_a_truth_nearer_to_its_periodic_state():
    assert_agree(*random_machine(521))  # 3e-7 from it, a stroke that is hardly completed seats 3e-5 faster


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_the_compiled_engine_agrees_with_the_truth_at_random_machines(seed):
    assert_agree(*random_machine(seed))


@pytest.mark.slow
def test_the_compiled_engine_agrees_with_the_truth_where_small_volumes_follow_large_areas_slowly():
    """At 41 r/min explicit steps, held down by the receiver's and the clearance's filling, are two million a cycle."""
    values = {
        "ambient__temperature": 310.6,
        "engine__bore": 20e-3,
        "engine__stroke": 45e-3,
        "engine__rod_length": 83.3e-3,
        "engine__pin_offset": 0.6e-3,
        "engine__compression_ratio": 6.6,
        "groove__effective_area": 1894.1e-6,
        "groove__lap": 5.34e-3,
        "engine__exhaust__effective_area": 222e-6,
        "engine__receiver__feed_area": 387e-6,
    }
    supply = 0.556 - AMBIENT * 1e-6
    assert_agree(machine("epv", supply, 386.8, -96.3, 112.5, receiver=0.047, control_air="receiver", **values), 41.0)


def test_the_compiled_engine_agrees_with_the_truth_on_a_check_valve_that_holds_air_in_the_receiver():
    """The exhaust closes early: the piston compresses air above the supply, and pushes it back through the groove."""
    values = {"engine__exhaust__closes": radians(230.0), "engine__receiver__check_valve": 1}
    shut = machine("ideal", receiver=1.0, **values)
    assert_agree(shut, 1000.0)
    free = changed(shut, {"engine.receiver.check_valve": 0})
    higher, lower = (results(periodic(engine_of(each), 1000.0 * RPM))["indicated_torque"] for each in (shut, free))
    assert higher > 1.1 * lower


def test_the_compiled_engine_agrees_with_the_truth_on_every_effect_of_the_engine_at_once():
    strengths = {
        "intake_flow_force__area": 60e-6,
        "groove_area_error__share": 0.2,
        "seat_leak__area": 0.3e-6,
        "clearance_error__share": 0.05,
        "cylinder_wall_heat__h": 200.0,
        "blow_by__area": 0.4e-6,
        "exhaust_timing__angle": radians(4.0),
        "exhaust_restriction__share": 0.2,
        "exhaust_back_pressure__pressure": 15e3,
        "release_delay__time": 0.6e-3,
        "friction_torque__fmep": 20e3,
        "intake_pipe_loss__area": 150e-6,
    }
    assert_agree(machine(supply=0.8, **{f"effects__{name}": value for name, value in strengths.items()}), 900.0)
