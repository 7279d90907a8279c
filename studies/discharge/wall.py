"""The heat that the wall of a vessel gives to the gas: its conductance, from the choked part of discharge tests.

While the valve is open its area is one number, so that what bends the pressures is heat. The smoothing of
`apesim.studies.discharge.area` would take it for an area that falls.
"""

from collections.abc import Sequence
from math import sqrt
from typing import NamedTuple

import numpy as np

from apesim.air import heat_capacity
from apesim.studies.discharge.area import NORMAL_95, AreaFit, monotone
from apesim.studies.discharge.records import Record, noise_before
from apesim.studies.discharge.vessel import Descent, Vessel

MIN_SAMPLES = 20
"""Samples of a test, choked and with the valve open, below which it tells no curvature."""
MIN_SIGMAS = 3.0
"""Conductance over its standard deviation from which it is taken: noise alone makes one in a thousand."""
MIN_EFFECT = 3e-3
"""Share of the area that a conductance has to change to be taken: law and tables are as good as a thousandth."""
MIN_RELATIVE, MAX_RELATIVE = 1e-6, 100.0
"""Conductance over the heat capacity of the first flow, at least and at most: adiabatic and isothermal in effect."""
TRIED = (MIN_RELATIVE, 0.1, 1.0, 10.0)
"""Ratios among which the fit of it starts."""
MAX_ROUNDS, SETTLED = 20, 0.03
"""Rounds of Gauss and Newton at most, and the step in standard deviations at which they end."""
TIMES_HALF_OPEN = 4.0
"""Time after which a valve is open, over that at which its area has come to half: the flow of heat hardly moves that,
though it may make the area seem to rise for as long as the vessel empties."""
STEP = 1e-2, 1e-4
"""Relative and absolute step of that ratio, for the derivative."""


class Wall(NamedTuple):
    """Heat conductance from the wall of a vessel to its gas."""

    conductance: float
    """h A [W/K]"""
    half_band: float
    """Half the width of its 95 % band [W/K]."""
    area: float
    """Effective area of the open valve beside it [m2]."""
    area_half_band: float
    """Half the width of its 95 % band, the error of the conductance in it [m2]."""
    adiabatic_area: float
    """Effective area of the open valve as the same samples show it without heat from the wall [m2]."""
    area_per_conductance: float
    """What the area changes by where the conductance is another [m2 K/W]."""
    sigmas: float
    """Root of what the squares of the residuals fall by, in standard deviations of what is left."""

    @property
    def is_identified(self) -> bool:
        """Whether it differs from 0 by more than noise, and matters."""
        return self.sigmas >= MIN_SIGMAS and self.effect >= MIN_EFFECT

    @property
    def effect(self) -> float:
        """Share of the area that it makes."""
        return abs(self.area - self.adiabatic_area) / self.area


def find_choked(vessel: Vessel, record: Record, pressures: np.ndarray, critical_ratio: float) -> float:
    """Find until when [s] the flow out of a vessel is choked, from the fitted pressures at a record's samples [Pa abs].

    It is the time of the last sample above the critical pressure, -inf if there is none; up to `critical_ratio`,
    ambient pressure over that in the vessel, the flow is choked.

    >>> from apesim.air import Air, gas_of
    >>> times, pressures = np.arange(4) * 1e-3, np.array([3e5, 2.5e5, 2e5, 1.5e5])
    >>> vessel = Vessel(500e-6, 293.0, 1e5, gas_of(Air()))
    >>> find_choked(vessel, Record("p060", times, pressures), pressures, 0.528)
    0.002
    """
    is_choked = vessel.ambient_pressure <= critical_ratio * pressures
    return float(record.times[is_choked][-1]) if is_choked.any() else -np.inf


def fit_wall(
    vessel: Vessel, records: Sequence[Record], fit: AreaFit, opened: float, critical_ratio: float
) -> Wall | None:
    """Find the conductance of the wall, and one area of the open valve beside it, from the choked part of some tests.

    The tests start at the temperature of their wall; the vessel's own wall is left out of account. The valve is open
    from `opened` [s] on, as the fit without a wall has it, and the flow choked up to `critical_ratio`, ambient pressure
    over that in the vessel. None: the valve is open for too short a time while the flow is choked.
    """
    opened = min(opened, TIMES_HALF_OPEN * _half_open_at(fit))
    parts, levels, sigmas = [], [], []
    for record, pressures in zip(records, fit.pressures, strict=True):
        is_used = (record.times >= opened) & (record.times <= find_choked(vessel, record, pressures, critical_ratio))
        if is_used.sum() >= MIN_SAMPLES:
            parts.append(Record(record.name, record.times[is_used], record.pressures[is_used]))
            levels.append(record.pressures[record.times <= 0.0].mean())
            deviation, colour = noise_before(record)
            sigmas.append(deviation * sqrt((1.0 + colour) / (1.0 - colour)))
    if not parts:
        return None
    unit = _heat_capacity_of_flow(vessel, max(levels))
    model = _OpenValve(vessel, parts, levels, sigmas, unit)
    # Far from a minimum an isothermal vessel looks like an adiabatic one of another area: all ratios are tried.
    tried = [model.solve(relative) for relative in TRIED]
    solution = min(tried, key=lambda each: each.cost)
    for _ in range(MAX_ROUNDS):
        step, sigma = model.improve(solution)
        if solution.relative <= MIN_RELATIVE and step < 0.0:
            break
        better = model.solve(solution.relative + step)
        while better.cost > solution.cost and abs(step) > SETTLED * sigma:
            step /= 2.0
            better = model.solve(solution.relative + step)
        if better.cost <= solution.cost:
            solution = better
        if abs(step) <= SETTLED * sigma:
            break
    covariance = model.covariance(solution)
    # The conductance is that ratio times the area, so that both have a say in its variance.
    area = solution.unknowns[0]
    to_conductance = unit * np.array([solution.relative, area])
    variance = float(to_conductance @ covariance @ to_conductance)
    slope = float(covariance[0] @ to_conductance) / variance
    adiabatic = tried[0]
    free = max(len(solution.residuals) - len(solution.unknowns) - 1, 1)
    gain = sqrt(max(adiabatic.cost - solution.cost, 0.0) / max(solution.cost / free, 1.0))
    conductance, half_band = unit * solution.relative * area, NORMAL_95 * sqrt(variance)
    area_half_band = NORMAL_95 * sqrt(float(covariance[0, 0]))
    return Wall(float(conductance), half_band, float(area), area_half_band, float(adiabatic.unknowns[0]), slope, gain)


class _Solution(NamedTuple):
    """Area and delays that fit best beside a conductance."""

    relative: float
    """Conductance over the area, over the heat capacity of the first flow over the area."""
    unknowns: np.ndarray
    """Area of the open valve [m2], and for each test when a valve that opens at once would have opened [s]."""
    residuals: np.ndarray
    """In standard deviations of the noise."""
    jacobian: np.ndarray
    """Derivatives of the residuals by the unknowns."""
    cost: float
    """Sum of the squares of the residuals."""


class _OpenValve:
    """Choked parts of tests while the valve is open: one area for all, and one delay for each."""

    def __init__(
        self, vessel: Vessel, parts: Sequence[Record], levels: Sequence[float], sigmas: Sequence[float], unit: float
    ) -> None:
        self.vessel, self.unit = vessel, unit
        self.tests = list(zip(parts, levels, sigmas, strict=True))
        self.start = np.array([_mean_area(vessel, parts, levels), *(0.5 * parts[0].times[0] for _ in parts)])

    def solve(self, relative: float) -> _Solution:
        """Area and delays that fit best beside a ratio, by Gauss and Newton."""
        relative = float(np.clip(relative, MIN_RELATIVE, MAX_RELATIVE))
        vessel = self.vessel._replace(wall=relative * self.unit)
        descents = [Descent(vessel, level) for _, level, _ in self.tests]
        unknowns = self.start
        for _ in range(MAX_ROUNDS):
            residuals, jacobian = self._linear(descents, unknowns)
            step = np.linalg.lstsq(jacobian, -residuals, rcond=None)[0]
            unknowns = np.append(max(unknowns[0] + step[0], 0.2 * unknowns[0]), unknowns[1:] + step[1:])
            if np.sum((jacobian @ step) ** 2) < SETTLED**2:
                break
        residuals, jacobian = self._linear(descents, unknowns)
        return _Solution(relative, unknowns, residuals, jacobian, float(residuals @ residuals))

    def improve(self, solution: _Solution) -> tuple[float, float]:
        """Step of the ratio towards the minimum, and its standard deviation, both as of a linear model."""
        whole = np.column_stack((solution.jacobian, self._slopes(solution)))
        return float(np.linalg.lstsq(whole, -solution.residuals, rcond=None)[0][-1]), _deviation(whole)

    def covariance(self, solution: _Solution) -> np.ndarray:
        """Covariance of area and ratio; what the model leaves beyond the noise counts as noise."""
        whole = np.column_stack((solution.jacobian[:, :1], self._slopes(solution), solution.jacobian[:, 1:]))
        left = solution.cost / max(len(solution.residuals) - whole.shape[1], 1)
        scale = np.linalg.norm(whole, axis=0)
        inverse = np.linalg.pinv((whole / scale).T @ (whole / scale)) / np.outer(scale, scale)
        return inverse[:2, :2] * max(left, 1.0)

    def _slopes(self, solution: _Solution) -> np.ndarray:
        """Derivative of the residuals by the ratio."""
        step = STEP[0] * solution.relative + STEP[1]
        vessel = self.vessel._replace(wall=(solution.relative + step) * self.unit)
        descents = [Descent(vessel, level) for _, level, _ in self.tests]
        return (self._linear(descents, solution.unknowns)[0] - solution.residuals) / step

    def _linear(self, descents: Sequence[Descent], unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residuals, and their derivative by the unknowns."""
        residuals, rows, area = [], [], unknowns[0]
        for number, (descent, (part, _, sigma)) in enumerate(zip(descents, self.tests, strict=True)):
            since = part.times - unknowns[1 + number]
            pressures, falls = descent.pressure(area * since)
            block = np.zeros((len(since), len(unknowns)))
            block[:, 0], block[:, 1 + number] = -falls * since / sigma, falls * area / sigma
            residuals.append((pressures - part.pressures) / sigma)
            rows.append(block)
        return np.concatenate(residuals), np.concatenate(rows)


def _deviation(jacobian: np.ndarray) -> float:
    """Standard deviation of the last unknown."""
    return 1.0 / max(abs(float(np.linalg.qr(jacobian).R[-1, -1])), 1e-300)


def _half_open_at(fit: AreaFit) -> float:
    """Time at which an area has come to half of its middle value over the later half [s]."""
    rising = monotone(fit.area[1:], fit.half_band[1:])
    return float(fit.knots[1 + int(np.argmax(rising >= 0.5 * np.median(rising[len(rising) // 2 :])))])


def _heat_capacity_of_flow(vessel: Vessel, initial_pressure: float) -> float:
    """Heat capacity of the first, choked flow over the effective area [W/(K m2)]."""
    flow = vessel.gas.choked_flow * initial_pressure / sqrt(vessel.gas.gas_constant * vessel.temperature)
    return float(flow * heat_capacity(vessel.gas, vessel.temperature))


def _mean_area(vessel: Vessel, parts: Sequence[Record], levels: Sequence[float]) -> float:
    """Mean effective area of some tests, as of a vessel without heat from its wall [m2]."""
    areas = []
    for part, level in zip(parts, levels, strict=True):
        passed = Descent(vessel._replace(wall=0.0), level).passed_at(part.pressures[[0, -1]])
        areas.append((passed[1] - passed[0]) / (part.times[-1] - part.times[0]))
    return float(np.mean(areas))
