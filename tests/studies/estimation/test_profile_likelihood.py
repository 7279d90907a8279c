"""Ends of intervals by profile likelihood, of sums of squares that are known."""

import numpy as np
import pytest

from apesim.studies.estimation.profile_likelihood import EndKind, Likelihood, find_end

BOUNDS = np.array([[0.0, -20.0], [10.0, 20.0]])


def likelihood(squares, best, slope=1.0, **more):
    """A parameter with given squares, and a nuisance that follows it; the curvature is that of a unit deviation."""

    def hold(guess, j):
        point = np.array([guess[0], slope * guess[0]])
        return point, float(squares(guess[0])), True

    covariance = np.array([[1.0, slope], [slope, 1.0 + slope**2]])
    return Likelihood(np.array([best, slope * best]), float(squares(best)), covariance, BOUNDS, hold, **more)


def test_the_ends_of_a_parabola_are_two_deviations_away():
    ends = [find_end(likelihood(lambda x: (x - 4.0) ** 2, 4.0), 0, side) for side in (-1, 1)]
    assert [end.at for end in ends] == pytest.approx([4.0 - 1.96, 4.0 + 1.96], abs=0.01)
    assert [end.kind for end in ends] == [EndKind.CLOSED] * 2
    assert ends[1].point[1] == pytest.approx(5.96, abs=0.01)


@pytest.mark.parametrize("best", [1.0, 3.0])
def test_an_interval_that_begins_on_the_flat_is_held_on_the_other_side(best):
    low, high = (find_end(likelihood(lambda x: max(0.0, x - 3.0) ** 2, best), 0, side) for side in (-1, 1))
    assert (low.at, low.kind) == (0.0, EndKind.OPEN)
    assert (high.at, high.kind) == (pytest.approx(4.96, abs=0.02), EndKind.CLOSED)


def test_an_interval_that_comes_to_the_flat_goes_on_to_the_bound_and_says_so():
    def squares(x):
        return 1.0 if x < 3.0 else (x - 6.0) ** 2 / 9.0

    low, high = (find_end(likelihood(squares, 6.0), 0, side) for side in (-1, 1))
    assert [(end.at, end.kind) for end in (low, high)] == [(0.0, EndKind.OPEN), (10.0, EndKind.OPEN)]


def test_an_end_is_where_the_squares_jump():
    high = find_end(likelihood(lambda x: 100.0 * (x > 5.5), 4.0), 0, 1)
    assert (high.at, high.kind) == (pytest.approx(5.5, rel=0.02), EndKind.CLOSED)


def test_a_point_that_leaves_less_is_no_end():
    end = find_end(likelihood(lambda x: min((x - 4.0) ** 2, (x - 6.0) ** 2 - 2.0), 4.0), 0, 1)
    assert end.kind is EndKind.NONE
    assert end.point[0] == pytest.approx(5.96, abs=1e-3)


def test_where_nothing_more_is_to_be_simulated_the_curvature_is_told_as_such():
    spent = likelihood(lambda x: 0.0, 9.0, is_spent=lambda: True)
    low, high = (find_end(spent, 0, side) for side in (-1, 1))
    assert (low.at, low.kind) == (pytest.approx(9.0 - 1.96, abs=1e-3), EndKind.FROM_CURVATURE)
    assert (high.at, high.kind) == (10.0, EndKind.FROM_CURVATURE_OPEN)
