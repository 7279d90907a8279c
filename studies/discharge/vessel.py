"""A vessel that empties through a valve: Eqs. 9 and 10 of doi 10.1631/jzus.A0820373.

Eq. 10 is ``dp/dt = -S(t) f(p)`` with ``f`` of `fall_per_area`. It separates: with ``Y(p) = integral of dp/f from p up
to the initial pressure``, ``Y = integral of S dt``. All pressures are absolute: with gauge ones the law is silently
wrong.
"""

from typing import NamedTuple

import numpy as np

from apesim.air import Gas, heat_capacity, heat_capacity_ratio
from apesim.restriction import flow_function

TABLE = 1500
MIN_RATIO = 1.02
"""Lowest pressure over ambient of the table of the law."""


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

    It is Eq. 10 of the EPV paper (doi 10.1631/jzus.A0820373), integrated with Eq. 9 by the trapezoidal rule.

    Parameters
    ----------
    vessel : Vessel
    initial_pressure : float
        At Y = 0 [Pa abs]; the table goes on a little above it.
    """

    def __init__(self, vessel, initial_pressure):
        from scipy.interpolate import CubicHermiteSpline

        low, high = MIN_RATIO * vessel.ambient_pressure, 1.1 * initial_pressure
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
