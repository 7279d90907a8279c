"""Uncertainty of a noise that is known from a limited number of samples only, and what it does to scores."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from apesim.studies.estimation.noise.process import Noise, noise_for

MEMORY = 2000
"""Samples after which noise has forgotten."""
STABLE = 0.999
"""Root of a process that still ends."""
MIN_SHIFT = 1e-3
"""Smallest shift of a weight that is worth a draw."""


def draws_of(noise: Noise, number: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Draw noises that may be the true one: their variances (number,) and shifts of weights (number, order).

    Variances are those of the innovations, over that of the estimate. For a noise known from n samples they have n
    degrees of freedom, and the weights have the covariance of large samples (Brockwell and Davis 1991, doi
    10.1007/978-1-4419-0320-4, section 8.1). Where the deviation is known, the weights w alone are in doubt, and the
    variance of the innovations tells them, too: ``(d ln v / dw)^2 / 2`` more for each sample.
    """
    weights = noise.predictors[-1]
    shift = np.zeros((number, noise.order))
    known = np.isinf(noise.samples)
    if noise.order and not known:
        response = _response(weights)
        powers = [response[lag:] @ response[: MEMORY - lag] for lag in range(noise.order)]
        information = toeplitz(powers)
        if noise.is_stated:  # the size of the errors of prediction tells the weights, too
            twice = np.convolve(response, response)[:MEMORY]
            slope = 2.0 * np.array([response[lag:] @ twice[: MEMORY - lag] for lag in range(1, noise.order + 1)])
            information = information + 0.5 * np.outer(slope, slope) / powers[0] ** 2
        covariance = np.linalg.inv(information) / noise.samples
        shift = rng.multivariate_normal(shift[0], covariance, size=number)
        for draw in shift:
            while draw.any() and not _ends(weights + draw):
                draw *= 0.5 if np.max(np.abs(draw)) > MIN_SHIFT else 0.0
    if noise.is_stated:
        size = np.sum(_response(weights) ** 2)
        return np.array([size / np.sum(_response(weights + draw) ** 2) for draw in shift]), shift
    return np.ones(number) if known else noise.samples / rng.chisquare(noise.samples, number), shift


def _ends(weights: np.ndarray) -> bool:
    """Whether an autoregressive process forgets."""
    return bool(np.max(np.abs(np.roots(np.append(1.0, -weights)))) <= STABLE)


def _response(weights: np.ndarray) -> np.ndarray:
    """Response of an autoregressive process to one innovation."""
    return lfilter([1.0], np.append(1.0, -weights), np.eye(1, MEMORY)[0])


def scatter(
    parts: Sequence[tuple[Noise, slice]], shapes: np.ndarray, number: int, rng: np.random.Generator
) -> np.ndarray:
    """Draw the factors by which scores of noise alone are larger, were the noise another that it may be.

    `shapes`, (n, m), are whitened changes of the data, each of length 1, `parts` the noise of their rows: the same
    object is the same noise, and rows without any have a noise that is known. The factors are (number, m).
    """
    groups: dict[int, tuple[Noise, list[np.ndarray]]] = {}
    for noise, rows in parts:
        groups.setdefault(id(noise), (noise, []))[1].append(shapes[rows])
    power = np.ones((number, shapes.shape[1]))
    for noise, rows_of_noise in groups.values():
        variance, shift = draws_of(noise, number, rng)
        # What noise of other weights is once it is whitened has this spectrum, where it should be flat.
        length = next_fast_len(2 * max(map(len, rows_of_noise)))
        estimate = _transfer(noise.predictors[-1][None, :], length)
        spectrum = variance[:, None] * (estimate / _transfer(noise.predictors[-1] + shift, length))
        lines = sum(np.abs(rfft(part, length, axis=0)) ** 2 for part in rows_of_noise) * _weights(length)[:, None]
        power += (spectrum - 1.0) @ lines
    return np.sqrt(np.maximum(power, 0.0))


def _transfer(weights: np.ndarray, length: int) -> np.ndarray:
    """Power of the filters that whiten processes of some weights (number, order), at the lines of `rfft`."""
    return np.abs(rfft(np.column_stack([np.ones(len(weights)), -weights]), length, axis=1)) ** 2


def _weights(length: int) -> np.ndarray:
    """Weights of the lines of `rfft` in the sum of squares."""
    weights = np.full(length // 2 + 1, 2.0 / length)
    weights[0] = 1.0 / length
    if length % 2 == 0:
        weights[-1] = 1.0 / length
    return weights


def parts_of(residuals: Any) -> list[tuple[Noise, slice]]:
    """Find the noise of each block and its rows among those of whitened residuals, as `scatter` takes them."""
    return [
        (noise_for(residuals.noise, block), rows)
        for block, rows in zip(residuals.blocks, residuals.block_slices(), strict=True)
    ]
