"""The first condition for a gap: the largest score of one effect, or of two together."""

from types import SimpleNamespace

import numpy as np
import pytest

from apesim.studies.estimation.scatter import find_spread
from apesim.studies.estimation.scatter_sizes import NARROWER
from apesim.studies.gap.search.gap_test import compare_with_noise
from apesim.studies.gap.search.score_test import Sensitivity

N = 400


def effects(*shapes, one_sided=False, file=""):
    """Sensitivities of candidates that do something to the data."""
    return [
        Sensitivity(
            SimpleNamespace(candidate=SimpleNamespace(name=f"{file}{number}", file=file), one_sided=one_sided),
            shape,
            shape,
            1.0,
        )
        for number, shape in enumerate(shapes)
    ]


def local():
    return np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, N), 3))[0]


def masking(cosine=0.95):
    """Two shapes that nearly cancel, and what both do together at sizes that leave little of either."""
    rng = np.random.default_rng(3)
    first, other = np.linalg.qr(rng.standard_normal((N, 2)))[0].T
    second = -cosine * first + np.sqrt(1.0 - cosine**2) * other
    return first, second, first + second


def test_two_effects_that_mask_each_other_raise_an_alarm_together():
    first, second, together = masking()
    errors = -7.0 * together / np.linalg.norm(together)
    found = compare_with_noise(effects(first, second), local(), errors, [])
    assert found.alarm
    assert found.pair == ("0", "1")
    assert found.largest < 2.5  # neither would do so alone
    assert found.largest_pair == pytest.approx(7.0)


def test_faults_of_files_are_no_pairs():
    first, second, together = masking()
    found = compare_with_noise(effects(first, second, file="a.csv"), local(), -7.0 * together, [])
    assert found.pair == ()


def test_a_pair_that_would_need_a_negative_strength_counts_for_nothing():
    first, second, together = masking()
    found = compare_with_noise(effects(first, second, one_sided=True), local(), 7.0 * together, [])
    assert not found.alarm


def test_noise_alone_raises_an_alarm_as_often_as_is_said():
    rng = np.random.default_rng(7)
    shapes = effects(*(rng.standard_normal(N) / np.sqrt(N) for _ in range(12)))
    chances = [compare_with_noise(shapes, local(), rng.standard_normal(N), []).p_value for _ in range(60)]
    assert np.mean(np.array(chances) < 0.5) == pytest.approx(0.5, abs=0.2)


def test_runs_that_scatter_with_heavy_tails_are_odd_as_often_as_is_said():
    rng = np.random.default_rng(11)
    # Six runs, each moved along one direction of its own by nine standard deviations of its noise.
    rows = [slice(start, start + 60) for start in range(0, 360, 60)]
    spreads = [(find_spread(9.0 * np.linalg.qr(rng.standard_normal((60, 1)))[0]), own) for own in rows]
    shapes = []
    for spread, own in spreads:
        shapes.append(np.zeros(N))
        shapes[-1][own] = spread.directions[:, 0]
    faults, errors = effects(*shapes, file="a.csv"), rng.standard_normal(N)
    known, normal = (compare_with_noise(faults, np.zeros((N, 0)), errors, [], told).limit for told in (spreads, ()))
    moved = rng.standard_normal((20000, 6)) / 9.0 + np.sqrt(NARROWER) * rng.standard_t(4.0, (20000, 6))
    largest = np.abs(moved).max(axis=1) / np.sqrt(1.0 + 1.0 / 81.0)
    assert np.mean(largest > known) == pytest.approx(0.01, abs=0.003)
    assert np.mean(largest > normal) > 0.05  # were it normal
