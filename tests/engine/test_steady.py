"""The periodic state: reached from anywhere, stated with how periodic it is, and refused where it is not."""

from math import inf, isinf, isnan

import numpy as np
import pytest

from apesim.engine.angles import DEGREE
from apesim.engine.cycle.operating_point import accuracy_at, charged_at_rest, cycle_of
from apesim.engine.cycle.state import (
    CYLINDER,
    RECEIVER,
    SCALE,
    STATES,
    engine_ledger,
)
from apesim.engine.indicators import indicators
from apesim.engine.steady import known_state, run_steady
from apesim.march.adaptive import LOG_HEAD, NO_CARRY, TOLERANCE, march
from apesim.march.periodic import PERIODIC_TOLERANCE, distance, periodic_orbit
from apesim.valve.actuator import PHASE
from apesim.valve.piston import STUCK
from tests.machines import RPM, machine, settled

COARSE = 5.0 * DEGREE
ROUNDING = 1e-12


def orbit_from(change_start, a_machine, rpm):
    """The periodic state, from a start that a function of state and mode has changed."""
    p, tables, breakpoints = cycle_of(a_machine, rpm * RPM)
    y, mode = charged_at_rest(p)
    change_start(y)
    return periodic_orbit(p, tables, y, mode, breakpoints, accuracy_at(p))


def hot_and_full(y):
    """Five times the gas in the cylinder, half as hot again; the receiver at half its pressure; chamber A leaner."""
    y[CYLINDER] *= 5.0
    y[CYLINDER + 1] *= 7.5
    y[RECEIVER] *= 0.5
    y[RECEIVER + 1] *= 0.5
    y[2:4] *= 0.8


@pytest.mark.parametrize(
    ("rpm", "options"),
    [
        (800.0, {}),
        (800.0, {"receiver": 1.0}),
        (800.0, {"receiver": 1.0, "control_air": "receiver"}),
        (1200.0, {}),
        (1600.0, {}),
        (1000.0, {"intake": "cam"}),
        (1000.0, {"intake": "ideal"}),
    ],
)
@pytest.mark.compiled
def test_the_start_does_not_matter(rpm, options):
    a_machine = machine(**options)
    usual, other = (orbit_from(change, a_machine, rpm) for change in (lambda y: None, hot_and_full))
    assert usual.converged
    assert other.converged
    states = slice(0, STATES) if options.get("intake") is None else slice(6, STATES)
    assert distance(usual.y[states], other.y[states], np.array(SCALE)[states]) < 1e-6


def test_the_run_says_how_periodic_it_is():
    run = settled(machine(), 800.0)
    assert run.orbit.period == 1
    assert run.orbit.change <= PERIODIC_TOLERANCE
    assert distance(run.start, run.end, np.array(SCALE)) < 10.0 * TOLERANCE
    found = indicators(machine(), run)
    assert found["converged"] == 1
    assert found["period_cycles"] == 1
    assert found["cycles"] == run.orbit.cycles > 2
    assert found["periodic_change"] == run.orbit.change
    assert found["tolerance"] == TOLERANCE


@pytest.mark.parametrize("max_cycles", [1, 2, 3])
def test_too_few_cycles_are_not_called_converged(max_cycles):
    run = run_steady(machine(receiver=1.0), 800.0 * RPM, max_cycles=max_cycles)
    assert not run.orbit.converged
    assert run.orbit.period == 0
    assert run.orbit.cycles == max_cycles
    assert run.orbit.change > PERIODIC_TOLERANCE
    found = indicators(machine(receiver=1.0), run)
    assert found["converged"] == 0
    assert found["period_cycles"] == 0
    assert found["periodic_change"] == run.orbit.change


@pytest.mark.parametrize("rpm", [400.0, 800.0, 1200.0, 1600.0])
@pytest.mark.compiled
def test_the_work_is_sure_by_quadrature_and_by_another_tolerance(rpm):
    run = settled(machine(receiver=1.0), rpm)
    assert run.work_by_quadrature == pytest.approx(run.end[-1], rel=1e-6)
    assert 0.0 < run.work_change < 1e-5
    assert 0.0 < run.air_change < 1e-5


@pytest.mark.parametrize(("rpm", "exhaust_area"), [(800.0, 20e-6), (1500.0, 100e-6), (2300.0, 100e-6)])
@pytest.mark.compiled
def test_a_large_receiver_settles_where_it_should(rpm, exhaust_area):
    """A cycle exchanges some thousandth of the receiver's air, so what is left to go is a thousand times the change of
    a cycle: Newton's method has to help, and a drift must not be called periodic."""
    a_machine = machine(
        intake="ideal",
        receiver=10.0,
        targets=(0.0, 100.0),
        groove__effective_area=20e-6,
        engine__exhaust__effective_area=exhaust_area,
    )
    orbits = [orbit_from(change, a_machine, rpm) for change in (lambda y: None, hot_and_full)]
    assert all(orbit.converged for orbit in orbits)
    assert all(orbit.cycles < 300 for orbit in orbits)
    apart = distance(orbits[0].y[6:], orbits[1].y[6:], np.array(SCALE)[6:])
    assert apart < 2.0 * PERIODIC_TOLERANCE / 1e-3


@pytest.mark.compiled
def test_a_state_far_from_the_start_is_come_to_by_several_helps():
    """Found among random machines: the cylinder's gas has to fall to a fifth, by 0.3 % a cycle. A plain march comes to
    -113.6260 J in 9000 cycles."""
    a_machine = machine(
        intake="ideal",
        receiver=10.0,
        supply=2.898 - 0.101325,
        temperature=265.0,
        targets=(-56.4, -21.62),
        groove__effective_area=341.2e-6,
        engine__bore=64.36e-3,
        engine__stroke=134.65e-3,
        engine__rod_length=268.98e-3,
        engine__pin_offset=11.56e-3,
        engine__compression_ratio=27.37,
        engine__exhaust__effective_area=1336e-6,
        engine__exhaust__opens=152.3 * DEGREE,
        engine__exhaust__closes=282.0 * DEGREE,
    )
    run = settled(a_machine, 2114.8, angle_step=COARSE)
    assert run.end[-1] == pytest.approx(-113.6260, abs=2e-4)
    assert run.orbit.cycles < 200


OPERATING = [
    (rpm, energise, duration)
    for rpm in (100.0, 700.0, 2000.0, 4000.0)
    for energise in (-200.0, -41.0, 100.0)
    for duration in (20.0, 75.0, 200.0, 340.0)
]


@pytest.mark.parametrize(("rpm", "energise", "duration"), OPERATING)
@pytest.mark.compiled
def test_every_operating_point_has_results_that_are_finite_or_mean_something(rpm, energise, duration):
    """Among them releases followed only after the next energising, valves that never open or never close."""
    a_machine = machine(energise=energise, release=energise + duration)
    run = settled(a_machine, rpm, angle_step=COARSE)
    found = indicators(a_machine, run)
    assert not any(isinf(value) for value in found.values())
    stroke, lap, lift = a_machine.valve.stroke, a_machine.groove.lap, found["peak_lift_m"]
    undefined = {name for name, value in found.items() if isnan(value)}
    over_brake = {name for name in found if "efficiency" in name or name.startswith("specific")}
    of_strokes = {name for name in found if "seating" in name or "fluctuation" in name}
    at_angles = {"valve_open_deg", "valve_close_deg", "full_open_deg", "closed_deg"}
    assert (undefined >= over_brake) == (found["brake_torque_Nm"] <= 0.0)
    assert ("indicated_specific_air_kg_per_kWh" in undefined) == (found["indicated_torque_Nm"] <= 0.0)
    assert undefined <= over_brake | of_strokes | at_angles | {"indicated_specific_air_kg_per_kWh"}
    assert ("valve_open_deg" in undefined) == ("valve_close_deg" in undefined)
    assert ("full_open_deg" in undefined) == ("opening_seating_speed_m_s" in undefined)
    assert ("closed_deg" in undefined) == ("closing_seating_speed_m_s" in undefined)
    if lift < stroke * (1.0 - ROUNDING):
        assert "full_open_deg" in undefined
    if "valve_open_deg" in undefined:
        assert lift <= lap or run.trace[:, 2].min() > 0.0
    else:
        assert lift > lap
        assert found["valve_open_deg"] >= energise
        assert found["valve_close_deg"] > found["valve_open_deg"]


@pytest.mark.parametrize(("rpm", "energise", "duration"), OPERATING)
@pytest.mark.compiled
def test_the_piston_stays_between_its_stops(rpm, energise, duration):
    a_machine = machine(energise=energise, release=energise + duration)
    run = settled(a_machine, rpm, angle_step=COARSE)
    for lift in (run.trace[:, 2], a_machine.valve.stroke - run.log[:, 3]):
        assert lift.min() >= -1e-9
        assert lift.max() <= a_machine.valve.stroke + 1e-9


def test_a_solenoid_may_follow_its_release_after_the_next_energising():
    """At 3000 r/min, released 20 degrees before it: the ramp of 1.5 ms ends 34 degrees after it, and all repeats."""
    a_machine = machine(energise=-30.0, release=310.0)
    run = settled(a_machine, 3000.0, angle_step=COARSE)
    assert run.status == 0
    assert run.orbit.period in (1, 2)
    assert indicators(a_machine, run)["mass_closure"] < 1e-9


def test_a_finer_trace_changes_nothing_but_the_trace():
    fine, coarse = (settled(machine(), 800.0, angle_step=step * DEGREE) for step in (0.25, 1.0))
    assert np.array_equal(fine.end, coarse.end)
    assert np.array_equal(fine.log, coarse.log)
    assert np.array_equal(fine.trace[::4], coarse.trace)


def held_by_friction(supply, energise, duration, breakaway, **options):
    """A machine at so low a supply that friction holds its valve between the stops."""
    friction = {"effects__coulomb_friction__force": 5.0, "effects__coulomb_friction__breakaway": breakaway}
    return machine(supply=supply, energise=energise, release=energise + duration, **friction, **options)


@pytest.mark.compiled
def test_a_state_with_its_valve_held_is_no_start_where_less_friction_lets_it_go():
    rpm, options = 765.07031, {"effects__seal_friction__coefficient": 1e-5}
    commands = 0.03, 6.403413, 113.914435
    known = known_state(held_by_friction(*commands, 50.0, **options), rpm * RPM)
    assert known.mode[PHASE] == STUCK
    looser = held_by_friction(*commands, 38.599, **options)
    ledgers = [engine_ledger(run_steady(looser, rpm * RPM, start=start).end) for start in (known, None)]
    assert ledgers[0].work == pytest.approx(ledgers[1].work, rel=1e-6)


@pytest.mark.compiled
def test_a_start_with_its_valve_held_beyond_another_stroke_is_put_at_the_stop():
    rpm, options = 2124.0, {"effects__seal_friction__coefficient": 1e-6}
    commands = 0.03, -10.0, 64.3, 50.0
    known = known_state(held_by_friction(*commands, **options), rpm * RPM)
    assert known.mode[PHASE] == STUCK and known.y[0] > 8.5e-3
    shorter = held_by_friction(*commands, valve__stroke=8.5e-3, **options)
    run = run_steady(shorter, rpm * RPM, start=known)
    assert run.orbit.converged and run.start[0] == run.end[0] <= 8.5e-3
    assert indicators(shorter, run)["exergy_closure"] < 1e-6


def test_infinite_receiver_keeps_its_pressure():
    run = settled(machine(receiver=inf), 800.0, angle_step=COARSE)
    assert np.all(run.trace[:, 8] == 1.101325e6)
    assert indicators(machine(), run)["intake_pressure_fluctuation_Pa"] == 0.0


@pytest.mark.parametrize(("restitution", "period"), [(0.9, 2), (0.95, 3)])
@pytest.mark.compiled
def test_work_and_air_of_a_state_that_repeats_after_some_cycles_are_their_mean(restitution, period):
    """A valve that bounces, hardly damped, at 2400 r/min."""
    bounce = {"effects__bounce__restitution": restitution}
    a_machine = machine(supply=0.3, valve__viscous_friction=20.0, release=144.48, **bounce)
    run = run_steady(a_machine, 2400.0 * RPM)
    assert (run.orbit.converged, run.orbit.period) == (True, period)
    p, tables, breakpoints = cycle_of(a_machine, 2400.0 * RPM)
    y, mode, cycles = run.orbit.y.copy(), run.orbit.mode.copy(), []
    for _ in range(period):
        y[STATES:] = 0.0
        nothing = np.empty((0, LOG_HEAD + STATES)), np.empty(0), np.empty((0, 0)), NO_CARRY
        march(p, tables, 0.0, y, mode, breakpoints, accuracy_at(p), *nothing)
        cycles.append(y[STATES:].copy())
    assert abs(cycles[1][-1] / cycles[0][-1] - 1.0) > 1e-4
    assert run.end[STATES:] == pytest.approx(np.mean(cycles, axis=0), rel=1e-6)
    found = indicators(a_machine, run)
    assert found["period_cycles"] == period
    assert max(found["mass_closure"], found["energy_closure"]) < 1e-11
    assert found["exergy_closure"] < 1e-7


def test_the_trace_may_begin_anywhere_in_the_cycle():
    given = machine()
    whole = run_steady(given, 800.0 * RPM, angle_step=0.1 * DEGREE)
    shifted = run_steady(given, 800.0 * RPM, angle_step=0.5 * DEGREE, trace_start=0.3 * DEGREE)
    np.testing.assert_allclose(shifted.angles[0] - whole.angles[0], 0.3 * DEGREE, rtol=1e-12)
    np.testing.assert_allclose(shifted.trace[:720], whole.trace[3::5], rtol=1e-9, atol=1e-12)
