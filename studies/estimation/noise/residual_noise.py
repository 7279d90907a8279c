"""Noise of what a fit leaves of each sensor, where no library of effects says what it may be besides.

See `apesim.studies.estimation.noise.estimation` for noise from repeats and from stretches at rest.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from apesim.studies.estimation.noise.estimation import FLOOR
from apesim.studies.estimation.noise.process import Noise, autoregressive, take_deviation, white

BELIEVED = 1.1
"""Times its standard deviation, up to which a noise is believed to be no more than that."""
LEFT_OVER = "what the fit leaves"
MAX_LAG = 20
"""Lags over which what is left is tested for correlation: more would dilute what is seen at the first ones."""
CHANCE = 1e-3
"""Chance of white noise to be taken for another."""


def find_rough_noise(blocks: Sequence[Any], stated: Mapping[str, float]) -> dict[str, dict[float, Noise]]:
    """Find a white noise of each sensor to begin a fit with: the stated one [SI], else from second differences.

    The result is by sensor, as `noise_for` takes it.

    >>> from types import SimpleNamespace
    >>> values = np.linspace(0.0, 9e-3, 5000) + np.random.default_rng(1).normal(0.0, 3e-5, 5000)
    >>> noise = find_rough_noise([SimpleNamespace(sensor="lift", values=values)], {})
    >>> round(noise["lift"][0.0].deviation, 6)
    3e-05
    """
    noise = {}
    for sensor in dict.fromkeys(block.sensor for block in blocks):
        bends = np.concatenate([np.diff(block.values, 2) for block in blocks if block.sensor == sensor])
        deviation = stated.get(sensor, float(np.sqrt(np.mean(bends**2) / 6.0)))
        noise[sensor] = {0.0: white(max(deviation, FLOOR[sensor]), "second differences")}
    return noise


def find_noise_left_over(
    blocks: Sequence[Any], differences: Sequence[np.ndarray], stated: Mapping[str, float]
) -> tuple[dict[str, dict[float, Noise]], dict[str, dict[float, Noise]], list[str]]:
    """Find the noise of each sensor from what the best fit leaves, as an autoregressive process.

    `differences` are prediction less measurement of each block, at the optimum [SI]; the standard deviation is the
    stated one [SI], else from repeats, else from what is left, the colour from repeats, else from what is left. Returns
    by sensor the noise of what is left where that is more than the sensor's own, else the sensor's; the noise of the
    sensor alone, white where what is left is more and no repeats tell its colour; and warnings.

    >>> from types import SimpleNamespace
    >>> run = SimpleNamespace(name="p040", pulse=50e-3, supply=0.5e6)
    >>> times, values = np.arange(5000) * 1e-4, np.random.default_rng(1).normal(0.0, 3e-5, 5000)
    >>> block = SimpleNamespace(sensor="lift", run=run, times=times)
    >>> noise, _, warnings = find_noise_left_over([block], [values], {"lift": 2e-5})
    >>> round(noise["lift"][0.0].deviation, 6), warnings[0].partition(";")[0]
    (3e-05, 'lift: the best fit is off by 1.50 times the noise')
    """
    noise, sensor_noise, warnings = {}, {}, []
    for sensor in dict.fromkeys(block.sensor for block in blocks):
        pairs = [(block, d) for block, d in zip(blocks, differences, strict=True) if block.sensor == sensor]
        left_over = autoregressive([d for _, d in pairs], LEFT_OVER)
        contrasts = _repeat_contrasts(pairs)
        pure = autoregressive(contrasts, "repeats") if contrasts else left_over
        known = max(stated.get(sensor, pure.deviation), FLOOR[sensor])
        own = take_deviation(pure, known) if sensor in stated else pure._replace(deviation=known)
        # Colour makes a standard deviation less certain: by this share.
        colour = left_over.colour
        chance = np.sqrt((1.0 + colour**2) / (1.0 - colour**2) / (2.0 * sum(len(d) for _, d in pairs)))
        noise[sensor], sensor_noise[sensor] = {0.0: own}, {0.0: own}
        if left_over.deviation > (BELIEVED + 3.0 * chance) * known:
            sensor_noise[sensor] = {0.0: own if contrasts else white(known, own.source)}
            warnings.append(
                f"{sensor}: the best fit is off by {left_over.deviation / known:.2f} times the noise; "
                "the intervals are widened accordingly, but the model may lack something"
            )
            noise[sensor] = {0.0: left_over}
    return noise, sensor_noise, warnings


def _repeat_contrasts(pairs: Sequence[tuple[Any, np.ndarray]]) -> list[np.ndarray]:
    """Differences of runs that share a name, a pulse, a supply and times from their mean, of the noise's deviation."""
    groups: dict[tuple[Any, ...], list[np.ndarray]] = {}
    for block, difference in pairs:
        run = block.run
        groups.setdefault((run.name, run.pulse, run.supply, block.times.tobytes()), []).append(difference)
    found: list[np.ndarray] = []
    for repeats in groups.values():
        if len(repeats) > 1:
            spread = np.sqrt(len(repeats) / (len(repeats) - 1))
            found += list((np.array(repeats) - np.mean(repeats, axis=0)) * spread)
    return found


def is_white(whitened: Sequence[np.ndarray]) -> bool:
    """Tell whether whitened residuals [standard deviations] have no correlation left.

    It is the test of Ljung and Box (1978, doi 10.1093/biomet/65.2.297) at `CHANCE`. Blocks that are all zero, as those
    of data without noise, have none.

    >>> noise = np.random.default_rng(1).normal(size=500)
    >>> is_white([noise]), is_white([noise + 0.5 * np.roll(noise, 1)])
    (True, False)
    >>> is_white([np.zeros(500)])
    True
    """
    from scipy.stats import chi2

    for e in whitened:
        if not np.any(e):
            continue
        n, lags = len(e), np.arange(1, min(MAX_LAG, len(e) // 4) + 1)
        correlation = np.array([e[lag:] @ e[:-lag] for lag in lags]) / (e @ e)
        if n * (n + 2) * np.sum(correlation**2 / (n - lags)) > chi2.isf(CHANCE, len(lags)):
            return False
    return True
