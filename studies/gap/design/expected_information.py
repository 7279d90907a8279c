"""Expected information: how much an experiment would tell about which of several explanations holds."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

N_DRAWS = 256
"""Outcomes that are drawn under each explanation: the information is then found to about 0.02 bits."""
SEED = 1967
MIN_SPAN = 1e-8
"""Size of a direction over the largest, below which the others say all of it."""


class Forecast(NamedTuple):
    """Outcome of an experiment as an explanation foresees it: normal, its noise independent and of the size 1."""

    mean: np.ndarray
    """Whitened samples that are expected, (n,) [standard deviations]."""
    spread: np.ndarray
    """Change of the samples by one standard deviation of each of q independent unknowns, (n, q) [standard deviations].
    The covariance of the samples is ``I + spread spread'``."""

    def take(self, rows: np.ndarray) -> "Forecast":
        """The forecast of a part of the samples: those whose entry in `rows`, (n,) bool, is true."""
        return Forecast(self.mean[rows], self.spread[rows])


def find_entropy(weights: Sequence[float] | np.ndarray) -> float:
    """Entropy [bit] of the weights of explanations, ``-sum(w log2(w))``: what is open between them; (k,), sum 1."""
    positive = np.array([weight for weight in weights if weight > 0.0])
    return float(abs(np.sum(positive * np.log2(positive))))


def find_separation(truth: Forecast, rival: Forecast) -> float:
    """Find by how many sigmas a rival misses what the truth gives, everything unknown of the rival fitted anew.

    With the difference d of both means and the rival's spread A it is ``sqrt(d'(I + A A')^-1 d)``, the root of the
    least ``|d - A s|^2 + s's`` over shifts s of the rival's unknowns.

    >>> truth, rival = Forecast(np.array([3.0, 0.0]), np.zeros((2, 1))), Forecast(np.zeros(2), np.zeros((2, 1)))
    >>> find_separation(truth, rival)
    3.0
    >>> round(find_separation(truth, rival._replace(spread=np.array([[10.0], [0.0]]))), 1)  # it could imitate the truth
    0.3
    """
    difference, spread = truth.mean - rival.mean, rival.spread
    slope = spread.T @ difference
    taken = slope @ np.linalg.solve(np.eye(spread.shape[1]) + spread.T @ spread, slope)
    return float(np.sqrt(max(difference @ difference - taken, 0.0)))


def find_information(
    forecasts: Sequence[Forecast], weights: Sequence[float] | np.ndarray, draws: int = N_DRAWS
) -> float:
    """Find the expected information of an experiment [bit]: by how much it lowers the entropy of the explanations.

    It is the mutual information (Lindley 1956, doi 10.1214/aoms/1177728069) of explanation k and outcome y, ``sum_k w_k
    E_k[log2(p_k(y) / sum_j w_j p_j(y))]``, proposed for choosing between models by Box and Hill (1967, doi
    10.1080/00401706.1967.10490441); the weights (k,) before the experiment have the sum 1. Under each explanation in
    turn `draws` outcomes are drawn, always the same; all densities are normal, so only the directions matter in which
    means and spreads differ.

    Two explanations of the same weight, that differ by 0, 2 and 20 sigmas in one sample:

    >>> here = Forecast(np.zeros(1), np.zeros((1, 1)))
    >>> away = [here._replace(mean=np.array([size])) for size in (0.0, 2.0, 20.0)]
    >>> [round(find_information([here, other], [0.5, 0.5]), 1) for other in away]
    [0.0, 0.5, 1.0]
    """
    first = forecasts[0].mean
    span = _find_span([*(forecast.spread for forecast in forecasts), *_columns(forecasts, first)])
    means = [span.T @ (forecast.mean - first) for forecast in forecasts]
    roots = [np.linalg.cholesky(np.eye(span.shape[1]) + (s := span.T @ f.spread) @ s.T) for f in forecasts]
    rng = np.random.default_rng(SEED)
    noise, log_weights = rng.standard_normal((span.shape[1], draws)), np.log(np.maximum(weights, 1e-300))
    information = 0.0
    for number, weight in enumerate(weights):
        outcomes = means[number][:, None] + roots[number] @ noise
        logs = np.array([_log_density(outcomes, *pair) for pair in zip(means, roots, strict=True)])
        whole = np.logaddexp.reduce(logs + log_weights[:, None], axis=0)
        information += weight * float(np.mean(logs[number] - whole))
    return float(np.clip(information / np.log(2.0), 0.0, find_entropy(weights)))


def _columns(forecasts: Sequence[Forecast], first: np.ndarray) -> list[np.ndarray]:
    """Differences of the means to the first, as columns."""
    return [(forecast.mean - first)[:, None] for forecast in forecasts[1:]]


def _find_span(parts: list[np.ndarray]) -> np.ndarray:
    """Orthonormal columns that span those of several arrays, (n, r)."""
    columns = np.column_stack(parts)
    left, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return left[:, sizes > MIN_SPAN * max(float(sizes[0]), 1.0)]


def _log_density(outcomes: np.ndarray, mean: np.ndarray, root: np.ndarray) -> np.ndarray:
    """Logarithms of a normal density at outcomes (r, m), its constant left out; (m,)."""
    scaled = solve_triangular(root, outcomes - mean[:, None], lower=True)
    return -0.5 * np.sum(scaled**2, axis=0) - float(np.sum(np.log(np.diag(root))))
