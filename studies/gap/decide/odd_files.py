"""Test of the residuals of each channel of each run: whether one file is explained worse than noise allows.

The search for a gap looks along shapes that are common to all runs. A fault of one file has none of them, so nothing is
said to be explained before this test is passed by every channel of every file.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.noise.process import Noise, noise_for
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.gap.decide.windows import average_over_windows
from apesim.studies.gap.thresholds import MAX_ODD_SIZE, MIN_ODD_SIGMA, WINDOWS


class OddChannel(NamedTuple):
    """A channel of a run whose residuals are more than noise."""

    file: str
    """File of the run, see `apesim.studies.measured.MeasuredRun.file`."""
    sensor: str
    """Name of the channel."""
    rms: float
    """Root mean square of its residuals over the noise."""
    size: float
    """Root mean square over the noise of what is left of them once noise is taken off."""
    n_sigma: float
    """Standard deviations by which that is more than noise gives."""


class Excess(NamedTuple):
    """Energy of residuals beyond that of noise."""

    energy: float
    """Sum of squares beyond that of noise alone [standard deviations squared]."""
    sigma: float
    """Standard deviation of it by noise alone [standard deviations squared]."""

    @property
    def n_sigma(self) -> float:
        """Energy over its standard deviation."""
        return self.energy / self.sigma


def find_odd_channels(residuals: WhitenedResiduals, errors: np.ndarray) -> list[OddChannel]:
    """Find the channels of runs whose residuals are more than noise.

    Two sums of squares are compared with those of noise: of all residuals, and of their means over `WINDOWS` windows,
    where a slow drift shows that is far below the noise of a sample. A channel is odd where either is larger by
    `MIN_ODD_SIGMA` standard deviations of noise alone, and by the size `MAX_ODD_SIZE`.

    Parameters
    ----------
    residuals : apesim.studies.estimation.residuals.WhitenedResiduals
    errors : (n,) float array
        Whitened residuals without the pulls of the priors [standard deviations].

    Returns
    -------
    list of OddChannel
        The largest first.

    Examples
    --------
    >>> from apesim.studies.gap.example_bench import explain_example
    >>> explanation = explain_example()
    >>> residuals = explanation.calibrated.residuals
    >>> larger = 1.5 * explanation.calibrated.fitted.data_residuals
    >>> sorted(each.file for each in find_odd_channels(residuals, larger))
    ['p30.csv', 'p40.csv']
    >>> find_odd_channels(residuals, explanation.best.fitted.data_residuals)
    []
    """
    found = []
    for block, values in zip(residuals.blocks, residuals.by_block(errors), strict=True):
        if len(values) < WINDOWS:
            continue
        noise = noise_for(residuals.noise, block)
        excess = max(find_excesses(values, noise), key=lambda each: each.n_sigma)
        size = float(np.sqrt(max(0.0, excess.energy) / len(values)))
        if excess.n_sigma > MIN_ODD_SIGMA and size > MAX_ODD_SIZE:
            rms = float(np.sqrt(values @ values / len(values)))
            found.append(OddChannel(block.run.file, block.sensor, rms, size, excess.n_sigma))
    return sorted(found, key=lambda each: -each.size)


def find_excesses(values: np.ndarray, noise: Noise) -> list[Excess]:
    """Energy of residuals beyond that of noise: of all of them, and of their means over windows.

    Of n samples it is ``sum(e^2) - n``, of m windows ``sum(w^2) - m`` with ``w = sum(e) / sqrt(length)``. By noise
    alone their standard deviations are ``sqrt(2 n)`` and ``sqrt(2 m)``; where the noise is known from N samples only,
    ``2 n^2 / N`` and ``2 m^2 / N`` are added to the squares, with N over the order of its process more for the windows.

    Parameters
    ----------
    values : (n,) float array
        Whitened residuals of one channel [standard deviations].
    noise : apesim.studies.estimation.noise.process.Noise

    Returns
    -------
    list of Excess

    Examples
    --------
    >>> from apesim.studies.estimation.noise.process import white
    >>> values = np.random.default_rng(1).standard_normal(1000)
    >>> all([abs(each.n_sigma) < 3.0 for each in find_excesses(values, white(3e-5, "stated"))])
    True
    >>> [round(each.n_sigma) for each in find_excesses(values + 0.5, white(3e-5, "stated"))]
    [4, 19]
    """
    means = average_over_windows(values)
    n, m = len(values), len(means)
    unknown = 0.0 if np.isinf(noise.samples) else 2.0 / noise.samples
    return [
        Excess(float(values @ values) - n, float(np.sqrt(2.0 * n + unknown * n**2))),
        Excess(float(means @ means) - m, float(np.sqrt(2.0 * m + unknown * (1 + noise.order) ** 2 * m**2))),
    ]


def list_odd_files(odd: Iterable[OddChannel]) -> list[str]:
    """The files of odd channels, each once.

    Parameters
    ----------
    odd : iterable of OddChannel

    Returns
    -------
    list of str

    Examples
    --------
    >>> list_odd_files([OddChannel("a.csv", "lift", 1.6, 1.2, 30.0), OddChannel("a.csv", "pressure_a", 1.2, 0.6, 9.0)])
    ['a.csv']
    """
    return list(dict.fromkeys(each.file for each in odd))
