from itertools import pairwise
from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apesim.valve.solenoid import (
    Solenoid,
    SolenoidCurves,
    breakpoints_of,
    energised_fraction,
    followed,
    shifted,
    solenoid_curves,
)

RAMPS = solenoid_curves(Solenoid())
PERIODS_BACK = 40


def naive_fraction(edges, period, curves, t):
    """Every ramp of every edge that ever was, added up and clipped."""
    turns = np.arange(-PERIODS_BACK, PERIODS_BACK + 1) * period if period < inf else [0.0]
    signs = np.where(np.arange(len(edges)) % 2 == 0, 1.0, -1.0)
    lags = t - np.asarray(edges)[:, None] - np.asarray(turns)
    ramps = [np.interp(lag, *curves[number % 2].T) for number, lag in enumerate(lags)]
    total = (signs[:, None] * np.array(ramps)).sum()
    return min(1.0, max(0.0, total))


@st.composite
def curves(draw):
    """Curves of up to four knots, rising from 0 to 1, no steeper than 1 in 0.1 ms."""
    steps = draw(st.lists(st.floats(1e-4, 4e-3), min_size=1, max_size=3))
    between = sorted(draw(st.lists(st.floats(0.0, 1.0), min_size=len(steps) - 1, max_size=len(steps) - 1)))
    times = draw(st.floats(0.0, 5e-3)) + np.append(0.0, np.cumsum(steps))
    return np.column_stack([times, [0.0, *between, 1.0]])


@st.composite
def both_curves(draw):
    """Curves of energising and of release: one for both, that of energising later or earlier, or another."""
    energising = draw(curves())
    same, moved = st.just(energising), st.floats(-5e-3, 5e-3).map(lambda time: shifted(energising, time))
    return SolenoidCurves(energising, draw(st.one_of(same, moved, curves())))


@st.composite
def pulses(draw):
    """Edges of one to three pulses, within a period that may be shorter than the ramps."""
    period = draw(st.sampled_from([2e-3, 10e-3, 100e-3]))
    count = draw(st.integers(1, 3))
    shares = draw(st.lists(st.integers(0, 999), min_size=2 * count, max_size=2 * count, unique=True))
    return np.sort(shares) / 1000.0 * period, period


@given(pulses(), both_curves(), st.floats(-1.0, 30.0))
def test_the_energised_fraction_is_the_sum_of_all_ramps_of_a_single_train(train, curves, share):
    edges, period = train
    t = share * period
    # The slope is below 1e4 / s; times are rounded at 1e-16 of a second or so.
    assert energised_fraction(edges, inf, curves, t) == pytest.approx(naive_fraction(edges, inf, curves, t), abs=1e-10)


@given(pulses(), both_curves(), st.floats(0.0, 3.0))
def test_the_energised_fraction_is_the_sum_of_all_ramps_of_a_repeated_train(train, curves, share):
    edges, period = train
    t = share * period
    assert energised_fraction(edges, period, curves, t) == pytest.approx(
        naive_fraction(edges, period, curves, t), abs=1e-10
    )


@given(pulses(), both_curves(), st.integers(0, 5), st.integers(0, 5))
def test_at_the_edges_themselves_the_sum_is_the_same(train, curves, edge, turn):
    edges, period = train
    t = edges[edge % len(edges)] + turn * period
    for repeats in (period, inf):
        assert energised_fraction(edges, repeats, curves, t) == pytest.approx(
            naive_fraction(edges, repeats, curves, t), abs=1e-10
        )


def test_the_default_is_a_dead_time_and_a_ramp_for_both_edges():
    edges = np.array([0.0, 20e-3])
    times = np.array([-1.0, 0.0, 1.5e-3, 2.25e-3, 3e-3, 20e-3, 21.5e-3, 22.125e-3, 23e-3, 1.0])
    fractions = [energised_fraction(edges, inf, RAMPS, t) for t in times]
    assert fractions == pytest.approx([0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0 - 0.625 / 1.5, 0.0, 0.0], abs=1e-12)


def test_a_pulse_shorter_than_the_ramp_reaches_its_share_of_it():
    edges = np.array([0.0, 0.6e-3])
    assert max(energised_fraction(edges, inf, RAMPS, t) for t in np.linspace(0.0, 5e-3, 501)) == pytest.approx(0.4)


def test_a_curve_begins_at_its_first_row_and_ends_at_its_last():
    curve = np.array([[1e-3, 0.0], [2e-3, 0.7], [4e-3, 1.0]])
    lags = [0.0, 1e-3, 1.5e-3, 2e-3, 3e-3, 4e-3, 1.0]
    assert [followed(curve, lag) for lag in lags] == pytest.approx([0.0, 0.0, 0.35, 0.7, 0.85, 1.0, 1.0])


# --- release ---


def fractions_at(solenoid, edges, times, period=inf):
    """Energised fractions; times in ms."""
    edges = 1e-3 * np.array(edges)
    return [energised_fraction(edges, period, solenoid_curves(solenoid), 1e-3 * t) for t in times]


def test_release_is_like_energising_where_nothing_is_said_of_it():
    measured = np.array([[0.0, 0.0], [1e-3, 0.0], [1.5e-3, 0.2], [3e-3, 1.0]])
    for solenoid in (Solenoid(), Solenoid(dead_time=2e-3, ramp_time=1e-3), Solenoid(opening_curve=measured)):
        energising, release = solenoid_curves(solenoid)
        assert np.array_equal(energising, release)


def test_release_has_a_dead_time_and_a_ramp_of_its_own():
    solenoid = Solenoid(release_dead_time=4e-3, release_ramp_time=2e-3)
    times = [1.5, 2.25, 3.0, 23.9, 24.5, 25.5, 26.0]
    expected = [0.0, 0.5, 1.0, 1.0, 0.75, 0.25, 0.0]
    assert fractions_at(solenoid, [0.0, 20.0], times) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("own", "expected"),
    [
        ({"release_dead_time": 2e-3}, [2.0, 3.5]),
        ({"release_ramp_time": 2e-3}, [1.5, 3.5]),
        ({"release_dead_time": 1.5e-3, "release_ramp_time": 1.5e-3}, [1.5, 3.0]),
    ],
)
def test_what_is_not_said_of_release_is_that_of_energising(own, expected):
    energising, release = solenoid_curves(Solenoid(**own))
    assert np.array_equal(energising, RAMPS.energising)
    assert 1e3 * release[:, 0] == pytest.approx(expected, rel=1e-12)


def test_numbers_of_release_that_are_those_of_energising_change_no_bit():
    energising, release = solenoid_curves(Solenoid(release_dead_time=1.5e-3, release_ramp_time=1.5e-3))
    assert np.array_equal(energising, release)


def test_a_measured_opening_is_moved_and_stretched_for_the_release():
    """It opens from 1 to 3 ms; release begins at 2 ms and takes 4 ms."""
    measured = np.array([[0.0, 0.0], [1e-3, 0.0], [1.5e-3, 0.2], [3e-3, 1.0], [5e-3, 1.0]])
    _, release = solenoid_curves(Solenoid(opening_curve=measured, release_dead_time=2e-3, release_ramp_time=4e-3))
    assert release == pytest.approx(np.array([[2e-3, 0.0], [3e-3, 0.2], [6e-3, 1.0]]), rel=1e-12)
    _, later = solenoid_curves(Solenoid(opening_curve=measured, release_dead_time=2e-3))
    assert later == pytest.approx(np.array([[2e-3, 0.0], [2.5e-3, 0.2], [4e-3, 1.0]]), rel=1e-12)


def test_a_measured_release_replaces_its_dead_time_and_ramp():
    measured = np.array([[1e-3, 0.0], [5e-3, 1.0]])
    solenoid = Solenoid(release_curve=measured, release_dead_time=2e-3)
    assert np.array_equal(solenoid_curves(solenoid).release, measured)
    assert dict(solenoid.overruled()) == {
        "release_dead_time": "valve.solenoid.release_curve is given",
        "release_ramp_time": "valve.solenoid.release_curve is given",
    }


def test_a_release_within_the_ramp_adds_to_it():
    """Energised at 0, released at 1 ms: up from 1.5 ms, for 1.3 ms alone, then level until 3 ms, then down."""
    solenoid = Solenoid(release_dead_time=1.8e-3)
    times = [1.5, 2.8, 2.9, 3.0, 3.75, 4.3]
    level = 1.3 / 1.5
    expected = [0.0, level, level, level, level - 0.5, 0.0]
    assert fractions_at(solenoid, [0.0, 1.0], times) == pytest.approx(expected, abs=1e-12)


def test_a_pulse_that_release_overtakes_moves_nothing():
    """Released at 0.5 ms, back from 0.5 ms on; energising would begin at 1.5 ms."""
    solenoid = Solenoid(release_dead_time=0.0)
    assert not any(fractions_at(solenoid, [0.0, 0.5], np.linspace(0.0, 6.0, 121)))


def test_a_late_release_outlasts_a_short_pulse_and_a_short_pause():
    solenoid = Solenoid(release_dead_time=6e-3)
    assert max(fractions_at(solenoid, [0.0, 0.1], np.linspace(0.0, 9.0, 181))) == pytest.approx(1.0)
    assert fractions_at(solenoid, [0.0, 10.0, 12.0, 20.0], np.linspace(3.0, 25.9, 230)) == [1.0] * 230


def test_a_release_later_than_the_period_keeps_a_repeated_pulse_energised():
    solenoid = Solenoid(release_dead_time=12e-3)
    assert fractions_at(solenoid, [0.0, 5.0], np.linspace(0.0, 30.0, 301), 10e-3) == [1.0] * 301


def test_where_the_sum_of_ramps_leaves_its_range_is_a_breakpoint():
    """After a pulse of 1 ms release falls from 1 to 4 ms, energising rises from 1.5 to 3 ms: they meet at 2 ms."""
    solenoid = Solenoid(release_dead_time=0.0, release_ramp_time=3e-3)
    breakpoints = breakpoints_of(np.array([0.0, 1e-3]), inf, solenoid_curves(solenoid), 0.0, 10e-3)
    assert 1e3 * breakpoints == pytest.approx([1.0, 1.5, 2.0, 3.0, 4.0, 10.0])
    assert fractions_at(solenoid, [0.0, 1.0], [2.0, 3.0, 4.0]) == pytest.approx([0.0, 1.0 / 3.0, 0.0], abs=1e-12)


# --- breakpoints ---


@given(pulses(), both_curves(), st.booleans())
def test_between_the_breakpoints_the_fraction_is_a_line(train, curves, repeated):
    edges, period = train
    repeats = period if repeated else inf
    ends = np.append(0.0, breakpoints_of(edges, repeats, curves, 0.0, 2.0 * period))
    for low, high in pairwise(ends):
        x = [energised_fraction(edges, repeats, curves, t) for t in (low, 0.5 * (low + high), high)]
        assert x[1] == pytest.approx(0.5 * (x[0] + x[2]), abs=1e-9)


@given(pulses(), curves(), st.booleans(), st.floats(0.0, 2.0), st.floats(0.1, 2.0))
def test_breakpoints_are_the_edges_and_corners_after_the_start_and_the_end(train, curve, repeated, first, length):
    edges, period = train
    start, end = first * period, (first + length) * period
    breakpoints = breakpoints_of(edges, period if repeated else inf, SolenoidCurves(curve, curve), start, end)
    turns = np.arange(-PERIODS_BACK, PERIODS_BACK + 1) * period if repeated else np.zeros(1)
    corners = (edges[:, None, None] + np.append(0.0, curve[:, 0])[:, None] + turns).ravel()
    assert breakpoints[-1] == end
    assert (np.diff(breakpoints) > 0.0).all()
    assert breakpoints[0] > start
    near = 1e-12
    for breakpoint in breakpoints[:-1]:
        assert np.abs(corners - breakpoint).min() < near
    for corner in corners[(corners > start + near) & (corners < end - near)]:
        assert np.abs(breakpoints - corner).min() < near


def test_breakpoints_of_the_default_pulse():
    breakpoints = breakpoints_of(np.array([0.0, 50e-3]), 100e-3, RAMPS, 0.0, 100e-3)
    assert breakpoints == pytest.approx([1.5e-3, 3e-3, 50e-3, 51.5e-3, 53e-3, 100e-3])


# --- faults ---


def test_a_curve_that_falls_back_on_its_way_is_at_fault():
    curve = np.array([[0.0, 0.0], [1e-3, 1.0], [2e-3, 0.2], [3e-3, 1.0]])
    assert [key for key, *_ in Solenoid(opening_curve=curve).faults()] == ["opening_curve"]
    assert [key for key, *_ in Solenoid(release_curve=curve).faults()] == ["release_curve"]


@pytest.mark.parametrize("opening", [[0.1, 1.0], [0.0, 0.9], [0.0, 1.2, 1.0], [0.0, -0.1, 1.0]])
def test_a_curve_that_does_not_run_from_0_to_1_is_at_fault(opening):
    curve = np.column_stack([np.arange(len(opening)) * 1e-3, opening])
    assert [key for key, *_ in Solenoid(opening_curve=curve).faults()] == ["opening_curve"]
    assert [key for key, *_ in Solenoid(release_curve=curve).faults()] == ["release_curve"]


def test_sound_solenoids_have_no_faults():
    assert not list(Solenoid().faults())
    assert not list(Solenoid(opening_curve=RAMPS.energising, release_curve=RAMPS.release).faults())
