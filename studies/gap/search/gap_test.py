"""The test for a gap: the largest score of all, against the largest that noise alone gives."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from apesim.studies.estimation.noise.process import Noise
from apesim.studies.estimation.noise.sampling import scatter
from apesim.studies.gap.search.score_test import Sensitivity
from apesim.studies.gap.thresholds import ALARM

NOISE_DRAWS = 500
"""Number of noises that are drawn, each of which may be the true one."""
SCORE_DRAWS = 40
"""Draws of scores from each."""
DRAWS = NOISE_DRAWS * SCORE_DRAWS
SEED = 20090715


class GapTest(NamedTuple):
    """Whether noise alone explains what the calibrated machine leaves: the first of two conditions for a gap."""

    p_value: float
    """Chance of noise alone to give as large a score."""
    largest: float
    """Largest score of all candidates and local shapes [standard deviations]."""
    limit: float
    """Score that noise alone exceeds with the chance `ALARM`."""

    @property
    def alarm(self) -> bool:
        """Whether what is left is more than noise: the chance is below `ALARM`."""
        return self.p_value < ALARM


def compare_with_noise(
    sensitivities: Sequence[Sensitivity], local: np.ndarray, errors: np.ndarray, parts: list[tuple[Noise, slice]]
) -> GapTest:
    """Compare the largest of all scores with the largest that noise alone gives, by Monte Carlo.

    The scores are ``-S'e`` over shapes S of length 1, those of the candidates and local ones. Noise alone gives them
    the covariance ``S'S``; each draw is scaled by what the noise may be, as it is known from so many samples only. With
    k of D draws at or above the largest score, the chance is ``(1 + k) / (1 + D)`` (Monte Carlo test [1]_).

    Parameters
    ----------
    sensitivities : sequence of apesim.studies.gap.search.score_test.Sensitivity
        What each candidate would do to the data; those that do not show are left out.
    local : (n + p, m) float array
        Shapes of no known cause, see `apesim.studies.gap.search.phases.find_local_shapes`.
    errors : (n + p,) float array
        Residuals of the model at its optimum [standard deviations].
    parts : list of (Noise, slice)
        Noise of each block's rows, see `apesim.studies.estimation.noise.sampling.parts_of`.

    Returns
    -------
    GapTest

    References
    ----------
    .. [1] A. C. Davison and D. V. Hinkley, "Bootstrap Methods and their Application", Cambridge University Press, 1997,
       doi 10.1017/CBO9780511802843, chapter 4.

    Examples
    --------
    >>> nothing = np.zeros(50)
    >>> local = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, 50), 3))[0]
    >>> compare_with_noise([], local, nothing, []).p_value, compare_with_noise([], local, 6.0 * local[:, 0], []).alarm
    (1.0, True)
    """
    sensitivities = [sensitivity for sensitivity in sensitivities if sensitivity.is_visible]
    shapes = np.column_stack([*(c.projected for c in sensitivities), local])
    lengths = np.linalg.norm(shapes, axis=0)
    shapes = shapes[:, lengths > 0.0] / lengths[lengths > 0.0]
    one_sided = np.array([c.probe.one_sided for c in sensitivities] + [False] * local.shape[1])[lengths > 0.0]
    seen = -(shapes.T @ errors)
    largest = float(np.max(np.where(one_sided, seen, np.abs(seen))))
    # Scores of white noise have the correlations of the shapes.
    values, vectors = np.linalg.eigh(shapes.T @ shapes)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    rng = np.random.default_rng(SEED)
    draws = rng.standard_normal((DRAWS, len(values))) @ root.T
    draws *= np.repeat(scatter(parts, shapes, NOISE_DRAWS, rng), SCORE_DRAWS, axis=0)
    highest = np.max(np.where(one_sided, draws, np.abs(draws)), axis=1)
    p_value = (1.0 + np.sum(highest >= largest)) / (1.0 + DRAWS)
    return GapTest(float(p_value), largest, float(np.quantile(highest, 1.0 - ALARM)))
