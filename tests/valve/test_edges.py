"""Edges that come while the valve is marched, beside those that are known beforehand."""

import numpy as np
import pytest

import apesim
from apesim.valve.actuator import actuator_of
from apesim.valve.edges import add_edge, len_of_ramps, next_corner_time
from apesim.valve.solenoid import breakpoints_of, energised_fraction

pytestmark = pytest.mark.plain


@pytest.mark.parametrize("release", [{}, {"valve.solenoid.release_dead_time": "0.2 ms"}])
def test_corners_of_a_solenoid_are_those_of_the_bench(release):
    edges = np.array([0.0, 2e-3, 9e-3, 9.5e-3])
    _, tables = actuator_of(apesim.Machine().with_(**release), edges, np.inf)
    expected, t = breakpoints_of(edges, np.inf, tables.curves_a, 1e-4, 1.0)[:-1], 1e-4
    found = []
    while (t := next_corner_time(tables, t)) < np.inf:
        found.append(t)
    # The edges themselves are corners of the bench's, where nothing has followed yet.
    assert found == pytest.approx([time for time in expected if np.abs(edges - time).min() > 1e-9], abs=1e-12)


def test_edges_that_are_added_and_forgotten_leave_the_fraction_that_all_of_them_give():
    rng = np.random.default_rng(5)
    times = np.cumsum(rng.exponential(4e-3, 41))
    _, tables = actuator_of(apesim.Machine(), [0.0], np.inf)
    room, ramps = np.full(12, np.inf), len_of_ramps(tables)
    for i, time in enumerate(times):
        add_edge(room, time, ramps)
        for t in (time, time + 1e-3, time + 2e-3):
            expected = energised_fraction(times[: i + 1], np.inf, tables.curves_a, t)
            assert energised_fraction(room, np.inf, tables.curves_a, t) == pytest.approx(expected, abs=1e-12)
