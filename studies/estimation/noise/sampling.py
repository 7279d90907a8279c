"""Uncertainty of a noise that is known from a limited number of samples only, and what it does to scores."""

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from apesim.studies.estimation.noise.process import noise_for

MEMORY = 2000
"""Samples after which noise has forgotten."""
STABLE = 0.999
"""Root of a process that still ends."""
LEAST = 1e-3
"""Shift of a weight that is worth a draw."""


def draws_of(noise, number, rng):
    """Noises that may be the true one.

    Of an autoregressive process that is known from n samples, the variance of its innovations has n degrees of freedom,
    and its weights have the covariance of large samples, their variance times the inverse of the process's own
    covariance over n (Brockwell and Davis [1]_).

    Parameters
    ----------
    noise : apesim.studies.estimation.noise.process.Noise
    number : int
    rng : numpy.random.Generator

    Returns
    -------
    variance : (number,) float array
        Of the innovations, over that which is taken.
    shift : (number, order) float array
        Of the weights of the samples before.

    References
    ----------
    .. [1] P. J. Brockwell and R. A. Davis, "Time Series: Theory and Methods", 2nd ed., Springer, 1991,
       doi 10.1007/978-1-4419-0320-4, section 8.1.
    """
    weights = noise.predictors[-1]
    shift = np.zeros((number, noise.order))
    known = np.isinf(noise.samples)
    if noise.order and not known:
        response = _response(weights)
        powers = [response[lag:] @ response[: MEMORY - lag] for lag in range(noise.order)]
        covariance = np.linalg.inv(toeplitz(powers)) / noise.samples
        shift = rng.multivariate_normal(shift[0], covariance, size=number)
        for one in shift:
            while one.any() and not _ends(weights + one):
                one *= 0.5 if np.max(np.abs(one)) > LEAST else 0.0
    if noise.is_stated:
        size = np.sum(_response(weights) ** 2)
        return np.array([size / np.sum(_response(weights + one) ** 2) for one in shift]), shift
    return np.ones(number) if known else noise.samples / rng.chisquare(noise.samples, number), shift


def _ends(weights):
    """Whether an autoregressive process forgets."""
    return np.max(np.abs(np.roots(np.append(1.0, -weights)))) <= STABLE


def _response(weights):
    """Response of an autoregressive process to one innovation."""
    return lfilter([1.0], np.append(1.0, -weights), np.eye(1, MEMORY)[0])


def scatter(parts, shapes, number, rng):
    """Factor by which scores of noise alone are larger, were the noise another that it may be.

    Parameters
    ----------
    parts : list of (Noise, slice)
        Rows of the shapes, and their noise; one object is one noise, rows of none are known.
    shapes : (n, m) float array
        Of length 1, the noise made white.
    number : int
    rng : numpy.random.Generator

    Returns
    -------
    (number, m) float array
    """
    groups = {}
    for noise, rows in parts:
        groups.setdefault(id(noise), (noise, []))[1].append(shapes[rows])
    power = np.ones((number, shapes.shape[1]))
    for noise, own in groups.values():
        variance, shift = draws_of(noise, number, rng)
        # What noise of other weights is once it is whitened has this spectrum, where it should be flat.
        length = next_fast_len(2 * max(map(len, own)))
        taken = _transfer(noise.predictors[-1][None, :], length)
        spectrum = variance[:, None] * (taken / _transfer(noise.predictors[-1] + shift, length))
        lines = sum(np.abs(rfft(part, length, axis=0)) ** 2 for part in own) * _weights(length)[:, None]
        power += (spectrum - 1.0) @ lines
    return np.sqrt(np.maximum(power, 0.0))


def _transfer(weights, length):
    """Power of the filters that whiten processes of some weights (number, order), at the lines of `rfft`."""
    return np.abs(rfft(np.column_stack([np.ones(len(weights)), -weights]), length, axis=1)) ** 2


def _weights(length):
    """Weights of the lines of `rfft` in the sum of squares."""
    weights = np.full(length // 2 + 1, 2.0 / length)
    weights[0] = 1.0 / length
    if length % 2 == 0:
        weights[-1] = 1.0 / length
    return weights


def parts_of(residuals):
    """The noise of each block's rows among those of `WhitenedResiduals.at`, as `scatter` takes it."""
    return [
        (noise_for(residuals.noise, block), rows)
        for block, rows in zip(residuals.blocks, residuals.block_slices(), strict=True)
    ]
