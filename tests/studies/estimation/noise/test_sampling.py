"""What else the noise may be, and what that does to scores."""

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import norm

from apesim.studies.estimation.noise.process import Noise, Whitening, autoregressive, take_deviation, white
from apesim.studies.estimation.noise.sampling import draws_of, scatter

N = 300
SHAPE = np.sin(np.linspace(0.0, np.pi, N))
"""Slow, as what the model lacks often is."""
DRAWS = 60
"""Draws of each chance; more of them do not show in the mean over a thousand chances."""


def process(rng, n, weight):
    """Noise of the first order, settled, its innovations of deviation 1."""
    return lfilter([1.0], [1.0, -weight], rng.normal(size=n + 300))[300:]


def coloured(weight, samples, is_stated=False):
    spread = np.array([1.0, np.sqrt(1.0 - weight**2)])
    return Noise(1.0, (np.zeros(0), np.array([weight])), spread, "", samples=samples, is_stated=is_stated)


def chances(weight, samples, trials, seed):
    """Chances of scores of noise alone, were the noise what it is taken for, and as it may be."""
    rng, times, taken, doubted = np.random.default_rng(seed), np.arange(N) * 1e-4, [], []
    draws = np.random.default_rng(1)
    for _ in range(trials):
        noise = autoregressive([process(rng, samples, weight)], "")
        white_ones = Whitening(noise, times).whiten(np.column_stack([SHAPE, process(rng, N, weight)]))
        shape = white_ones[:, :1] / np.linalg.norm(white_ones[:, 0])
        score = abs(float(shape[:, 0] @ white_ones[:, 1]))
        taken.append(2.0 * norm.sf(score))
        factors = scatter([(noise, slice(None))], shape, DRAWS, draws)[:, 0]
        doubted.append(float(np.mean(2.0 * norm.sf(score / factors))))
    return np.array(taken), np.array(doubted)


@pytest.mark.parametrize(("weight", "samples"), [(0.0, 10), (0.9, 240)])
@pytest.mark.slow
def test_chances_of_noise_known_from_few_samples_are_right_once_that_is_counted(weight, samples):
    taken, doubted = chances(weight, samples, 1000, 5)
    assert np.mean(taken < 0.01) > 0.018
    assert 0.004 < np.mean(doubted < 0.01) < 0.016
    assert np.mean(doubted < 0.5) == pytest.approx(0.5, abs=0.04)


def test_noise_known_from_many_samples_is_what_it_is_taken_for():
    shape = SHAPE[:, None] / np.linalg.norm(SHAPE)
    factors = scatter([(coloured(0.7, 1e7), slice(None))], shape, 100, np.random.default_rng(1))
    assert factors == pytest.approx(np.ones((100, 1)), abs=0.01)


def test_a_stated_deviation_leaves_the_colour_in_doubt():
    shape = SHAPE[:, None] / np.linalg.norm(SHAPE)
    rng = np.random.default_rng(1)
    white_one = white(1.0, "", 100.0)._replace(is_stated=True)
    assert scatter([(white_one, slice(None))], shape, 50, rng) == pytest.approx(np.ones((50, 1)))
    variance, shift = draws_of(coloured(0.7, 200.0, is_stated=True), 2000, rng)
    size = variance / (1.0 - (0.7 + shift[:, 0]) ** 2)
    assert size == pytest.approx(np.full(2000, 1.0 / (1.0 - 0.7**2)))
    assert np.std(shift) == pytest.approx((1.0 - 0.7**2) / np.sqrt(200.0 * (1.0 + 0.7**2)), rel=0.05)


@pytest.mark.parametrize("weights", [[0.9], [1.2, -0.4]])
def test_what_is_drawn_beside_a_stated_deviation_is_what_estimates_differ_by(weights):
    rng, found = np.random.default_rng(2), []
    poles = np.append(1.0, -np.array(weights))
    deviation = float(np.linalg.norm(lfilter([1.0], poles, np.eye(1, 2000)[0])))
    for _ in range(200):
        noise = autoregressive([lfilter([1.0], poles, rng.normal(size=1000))[300:]], "")
        if noise.order == len(weights):
            found.append(take_deviation(noise, deviation))
    assert len(found) > 190
    _, shift = draws_of(found[0], 2000, rng)
    estimates = np.array([noise.predictors[-1] for noise in found])
    assert estimates.mean(axis=0) == pytest.approx(weights, abs=0.01)
    assert np.std(shift, axis=0) == pytest.approx(np.std(estimates, axis=0), rel=0.25)


def test_rows_of_one_noise_share_what_it_may_be_and_others_are_their_own():
    shape = np.full((N, 1), 1.0 / np.sqrt(N))
    one, other = (white(1.0, "", 20.0) for _ in range(2))
    halves = slice(0, N // 2), slice(N // 2, N)
    shared = scatter([(one, rows) for rows in halves], shape, 4000, np.random.default_rng(1))
    apart = scatter(list(zip((one, other), halves, strict=True)), shape, 4000, np.random.default_rng(1))
    assert np.std(apart**2) == pytest.approx(np.std(shared**2) / np.sqrt(2.0), rel=0.1)
    known = scatter([(one, halves[0])], shape, 4000, np.random.default_rng(1))
    assert np.min(known**2) > 0.5


@pytest.mark.parametrize("weight", [0.97, 0.9995])
def test_every_draw_is_a_process_that_ends(weight):
    _, shift = draws_of(coloured(weight, 40.0), 500, np.random.default_rng(1))
    assert np.all(np.abs(weight + shift) < 1.0)
