"""Air in volumes and through restrictions, after Eqs. 3-8 of doi 10.1631/jzus.A0820373, as pressure and temperature.

Eq. 8 is written over the Mach number in the throat, which stops at one: that is choking, and no case of its own.
Heat capacities are constant, or a parabola over temperature.
"""

from math import sqrt

import numpy as np

LINEAR_ABOVE = 0.999
"""Pressure ratio above which Eq. 8 is replaced by a line: its slope at one is infinite."""
TABLE = np.array(
    [(200, 1002.5), (250, 1003.1), (300, 1004.9), (350, 1008.2), (400, 1013.5), (450, 1020.6), (500, 1029.5)]
)
"""Heat capacity of dry air at constant pressure and 1 atm over temperature [K, J/(kg K)]: Hilsenrath et al. 1955,
NBS circular 564, rounded."""
REAL_AIR = tuple(np.polyfit(*TABLE.T, 2)[::-1].tolist())
"""Coefficients of 1, T and T^2, fitted to that table."""


def flow_function(r, k):
    """psi of Eq. 8 over the downstream to upstream pressure ratio."""
    if r > LINEAR_ABOVE:
        return flow_function(LINEAR_ABOVE, k) * (1.0 - r) / (1.0 - LINEAR_ABOVE)
    widest = 0.5 * (k - 1.0)
    mach_squared = (r ** ((1.0 - k) / k) - 1.0) / widest
    if mach_squared > 1.0:
        mach_squared = 1.0
    return sqrt(k * mach_squared) * (1.0 + widest * mach_squared) ** (-0.5 * (k + 1.0) / (k - 1.0))


def enthalpy(air, temperature):
    """Specific enthalpy, from absolute zero on along the heat capacity [J/kg]."""
    if not air.heat_capacity:
        return air.heat_capacity_ratio / (air.heat_capacity_ratio - 1.0) * air.gas_constant * temperature
    a, b, c = air.heat_capacity
    return temperature * (a + temperature * (0.5 * b + temperature * c / 3.0))


def capacity(air, temperature):
    """Heat capacity of a gas at constant pressure [J/(kg K)]."""
    if not air.heat_capacity:
        return air.heat_capacity_ratio / (air.heat_capacity_ratio - 1.0) * air.gas_constant
    a, b, c = air.heat_capacity
    return a + temperature * (b + temperature * c)


def ratio(air, temperature):
    """Heat capacity at constant pressure over that at constant volume."""
    if not air.heat_capacity:
        return air.heat_capacity_ratio
    cp = capacity(air, temperature)
    return cp / (cp - air.gas_constant)


def inflow(air, area, inside, outside, stretch=1.0):
    """Mass [kg/s] and enthalpy [W] into a volume through a restriction (Eq. 7).

    Parameters
    ----------
    air : NamedTuple
        With a ``gas_constant`` [J/(kg K)], a ``heat_capacity_ratio`` and, in place of that, a ``heat_capacity``: ()
        or the coefficients of 1, T and T^2.
    area : float
        Effective [m2].
    inside, outside : pair of float
        Pressure [Pa abs] and temperature [K].
    stretch : float
        On how far the pressure ratio is from one.

    Returns
    -------
    mass, enthalpy : float
    """
    if area <= 0.0:
        return 0.0, 0.0
    into = outside[0] > inside[0]
    up, down = (outside, inside) if into else (inside, outside)
    gas, warm = air.gas_constant, up[1]
    if air.heat_capacity:
        k, carried = ratio(air, warm), enthalpy(air, warm)
    else:
        k = air.heat_capacity_ratio
        carried = k / (k - 1.0) * gas * warm
    mass = area * flow_function(1.0 - stretch * (1.0 - down[0] / up[0]), k) * up[0] / sqrt(gas * warm)
    mass = mass if into else -mass
    return mass, mass * carried


def gas_rates(air, state, volume, growth, mass, heat):
    """Rates of pressure [Pa/s] and temperature [K/s] of a volume of gas (Eqs. 3-6).

    Parameters
    ----------
    air : NamedTuple
        See `inflow`.
    state : pair of float
        Pressure [Pa abs] and temperature [K].
    volume, growth : float
        [m3], [m3/s]
    mass, heat : float
        Into it, with the enthalpy it carries [kg/s, W].

    Returns
    -------
    list of float
    """
    p, warm = state
    gas = air.gas_constant
    if not air.heat_capacity:
        k = air.heat_capacity_ratio
        rise = ((k - 1.0) * heat - k * p * growth) / volume
        return [rise, warm * (rise / p + (growth - mass * gas * warm / p) / volume)]
    held = p * volume / (gas * warm)
    inner = enthalpy(air, warm) - gas * warm
    warming = (heat - inner * mass - p * growth) / (held * (capacity(air, warm) - gas))
    return [p * (mass / held + warming / warm - growth / volume), warming]
