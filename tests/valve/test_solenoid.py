from itertools import pairwise
from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apesim.valve.solenoid import Solenoid, breakpoints_of, energised_fraction, followed, opening_curve

RAMP = opening_curve(Solenoid())
PERIODS_BACK = 40


def naive_fraction(edges, period, curve, t):
    """Every ramp of every edge that ever was, added up and clipped."""
    turns = np.arange(-PERIODS_BACK, PERIODS_BACK + 1) * period if period < inf else [0.0]
    signs = np.where(np.arange(len(edges)) % 2 == 0, 1.0, -1.0)
    lags = t - np.asarray(edges)[:, None] - np.asarray(turns)
    total = (signs[:, None] * np.interp(lags, curve[:, 0], curve[:, 1])).sum()
    return min(1.0, max(0.0, total))


@st.composite
def curves(draw):
    """Curves of up to four knots, rising from 0 to 1, no steeper than 1 in 0.1 ms."""
    steps = draw(st.lists(st.floats(1e-4, 4e-3), min_size=1, max_size=3))
    between = sorted(draw(st.lists(st.floats(0.0, 1.0), min_size=len(steps) - 1, max_size=len(steps) - 1)))
    times = draw(st.floats(0.0, 5e-3)) + np.append(0.0, np.cumsum(steps))
    return np.column_stack([times, [0.0, *between, 1.0]])


@st.composite
def pulses(draw):
    """Edges of one to three pulses, within a period that may be shorter than the ramps."""
    period = draw(st.sampled_from([2e-3, 10e-3, 100e-3]))
    count = draw(st.integers(1, 3))
    shares = draw(st.lists(st.integers(0, 999), min_size=2 * count, max_size=2 * count, unique=True))
    return np.sort(shares) / 1000.0 * period, period


@given(pulses(), curves(), st.floats(-1.0, 30.0))
def test_the_energised_fraction_is_the_sum_of_all_ramps_of_a_single_train(train, curve, share):
    edges, period = train
    t = share * period
    # The slope is below 1e4 / s; times are rounded at 1e-16 of a second or so.
    assert energised_fraction(edges, inf, curve, t) == pytest.approx(naive_fraction(edges, inf, curve, t), abs=1e-10)


@given(pulses(), curves(), st.floats(0.0, 3.0))
def test_the_energised_fraction_is_the_sum_of_all_ramps_of_a_repeated_train(train, curve, share):
    edges, period = train
    t = share * period
    assert energised_fraction(edges, period, curve, t) == pytest.approx(
        naive_fraction(edges, period, curve, t), abs=1e-10
    )


@given(pulses(), curves(), st.integers(0, 5), st.integers(0, 5))
def test_at_the_edges_themselves_the_sum_is_the_same(train, curve, edge, turn):
    edges, period = train
    t = edges[edge % len(edges)] + turn * period
    for repeats in (period, inf):
        assert energised_fraction(edges, repeats, curve, t) == pytest.approx(
            naive_fraction(edges, repeats, curve, t), abs=1e-10
        )


def test_the_default_is_a_dead_time_and_a_ramp_for_both_edges():
    edges = np.array([0.0, 20e-3])
    times = np.array([-1.0, 0.0, 1.5e-3, 2.25e-3, 3e-3, 20e-3, 21.5e-3, 22.125e-3, 23e-3, 1.0])
    fractions = [energised_fraction(edges, inf, RAMP, t) for t in times]
    assert fractions == pytest.approx([0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0 - 0.625 / 1.5, 0.0, 0.0], abs=1e-12)


def test_a_pulse_shorter_than_the_ramp_reaches_its_share_of_it():
    edges = np.array([0.0, 0.6e-3])
    assert max(energised_fraction(edges, inf, RAMP, t) for t in np.linspace(0.0, 5e-3, 501)) == pytest.approx(0.4)


def test_a_curve_begins_at_its_first_row_and_ends_at_its_last():
    curve = np.array([[1e-3, 0.0], [2e-3, 0.7], [4e-3, 1.0]])
    lags = [0.0, 1e-3, 1.5e-3, 2e-3, 3e-3, 4e-3, 1.0]
    assert [followed(curve, lag) for lag in lags] == pytest.approx([0.0, 0.0, 0.35, 0.7, 0.85, 1.0, 1.0])


# --- breakpoints ---


@given(pulses(), curves(), st.booleans())
def test_between_the_breakpoints_the_fraction_is_a_line(train, curve, repeated):
    edges, period = train
    repeats = period if repeated else inf
    ends = np.append(0.0, breakpoints_of(edges, repeats, curve[:, 0], 0.0, 2.0 * period))
    for low, high in pairwise(ends):
        x = [energised_fraction(edges, repeats, curve, t) for t in (low, 0.5 * (low + high), high)]
        assert x[1] == pytest.approx(0.5 * (x[0] + x[2]), abs=1e-9)


@given(pulses(), curves(), st.booleans(), st.floats(0.0, 2.0), st.floats(0.1, 2.0))
def test_breakpoints_are_the_edges_and_corners_after_the_start_and_the_end(train, curve, repeated, first, length):
    edges, period = train
    start, end = first * period, (first + length) * period
    breakpoints = breakpoints_of(edges, period if repeated else inf, curve[:, 0], start, end)
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
    breakpoints = breakpoints_of(np.array([0.0, 50e-3]), 100e-3, RAMP[:, 0], 0.0, 100e-3)
    assert breakpoints == pytest.approx([1.5e-3, 3e-3, 50e-3, 51.5e-3, 53e-3, 100e-3])


# --- faults ---


def test_a_curve_that_falls_back_on_its_way_is_at_fault():
    curve = np.array([[0.0, 0.0], [1e-3, 1.0], [2e-3, 0.2], [3e-3, 1.0]])
    assert [key for key, *_ in Solenoid(opening_curve=curve).faults()] == ["opening_curve"]


@pytest.mark.parametrize("opening", [[0.1, 1.0], [0.0, 0.9], [0.0, 1.2, 1.0], [0.0, -0.1, 1.0]])
def test_a_curve_that_does_not_run_from_0_to_1_is_at_fault(opening):
    curve = np.column_stack([np.arange(len(opening)) * 1e-3, opening])
    assert [key for key, *_ in Solenoid(opening_curve=curve).faults()] == ["opening_curve"]


def test_sound_solenoids_have_no_faults():
    assert not list(Solenoid().faults())
    assert not list(Solenoid(opening_curve=RAMP).faults())
