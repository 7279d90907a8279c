"""Figures that judge stated probabilities: a good forecaster passes, one that is too sure is caught."""

import numpy as np
import pytest

from tests.truth.scoring import forecasts
from tests.truth.scoring.figures import figures, judged
from tests.truth.scoring.forecasts import find_bins, judge, slopes, spiegelhalter, squared_errors
from tests.truth.scoring.score import Scored
from tests.truth.scoring.tables import say_interval, short
from tests.truth.sealed.schedule import SINGLE

STATEMENTS = 91
"""Number of statements: a block of 51 cases has made as many."""
COVERAGE = 0.80
"""Share of intervals that hold the truth, at least: of 250 they were 0.93, and of 50 that is 0.80 once in 500."""
OWNERS = np.arange(STATEMENTS) // 2


def forecast(rng, sureness=1.0):
    """What is stated and what is so: the log odds that are stated are the true ones times some factor."""
    scores = rng.normal(1.0, 1.8, size=STATEMENTS)
    return 1.0 / (1.0 + np.exp(-sureness * scores)), rng.uniform(size=STATEMENTS) < 1.0 / (1.0 + np.exp(-scores))


def once(statistic, stated, right, *more, **options):
    return statistic(stated, right.astype(float), np.ones((1, len(stated))), *more, **options)[0]


def test_a_perfect_forecaster_has_no_debiased_error_though_it_has_a_plain_one():
    rng = np.random.default_rng(1)
    found = [
        [once(squared_errors, *each, find_bins(each[0]), debias=debias) for debias in (True, False)]
        for each in (forecast(rng) for _ in range(400))
    ]
    debiased, plain = np.mean(found, axis=0)
    assert abs(debiased) < 0.002
    assert plain > 0.01


def test_the_z_of_a_perfect_forecaster_is_normal():
    rng = np.random.default_rng(2)
    z = np.array([once(spiegelhalter, *forecast(rng)) for _ in range(400)])
    assert np.mean(np.abs(z) < 2.0) == pytest.approx(0.954, abs=0.025)
    assert z.std() == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(("sureness", "least", "most"), [(1.0, COVERAGE, 1.0), (2.5, 0.0, 0.2), (0.4, 0.0, 0.2)])
def test_intervals_hold_what_a_perfect_forecaster_has_and_not_what_another_has(monkeypatch, sureness, least, most):
    monkeypatch.setattr(forecasts, "DRAWS", 200)
    rng = np.random.default_rng(3)
    found = [judge(OWNERS, *forecast(rng, sureness)) for _ in range(50)]
    assert least <= np.mean([low <= 1.0 <= high for low, high in (one["slope"].interval for one in found)]) <= most


def test_one_who_is_too_sure_is_caught():
    found = judge(OWNERS, *forecast(np.random.default_rng(4), sureness=2.5))
    assert found["z"].value > 2.0
    assert found["z"].interval[0] > 0.0
    assert found["slope"].interval[1] < 1.0
    assert found["error"].value > 0.05


def test_statements_of_one_case_count_as_one_in_intervals():
    stated, right = (np.repeat(each, 4) for each in forecast(np.random.default_rng(5)))
    owners = np.repeat(np.arange(STATEMENTS), 4)
    widths = [np.ptp(judge(each, stated, right)["slope"].interval) for each in (owners, np.arange(len(stated)))]
    assert widths[0] > 1.5 * widths[1]


def test_what_chance_adds_is_taken_off_the_error():
    right = np.array([True] * 3 + [False] + [True] * 4)
    stated = np.repeat([0.5, 0.9], 4)
    bins = np.repeat([0, 1], 4)
    plain = 0.5 * (0.25**2 + 0.1**2)
    assert once(squared_errors, stated, right, bins, debias=False) == pytest.approx(plain)
    assert once(squared_errors, stated, right, bins) == pytest.approx(plain - 0.5 * 0.75 * 0.25 / 3.0)


def test_z_is_the_excess_of_the_brier_score_over_its_deviation():
    stated, right = np.array([0.9, 0.8, 0.2]), np.array([True, False, False])
    expected, variance = np.sum(stated * (1.0 - stated)), np.sum((1.0 - 2.0 * stated) ** 2 * stated * (1.0 - stated))
    excess = np.sum((right - stated) ** 2) - expected
    assert once(spiegelhalter, stated, right) == pytest.approx(excess / np.sqrt(variance))


def test_the_slope_is_finite_where_right_and_wrong_are_parted_and_none_where_all_state_the_same():
    stated = np.linspace(0.1, 0.9, 20)
    assert 1.0 < once(slopes, stated, stated > 0.5) < 10.0
    assert np.isnan(once(slopes, np.full(20, 0.8), stated > 0.5))
    assert judge(range(20), np.full(20, 0.8), stated > 0.5)["slope"].value is None


def test_the_slope_is_that_of_a_regression_of_many():
    rng = np.random.default_rng(6)
    scores = rng.normal(size=40000)
    right = rng.uniform(size=40000) < 1.0 / (1.0 + np.exp(-0.5 - 0.6 * scores))
    assert once(slopes, 1.0 / (1.0 + np.exp(-scores)), right) == pytest.approx(0.6, abs=0.03)


def test_few_statements_are_not_judged():
    stated, right = np.linspace(0.1, 0.9, 20), np.arange(20) % 2 == 0
    few, of_one = judge(range(5), stated[:5], right[:5]), judge([1] * 20, stated, right)
    assert {each for found in (few, of_one) for one in found.values() for each in one} == {None}
    assert judge(range(20), stated, right)["z"].value is not None


def test_figures_carry_intervals_of_their_own():
    claims = [*zip(OWNERS, *forecast(np.random.default_rng(7)), strict=True)]
    slope, *_ = judged("all", claims)
    low, high = slope.interval
    assert low < slope.value < high
    assert say_interval(slope) == f"{low:.2f} to {high:.2f}"
    assert short(slope) == f"{slope.value:.3g} ({STATEMENTS})"


def test_where_nothing_is_stated_nothing_is_judged():
    silent = Scored({"kind": SINGLE, "hidden": [], "bench": "valve", "deviations": 0.0}, {"verdict": "AMBIGUOUS"})
    shown = {one.what: (short(one), say_interval(one)) for one in figures([silent])}
    assert shown["slope of the reliability line, all stated probabilities"] == ("–", "–")
