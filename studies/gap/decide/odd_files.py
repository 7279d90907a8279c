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
    """Find the channels of runs whose residuals are more than noise, the largest first.

    Two sums of squares are compared with those of noise: of all residuals, and of their means over `WINDOWS` windows,
    where a slow drift shows that is far below the noise of a sample. A channel is odd where the larger excess is beyond
    `MIN_ODD_SIGMA` standard deviations of noise alone, and its size beyond `MAX_ODD_SIZE`; one with fewer than
    `WINDOWS` samples is not judged. `errors` (n,) are whitened residuals without the pulls of the priors [standard
    deviations].
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

    `values` (n,) are the whitened residuals of one channel [standard deviations]. Of n samples the energy is ``sum(e^2)
    - n``, of m windows ``sum(w^2) - m`` with ``w = sum(e) / sqrt(length)``. By noise alone their standard deviations
    are ``sqrt(2 n)`` and ``sqrt(2 m)``; where the noise is known from N samples only, ``2 n^2 / N`` and ``2 m^2 / N``
    are added to the squares, the latter times the square of one more than the order of the noise's process.

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
    """The files of odd channels, each once."""
    return list(dict.fromkeys(each.file for each in odd))
