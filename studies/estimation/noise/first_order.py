"""Noise of the first order, AR(1), of what a fit leaves: its standard deviation and its colour for each sensor.

It is what a fit of few parameters uses, for which there is no library of effects; see `estimation` for noise from
repeats and from stretches at rest.
"""

import numpy as np

from apesim.studies.estimation.noise.estimation import FLOOR
from apesim.studies.estimation.noise.process import Noise, whitened

FITTED = {sensor: FLOOR[sensor] for sensor in ("lift", "pressure_a", "pressure_b")}
"""Sensors that are fitted, and the error of the simulator, below which no noise is believed [SI]."""
BELIEVED = 1.1
"""Times its standard deviation, up to which a noise is believed to be no more than that."""


def whiten(residuals: np.ndarray, times: np.ndarray, deviation: float, colour: float) -> np.ndarray:
    """AR(1) noise made white, of standard deviation 1.

    Parameters
    ----------
    residuals, times : (n,) float array
    deviation : float
        Of the noise.
    colour : float
        Correlation of neighbours a median interval apart; where intervals differ, it falls exponentially.

    Returns
    -------
    (n,) float array
    """
    steps = np.diff(times)
    usual = np.median(steps)
    if np.ptp(steps) < 0.01 * usual:
        spread = np.array([1.0, np.sqrt(1.0 - colour**2)])
        noise = Noise(deviation, (np.zeros(0), np.array([colour])), spread, "what is left")
        return whitened(noise, residuals[:, None], times)[:, 0]
    correlation = max(colour, 0.0) ** (steps / usual)
    rest = (residuals[1:] - correlation * residuals[:-1]) / np.sqrt(1.0 - correlation**2)
    return np.append(residuals[0], rest) / deviation


def noise_model(problem, x, stated):
    """Standard deviation and colour of each sensor's noise, and warnings.

    Parameters
    ----------
    problem : Problem
    x : (p,) float array
        The optimum.
    stated : dict
        Standard deviations that the user states [SI], by sensor.

    Returns
    -------
    noise : dict
        Deviation [SI] and colour of what is left, by sensor, if that is more than the sensor's noise; else of that.
    own : dict
        Of the sensor alone; white where what is left is more, and no repeats tell its colour.
    warnings : list of str
    """
    noise, own, warnings = {}, {}, []
    for sensor in dict.fromkeys(problem.sensors):
        pairs = [(run, r) for r, (run, of) in zip(problem.residuals(x), problem.blocks, strict=True) if of == sensor]
        deviation, colour = _deviation_and_colour([r for _, r in pairs])
        repeats = _repeat_differences(pairs)
        pure, pure_colour = _deviation_and_colour(repeats or [r for _, r in pairs])
        known = max(stated.get(sensor, pure), FITTED[sensor])
        # Colour makes a standard deviation less certain: by this share.
        chance = np.sqrt((1.0 + colour**2) / (1.0 - colour**2) / (2.0 * sum(len(r) for _, r in pairs)))
        own[sensor] = known, pure_colour
        if deviation > (BELIEVED + 3.0 * chance) * known:
            own[sensor] = known, pure_colour if repeats else 0.0
            warnings.append(
                f"{sensor}: the best fit is off by {deviation / known:.2f} times the noise; "
                "the intervals are widened accordingly, but the model may lack something"
            )
            known, pure_colour = deviation, colour
        noise[sensor] = known, pure_colour
    return noise, own, warnings


def _deviation_and_colour(errors):
    """Deviation and colour of AR(1) noise in several stretches."""
    power = sum(float(e @ e) for e in errors)
    lagged = sum(float(e[1:] @ e[:-1]) for e in errors)
    return np.sqrt(power / sum(map(len, errors))), min(max(lagged / power, -0.99), 0.999) if power else 0.0


def _repeat_differences(pairs):
    """Noise of runs that share a name, a pulse, a supply and times: what they differ by from their mean."""
    groups: dict = {}
    for run, r in pairs:
        groups.setdefault((run.name, run.pulse, run.supply, run.times.tobytes()), []).append(r)
    found = []
    for repeats in groups.values():
        if len(repeats) > 1:
            found += list((np.array(repeats) - np.mean(repeats, axis=0)) * np.sqrt(len(repeats) / (len(repeats) - 1)))
    return found


def rough_noise(problem, stated):
    """White noise, from the second differences where it is not stated.

    The variance is the mean square of second differences over 6: a difference-based estimate as that of Gasser and
    others [1]_.

    References
    ----------
    .. [1] T. Gasser, L. Sroka and C. Jennen-Steinmetz, "Residual variance and residual pattern in nonlinear
       regression", Biometrika 73, 1986, pp. 625-633.
    """
    noise = {}
    for sensor in dict.fromkeys(problem.sensors):
        bends = np.concatenate([np.diff(run.channels[sensor], 2) for run, of in problem.blocks if of == sensor])
        noise[sensor] = max(stated.get(sensor, np.sqrt(np.mean(bends**2) / 6.0)), FITTED[sensor]), 0.0
    return noise


def is_white(problem, x, noise):
    """Whether the whitened residuals have no correlation left over 20 lags (Ljung and Box), at 0.1 %.

    It is the test of Ljung and Box [1]_, of each block alone.

    References
    ----------
    .. [1] G. M. Ljung and G. E. P. Box, "On a measure of lack of fit in time series models", Biometrika 65, 1978,
       pp. 297-303, doi 10.1093/biomet/65.2.297.
    """
    from scipy.stats import chi2

    for r, (run, sensor) in zip(problem.residuals(x), problem.blocks, strict=True):
        e = whiten(r, run.times, *noise[sensor])
        n, lags = len(e), np.arange(1, min(20, len(e) // 4) + 1)
        correlation = np.array([e[lag:] @ e[:-lag] for lag in lags]) / (e @ e)
        if n * (n + 2) * np.sum(correlation**2 / (n - lags)) > chi2.isf(1e-3, len(lags)):
            return False
    return True
