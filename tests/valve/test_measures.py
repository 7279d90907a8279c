import numpy as np
import pytest

from apesim.march.adaptive import BREAKPOINT, ZERO_CROSSING
from apesim.valve.measures import Stroke, closing_stroke, opening_stroke
from apesim.valve.motion import LEFT, MET_CLOSED, MET_OPEN, NEAR_OPEN, ONE_PERCENT, SPEED_EXTREMUM, TURNED

OPENED, NEARLY_OPEN, EXTREMUM = ZERO_CROSSING + ONE_PERCENT, ZERO_CROSSING + NEAR_OPEN, ZERO_CROSSING + SPEED_EXTREMUM

# Time, code, sign of the change, position, speed: a stroke each way, speeds with two peaks on the way to open.
LOG = np.array(
    [
        [0.000, BREAKPOINT, 0.0, 9.0, 0.0],
        [0.003, LEFT, 0.0, 9.0, 0.0],
        [0.006, OPENED, 1.0, 8.91, -0.2],
        [0.007, EXTREMUM, 1.0, 7.0, -2.0],
        [0.008, EXTREMUM, -1.0, 5.0, -0.5],
        [0.009, EXTREMUM, 1.0, 3.0, -1.6],
        [0.010, NEARLY_OPEN, 1.0, 0.09, -1.2],
        [0.011, MET_OPEN, 0.0, 0.0, -1.0],
        [0.012, MET_OPEN, 0.0, 0.0, -0.3],
        [0.050, BREAKPOINT, 0.0, 0.0, 0.0],
        [0.057, NEARLY_OPEN, -1.0, 0.09, 0.3],
        [0.058, EXTREMUM, -1.0, 4.0, 1.5],
        [0.060, OPENED, -1.0, 8.91, 1.25],
        [0.061, MET_CLOSED, 0.0, 9.0, 1.2],
        [0.100, BREAKPOINT, 0.0, 9.0, 0.0],
    ]
)


def measures(stroke):
    return pytest.approx(tuple(stroke), rel=1e-12, nan_ok=True)


def test_an_opening_is_measured_to_its_first_contact():
    assert tuple(opening_stroke(LOG, 0.001, 0.1)) == measures(
        Stroke(0.005, 0.005, 1.0, (2.0 - 0.5) / 2.0, False, 0.011)
    )


def test_a_closing_is_measured_from_99_percent_of_lift():
    assert tuple(closing_stroke(LOG, 0.050, 0.1)) == measures(
        Stroke(0.007, 0.004, 1.2, (1.5 - 1.2) / 1.5, False, 0.061)
    )


def test_what_lies_before_the_command_or_after_the_end_does_not_count():
    assert tuple(opening_stroke(LOG, 0.02, 0.1)) == measures(Stroke())
    assert tuple(opening_stroke(LOG, 0.0, 0.005)) == measures(Stroke())
    assert tuple(opening_stroke(LOG, 0.0, 0.0105)) == measures(Stroke(delay=0.006))
    assert tuple(closing_stroke(LOG, 0.0, 0.0605)) == measures(Stroke(delay=0.057))


def test_a_crossing_in_the_other_direction_begins_nothing():
    log = LOG[LOG[:, 2] != 1.0]
    assert np.isnan(opening_stroke(log, 0.0, 0.1)[:2]).all()


def test_a_contact_without_a_beginning_keeps_its_time_and_speed():
    # A pulse too short for full lift: the piston comes back to the closed stop from where it turned.
    log = LOG[LOG[:, 1] != NEARLY_OPEN]
    stroke = closing_stroke(log, 0.050, 0.1)
    assert np.isnan([stroke.delay, stroke.stroke_time]).all()
    assert (stroke.seating_speed, stroke.contact) == (1.2, 0.061)


def test_speeds_away_from_the_stop_are_no_part_of_the_fluctuation():
    log = np.insert(LOG, 10, [0.0501, EXTREMUM, -1.0, 1.0, -9.0], axis=0)
    assert closing_stroke(log, 0.050, 0.1).fluctuation == closing_stroke(LOG, 0.050, 0.1).fluctuation


def test_a_motion_that_turns_back_before_contact_has_full_fluctuation():
    log = np.insert(LOG, 5, [0.0085, TURNED, 0.0, 4.5, 0.0], axis=0)
    stroke = opening_stroke(log, 0.0, 0.1)
    assert stroke.reverses is True
    assert stroke.fluctuation == 1.0
    assert stroke[:3] == opening_stroke(LOG, 0.0, 0.1)[:3]


def test_turning_back_after_contact_is_no_reversal():
    log = np.insert(LOG, 9, [0.0125, TURNED, 0.0, 0.5, 0.0], axis=0)
    assert opening_stroke(log, 0.0, 0.1) == opening_stroke(LOG, 0.0, 0.1)


def test_a_speed_that_grows_up_to_contact_does_not_fluctuate():
    log = LOG[LOG[:, 1] != EXTREMUM]
    assert opening_stroke(log, 0.0, 0.1).fluctuation == 0.0


def test_only_speeds_after_the_peak_count_as_fluctuation():
    log = LOG.copy()
    log[3, 4], log[5, 4] = -0.6, -2.0
    assert opening_stroke(log, 0.0, 0.1).fluctuation == pytest.approx((2.0 - 1.0) / 2.0)


def test_an_empty_log_measures_nothing():
    assert tuple(opening_stroke(LOG[:0], 0.0, 0.1)) == measures(Stroke())
