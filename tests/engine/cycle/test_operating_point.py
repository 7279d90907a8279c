"""What the march is told of a machine at a speed: where its smooth stretches end, and where it starts."""

from math import inf, pi

import numpy as np
import pytest

from apesim.engine.angles import DEGREE
from apesim.engine.cam import cam_corners
from apesim.engine.cycle.operating_point import NOT_HELD, accuracy_at, charged_at_rest, cycle_of, with_exergy
from apesim.engine.cycle.state import CYLINDER, RECEIVER, SIZE
from apesim.engine.exergy import RATES
from apesim.engine.kinematics import cylinder_volume
from apesim.valve.actuator import PHASE
from apesim.valve.piston import HELD_CLOSED
from tests.machines import AMBIENT, RPM, machine

EXHAUST = (165.0, 190.0, 315.0, 340.0)


def breakpoints_in_degrees(a_machine, rpm):
    p, _, breakpoints = cycle_of(a_machine, rpm * RPM)
    return (p.start + p.speed * breakpoints) / DEGREE


def degrees_of(milliseconds, rpm):
    return milliseconds * 1e-3 * rpm * 6.0


def test_a_cycle_begins_at_the_energising_and_ends_a_turn_later():
    p, _, breakpoints = cycle_of(machine(energise=-41.0), 1000.0 * RPM)
    assert p.start == -41.0 * DEGREE
    assert breakpoints[-1] == pytest.approx(60e-3, rel=1e-14)
    assert np.all(np.diff(breakpoints) > 0.0)
    assert breakpoints[0] > 0.0


def test_breakpoints_of_an_epv_are_both_edges_of_the_solenoids_and_the_exhaust_valve_s_corners():
    """Dead time and end of ramp, 1.5 and 3 ms after -5 and 70 degrees; the release itself; 600 r/min."""
    solenoids = [edge + degrees_of(lag, 600.0) for edge in (-5.0, 70.0) for lag in (0.0, 1.5, 3.0)][1:]
    assert breakpoints_in_degrees(machine(), 600.0) == pytest.approx(sorted([*solenoids, *EXHAUST, 355.0]), abs=1e-9)


def test_breakpoints_of_a_solenoid_that_follows_after_the_next_energising_are_wrapped_into_the_cycle():
    """Released 20 degrees before the next energising at 3000 r/min: 1.5 ms are 27 degrees, 3 ms are 54."""
    found = breakpoints_in_degrees(machine(energise=-30.0, release=310.0), 3000.0)
    expected = [-30.0 + 7.0, -30.0 + 27.0, -30.0 + 34.0, -30.0 + 54.0, *EXHAUST[:3], 340.0 - 360.0, 310.0, 330.0]
    assert found == pytest.approx(sorted(expected), abs=1e-9)


def test_breakpoints_of_a_cam_are_its_corners_and_where_it_passes_the_lap():
    a_machine = machine(intake="cam")
    cam = cam_corners(a_machine.engine.cam.resolve_lift(9e-3), np.array([1e-3, 9e-3])) / DEGREE
    assert len(cam) == 6
    expected = {round(angle, 6) for angle in [*cam, *EXHAUST, 355.0]} - {-5.0}
    assert breakpoints_in_degrees(a_machine, 1000.0) == pytest.approx(sorted(expected), abs=2e-6)


def test_breakpoints_of_a_lift_curve_are_its_rows_and_where_it_passes_the_lap():
    curve = np.array([[-35.0, 0.0], [-15.0, 2e-3], [25.0, 8e-3], [55.0, 8e-3], [95.0, 0.0]]) * [DEGREE, 1.0]
    a_machine = machine(intake="cam", engine__cam__lift_curve=curve)
    expected = sorted([25.0, 55.0, 90.0, 95.0, *EXHAUST, 325.0, 335.0, 345.0, 355.0])
    assert breakpoints_in_degrees(a_machine, 1000.0) == pytest.approx(expected, abs=1e-9)


def test_breakpoints_of_the_ideal_valve_are_its_targets():
    a_machine = machine(intake="ideal", energise=-41.0, targets=(-5.0, 70.0))
    expected = [340.0 - 360.0, -5.0, 70.0, *EXHAUST[:3], 319.0]
    assert breakpoints_in_degrees(a_machine, 1000.0) == pytest.approx(expected, abs=1e-9)


def test_the_start_is_at_rest_with_the_cylinder_at_ambient_and_the_receiver_at_supply():
    a_machine = machine(receiver=2.0, supply=0.7, temperature=280.0)
    p, _, _ = cycle_of(a_machine, 1000.0 * RPM)
    y, mode = charged_at_rest(p)
    assert y.shape == (SIZE,)
    assert mode[PHASE] == HELD_CLOSED
    assert (y[0], y[1]) == (9e-3, 0.0)
    volume = cylinder_volume(p.crank, p.start)[0]
    assert y[CYLINDER] == pytest.approx(AMBIENT * volume / (287.05 * 293.15), rel=1e-14)
    assert y[CYLINDER + 1] == pytest.approx(AMBIENT * volume / 0.4, rel=1e-14)
    assert y[RECEIVER] == pytest.approx((0.7e6 + AMBIENT) * 2e-3 / (287.05 * 280.0), rel=1e-14)
    assert y[RECEIVER + 1] == pytest.approx((0.7e6 + AMBIENT) * 2e-3 / 0.4, rel=1e-14)
    assert not y[10:].any()


def test_an_infinite_receiver_is_none():
    p, _, _ = cycle_of(machine(receiver=inf), 1000.0 * RPM)
    assert p.receiver_volume == 0.0
    assert not charged_at_rest(p)[0][RECEIVER]


def test_control_air_has_its_own_pressure_where_one_is_given():
    p, _, _ = cycle_of(machine(supply__control_pressure=0.5e6), 1000.0 * RPM)
    assert p.control == (0.5e6, 287.0)
    assert p.supply == (1.101325e6, 287.0)


@pytest.mark.parametrize(("supply", "higher"), [(0.7, 0.7e6 + AMBIENT), (-0.05, AMBIENT)], ids=["pressure", "suction"])
def test_exergy_is_held_to_a_hundredth_of_what_the_higher_pressure_would_do_over_the_swept_volume(supply, higher):
    p, _, _ = cycle_of(machine(supply=supply), 1000.0 * RPM)
    usual = accuracy_at(p)
    accuracy = with_exergy(p, usual)
    held = len(usual.scale)
    assert accuracy.max_step == usual.max_step
    sum_of_squares = len(accuracy.scale) * accuracy.tolerance**2  # which an error of a step is the mean of
    assert sum_of_squares == pytest.approx(held * usual.tolerance**2, rel=1e-12), "states are held as without it"
    assert np.array_equal(accuracy.scale[:held], usual.scale)
    assert np.all(accuracy.scale[held:SIZE] == NOT_HELD)
    swept = 0.25 * pi * p.engine.bore**2 * p.engine.stroke
    assert accuracy.scale[SIZE:] == pytest.approx(np.full(RATES, 0.01 * higher * swept), rel=1e-12)
