"""The effective area of a valve through which a vessel empties, from the vessel's noisy pressure.

The law is Eq. 10 of doi 10.1631/jzus.A0820373, ``dp/dt = -S(t) f(p)`` with ``f`` of `fall_per_area`. It separates: with
``Y(p) = integral of dp/f from p up to the initial pressure``, ``Y = integral of S dt``. So nothing noisy is
differentiated: S(t), straight between knots, is fitted through the forward law to all samples of all tests at once.

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

from apesim.air import heat_capacity, heat_capacity_ratio
from apesim.restriction import flow_function

DEVIATIONS = 1.959964
"""Half the width of a 95 % interval, in standard deviations."""
BIAS_LOST = 2.0
"""A second smoothing takes about half of what the first took off a corner, for the first has rounded it."""
UNDERSMOOTHED = 4.0
TABLE = 1500
LEAST_RATIO = 1.02
"""Lowest pressure over ambient of the table of the law."""
ROUNDS = 40
PILOT_KNOTS, KNOTS = 80, 120
SETTLED = 1e-4
"""Largest change of S over its largest value at which the fit is done."""


class Record(NamedTuple):
    """A discharge test."""

    name: str
    times: np.ndarray
    """After the switching command [s], shape (n,), ascending."""
    pressures: np.ndarray
    """[Pa abs], shape (n,)"""


class Vessel(NamedTuple):
    """What empties, and into what."""

    volume: float
    """[m3]"""
    temperature: float
    """Before the valve opens [K]."""
    ambient_pressure: float
    """[Pa]"""
    gas: object
    """`apesim.air.Gas`"""


class AreaFit(NamedTuple):
    """An effective area over time, at j knots."""

    knots: np.ndarray
    """[s], shape (j,); the first is the switching command, 0."""
    area: np.ndarray
    """[m2], shape (j,)"""
    half_band: np.ndarray
    """Half the width of the point-wise 95 % band [m2], shape (j,)."""
    covariance: np.ndarray
    """Of the estimate under the noise [m4], shape (j, j)."""
    noise: np.ndarray
    """Standard deviation of each test [Pa]."""
    pressures: list
    """Fitted, at the samples of each test [Pa abs]."""
    rate: float
    """Of the random walk before the valve is open [m4/s]."""


def temperatures(vessel, initial_pressure, pressures):
    """Temperature of the gas that stays in an emptying vessel, adiabatic: Eq. 9 of doi 10.1631/jzus.A0820373.

    Parameters
    ----------
    vessel : Vessel
    initial_pressure : float
        [Pa abs]
    pressures : (n,) float array
        Descending, by small steps if cp depends on the temperature [Pa abs].

    Returns
    -------
    (n,) float array
        [K]
    """
    gas, ratios = vessel.gas, np.asarray(pressures) / initial_pressure
    k = gas.heat_capacity_ratio
    t = vessel.temperature * ratios ** ((k - 1.0) / k)
    if gas.perfect:  # d ln T = R/cp d ln p, from the initial state
        for _ in range(4):
            powers = gas.gas_constant / np.array([heat_capacity(gas, x) for x in t])
            logs = np.log(ratios)
            steps = np.append(0.0, np.cumsum(np.diff(logs) * (powers[1:] + powers[:-1]) / 2.0))
            t = vessel.temperature * np.exp(steps - np.interp(0.0, -logs, steps))
    return t


def fall_per_area(vessel, initial_pressure, pressures):
    """How fast the pressure falls per effective area: Eq. 10 of doi 10.1631/jzus.A0820373, solved for -dp/dt / S.

    ``f = k psi p sqrt(R T) / V``, with T of Eq. 9 ``f = k psi sqrt(R T_ini) p^((3k-1)/(2k)) p_ini^((1-k)/(2k)) / V``.
    Absolute pressures: with gauge ones the law is silently wrong.

    Parameters
    ----------
    vessel : Vessel
    initial_pressure : float
        [Pa abs]
    pressures : (n,) float array
        As `temperatures` wants them [Pa abs].

    Returns
    -------
    (n,) float array
        [Pa/(s m2)]
    """
    gas, t = vessel.gas, temperatures(vessel, initial_pressure, pressures)
    psi = np.array([flow_function(gas, vessel.ambient_pressure / p, x) for p, x in zip(pressures, t, strict=True)])
    k = np.array([heat_capacity_ratio(gas, x) for x in t]) if gas.perfect else gas.heat_capacity_ratio
    return k * psi * pressures * np.sqrt(gas.gas_constant * t) / vessel.volume


def effective_area(vessel, initial_pressure, pressures, slopes):
    """Effective area from a pressure and its slope: Eq. 10 of doi 10.1631/jzus.A0820373.

    Parameters
    ----------
    vessel : Vessel
    initial_pressure : float
        [Pa abs]
    pressures, slopes : (n,) float array
        [Pa abs], [Pa/s]

    Returns
    -------
    (n,) float array
        Coefficient times geometric area, mu S [m2].
    """
    return -np.asarray(slopes) / fall_per_area(vessel, initial_pressure, np.asarray(pressures))


class Descent:
    """The pressure p(Y) of a vessel from which the time integral Y of an effective area [m2 s] has let out gas.

    Parameters
    ----------
    vessel : Vessel
    initial_pressure : float
        At Y = 0 [Pa abs]; the table goes on a little above it.
    """

    def __init__(self, vessel, initial_pressure):
        from scipy.interpolate import CubicHermiteSpline

        low, high = LEAST_RATIO * vessel.ambient_pressure, 1.1 * initial_pressure
        self.pressures = low + (high - low) * np.linspace(1.0, 0.0, TABLE) ** 2
        falls = fall_per_area(vessel, initial_pressure, self.pressures)
        steps = -np.diff(self.pressures) * (1.0 / falls[1:] + 1.0 / falls[:-1]) / 2.0
        passed = np.append(0.0, np.cumsum(steps))
        self.passed = passed - np.interp(-initial_pressure, -self.pressures, passed)
        self._curve = CubicHermiteSpline(self.passed, self.pressures, -falls)

    def pressure(self, passed):
        """Pressure [Pa abs] and how fast it falls with Y [Pa/(m2 s)]."""
        inside = np.clip(passed, self.passed[0], self.passed[-1])
        return self._curve(inside), -self._curve(inside, 1)

    def passed_at(self, pressures):
        """Y at given pressures [m2 s]."""
        return np.interp(-np.asarray(pressures), -self.pressures, self.passed)


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


def least_noise(record):
    """Below which no noise is believed: that of the steps between neighbouring values, or of the law [Pa]."""
    values = np.unique(record.pressures)
    steps = np.diff(values).min() / np.sqrt(12.0) if len(values) > 1 else 0.0
    return max(steps, 1e-7 * values[-1])


def noise_before(record):
    """Standard deviation [Pa] and colour (lag-one correlation where it is significant) before the valve is switched."""
    before = record.pressures[record.times <= 0.0]
    e = before - before.mean()
    colour = float(e[1:] @ e[:-1] / max(e @ e, 1e-300))
    return max(e.std(ddof=1), least_noise(record)), colour if colour > 2.0 / np.sqrt(len(e)) else 0.0


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
        self.least = self.noise.copy()

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
            self.noise[i] = max(left, self.least[i])


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
    least = 1e-9 * rate
    for round_ in range(ROUNDS):
        information, vector, fitted = problem.linear(unknowns)
        penalty = problem.penalty(rate)
        gain = _inverse(information + penalty)
        freedom = np.sum(gain * information)
        found = gain @ vector
        if round_:
            problem.reestimate(fitted, freedom)
        rate = max(rate * (found @ penalty @ found) / max(freedom - len(problem.records), 0.5), least)
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
    """The nearest curve that never falls and is nowhere negative, weighted by the band; shape (j,)."""
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
    """
    if knots is None:
        end = max(record.times[-1] for record in records)
        pilot = _Problem(vessel, records, np.linspace(0.0, end, PILOT_KNOTS + 1), end)
        opened = opened_at(_finished(pilot, _solve(pilot)))
        knots = _knots(end, opened)
    problem = _Problem(vessel, records, knots, opened)
    return _finished(problem, _solve(problem)), opened
