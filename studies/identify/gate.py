"""Runs that are not fitted, judged by whether more than noise is left between them and the model.

What is left is whitened by the noise of the sensors alone, and freed of what the parameters' uncertainty allows, to
first order: the least of ``|e - J d|^2 + d C^-1 d`` over shifts d of the parameters, with the sensitivities J of the
run and the covariance C of the parameters from the fitted runs. If the model is right this has the chi-square
distribution of as many degrees as samples, or Fisher's where the noise is not stated but estimated. A noise is believed
to a tenth of its standard deviation, as in the fit.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from apesim.studies.estimation.noise.residual_noise import BELIEVED, find_rough_noise
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.identify.profile import invert_curvature
from apesim.studies.identify.shift import find_time_shift
from apesim.studies.identify.simulation import Free, free_residuals, holds_in
from apesim.studies.measured import FIT, Measured, MeasuredRun

if TYPE_CHECKING:
    from apesim.studies.identify.fit import Identified

CHANCE = 1e-3
"""Chance of noise alone to contradict a model by one of the runs it is judged by."""


class Judgement(NamedTuple):
    """The judgement of the fitted model by a run that was not fitted."""

    run: str
    """Name of the data file."""
    time_shift_s: float
    """Largest time shift at equal lift in flight, positive where the measured piston is later [s]; NaN where nothing
    flies or lift is not measured."""
    noise_limit_s: float
    """Time shift that noise alone exceeds in one of twenty such runs [s]."""
    residual_over_noise: float
    """Root mean square of what is left over the noise; NaN without a sensor that is fitted."""
    limit: float
    """Value of `residual_over_noise` above which the model is contradicted."""
    contradicted: bool
    """Whether the run contradicts the model beyond noise."""


def judge(
    identified: "Identified", measured: Measured, free: Sequence[Free], runs: Sequence[MeasuredRun]
) -> list[Judgement]:
    """Judge the fitted model by runs that were not fitted; the parameters stay as they are.

    `measured` holds the runs that were fitted, `runs` those by which the model is judged.
    """
    if not runs:
        return []
    fitted = free_residuals(identified.machine, measured.of(FIT), free).with_noise(identified.noise)
    x = np.array([identified.parameters[f.key] / f.scale for f in free])
    sensitivities, _ = fitted.jacobian(x, fitted.at(x), identified.steps)
    samples = sum(len(block.values) for block in fitted.blocks)
    _, covariance = invert_curvature(sensitivities)
    judged = []
    for run in runs:
        kept = [j for j, f in enumerate(free) if holds_in(identified, f.key, run)]
        residuals = free_residuals(identified.machine, [run], [free[j] for j in kept])
        ratio, limit = np.nan, np.nan
        if residuals.blocks:
            noise = find_rough_noise(residuals.blocks, measured.noise) | identified.sensor_noise
            residuals = residuals.with_noise(noise)
            ratio = _left_over(residuals, x[kept], identified.steps[kept], covariance[np.ix_(kept, kept)])
            known = all(block.sensor in measured.noise for block in residuals.blocks)
            limit = _limit(residuals, None if known else samples, len(runs))
        shift = find_time_shift(identified, run)
        judged.append(Judgement(**shift, residual_over_noise=ratio, limit=limit, contradicted=bool(ratio > limit)))
    return judged


def _left_over(residuals: WhitenedResiduals, x: np.ndarray, steps: np.ndarray, covariance: np.ndarray) -> float:
    """Root mean square of the whitened residuals, less what the parameters' uncertainty allows."""
    values = residuals.at(x)
    e = values[: len(values) - len(x)]
    square = float(e @ e)
    if len(x):
        jacobian, _ = residuals.jacobian(x, values, steps)
        pull = jacobian.T @ values
        square -= pull @ np.linalg.solve(np.linalg.inv(covariance) + jacobian.T @ jacobian, pull)
    return float(np.sqrt(max(square, 0.0) / len(e)))


def _limit(residuals: WhitenedResiduals, estimated_from: int | None, runs: int) -> float:
    """Limit of `_left_over`; estimated_from: the samples that the noise is estimated from, None if it is stated."""
    from scipy.stats import chi2, f

    n, chance = sum(len(block.values) for block in residuals.blocks), CHANCE / runs
    square = chi2.isf(chance, n) / n if estimated_from is None else f.isf(chance, n, estimated_from)
    return float(BELIEVED * np.sqrt(square))
