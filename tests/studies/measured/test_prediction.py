"""What sensors would have shown of a run, against an independent simulator, and as fast from a start near by."""

import numpy as np
import pytest

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cycle.operating_point import cycle_of
from apesim.engine.steady import known_state, run_steady
from apesim.studies.estimation.engine_starts import Starts
from apesim.studies.measured import MeasuredRun
from apesim.studies.measured.prediction import exhaust_marks, predict, run_of, start_of, with_value
from apesim.valve.bench import run_bench
from tests.machines import AMBIENT, RPM, changed, machine
from tests.truth.simulator.engine import CYLINDER_PRESSURE, Engine
from tests.truth.simulator.periodic import periodic, results
from tests.truth.simulator.valve import POSITION, PRESSURE_A, PRESSURE_B, Bench, simulate

RANDOM = np.random.default_rng(1)
TIMES = np.sort(RANDOM.uniform(-5e-3, 0.1, 3000))
ANGLES = np.sort(RANDOM.uniform(-180.0, 540.0, 500)) * DEGREE
ENERGISE, RELEASE = -5.0 * DEGREE, 70.0 * DEGREE
PREDICTED = ("cylinder_pressure", "lift", "pressure_a", "pressure_b", "receiver_pressure", "torque", "air_flow")
ALIKE = 1e-6
"""Relative, whatever the march to the periodic state started from."""


def valve_run(supply=0.4, times=TIMES, **channels):
    return MeasuredRun("a", "a.csv", AMBIENT + supply * 1e6, 287.0, 50e-3, "fit", times, channels)


def engine_run(rpm=1000.0, supply=1.0, angles=ANGLES, means=("torque", "air_flow")):
    speed = rpm * RPM
    return MeasuredRun(
        "a",
        "a.csv",
        AMBIENT + supply * 1e6,
        287.0,
        np.nan,
        "fit",
        (angles - ENERGISE) / speed,
        {},
        "engine",
        speed,
        ENERGISE,
        RELEASE,
        angles,
        dict.fromkeys(means, 0.0),
    )


# --- a machine of a run ---


def test_a_value_is_set_at_its_key():
    assert with_value(machine(), "valve.solenoid.dead_time", 1e-3).valve.solenoid.dead_time == 1e-3


def test_the_supply_of_a_run_is_that_of_the_control_air_too():
    at = run_of(machine(supply__control_pressure=0.9e6), valve_run())
    assert at.supply.control() == (AMBIENT + 0.4e6, 287.0)


def test_the_command_of_an_engines_run_is_taken_over_and_a_valves_has_none():
    base = machine(energise=-30.0, release=20.0)
    assert run_of(base, engine_run()).command[:2] == (ENERGISE, RELEASE)
    assert run_of(base, valve_run()).command == base.command


# --- the valve's bench ---


def test_a_valves_prediction_is_the_independent_simulators_at_the_very_times():
    run = valve_run()
    at = run_of(machine(), run)
    found = predict(at, run, ["lift", "pressure_a", "pressure_b"])
    true = simulate(Bench(run.supply), 50e-3, 0.1)
    states = true.states(np.maximum(TIMES, 0.0))
    assert not found.failed
    assert np.abs(found.channels["lift"] - (9e-3 - states[POSITION])).max() < 1e-8
    assert np.abs(found.channels["pressure_a"] - states[PRESSURE_A]).max() < 1.0
    assert np.abs(found.channels["pressure_b"] - states[PRESSURE_B]).max() < 1.0
    assert found.channels["lift"].max() == run_bench(at, 50e-3).trace[:, 0].max()


def test_a_valves_marks_are_its_command_starts_and_contacts():
    run = valve_run()
    found, true = predict(run_of(machine(), run), run, []), simulate(Bench(run.supply), 50e-3, 0.1)
    begins = true.opening.delay, 50e-3 + true.closing.delay
    assert found.channels == found.means == {}
    assert found.marks == pytest.approx(
        {
            "energise": 0.0,
            "release": 50e-3,
            "opening_start": begins[0],
            "opening_contact": begins[0] + true.opening.stroke_time,
            "closing_start": begins[1],
            "closing_contact": begins[1] + true.closing.stroke_time,
        },
        abs=1e-7,
    )


def test_a_valve_that_does_not_close_within_the_record_has_no_mark_of_it():
    marks = predict(run_of(machine(), valve_run()), valve_run(times=TIMES[TIMES < 56e-3]), ["lift"]).marks
    assert not np.isnan(marks["opening_contact"])
    assert np.isnan(marks["closing_contact"])


def test_the_channels_of_a_run_are_predicted_if_none_are_named():
    run = valve_run(lift=TIMES, temperature_a=TIMES)
    assert predict(run_of(machine(), run), run).channels.keys() == {"lift", "temperature_a"}


def test_a_march_that_fails_is_told_and_shows_nothing():
    run = valve_run()
    at = run_of(machine(valve__clearance_volume=1e-14, valve__solenoid__effective_area=1.0), run)
    found = predict(at, run, ["lift"])
    assert found.failed
    assert np.all(np.isnan(found.channels["lift"]))


# --- the engine's ---


@pytest.fixture(scope="module")
def truth():
    return periodic(Engine(), 1000.0 * RPM)


def test_an_engines_prediction_is_the_independent_simulators_at_the_very_angles(truth):
    run = engine_run()
    found = predict(run_of(machine(receiver=1.0), run), run, PREDICTED)
    states = truth.march.states(ENERGISE + (ANGLES - ENERGISE) % TURN)
    values = results(truth)
    air = (values["engine_air"] + values["control_air"]) * run.speed / TURN
    assert not found.failed
    assert np.abs(found.channels["lift"] - (9e-3 - states[POSITION])).max() < 1e-7
    for name, row in (("cylinder_pressure", CYLINDER_PRESSURE), ("pressure_a", PRESSURE_A), ("pressure_b", PRESSURE_B)):
        assert found.channels[name] == pytest.approx(states[row], rel=1e-4)
    assert found.means["torque"] == pytest.approx(values["brake_torque"], rel=2e-5)
    assert found.means["air_flow"] == pytest.approx(air, rel=2e-5)


def test_an_engines_marks_are_its_valves(truth):
    run = engine_run()
    marks, values = predict(run_of(machine(receiver=1.0), run), run, []).marks, results(truth)
    named = {
        "groove_opens": "opens",
        "groove_closes": "closes",
        "opening_contact": "full_open",
        "closing_contact": "closed",
    }
    for mark, name in named.items():
        assert marks[mark] == pytest.approx((values[name] - ENERGISE) / run.speed, abs=1e-7)
    assert marks["release"] == pytest.approx(75.0 / 6000.0)
    assert marks["exhaust_opens"] == pytest.approx(170.0 / 6000.0)
    assert marks["exhaust_closes"] == pytest.approx(345.0 / 6000.0)
    assert 0.0 < marks["opening_start"] < marks["groove_opens"]
    assert marks["release"] < marks["closing_start"] < marks["groove_closes"]


@pytest.mark.parametrize(
    ("window", "opens", "closes"),
    [((150.0, 330.0), 150.0, 340.0), ((180.0, 350.0), 165.0, 350.0), ((200.0, 320.0), 165.0, 340.0)],
)
def test_the_exhaust_lasts_from_the_first_valves_opening_to_the_last_ones_closing(window, opens, closes):
    run = engine_run()
    keys = {"effective_area": (200.0, "mm^2"), "opens": (window[0], "deg"), "closes": (window[1], "deg")}
    two = machine(receiver=1.0).with_(**{f"engine.exhaust_2.{key}": value for key, value in keys.items()})
    cycle, _, _ = cycle_of(run_of(two, run), run.speed)
    marks = exhaust_marks(cycle)
    assert marks["exhaust_opens"] == pytest.approx((opens + 5.0) / 6000.0)
    assert marks["exhaust_closes"] == pytest.approx((closes + 5.0) / 6000.0)


def test_an_engine_with_a_cam_has_the_marks_of_its_groove():
    run = engine_run()
    marks = predict(run_of(machine("cam"), run), run, ["lift"]).marks
    assert marks["groove_opens"] < marks["opening_contact"] < marks["closing_contact"]
    assert np.isnan(marks["opening_start"])


def test_an_engines_means_need_no_trace():
    run = engine_run(angles=np.empty(0))
    at = run_of(machine(), run)
    found, whole = predict(at, run), predict(at, engine_run())
    assert (found.channels, found.means, found.marks) == ({}, whole.means, whole.marks)


def test_every_turn_is_alike():
    a, b = (predict(run_of(machine(), engine_run()), engine_run(angles=ANGLES + by), ["lift"]) for by in (0.0, TURN))
    np.testing.assert_allclose(a.channels["lift"], b.channels["lift"], atol=1e-11)


# --- from a known periodic state ---

CHANGES = [
    {"effects.coulomb_friction.force": 3.0},
    {"effects.cylinder_wall_heat.h": 100.0},
    {"effects.blow_by.area": 0.5e-6},
    {"effects.clearance_error.share": 0.04},
    {"supply.temperature": 290.0},
    {"engine.receiver.volume": 1.1e-3},
    {"valve.stroke": 9.05e-3},
]


@pytest.mark.parametrize("change", CHANGES, ids=[next(iter(change)) for change in CHANGES])
def test_a_start_near_by_changes_nothing_but_the_number_of_cycles(change):
    run = engine_run()
    base = run_of(machine(receiver=1.0), run)
    near, far = (predict(changed(base, change), run, PREDICTED, start) for start in (start_of(base, run), None))
    for name, values in far.channels.items():
        assert np.abs(near.channels[name] - values).max() <= ALIKE * np.abs(values).max()
    assert near.means == pytest.approx(far.means, rel=ALIKE)
    assert near.marks == pytest.approx(far.marks, rel=ALIKE)
    at = changed(base, change)
    known = run_steady(at, run.speed, start=known_state(base, run.speed))
    assert known.orbit.converged
    assert known.orbit.cycles < run_steady(at, run.speed).orbit.cycles


def test_a_valve_that_never_moves_stands_at_its_own_stop_whatever_the_start():
    base = machine(release=-4.0)
    run = run_steady(changed(base, {"valve.stroke": 9.05e-3}), 1000.0 * RPM, start=known_state(base, 1000.0 * RPM))
    assert run.orbit.converged
    assert np.all(run.trace[:, 2] == 0.0)


@pytest.mark.parametrize("way", [1, -1])
def test_a_start_with_other_volumes_is_left_for_rest(way):
    run = engine_run()
    plain = run_of(machine(receiver=1.0), run)
    piped = changed(plain, {"effects.intake_pipe_loss.area": 2e-4})
    base, at = (plain, piped)[::way]
    near, far = (predict(at, run, PREDICTED, start) for start in (start_of(base, run), None))
    assert not near.failed
    assert near.means == pytest.approx(far.means, rel=ALIKE)


@pytest.mark.parametrize("size", [(0.5e-3, 40e-6), (0.3e-3, 5e-6)], ids=["large", "slow"])
def test_a_start_follows_the_volume_of_a_supply_line(size):
    run = engine_run()
    base, at = (
        changed(run_of(machine(receiver=1.0), run), {f"effects.supply_droop.{name}": value for name, value in line})
        for line in (
            [("volume", 0.1e-3), ("feed_area", 25e-6)],
            [("volume", size[0]), ("feed_area", size[1])],
        )
    )
    found = run_steady(at, run.speed, start=Starts([base], [run]).near(0, at))
    assert found.orbit.converged
    assert found.orbit.cycles <= run_steady(at, run.speed).orbit.cycles


def test_a_start_far_away_is_left_for_rest():
    run = engine_run()
    start = start_of(run_of(machine(receiver=1.0), run), run)
    slow = engine_run(300.0, 0.3)
    at = run_of(machine(receiver=0.2, energise=-20.0), slow)
    found, plain = (predict(at, slow, PREDICTED, one) for one in (start, None))
    assert not plain.failed
    assert found.means == pytest.approx(plain.means, rel=ALIKE)


def test_the_start_of_a_valves_run_is_rest():
    assert start_of(run_of(machine(), valve_run()), valve_run()) is None


def test_an_engine_that_settles_to_two_cycles_is_no_start():
    a_machine = machine(supply=0.3, valve__viscous_friction=20.0, release=144.48, effects__bounce__restitution=0.9)
    assert known_state(a_machine, 2400.0 * RPM) is None
