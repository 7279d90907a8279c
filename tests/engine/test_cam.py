"""Windows with flanks, against a twin that is written as one would say it, and the corners the march must meet."""

from math import cos, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cam import (
    MAX_ROWS,
    Cam,
    cam_angles,
    cam_corners,
    lift_crossings,
    lift_line,
    raised_cosine,
    window_corners,
    within_turn,
)
from apesim.engine.exhaust import Exhaust

ANGLES = st.floats(-720.0, 1080.0).map(lambda degrees: degrees * DEGREE)


def plain_raised_cosine(angle, opens, closes, flank):
    """The twin: the remainder operator, one case for each part of the window."""
    duration, since = (closes - opens) % TURN, (angle - opens) % TURN
    if since >= duration:
        return 0.0
    if since < flank:
        return (1.0 - cos(pi * since / flank)) / 2.0
    if since > duration - flank:
        return (1.0 - cos(pi * (duration - since) / flank)) / 2.0
    return 1.0


@st.composite
def windows(draw):
    """Window of 20 to 350 degrees that opens anywhere, with flanks that fit in."""
    opens, duration = draw(st.floats(-360.0, 360.0)), draw(st.floats(20.0, 350.0))
    return opens * DEGREE, (opens + duration) * DEGREE, draw(st.floats(0.1, 0.5)) * duration * DEGREE


@given(windows(), ANGLES)
def test_raised_cosine_is_its_plain_twin(window, angle):
    """Rounding of the remainder moves the angle by 1e-15; flanks are no steeper than pi/2 over 2 degrees."""
    assert raised_cosine(angle, *window) == pytest.approx(plain_raised_cosine(angle, *window), abs=1e-11)


def test_raised_cosine_is_its_plain_twin_all_around():
    window = Exhaust()[1:]
    for angle in np.arange(-30.0, 400.0, 0.05) * DEGREE:
        assert raised_cosine(angle, *window) == pytest.approx(plain_raised_cosine(angle, *window), abs=1e-11)


@given(ANGLES)
def test_an_angle_is_brought_into_one_turn(angle):
    inside = within_turn(angle)
    assert 0.0 <= inside <= TURN
    assert cos(inside) == pytest.approx(cos(angle), abs=1e-14)


def test_a_window_may_span_zero_degrees():
    """From 350 to 40 degrees: fully open at 15, half up its flank at 0, closed at 180."""
    window = np.array([350.0, 40.0, 20.0]) * DEGREE
    share = [raised_cosine(angle * DEGREE, *window) for angle in (-10.0, 0.0, 15.0, 360.0, 375.0, 30.0, 40.0, 180.0)]
    assert share == pytest.approx([0.0, 0.5, 1.0, 0.5, 1.0, 0.5, 0.0, 0.0], abs=1e-12)


def test_flanks_lie_inside_the_window():
    exhaust = Exhaust()
    middle_of_flanks = (165.0 + 12.5, 340.0 - 12.5)
    for angle in middle_of_flanks:
        share = raised_cosine(angle * DEGREE, exhaust.opens, exhaust.closes, exhaust.flank)
        assert share == pytest.approx(0.5, abs=1e-12)
    assert window_corners(exhaust) / DEGREE == pytest.approx([165.0, 190.0, 315.0, 340.0])


@given(windows(), st.lists(st.floats(0.01, 0.99), min_size=1, max_size=4))
def test_a_cam_s_corners_meet_the_groove_s_knots(window, shares):
    """At the corner the lift is the knot: the arccosine's rounding is 1e-16 over its slope."""
    cam = Cam(window[0], window[1], 9e-3, window[2])
    knots = 9e-3 * np.array(sorted(shares))
    corners = cam_corners(cam, knots)
    assert corners[:4] == pytest.approx(window_corners(cam))
    lifts = [cam.lift * raised_cosine(angle, cam.opens, cam.closes, cam.flank) for angle in corners[4:]]
    assert lifts == pytest.approx([*knots, *knots], abs=1e-13)


def test_knots_that_the_cam_never_lifts_to_have_no_corner():
    assert len(cam_corners(Cam(lift=5e-3), np.array([0.0, 1e-3, 5e-3, 9e-3]))) == 4 + 2


@pytest.mark.parametrize(
    ("window", "key"),
    [
        (Cam(opens=1.0, closes=1.0), "closes"),
        (Exhaust(opens=100.0 * DEGREE, closes=140.0 * DEGREE, flank=21.0 * DEGREE), "flank"),
        (Exhaust(opens=340.0 * DEGREE, closes=20.0 * DEGREE, flank=21.0 * DEGREE), "flank"),
    ],
)
def test_a_window_that_cannot_be_is_named(window, key):
    assert [fault[0] for fault in window.faults()] == [key]


@pytest.mark.parametrize("window", [Cam(), Exhaust(), Exhaust(100.0e-6, 340.0 * DEGREE, 20.0 * DEGREE, 20.0 * DEGREE)])
def test_a_window_whose_flanks_just_fit_has_no_fault(window):
    assert not list(window.faults())


# --- lift curves ---

CURVE = np.array([[-10.0, 0.0], [20.0, 3e-3], [30.0, 9e-3], [50.0, 9e-3], [90.0, 1e-3], [100.0, 0.0]]) * [DEGREE, 1.0]


@st.composite
def curves(draw):
    """Curves of three to eight rows over 5 to 360 degrees that rise and fall at will, from anywhere in a turn."""
    lifts = draw(st.lists(st.floats(0.0, 9e-3), min_size=1, max_size=6))
    steps = np.array(draw(st.lists(st.floats(0.1, 1.0), min_size=len(lifts) + 1, max_size=len(lifts) + 1)))
    start, span = draw(st.floats(-360.0, 360.0)), draw(st.floats(5.0, 360.0))
    angles = start + span * np.append(0.0, np.cumsum(steps) / steps.sum())
    return np.column_stack((angles * DEGREE, [0.0, *lifts, 0.0]))


@given(curves(), ANGLES)
def test_a_lift_curve_is_linear_between_its_rows_closed_outside_and_repeats_every_turn(curve, angle):
    """Its steepest piece has 9 mm in 0.1 degrees or so: 5 m/rad on an angle that is rounded at 1e-15."""
    lift, slope = lift_line(curve, angle)
    turns = np.arange(-6, 7) * TURN
    expected = np.interp(angle + turns, *curve.T, left=0.0, right=0.0).max()
    assert lift + slope * angle == pytest.approx(expected, abs=1e-12)


@given(curves(), st.floats(0.0, 9e-3))
def test_a_lift_curve_passes_a_lift_where_its_side_changes(curve, lift):
    """Against a count of the rows above it; on the way there and back again."""
    rises, falls = lift_crossings(curve, lift)
    above = curve[:, 1] > lift
    assert len(rises) == len(falls) == np.count_nonzero(above[1:] & ~above[:-1])
    for angle in (*rises, *falls):
        assert np.interp(angle, *curve.T) == pytest.approx(lift, abs=1e-12)
    assert np.all(rises <= falls)


def test_the_corners_of_a_lift_curve_are_its_rows_and_where_it_passes_the_groove_s_knots():
    corners = cam_corners(Cam(lift_curve=CURVE), np.array([1e-3, 6e-3, 9e-3])) / DEGREE
    expected = [-10.0, 0.0, 20.0, 25.0, 30.0, 50.0, 65.0, 90.0, 100.0]
    assert np.unique(corners.round(9)) == pytest.approx(expected)


def test_the_angles_of_a_lift_curve_are_those_of_its_flanks_at_the_lap():
    found = cam_angles(Cam(lift_curve=CURVE), 2e-3)
    assert np.array(found[:4]) / DEGREE == pytest.approx([10.0, 85.0, 30.0, 100.0])
    assert found[4] == 9e-3


def test_the_angles_of_a_lift_curve_without_lap_are_its_ends_and_beyond_its_peak_there_are_none():
    assert np.array(cam_angles(Cam(lift_curve=CURVE), 0.0)[:2]) / DEGREE == pytest.approx([-10.0, 100.0])
    assert np.isnan(cam_angles(Cam(lift_curve=CURVE), 9e-3)[:2]).all()


@pytest.mark.parametrize(
    "rows",
    [
        [[-10.0, 1e-4], [20.0, 9e-3], [100.0, 0.0]],
        [[-10.0, 0.0], [20.0, 9e-3], [100.0, 1e-4]],
        [[-10.0, 0.0], [20.0, 9e-3], [60.0, -1e-6], [100.0, 0.0]],
        [[-10.0, 0.0], [100.0, 0.0]],
        [[-10.0, 0.0], [20.0, 0.11], [100.0, 0.0]],
        [[-10.0, 0.0], [20.0, 9e-3], [351.0, 0.0]],
        [[-361.0, 0.0], [-320.0, 9e-3], [-300.0, 0.0]],
        [[600.0, 0.0], [620.0, 9e-3], [721.0, 0.0]],
        [[number * 0.1, 0.001 * (0 < number < MAX_ROWS)] for number in range(MAX_ROWS + 1)],
    ],
)
def test_a_lift_curve_that_cannot_be_is_named(rows):
    assert [fault[0] for fault in Cam(lift_curve=np.array(rows) * [DEGREE, 1.0]).faults()] == ["lift_curve"]


def test_a_lift_curve_stands_for_the_window_whatever_that_is():
    whole_turn = np.array([[-180.0, 0.0], [0.0, 9e-3], [180.0, 0.0]]) * [DEGREE, 1.0]
    for curve in (CURVE, whole_turn):
        assert not list(Cam(opens=1.0, closes=1.0, lift_curve=curve).faults())
