"""The test for a gap: the largest score of all, against the largest that noise alone gives."""

from collections.abc import Iterator, Sequence
from itertools import combinations, groupby
from typing import Any, NamedTuple

import numpy as np

from apesim.studies.estimation.noise.process import Noise
from apesim.studies.estimation.noise.sampling import scatter
from apesim.studies.estimation.scatter import Spread
from apesim.studies.estimation.scatter_sizes import draw_stretches
from apesim.studies.gap.search.score_test import Sensitivity
from apesim.studies.gap.thresholds import ALARM

NOISE_DRAWS = 500
"""Number of noises that are drawn, each of which may be the true one."""
SCORE_DRAWS = 40
"""Draws of scores from each."""
DRAWS = NOISE_DRAWS * SCORE_DRAWS
SEED = 20090715
CHUNK = 1000
"""Draws of which pairs are scored at a time."""
MAX_PAIR_COSINE = 0.99
"""Cosine between two effects from which they are no pair: their difference is within the march's own error."""


class GapTest(NamedTuple):
    """Whether noise alone explains what the calibrated machine leaves: the first of two conditions for a gap."""

    p_value: float
    """Chance of noise alone to give as large a score, or as large a score of two effects together."""
    largest: float
    """Largest score of all candidates and local shapes [standard deviations]."""
    limit: float
    """Score that noise alone exceeds with the chance `ALARM`."""
    pair: tuple[str, ...] = ()
    """Names of the two effects whose score together is the largest; (): there are no pairs."""
    largest_pair: float = 0.0
    """Their score: root of the sum of squares that both together take [standard deviations]."""

    @property
    def alarm(self) -> bool:
        """Whether what is left is more than noise: the chance is below `ALARM`."""
        return self.p_value < ALARM


def compare_with_noise(
    sensitivities: Sequence[Sensitivity],
    local: np.ndarray,
    errors: np.ndarray,
    parts: list[tuple[Noise, slice]],
    spreads: Sequence[tuple[Spread, slice]] = (),
) -> GapTest:
    """Compare the largest of all scores with the largest that noise alone gives, by Monte Carlo.

    The scores are ``-S'e`` over shapes S of length 1 in residuals e (n + p,) [standard deviations]: those of the
    candidates that show, and `local` (n + p, m) of no known cause, see `find_local_shapes`. Noise gives them the
    covariance ``S'S``, each draw scaled by what the noise may be; what scatters from run to run is Student's t, see
    `draw_stretches`. With k of D draws at or above the largest score, the chance is ``(1 + k) / (1 + D)`` (Davison and
    Hinkley 1997, doi 10.1017/CBO9780511802843, chapter 4). As two effects that mask each other have small scores alone,
    the largest score of two together is compared too, see `score_pairs`, and the smaller of both chances counts,
    against the smaller one that noise alone gives. `parts` give the noise of each block's rows, see `parts_of`,
    `spreads` how each run varies by scatter, and its rows.

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
    correlations = shapes.T @ shapes
    draws = _draw_scores(shapes, correlations, parts, spreads)
    highest = np.max(np.where(one_sided, draws, np.abs(draws)), axis=1)
    limit = float(np.quantile(highest, 1.0 - ALARM))
    pairs = list_pairs(sensitivities, correlations)
    if not len(pairs):
        return GapTest(_find_chances(highest, largest), largest, limit)
    together = score_pairs(seen[None, :], pairs, correlations, one_sided)[0]
    best = int(np.argmax(together))
    names = tuple(sensitivities[number].probe.candidate.name for number in pairs[best])
    if largest > np.max(highest):  # which no pair can make less probable by noise
        return GapTest(1.0 / (1.0 + DRAWS), largest, limit, names, float(together[best]))
    highest_pairs = score_best_pairs(draws, pairs, correlations, one_sided)
    smaller = min(_find_chances(highest, largest), _find_chances(highest_pairs, together[best]))
    smaller_by_noise = np.minimum(_find_chances(highest, highest), _find_chances(highest_pairs, highest_pairs))
    p_value = float((1.0 + np.sum(smaller_by_noise <= smaller)) / (1.0 + DRAWS))
    return GapTest(p_value, largest, limit, names, float(together[best]))


def _draw_scores(
    shapes: np.ndarray,
    correlations: np.ndarray,
    parts: list[tuple[Noise, slice]],
    spreads: Sequence[tuple[Spread, slice]],
) -> np.ndarray:
    """Scores that noise and scatter alone give shapes, (DRAWS, m)."""
    rng = np.random.default_rng(SEED)
    along = [(spread, spread.directions.T @ shapes[rows]) for spread, rows in spreads]
    # Scores of white noise have the correlations of the shapes.
    of_noise = correlations - sum((part.T @ part for _, part in along), np.zeros_like(correlations))
    values, vectors = np.linalg.eigh(of_noise)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    draws = rng.standard_normal((DRAWS, len(values))) @ root.T
    factors = np.repeat(scatter(parts, shapes, NOISE_DRAWS, rng), SCORE_DRAWS, axis=0)
    for spread, part in along:
        stretches = draw_stretches(spread.parts, DRAWS, rng)
        draws += (stretches * rng.standard_normal(stretches.shape)) @ part
    return draws * factors


def _find_chances(highest: np.ndarray, seen: "np.ndarray | float") -> Any:
    """The chance of each of some scores, or of a higher one, by the highest scores of draws."""
    ascending = np.sort(highest)
    above = len(ascending) - np.searchsorted(ascending, seen, side="left")
    chances = (1.0 + above) / (1.0 + len(ascending))
    return chances if np.ndim(seen) else float(chances)


def list_pairs(sensitivities: Sequence[Sensitivity], correlations: np.ndarray) -> np.ndarray:
    """The pairs of probes, places (k, 2), of two different effects of the library that are not nearly the same shape.

    The sensitivities stand first among the shapes, whose cosines are `correlations` (m, m).

    >>> from apesim.studies.gap.example_bench import find_example_gap
    >>> sensitivities = find_example_gap().sensitivities[:2]
    >>> list_pairs(sensitivities, np.eye(2)).tolist(), list_pairs(sensitivities, np.ones((2, 2))).tolist()
    ([[0, 1]], [])
    """
    effects = [
        (number, each.probe.candidate) for number, each in enumerate(sensitivities) if not each.probe.candidate.file
    ]
    pairs = [
        (first, second)
        for (first, one), (second, other) in combinations(effects, 2)
        if one.name != other.name and abs(correlations[first, second]) < MAX_PAIR_COSINE
    ]
    return np.array(pairs, dtype=int).reshape(-1, 2)


def score_pairs(scores: np.ndarray, pairs: np.ndarray, correlations: np.ndarray, one_sided: np.ndarray) -> np.ndarray:
    """Score pairs of shapes together [standard deviations]: the root of the sum of squares that both take, (d, k).

    With the scores a and b of two shapes of cosine r it is ``sqrt((a^2 + b^2 - 2 r a b) / (1 - r^2))``, a score test of
    two parameters (Rao 1948, doi 10.1017/S0305004100023987), and 0 where a strength that cannot be negative
    (`one_sided`, (m,) bool) would have to be. `scores` is (d, m) for d draws, `pairs` (k, 2), `correlations` (m, m).

    Two shapes that nearly cancel, each with a score of 1 alone:

    >>> correlations = np.array([[1.0, -0.9], [-0.9, 1.0]])
    >>> score_pairs(np.ones((1, 2)), np.array([[0, 1]]), correlations, np.array([False, False])).round(2).tolist()
    [[4.47]]
    """
    squared = np.concatenate(list(_square_pairs(scores, pairs, correlations, one_sided)))
    return np.sqrt(np.maximum(squared, 0.0)).T


def score_best_pairs(
    scores: np.ndarray, pairs: np.ndarray, correlations: np.ndarray, one_sided: np.ndarray
) -> np.ndarray:
    """Score the best pair of shapes of each draw, (d,) [standard deviations], see `score_pairs` for the arguments.

    `pairs` holds one pair at least.
    """
    best = np.zeros(len(scores))
    # A part of the draws at a time, so that what is worked on stays near the processor.
    for start in range(0, len(scores), CHUNK):
        part = best[start : start + CHUNK]
        for squared in _square_pairs(scores[start : start + CHUNK], pairs, correlations, one_sided):
            np.maximum(part, squared.max(axis=0), out=part)
    return np.sqrt(best)


def _square_pairs(
    scores: np.ndarray, pairs: np.ndarray, correlations: np.ndarray, one_sided: np.ndarray
) -> Iterator[np.ndarray]:
    """Squares of what `score_pairs` gives of the pairs of each first shape, (k, d); below 0 by rounding alone."""
    rows = np.ascontiguousarray(scores.T)
    squares = rows * rows
    for first, group in groupby(pairs.tolist(), key=lambda pair: pair[0]):
        others = [second for _, second in group]
        r, a, b = correlations[first, others][:, None], rows[first], rows[others]
        squared = (squares[first] + squares[others] - 2.0 * r * a * b) / (1.0 - r * r)
        if one_sided[first]:
            squared[a < r * b] = 0.0
        bound = one_sided[others]
        squared[bound] *= b[bound] >= r[bound] * a
        yield squared
