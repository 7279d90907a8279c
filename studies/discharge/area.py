"""The effective area of a valve over time, from the noisy pressures of all its discharge tests at once.

Nothing noisy is differentiated: S(t), straight between knots, is fitted through the forward law of
`apesim.studies.discharge.vessel` to all samples of all tests.

- Smoothing: S is a random walk from S(0) = 0, whose steps have the variance ``rate * h``. The rate is that of the
  largest marginal likelihood (empirical Bayes, fixed-point iteration), times `UNDERSMOOTHED`, so that smoothing takes
  less off the corners of a ramp than the noise puts on. It fades as 1/t^2 once the valve has opened.
- Noise: of each test's own deviation, the root mean square of what the fit leaves, but not less than before the valve
  is switched; colour (AR(1)) found there counts as fewer samples.
- Band: 95 % of a normal distribution with the deviation of the estimate under the noise, and with a bias, which is what
  smoothing does to the estimate itself, made monotone, times `BIAS_LOST`.
"""

from typing import NamedTuple

import numpy as np

from apesim.studies.discharge.records import noise_before
from apesim.studies.discharge.vessel import Descent

DEVIATIONS = 1.959964
"""Half the width of a 95 % interval, in standard deviations."""
BIAS_LOST = 2.0
"""A second smoothing takes about half of what the first took off a corner, for the first has rounded it."""
UNDERSMOOTHED = 4.0
ROUNDS = 40
PILOT_KNOTS, KNOTS = 80, 120
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
    pressures: list
    """Fitted, at the samples of each test [Pa abs]."""
    rate: float
    """Rate of the random walk before the valve is open [m4/s]."""


def integrals(times, knots):
    """Matrix that turns a curve at knots 1, 2, ... (0 at the first, straight between) into its integral up to times.

    Parameters
    ----------
    times : (n,) float array
        [s]
    knots : (j,) float array
        [s]

    Returns
    -------
    (n, j - 1) float array
        [s]
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


def _knots(end, opened):
    """Knots [s]: evenly spaced until the valve has opened, then ever farther apart, as the random walk fades."""
    if end <= opened:
        return np.linspace(0.0, end, KNOTS + 1)
    more = int(np.ceil(KNOTS * np.log(end / opened)))
    return np.append(np.linspace(0.0, opened, KNOTS + 1), np.geomspace(opened, end, more + 1)[1:])


class _Problem:
    """Tests, and knots at which their common area is sought."""

    def __init__(self, vessel, records, knots, opened):
        self.knots, self.steps = knots, np.diff(knots)
        self.fading = np.minimum(1.0, opened / knots[1:]) ** 2
        self.records = records
        self.descents, self.matrices, self.noise, self.samples_lost = [], [], [], []
        for number, record in enumerate(records):
            self.descents.append(Descent(vessel, record.pressures[record.times <= 0.0].mean()))
            own = np.zeros((len(record.times), len(records)))
            own[:, number] = 1.0  # what the initial pressure, known from few samples, is wrong by
            self.matrices.append(np.hstack((integrals(record.times, knots), own)))
            deviation, colour = noise_before(record)
            self.noise.append(deviation)
            self.samples_lost.append((1.0 + colour) / (1.0 - colour))
        self.min_noise = self.noise.copy()

    def linear(self, unknowns):
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

    def penalty(self, rate):
        """Inverse covariance of the random walk, bordered by zeros for the initial pressures."""
        count = len(self.steps)
        walk = np.eye(count) - np.eye(count, k=-1)
        whole = np.zeros((count + len(self.records),) * 2)
        whole[:count, :count] = (walk.T / (rate * self.fading * self.steps)) @ walk
        return whole

    def reestimate(self, fitted, freedom):
        """Noise from what the fit leaves."""
        share = 1.0 - freedom / sum(len(record.times) for record in self.records)
        for i, record in enumerate(self.records):
            left = np.sqrt(np.mean((record.pressures - fitted[i]) ** 2) / max(share, 0.1))
            self.noise[i] = max(left, self.min_noise[i])


def _inverse(matrix):
    """Inverse of a positive matrix of very unequal scales."""
    scale = np.sqrt(np.diag(matrix))
    return np.linalg.inv(matrix / np.outer(scale, scale)) / np.outer(scale, scale)


def _solve(problem):
    """Unknowns, their gain matrix (covariance of the Bayesian), information, rate and fitted pressures."""
    count, unknowns = len(problem.steps), None
    pairs = zip(problem.descents, problem.records, strict=True)
    scale = np.mean([descent.passed_at(r.pressures[-1]) / r.times[-1] for descent, r in pairs])  # a mean area
    rate = scale**2 / problem.knots[-1]
    min_rate = 1e-9 * rate
    for round_ in range(ROUNDS):
        information, vector, fitted = problem.linear(unknowns)
        penalty = problem.penalty(rate)
        gain = _inverse(information + penalty)
        freedom = np.sum(gain * information)
        found = gain @ vector
        if round_:
            problem.reestimate(fitted, freedom)
        rate = max(rate * (found @ penalty @ found) / max(freedom - len(problem.records), 0.5), min_rate)
        change = np.inf if unknowns is None else np.abs(found - unknowns)[:count].max()
        unknowns = found
        if round_ > 3 and change < SETTLED * np.abs(found[:count]).max():
            break
    rate *= UNDERSMOOTHED
    for _ in range(3):
        information, vector, fitted = problem.linear(unknowns)
        gain = _inverse(information + problem.penalty(rate))
        unknowns = gain @ vector
    return unknowns, gain, information, rate, fitted


def monotone(area, half_band):
    """The nearest curve that never falls and is nowhere negative, weighted by the band; shape (j,).

    It is isotonic regression, from SciPy [1]_.

    References
    ----------
    .. [1] F. M. T. A. Busing, "Monotone regression: a simple and fast O(n) PAVA implementation", J. Statist. Softw.
       102, 2022, code snippet 1, doi 10.18637/jss.v102.c01.
    """
    from scipy.optimize import isotonic_regression

    return np.clip(isotonic_regression(area, weights=1.0 / half_band**2).x, 0.0, None)


def _finished(problem, solution):
    """The `AreaFit` of a solution."""
    from scipy.stats import ncx2

    unknowns, gain, information, rate, fitted = solution
    count = len(problem.steps)
    covariance = (gain @ information @ gain)[:count, :count]
    deviation = np.sqrt(np.diag(covariance))
    smooth = np.append(monotone(unknowns[:count], deviation), np.zeros(len(problem.records)))
    bias = BIAS_LOST * np.abs(gain @ (information @ smooth) - smooth)[:count] / deviation
    near = np.clip(bias, 1e-6, 5.0)
    half = deviation * np.where(bias < 5.0, np.sqrt(ncx2.ppf(0.95, 1, near**2)), bias + 1.645)
    whole = np.zeros((count + 1, count + 1))
    whole[1:, 1:] = covariance
    area = np.append(0.0, unknowns[:count])
    return AreaFit(problem.knots, area, np.append(0.0, half), whole, np.array(problem.noise), fitted, rate)


def opened_at(fit):
    """Twice the time at which an area has come to 95 % of its middle value over the later half [s]."""
    rising = monotone(fit.area[1:], fit.half_band[1:])
    level = np.median(rising[len(rising) // 2 :])
    return 2.0 * fit.knots[1 + int(np.argmax(rising >= 0.95 * level))]


def fit_area(vessel, records, knots=None, opened=None):
    """The effective area that explains all of some discharge tests.

    The law is Eq. 10 of the EPV paper [1]_, integrated; the rate of the random walk is found by the fixed point of the
    evidence [2]_.

    Parameters
    ----------
    vessel : Vessel
    records : sequence of Record
        With samples before t = 0, while the pressure is well above ambient.
    knots : (j,) float array, optional
        As another fit has them; else chosen in a pilot fit [s].
    opened : float, optional
        Until when the random walk does not fade, of that other fit [s].

    Returns
    -------
    AreaFit, float
        And until when the random walk does not fade [s].

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 10.
    .. [2] D. J. C. MacKay, "Bayesian interpolation", Neural Comput. 4, 1992, pp. 415-447,
       doi 10.1162/neco.1992.4.3.415.
    """
    if knots is None:
        end = max(record.times[-1] for record in records)
        pilot = _Problem(vessel, records, np.linspace(0.0, end, PILOT_KNOTS + 1), end)
        opened = opened_at(_finished(pilot, _solve(pilot)))
        knots = _knots(end, opened)
    problem = _Problem(vessel, records, knots, opened)
    return _finished(problem, _solve(problem)), opened
