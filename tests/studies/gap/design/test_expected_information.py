"""Expected information: against closed forms, and against what fitting would tell."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from apesim.studies.gap.design.expected_information import Forecast, find_entropy, find_information, find_separation


def forecast(mean, spread=None):
    mean = np.atleast_1d(np.asarray(mean, dtype=float))
    return Forecast(mean, np.zeros((len(mean), 1)) if spread is None else np.asarray(spread, dtype=float))


def exact_information(means, deviations, weights):
    """The mutual information of an explanation and one sample, by quadrature [bit]."""

    def density(y):
        return [w * norm.pdf(y, m, s) for w, m, s in zip(weights, means, deviations, strict=True)]

    def integrand(y):
        parts = [part for part in density(y) if part > 0.0]
        whole = sum(parts)
        return -sum(part * np.log2(part / whole) for part in parts)

    left, _ = quad(integrand, min(means) - 40.0, max(means) + 40.0, limit=400)
    return find_entropy(weights) - left


@pytest.mark.parametrize(
    ("means", "deviations", "weights"),
    [
        ((0.0, 1.0), (1.0, 1.0), (0.5, 0.5)),
        ((0.0, 3.0), (1.0, 1.0), (0.9, 0.1)),
        ((0.0, 0.0), (1.0, 5.0), (0.5, 0.5)),
        ((0.0, 2.0, 5.0), (1.0, 2.0, 1.0), (0.2, 0.5, 0.3)),
    ],
)
def test_information_is_that_of_quadrature(means, deviations, weights):
    forecasts = [forecast(m, [[np.sqrt(s**2 - 1.0)]]) for m, s in zip(means, deviations, strict=True)]
    exact = exact_information(means, deviations, weights)
    assert find_information(forecasts, weights, draws=20000) == pytest.approx(exact, abs=0.01)
    assert find_information(forecasts, weights) == pytest.approx(exact, abs=0.07)


def test_information_does_not_depend_on_samples_that_tell_nothing():
    here, away = forecast([0.0, 0.0]), forecast([2.0, 0.0])
    alone = find_information([here.take(np.array([True, False])), away.take(np.array([True, False]))], [0.5, 0.5])
    assert find_information([here, away], [0.5, 0.5]) == pytest.approx(alone, abs=1e-9)
    assert find_information([here, here], [0.5, 0.5]) == 0.0


def test_what_every_explanation_is_uncertain_of_tells_less():
    """A difference along a direction that both leave open hardly tells; one beside it tells as before."""
    direction = np.array([[30.0], [0.0]])
    along = find_information([forecast([0.0, 0.0], direction), forecast([4.0, 0.0], direction)], [0.5, 0.5])
    beside = find_information([forecast([0.0, 0.0], direction), forecast([0.0, 4.0], direction)], [0.5, 0.5])
    assert along < 0.03
    assert beside > 0.8


def test_separation_is_the_least_that_a_fit_leaves():
    rng = np.random.default_rng(3)
    truth, rival = forecast(rng.normal(size=40)), forecast(rng.normal(size=40), 2.0 * rng.normal(size=(40, 3)))
    wide = np.vstack([rival.spread, np.eye(3)])
    target = np.append(truth.mean - rival.mean, np.zeros(3))
    left = target - wide @ np.linalg.lstsq(wide, target, rcond=None)[0]
    assert find_separation(truth, rival) == pytest.approx(np.linalg.norm(left))


def test_entropy_is_largest_where_all_weigh_alike():
    assert find_entropy([0.25] * 4) == pytest.approx(2.0)
    assert find_entropy([0.7, 0.3, 0.0]) == pytest.approx(find_entropy([0.3, 0.7]))
