"""A vessel that empties through a valve: Eqs. 9 and 10 of doi 10.1631/jzus.A0820373.

Eq. 10 is ``dp/dt = -S(t) f(p)`` with ``f`` of `fall_per_area`. It separates: with ``Y(p) = integral of dp/f from p up
to the initial pressure``, ``Y = integral of S dt``. All pressures are absolute: with gauge ones the law is silently
wrong.

Eq. 9 holds for a vessel whose wall gives no heat. With a wall of the conductance h A to the gas, p is a function of Y,
too, once the valve is open, as both balances are divided by its area: `Descent` integrates them over Y. Until then heat
has had no time to flow. A vessel full of wire keeps the temperature of the start (ISO 6358-2).
"""

from math import exp, inf, log, sqrt
from typing import NamedTuple

import numpy as np

from apesim.air import Gas, heat_capacity, heat_capacity_ratio
from apesim.restriction import flow_function

TABLE = 1500
"""Rows of the table of the law."""
MIN_RATIO = 1.02
"""Lowest pressure over ambient of the table of the law."""
MAX_EMPTYINGS = 50.0
"""Times of `_emptying` that a table is carried to at most: a warm vessel comes to `MIN_RATIO` within six of them."""
MARCH = {"method": "LSODA", "rtol": 1e-8, "atol": 1e-10}
"""Integration of the logarithms of pressure and temperature; a wall may be so warm that the balance is stiff."""


class Vessel(NamedTuple):
    """What empties, and into what."""

    volume: float
    """[m3]"""
    temperature: float
    """Before the valve opens [K]."""
    ambient_pressure: float
    """[Pa]"""
    gas: Gas
    """Properties of the gas, see `apesim.air.gas_of`."""
    wall: float = 0.0
    """Heat conductance h A from the wall, of the temperature of the start, to the gas, over the effective area of the
    open valve [W/(K m2)]; 0: adiabatic; inf: isothermal, as a vessel full of wire is."""


def temperatures(vessel: Vessel, initial_pressure: float, pressures: np.ndarray) -> np.ndarray:
    """Find the temperature [K] of the gas that stays in an emptying vessel, adiabatic [EPV, Eq. 9].

    The pressures [Pa abs] descend from the initial one before the valve opens [Pa abs], by small steps if cp depends on
    the temperature.
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


def fall_per_area(vessel: Vessel, initial_pressure: float, pressures: np.ndarray) -> np.ndarray:
    """Find how fast the pressure falls per effective area [Pa/(s m2)]: [EPV, Eq. 10], solved for -dp/dt / S.

    It is ``f = k psi p sqrt(R T) / V``, with T of [EPV, Eq. 9] ``f = k psi sqrt(R T_ini) p^((3k-1)/(2k))
    p_ini^((1-k)/(2k)) / V``; in an isothermal vessel T is T_ini, and 1 stands for the first k, as dm is V dp/(R T)
    then. The wall gives no heat, or is isothermal; pressures are as `temperatures` wants them [Pa abs]: with gauge ones
    the law is silently wrong.

    A valve of 9 mm^2 on 500 cm^3 at 7 bar lets the pressure fall by so much:

    >>> from apesim.air import gas_of
    >>> from apesim.engine.machine import Machine
    >>> vessel = Vessel(500e-6, 293.0, 1e5, gas_of(Machine().air))
    >>> f"{1e-5 * 1e-3 * 9e-6 * fall_per_area(vessel, 7e5, np.array([7e5]))[0]:.4f} bar/ms"
    '0.0350 bar/ms'
    """
    gas, is_isothermal = vessel.gas, vessel.wall == inf
    t = np.full(len(pressures), vessel.temperature)
    if not is_isothermal:
        t = temperatures(vessel, initial_pressure, pressures)
    psi = np.array([flow_function(gas, vessel.ambient_pressure / p, x) for p, x in zip(pressures, t, strict=True)])
    k = np.array([heat_capacity_ratio(gas, x) for x in t]) if gas.perfect else gas.heat_capacity_ratio
    if is_isothermal:
        k = 1.0
    return k * psi * pressures * np.sqrt(gas.gas_constant * t) / vessel.volume


def effective_area(vessel: Vessel, initial_pressure: float, pressures: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Find the effective area mu S [m2] from pressures [Pa abs] and their slopes [Pa/s] [EPV, Eq. 10].

    The initial pressure is that before the valve opens [Pa abs].
    """
    return -np.asarray(slopes) / fall_per_area(vessel, initial_pressure, np.asarray(pressures))


def _emptying(vessel: Vessel) -> float:
    """Time integral of the effective area in which a choked flow would let the whole filling out [m2 s]."""
    return vessel.volume / (vessel.gas.choked_flow * sqrt(vessel.gas.gas_constant * vessel.temperature))


def _march_warm(vessel: Vessel, initial_pressure: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time integrals of the area [m2 s], pressures [Pa abs], and how fast they fall, of a vessel with a warm wall.

    Mass and energy balance of the gas (Eqs. 4, 5 and 7 of the EPV paper, doi 10.1631/jzus.A0820373), over Y.
    """
    from scipy.integrate import solve_ivp

    gas, volume, ambient = vessel.gas, vessel.volume, vessel.ambient_pressure

    def slopes(_: float, state: np.ndarray) -> tuple[float, float]:
        pressure, temperature = exp(state[0]), exp(state[1])
        k = heat_capacity_ratio(gas, temperature)
        psi = flow_function(gas, min(ambient / pressure, 1.0), temperature)
        heating = vessel.wall * (vessel.temperature - temperature) / (volume * pressure)
        falling = -k * psi * sqrt(gas.gas_constant * temperature) / volume + (k - 1.0) * heating
        return falling, (k - 1.0) / k * (falling + heating)

    def is_low(_: float, state: np.ndarray) -> float:
        return float(state[0]) - log(MIN_RATIO * ambient)

    is_low.terminal = True  # type: ignore[attr-defined]
    start, end = (log(initial_pressure), log(vessel.temperature)), MAX_EMPTYINGS * _emptying(vessel)
    solution = solve_ivp(slopes, (0.0, end), start, events=is_low, dense_output=True, **MARCH)
    passed = solution.t[-1] * np.linspace(0.0, 1.0, TABLE // 3) ** 2
    states = solution.sol(passed)
    pressures = np.exp(states[0])
    falls = -pressures * np.array([slopes(0.0, state)[0] for state in states.T])
    # Above the initial pressure, where noise and an offset may lead, nothing has flowed: the wall has no say.
    above = np.linspace(1.1, 1.0, TABLE // 10, endpoint=False) * initial_pressure
    falls = np.append(fall_per_area(vessel, initial_pressure, above), falls)
    steps = -np.diff(np.append(above, initial_pressure))
    passed = np.append(-np.cumsum((steps / falls[: len(above)])[::-1])[::-1], passed)
    return passed, np.append(above, pressures), falls


class Descent:
    """The pressure p(Y) of a vessel from which the time integral Y of an effective area [m2 s] has let out gas.

    It is [EPV, Eq. 10], integrated with [EPV, Eq. 9] by the trapezoidal rule; with a warm wall the balances stand for
    Eq. 9. The initial pressure [Pa abs] is that at Y = 0; the table goes on a little above it.
    """

    def __init__(self, vessel: Vessel, initial_pressure: float) -> None:
        from scipy.interpolate import CubicHermiteSpline

        if 0.0 < vessel.wall < inf:
            self.passed, self.pressures, falls = _march_warm(vessel, initial_pressure)
        else:
            low, high = MIN_RATIO * vessel.ambient_pressure, 1.1 * initial_pressure
            self.pressures = low + (high - low) * np.linspace(1.0, 0.0, TABLE) ** 2
            falls = fall_per_area(vessel, initial_pressure, self.pressures)
            steps = -np.diff(self.pressures) * (1.0 / falls[1:] + 1.0 / falls[:-1]) / 2.0
            passed = np.append(0.0, np.cumsum(steps))
            self.passed = passed - np.interp(-initial_pressure, -self.pressures, passed)
        self._curve = CubicHermiteSpline(self.passed, self.pressures, -falls)

    def pressure(self, passed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Find the pressure of the vessel once some gas is out, from time integrals Y of the effective area [m2 s].

        Returns pressures [Pa abs], and how fast they fall with Y, as `fall_per_area` [Pa/(m2 s)].
        """
        inside = np.clip(passed, self.passed[0], self.passed[-1])
        return self._curve(inside), -self._curve(inside, 1)

    def passed_at(self, pressures: np.ndarray) -> np.ndarray:
        """Find the time integral of the effective area [m2 s] that leaves the vessel at some pressures [Pa abs].

        The pressures lie within the table; the integral is 0 at the initial one.
        """
        return np.interp(-np.asarray(pressures), -self.pressures, self.passed)
