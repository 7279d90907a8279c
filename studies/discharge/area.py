"""The effective area of a valve over time, from the noisy pressures of all its discharge tests at once.

Nothing noisy is differentiated: S(t), straight between knots, is fitted through the forward law of
`apesim.studies.discharge.vessel` to all samples of all tests.

- Smoothing: S is a random walk from S(0) = 0, whose steps have the variance ``rate * h``. The rate is that of the
  largest marginal likelihood (empirical Bayes, fixed-point iteration), times `UNDERSMOOTHED`, so that smoothing takes
  less off the corners of a ramp than the noise puts on. It fades as 1/t^2 once the valve has opened.
- Noise: of each test's own deviation, the root mean square of the residuals, but not less than before the valve
  is switched; colour (AR(1)) found there counts as fewer samples.
- Band: 95 % of a normal distribution with the deviation of the estimate under the noise, and with a bias, which is what
  smoothing does to the estimate itself, made monotone, times `BIAS_LOST`.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from apesim.studies.discharge.records import Record, noise_before
from apesim.studies.discharge.vessel import Descent, Vessel

NORMAL_95 = 1.959964
"""Half the width of a 95 % interval of a normal distribution, in standard deviations."""
BIAS_LOST = 2.0
"""A second smoothing takes about half of what the first took off a corner, for the first has rounded it."""
UNDERSMOOTHED = 4.0
"""Factor on the rate of the random walk: smoothing then takes less off a corner than the noise puts on."""
MAX_ROUNDS = 40
"""Rounds of the fixed point, which ends as soon as it is `SETTLED`."""
PILOT_KNOTS, KNOTS = 80, 120
"""Intervals between knots: of the pilot fit in all, of the fit until the valve has opened."""
SETTLED = 1e-4
"""Largest change of S over its largest value at which the fit is done."""


class AreaFit(NamedTuple):
    """An effective area over time, at j knots."""

    knots: np.ndarray
    """[s], shape (j,); the first is the switching command, 0."""
    area: np.ndarray
    """[m2], shape (j,)"""
    half_band: np.ndarray
    """Half the width of the point-wise 95 % band [m2], shape (j,)."""
    covariance: np.ndarray
    """Covariance of the estimate under the noise [m4], shape (j, j)."""
    noise: np.ndarray
    """Standard deviation of each test [Pa]."""
    pressures: list[np.ndarray]
    """Fitted, at the samples of each test [Pa abs]."""
    rate: float
    """Rate of the random walk before the valve is open [m4/s]."""


def integrals(times: np.ndarray, knots: np.ndarray) -> np.ndarray:
    """Matrix that turns a curve at knots 1, 2, ... (0 at the first, straight between) into its integral up to times.

    Times (n,), knots (j,) and matrix (n, j - 1) are in s.

    >>> integrals(np.array([0.5, 2.0]), np.array([0.0, 1.0, 2.0])).tolist()
    [[0.125, 0.0], [1.0, 0.5]]
    """
    h = np.diff(knots)
    halves = np.tril(np.ones((len(knots), len(h))), -1) * h / 2.0  # of all intervals before a knot
    to_knots = np.pad(halves, ((0, 0), (0, 1))) + np.pad(halves, ((0, 0), (1, 0)))
    i = np.clip(np.searchsorted(knots, times, side="right") - 1, 0, len(h) - 1)
    u = np.clip(times - knots[i], 0.0, None)
    matrix, rows = to_knots[i], np.arange(len(times))
    matrix[rows, i] += u - u**2 / (2.0 * h[i])
    matrix[rows, i + 1] += u**2 / (2.0 * h[i])
    return matrix[:, 1:]


def _knots(end: float, opened: float) -> np.ndarray:
    """Knots [s]: evenly spaced until the valve has opened, then ever farther apart, as the random walk fades."""
    if end <= opened:
        return np.linspace(0.0, end, KNOTS + 1)
    more = int(np.ceil(KNOTS * np.log(end / opened)))
    return np.append(np.linspace(0.0, opened, KNOTS + 1), np.geomspace(opened, end, more + 1)[1:])


class _Tests:
    """Tests, and knots at which their common area is sought."""

    def __init__(self, vessel: Vessel, records: Sequence[Record], knots: np.ndarray, opened: float) -> None:
        self.knots, self.steps = knots, np.diff(knots)
        self.fading = np.minimum(1.0, opened / knots[1:]) ** 2
        self.records = records
        self.descents: list[Descent] = []
        self.matrices: list[np.ndarray] = []
        self.noise: list[float] = []
        self.samples_lost: list[float] = []
        for number, record in enumerate(records):
            self.descents.append(Descent(vessel, record.pressures[record.times <= 0.0].mean()))
            offsets = np.zeros((len(record.times), len(records)))
            offsets[:, number] = 1.0  # what the initial pressure, known from few samples, is wrong by
            self.matrices.append(np.hstack((integrals(record.times, knots), offsets)))
            deviation, colour = noise_before(record)
            self.noise.append(deviation)
            self.samples_lost.append((1.0 + colour) / (1.0 - colour))
        self.min_noise = self.noise.copy()

    def linear(self, unknowns: np.ndarray | None) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
        """Information matrix and vector of the law, linear about the unknowns, and the fitted pressures."""
        size, fitted = self.matrices[0].shape[1], []
        information, vector = np.zeros((size, size)), np.zeros(size)
        for i, (record, descent, matrix) in enumerate(zip(self.records, self.descents, self.matrices, strict=True)):
            passed = descent.passed_at(record.pressures) if unknowns is None else matrix @ unknowns
            pressure, fall = descent.pressure(passed)
            weighted = matrix.T * (fall**2 / (self.noise[i] ** 2 * self.samples_lost[i]))
            information += weighted @ matrix
            vector += weighted @ (passed - (record.pressures - pressure) / fall)
            fitted.append(pressure)
        return information, vector, fitted

    def penalty(self, rate: float) -> np.ndarray:
        """Inverse covariance of the random walk, bordered by zeros for the initial pressures."""
        count = len(self.steps)
        walk = np.eye(count) - np.eye(count, k=-1)
        whole = np.zeros((count + len(self.records),) * 2)
        whole[:count, :count] = (walk.T / (rate * self.fading * self.steps)) @ walk
        return whole

    def update_noise(self, fitted: Sequence[np.ndarray], freedom: float) -> None:
        """Estimate the noise from the residuals of the fit."""
        share = 1.0 - freedom / sum(len(record.times) for record in self.records)
        for i, record in enumerate(self.records):
            rms = np.sqrt(np.mean((record.pressures - fitted[i]) ** 2) / max(share, 0.1))
            self.noise[i] = max(float(rms), self.min_noise[i])


def _inverse(matrix: np.ndarray) -> np.ndarray:
    """Inverse of a positive matrix of very unequal scales."""
    scale = np.sqrt(np.diag(matrix))
    return np.linalg.inv(matrix / np.outer(scale, scale)) / np.outer(scale, scale)


def _solve(tests: _Tests) -> tuple[np.ndarray, np.ndarray, np.ndarray, float, list[np.ndarray]]:
    """Unknowns, their gain matrix (covariance of the Bayesian), information, rate and fitted pressures."""
    count = len(tests.steps)
    unknowns: np.ndarray | None = None
    pairs = zip(tests.descents, tests.records, strict=True)
    scale = np.mean([descent.passed_at(r.pressures[-1]) / r.times[-1] for descent, r in pairs])  # a mean area
    rate = scale**2 / tests.knots[-1]
    min_rate = 1e-9 * rate
    for round_ in range(MAX_ROUNDS):
        information, vector, fitted = tests.linear(unknowns)
        penalty = tests.penalty(rate)
        gain = _inverse(information + penalty)
        freedom = np.sum(gain * information)
        solution = gain @ vector
        if round_:
            tests.update_noise(fitted, freedom)
        rate = max(rate * (solution @ penalty @ solution) / max(freedom - len(tests.records), 0.5), min_rate)
        change = np.inf if unknowns is None else np.abs(solution - unknowns)[:count].max()
        unknowns = solution
        if round_ > 3 and change < SETTLED * np.abs(solution[:count]).max():
            break
    rate *= UNDERSMOOTHED
    for _ in range(3):
        information, vector, fitted = tests.linear(unknowns)
        gain = _inverse(information + tests.penalty(rate))
        unknowns = solution = gain @ vector
    return solution, gain, information, rate, fitted


def monotone(area: np.ndarray, half_band: np.ndarray) -> np.ndarray:
    """Find the nearest curve that never falls and is nowhere negative, weighted by half the width of its band.

    Curve and band are in m2; it is SciPy's isotonic regression (Busing 2022, doi 10.18637/jss.v102.c01).

    >>> monotone(np.array([-1.0, 3.0, 2.0, 5.0]), np.ones(4)).tolist()
    [0.0, 2.5, 2.5, 5.0]
    """
    from scipy.optimize import isotonic_regression

    return np.clip(isotonic_regression(area, weights=1.0 / half_band**2).x, 0.0, None)


def _finished(tests: _Tests, solution: tuple[Any, ...]) -> AreaFit:
    """The `AreaFit` of a solution."""
    from scipy.stats import ncx2

    unknowns, gain, information, rate, fitted = solution
    count = len(tests.steps)
    covariance = (gain @ information @ gain)[:count, :count]
    deviation = np.sqrt(np.diag(covariance))
    smooth = np.append(monotone(unknowns[:count], deviation), np.zeros(len(tests.records)))
    bias = BIAS_LOST * np.abs(gain @ (information @ smooth) - smooth)[:count] / deviation
    near = np.clip(bias, 1e-6, 5.0)
    half = deviation * np.where(bias < 5.0, np.sqrt(ncx2.ppf(0.95, 1, near**2)), bias + 1.645)
    whole = np.zeros((count + 1, count + 1))
    whole[1:, 1:] = covariance
    area = np.append(0.0, unknowns[:count])
    return AreaFit(tests.knots, area, np.append(0.0, half), whole, np.array(tests.noise), fitted, rate)


def _opened_at(fit: AreaFit) -> float:
    """Twice the time at which an area has come to 95 % of its middle value over the later half [s]."""
    rising = monotone(fit.area[1:], fit.half_band[1:])
    level = np.median(rising[len(rising) // 2 :])
    return 2.0 * float(fit.knots[1 + int(np.argmax(rising >= 0.95 * level))])


def fit_area(
    vessel: Vessel, records: Sequence[Record], knots: np.ndarray | None = None, opened: float | None = None
) -> tuple[AreaFit, float]:
    """Fit the effective area that explains all of some discharge tests.

    Beside it stands until when the random walk does not fade [s]. Records have samples before t = 0, while the pressure
    is well above ambient; `knots` and `opened` [s] are those of another fit, else found in a pilot fit. The law is
    [EPV, Eq. 10], integrated; the rate of the random walk is found by the fixed point of the evidence (MacKay 1992, doi
    10.1162/neco.1992.4.3.415).
    """
    if knots is None or opened is None:
        end = max(record.times[-1] for record in records)
        pilot = _Tests(vessel, records, np.linspace(0.0, end, PILOT_KNOTS + 1), end)
        opened = _opened_at(_finished(pilot, _solve(pilot)))
        knots = _knots(end, opened)
    tests = _Tests(vessel, records, knots, opened)
    return _finished(tests, _solve(tests)), opened
