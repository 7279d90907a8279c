"""Sizes of a scatter between runs, from what repeats of a run differ by.

Three pairs of repeats say little of four sizes. So they are not estimated but drawn: from all that are possible by the
repeats and by what is known of each number beforehand, with tails as heavy as a laboratory's bad days.
"""

from collections.abc import Sequence
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize
from scipy.special import logsumexp
from scipy.stats import chi2, norm, t

from apesim.studies.estimation.heavy_tails import FREEDOM
from apesim.studies.measured import MeasuredRun

MIN_FALL = 10.0
"""Fall of twice the negative log likelihood from which repeats show a scatter: four sizes that are not there give 9.5
in one case of twenty."""
ODD_CHANCE = 0.05
"""Chance of scatter and noise alone, in one set of repeats, below which the oddest tells nothing of the scatter."""
FAR, QUIET = 5.0, 2.0
"""Root mean squares of differences of repeats over noise, beyond which one set is far apart, and below which others are
no more than noise."""
USUAL = 0.3
"""Size of a scatter before repeats are seen, in prior standard deviations: what is not known of a number is mostly the
same in all runs, or it would have been noticed."""
COVER = 0.975
"""Quantile at which a size is as wide as what is drawn."""
LARGEST = 100.0
"""Largest size that is tried, in prior standard deviations."""
GRID = np.logspace(-3.0, 1.3, 60)
"""Sizes among which one is drawn, in prior standard deviations."""
FACTORS = np.logspace(-1.0, 3.0, 60)
"""Factors among which that of the variances of one contrast is drawn."""
TAILS = chi2.logpdf(FREEDOM / FACTORS, FREEDOM) - np.log(FACTORS)
"""Logarithm of the weight of each factor by Student's t, but for a constant."""
NARROWER = float((norm.ppf(COVER) / t.ppf(COVER, FREEDOM)) ** 2)
"""Variance of Student's t, but for its factor, over that of the normal number that reaches as far at `COVER`."""
CHAINS, SWEEPS = 256, 8
"""Sets of sizes that are drawn, and rounds of drawing one size of each after the other."""
SEED = 8302


class Contrast(NamedTuple):
    """What two parts of a set of repeats differ by, along the directions in which scatter moves it."""

    files: tuple[str, ...]
    """Files that it is made of."""
    values: np.ndarray
    """Independent and of variance one by noise alone, (k,)."""
    slopes: np.ndarray
    """Change of the values by each size, (k, p)."""


def list_contrasts(
    runs: Sequence[MeasuredRun], errors: Sequence[np.ndarray], columns: Sequence[np.ndarray]
) -> list[Contrast]:
    """List what repeats of runs differ by: Helmert's contrasts, along the directions in which scatter moves them.

    `errors` are the whitened residuals of each run, (n,), `columns` what each scattering number does to them, (n, p).
    Directions in which a scatter of the size `USUAL` moves less than noise are left out: they say little of it, and
    what is bent of larger ones shows there.
    """
    groups: dict[Any, list[int]] = {}
    for number, run in enumerate(runs):
        groups.setdefault((run.name, run.role, len(errors[number])), []).append(number)
    found = []
    for numbers in groups.values():
        basis, lengths, ways = np.linalg.svd(np.mean([columns[number] for number in numbers], axis=0), False)
        seen = USUAL * lengths > 1.0
        if not seen.any():
            continue
        basis, slopes = basis[:, seen], lengths[seen, None] * ways[seen]
        along = [basis.T @ errors[number] for number in numbers]
        for k in range(1, len(numbers)):
            values = (np.sum(along[:k], axis=0) - k * along[k]) / sqrt(k * (k + 1.0))
            found.append(Contrast(tuple(runs[number].data for number in numbers[: k + 1]), values, slopes))
    return found


def find_sizes(contrasts: Sequence[Contrast], stated: np.ndarray | None = None) -> tuple[np.ndarray, list[Contrast]]:
    """Find how much each number scatters, (p,), and the contrasts that tell it: those that scatter explains.

    Sizes are in prior standard deviations: those `stated` (NaN: the contrasts are to tell), and zeros where none is
    stated and the contrasts are no more than noise, or none. Beforehand a size is half a normal number of the standard
    deviation `USUAL`, which also says what scatters where the repeats do not; what scatters is Student's t of `FREEDOM`
    degrees of freedom. Sizes are drawn from what is possible then, one after the other (Gibbs sampling, Geman and Geman
    1984, doi 10.1109/TPAMI.1984.4767596), and become the size of a normal number that reaches as far as all draws
    together do at `COVER`.
    """
    if not contrasts:
        return np.zeros(0) if stated is None else np.nan_to_num(stated), []
    if stated is None:
        stated = np.full(contrasts[0].slopes.shape[1], np.nan)
    told, kept = np.isnan(stated), list(contrasts)
    while True:
        sizes = _draw_sizes(kept, stated)
        if len(kept) < (2 if told.any() else 1):
            break
        chances = [_chance(each, sizes) for each in kept]
        odd = int(np.argmin(chances))
        others = kept[:odd] + kept[odd + 1 :]
        if _chance(kept[odd], _draw_sizes(others, stated)) * len(kept) > ODD_CHANCE:
            break
        kept = others
    if not told.any() or _fall(kept, stated) < MIN_FALL:
        return np.nan_to_num(stated), kept
    found = stated.copy()
    found[told] = np.array([_reach(drawn) for drawn in sizes.T[told]]) / norm.ppf(COVER)
    return found, kept


def find_lone(contrasts: Sequence[Contrast]) -> tuple[str, ...]:
    """Find the files of the only set of repeats that is far apart, where two others or more are no more than noise.

    Scatter between runs may do that, and so may one record that is wrong: these data do not tell. () where there is no
    such set.

    >>> quiet = [Contrast((f"{name}1.csv", f"{name}2.csv"), np.array([0.7, -1.0]), np.eye(2)) for name in "ab"]
    >>> far = Contrast(("c1.csv", "c2.csv"), np.array([13.0, 1.0]), np.eye(2))
    >>> find_lone([*quiet, far]), find_lone([*quiet[:1], far])  # of two alone none is the odd one
    (('c1.csv', 'c2.csv'), ())
    >>> find_lone([*quiet, far, far._replace(files=("d1.csv", "d2.csv"))])
    ()
    """
    if not contrasts:
        return ()
    sizes = [float(np.sqrt(np.mean(each.values**2))) for each in contrasts]
    lone = contrasts[int(np.argmax(sizes))].files
    others = [size for size, each in zip(sizes, contrasts, strict=True) if set(each.files).isdisjoint(lone)]
    return lone if max(sizes) > FAR and len(others) > 1 and max(others) < QUIET else ()


def find_relief(values: np.ndarray, shares: np.ndarray) -> float:
    """Find by how much twice the negative log likelihood falls if what scatters is Student's t, and not normal.

    `values`, (k,), are white samples along the directions in which scatter moves a run [standard deviations], `shares`
    the share of the variance of each that is scatter, the rest being noise. The normal number is the one of
    `find_sizes`, which reaches as far as Student's t does at `COVER`; the result is above 0 where a run lies farther
    off than normal scatter does.

    >>> shares = np.array([0.99, 0.5])
    >>> [round(find_relief(np.array([far, 0.0]), shares), 1) for far in (0.0, 1.0, 3.0, 10.0)]
    [0.8, -0.3, 0.4, 78.4]
    """
    variances = 1.0 + (NARROWER * FACTORS[:, None] - 1.0) * shares
    logs = TAILS - 0.5 * (np.log(variances) + values**2 / variances).sum(axis=1)
    return float(values @ values + 2.0 * (logsumexp(logs) - logsumexp(TAILS)))


def draw_stretches(shares: np.ndarray, number: int, rng: np.random.Generator) -> np.ndarray:
    """Draw by how much a run lies farther off, or less far, than if its scatter were normal, see `find_relief`.

    `shares`, (k,), are the shares of the variance of each white sample that are scatter, the rest being noise. The
    factors of the samples are (number, k), each draw by one factor of Student's t.

    >>> drawn = draw_stretches(np.array([1.0, 0.0]), 10000, np.random.default_rng(1))
    >>> wide = drawn[:, 0] * np.random.default_rng(2).standard_normal(10000)
    >>> round(float(np.quantile(np.abs(wide), 0.95)), 1), float(drawn[:, 1].max())  # a normal number has 1.96 there
    (2.0, 1.0)
    """
    factors = FREEDOM / rng.chisquare(FREEDOM, number)
    return np.sqrt(1.0 + (NARROWER * factors[:, None] - 1.0) * shares)


def _reach(sizes: np.ndarray) -> float:
    """Quantile at `COVER` of Student's t, over the sizes drawn."""
    ends = np.array([0.5, 2.0]) * t.ppf(COVER, FREEDOM) * (sizes.min(), sizes.max())
    return float(brentq(lambda end: np.mean(t.sf(end / sizes, FREEDOM)) - (1.0 - COVER), *ends))


def _draw_sizes(contrasts: Sequence[Contrast], stated: np.ndarray) -> np.ndarray:
    """Sizes that are possible by the contrasts, (CHAINS, p), from Gibbs' sampler, and those that are stated.

    Of a size that is stated the normal number reaches as far as what is drawn, see `find_relief`.
    """
    rng = np.random.default_rng(SEED)
    sizes = np.tile(np.where(np.isnan(stated), 0.3, stated * sqrt(NARROWER)), (CHAINS, 1))
    factors = np.ones((CHAINS, len(contrasts)))
    for _ in range(SWEEPS):
        for number in np.flatnonzero(np.isnan(stated)).tolist():
            others = sizes.copy()
            others[:, number] = 0.0
            logs = (
                -0.5 * (GRID / USUAL) ** 2 + np.log(GRID) + np.zeros((CHAINS, 1))
            )  # a step of the grid is a share of the size
            for contrast, factor in zip(contrasts, factors.T, strict=True):
                logs += _log_likelihood(contrast, factor, others, number)
            sizes[:, number] = _pick(rng, logs, GRID)
        for place, contrast in enumerate(contrasts):
            along, squares = _principal(contrast, sizes)
            spread = 1.0 + FACTORS[:, None] * squares[:, None, :]
            logs = TAILS - 0.5 * (np.log(spread) + along[:, None, :] / spread).sum(axis=2)
            factors[:, place] = _pick(rng, logs, FACTORS)
    return sizes


def _pick(rng: np.random.Generator, logs: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """A value of a grid for each row of logarithms of chances."""
    shares = np.cumsum(np.exp(logs - logs.max(axis=1, keepdims=True)), axis=1)
    places = (shares < rng.random((len(logs), 1)) * shares[:, -1:]).sum(axis=1)
    return grid[np.minimum(places, len(grid) - 1)]


def _log_likelihood(contrast: Contrast, factor: np.ndarray, others: np.ndarray, number: int) -> np.ndarray:
    """Log likelihood of a contrast for each size of one number, the others being as they are; but for a constant."""
    slopes, column = contrast.slopes, contrast.slopes[:, number]
    covariance = np.eye(len(column)) + np.einsum("ij,cj,kj->cik", slopes, factor[:, None] * others**2, slopes)
    solved = np.linalg.solve(covariance, np.column_stack([column, contrast.values]))
    slope, value = column @ solved[:, :, 0].T, column @ solved[:, :, 1].T
    more = factor[:, None] * GRID**2
    wider = 1.0 + more * slope[:, None]
    return -0.5 * np.log(wider) + 0.5 * more * value[:, None] ** 2 / wider


def _principal(contrast: Contrast, sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Squares of a contrast along the principal directions of its scatter, and its variances there, (CHAINS, k)."""
    scatter = np.einsum("ij,cj,kj->cik", contrast.slopes, sizes**2, contrast.slopes)
    variances, directions = np.linalg.eigh(scatter)
    along = np.einsum("cik,i->ck", directions, contrast.values)
    return along**2, np.maximum(variances, 0.0)


def _chance(contrast: Contrast, sizes: np.ndarray) -> float:
    """Chance of a contrast as unlikely, over sizes that are possible and factors of Student's t."""
    along, squares = _principal(contrast, sizes)
    whole = (along[:, None, :] / (1.0 + FACTORS[:, None] * squares[:, None, :])).sum(axis=2)
    weights = np.exp(TAILS)
    return float(np.mean(chi2.sf(whole, len(contrast.values)) @ weights) / weights.sum())


def _fall(contrasts: Sequence[Contrast], stated: np.ndarray) -> float:
    """Fall of twice the negative log likelihood from no scatter but the stated one to the most probable one."""
    told = np.isnan(stated)
    least, number = np.nan_to_num(stated) ** 2, int(told.sum())

    def variances(sizes: np.ndarray) -> np.ndarray:
        whole = least.copy()
        whole[told] = sizes**2
        return whole

    def price(sizes: np.ndarray) -> float:
        return float(sizes @ sizes) / USUAL**2 + sum(_price(each, variances(sizes)) for each in contrasts)

    ends = [minimize(price, np.full(number, start), bounds=[(0.0, LARGEST)] * number) for start in (0.1, 1.0)]
    best = variances(min(ends, key=lambda end: end.fun).x)
    return sum(_price(each, least) - _price(each, best) for each in contrasts)


def _price(contrast: Contrast, variances: np.ndarray) -> float:
    """Twice the negative log likelihood of a contrast, but for a constant."""
    covariance = np.eye(len(contrast.values)) + (contrast.slopes * variances) @ contrast.slopes.T
    return float(np.linalg.slogdet(covariance)[1] + contrast.values @ np.linalg.solve(covariance, contrast.values))
