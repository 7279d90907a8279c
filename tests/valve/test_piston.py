import pytest
from hypothesis import given
from hypothesis import strategies as st

from apesim.valve.piston import (
    HELD_CLOSED,
    HELD_OPEN,
    REST_SPEED,
    STUCK,
    TO_CLOSED,
    TO_OPEN,
    Valve,
    dry_friction_force,
    is_moving,
    land,
    overcome,
    smooth_force,
    start_moving,
    volume_a,
    volume_b,
)

VALVE = Valve()
MIDDLE = VALVE.stroke / 2.0


def test_positive_forces_push_to_closed():
    assert smooth_force(VALVE, MIDDLE, 0.0, 6e5, 5e5) == pytest.approx(1e5 * 1134.1e-6)
    assert smooth_force(VALVE, MIDDLE, 0.0, 5e5, 6e5) == pytest.approx(-1e5 * 1134.1e-6)


def test_the_springs_push_to_the_middle_and_friction_against_the_motion():
    assert smooth_force(VALVE, 0.0, 0.0, 5e5, 5e5) == pytest.approx(1828.0 * 9e-3)
    assert smooth_force(VALVE, VALVE.stroke, 0.0, 5e5, 5e5) == pytest.approx(-1828.0 * 9e-3)
    assert smooth_force(VALVE, MIDDLE, 2.0, 5e5, 5e5) == pytest.approx(-2.0 * 111.08)


@given(st.floats(0.0, 9e-3), st.floats(-3.0, 3.0), st.floats(1e5, 2e6), st.floats(1e5, 2e6))
def test_the_force_is_antisymmetric_about_the_middle(position, speed, p_a, p_b):
    # The largest term is 2e6 Pa times the area, 2268 N, rounded at 1e-16 of it; of the positions, at 1e-18 m.
    mirrored = smooth_force(VALVE, VALVE.stroke - position, -speed, p_b, p_a)
    assert smooth_force(VALVE, position, speed, p_a, p_b) == pytest.approx(-mirrored, abs=1e-11)


def test_chamber_a_grows_towards_closed_at_the_expense_of_b():
    assert volume_a(VALVE, 0.0) == volume_b(VALVE, VALVE.stroke) == VALVE.clearance_volume
    for position in (0.0, 2e-3, 9e-3):
        total = 2.0 * VALVE.clearance_volume + VALVE.piston_area * VALVE.stroke
        assert volume_a(VALVE, position) + volume_b(VALVE, position) == pytest.approx(total, rel=1e-15)
    assert volume_a(VALVE, 9e-3) - volume_a(VALVE, 0.0) == pytest.approx(1134.1e-6 * 9e-3)


def test_the_sign_of_a_moving_phase_is_that_of_its_speed():
    assert (TO_CLOSED, TO_OPEN) == (1, -1)
    assert [is_moving(phase) for phase in (HELD_CLOSED, TO_CLOSED, STUCK, TO_OPEN, HELD_OPEN)] == [
        False,
        True,
        False,
        True,
        False,
    ]


def test_dry_friction_acts_against_the_motion_and_not_at_rest():
    assert dry_friction_force(TO_CLOSED, 3.0) == -3.0
    assert dry_friction_force(TO_OPEN, 3.0) == 3.0
    assert [dry_friction_force(phase, 3.0) for phase in (HELD_CLOSED, STUCK, HELD_OPEN)] == [0.0, 0.0, 0.0]


@given(st.floats(-50.0, 50.0), st.floats(0.0, 50.0))
def test_a_piston_leaves_a_stop_one_way_and_gets_unstuck_both_ways(force, breakaway):
    assert (overcome(HELD_CLOSED, force, breakaway) > 0.0) == (force < -breakaway)
    assert (overcome(HELD_OPEN, force, breakaway) > 0.0) == (force > breakaway)
    assert (overcome(STUCK, force, breakaway) > 0.0) == (abs(force) > breakaway)


def test_a_piston_starts_the_way_it_is_pushed():
    assert start_moving(HELD_CLOSED, -1.0) == TO_OPEN
    assert start_moving(HELD_OPEN, 1.0) == TO_CLOSED
    assert start_moving(STUCK, 1.0) == TO_CLOSED
    assert start_moving(STUCK, -1.0) == TO_OPEN


def test_a_stop_gives_back_its_share_of_the_speed():
    assert land(HELD_OPEN, -2.0, 0.3) == (pytest.approx(0.6), TO_CLOSED)
    assert land(HELD_CLOSED, 2.0, 0.3) == (pytest.approx(-0.6), TO_OPEN)


def test_a_stop_without_restitution_or_with_a_slow_rebound_holds():
    assert land(HELD_OPEN, -2.0, 0.0) == (0.0, HELD_OPEN)
    assert land(HELD_CLOSED, 0.99 * REST_SPEED / 0.5, 0.5) == (0.0, HELD_CLOSED)
    assert land(HELD_CLOSED, 1.01 * REST_SPEED / 0.5, 0.5)[1] == TO_OPEN
