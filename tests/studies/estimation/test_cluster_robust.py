"""Variances by what groups of runs leave, against textbook formulas and known coverage."""

import numpy as np
import pytest
from scipy.linalg import fractional_matrix_power

from apesim.studies.estimation.cluster_robust import GroupVariances, compare_groups

GROUPS = [np.arange(0, 3), np.arange(3, 40), np.arange(40, 60)]
SAMPLES, NUMBERS = 60, 4
HALF = 1.96


def linear_model(seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Sensitivities of three groups, the last parameter only in two of them and two priors below, and their noise."""
    rng = np.random.default_rng(seed)
    slopes = rng.standard_normal((SAMPLES, NUMBERS))
    slopes[:3, -1] = 0.0
    return np.vstack([slopes, np.eye(2, NUMBERS)]), rng.standard_normal(SAMPLES + 2)


def leave(jacobian: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Residuals at the least sum of squares."""
    return errors - jacobian @ np.linalg.lstsq(jacobian, errors, rcond=None)[0]


def test_variances_are_those_of_cr2_with_the_roots_of_whole_groups():
    jacobian, errors = linear_model()
    residuals, covariance = leave(jacobian, errors), np.linalg.inv(jacobian.T @ jacobian)
    scores = []
    for rows in GROUPS:
        slopes = jacobian[rows]
        root = fractional_matrix_power(np.eye(len(rows)) - slopes @ covariance @ slopes.T, -0.5)
        scores.append(covariance @ slopes.T @ root @ residuals[rows])
    by_noise = np.diag(covariance @ jacobian[:SAMPLES].T @ jacobian[:SAMPLES] @ covariance)
    compared = compare_groups(jacobian, residuals, GROUPS)
    assert compared.ratios == pytest.approx(np.sum(np.square(scores), axis=0) / by_noise)
    assert compared.shares == pytest.approx(by_noise / np.diag(covariance))


def test_a_mean_of_equal_groups_has_the_variance_of_their_means():
    """Variance over G of the means of G equal groups, with G - 1 degrees of freedom, is what CR2 then is."""
    rng = np.random.default_rng(2)
    errors = rng.standard_normal(40) + np.repeat([2.0, -1.0, 0.5, -1.5], 10)
    compared = compare_groups(np.ones((40, 1)), errors - errors.mean(), list(np.arange(40).reshape(4, 10)))
    means = errors.reshape(4, 10).mean(axis=1)
    assert compared.ratios == pytest.approx(np.var(means, ddof=1) / 4 * 40)
    assert compared.freedom == pytest.approx(3.0)


def test_white_noise_gives_the_variance_of_the_curvature_with_the_freedom_that_is_stated():
    jacobian, _ = linear_model()
    draws = np.random.default_rng(3).standard_normal((4000, SAMPLES + 2))
    found = [compare_groups(jacobian, leave(jacobian, errors), GROUPS) for errors in draws]
    ratios = np.array([each.ratios for each in found])
    assert ratios.mean(axis=0) == pytest.approx(1.0, abs=0.1)
    assert 2.0 / ratios.var(axis=0) == pytest.approx(found[0].freedom, rel=0.2)


def test_what_one_group_alone_determines_is_left_to_the_curvature():
    jacobian, errors = linear_model()
    jacobian[3:SAMPLES, -1] = 0.0
    jacobian[:3] = 0.0
    jacobian[:3, -1] = [1.0, -2.0, 0.5]
    errors[:3] *= 100.0
    compared = compare_groups(jacobian, leave(jacobian, errors), GROUPS)
    assert (compared.ratios[-1], compared.freedom[-1], compared.factors[-1]) == (1.0, 0.0, 1.0)


def test_a_variance_is_drawn_to_the_curvature_and_never_below_it():
    freedom = np.array([2.0, 2.0, 2.0, 0.0])
    compared = GroupVariances(np.array([1.0, 1.0, 0.5, 1.0]), np.array([5.0, 0.1, 5.0, 1.0]), freedom)
    assert compared.factors == pytest.approx([3.0, 1.0, 2.0, 1.0])


MEANS = [(0.0, 0.95, 0.96), (0.15, 0.82, 0.89), (0.3, 0.61, 0.83)]
"""Errors of an operating point, and the shares of intervals that hold by the curvature and by the points."""


@pytest.mark.parametrize(("scatter", "by_curvature", "by_groups"), MEANS)
def test_intervals_hold_the_truth_more_often_where_points_have_errors_of_their_own(scatter, by_curvature, by_groups):
    """Means of four operating points beside a nuisance with a prior; the noise of the mean of a point is 0.14."""
    rng, points, samples = np.random.default_rng(4), 4, 50
    slopes = np.column_stack([np.ones(points * samples), rng.standard_normal(points * samples)])
    jacobian = np.vstack([slopes, [0.0, 1.0]])
    groups = list(np.arange(points * samples).reshape(points, samples))
    error = np.sqrt(np.linalg.inv(jacobian.T @ jacobian)[0, 0])
    held = []
    for _ in range(2000):
        errors = rng.standard_normal(points * samples + 1)
        errors[:-1] += scatter * np.repeat(rng.standard_normal(points), samples)
        off = abs(np.linalg.lstsq(jacobian, errors, rcond=None)[0][0])
        wider = np.sqrt(compare_groups(jacobian, leave(jacobian, errors), groups).factors[0])
        held.append((off <= HALF * error, off <= HALF * error * wider))
    assert np.mean(held, axis=0) == pytest.approx([by_curvature, by_groups], abs=0.025)
