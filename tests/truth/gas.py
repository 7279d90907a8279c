"""Air in volumes and through restrictions, after Eqs. 3-8 of doi 10.1631/jzus.A0820373, as pressure and temperature.

Eq. 8 is written over the Mach number in the throat, which stops at one: that is choking, and no case of its own.
"""

from math import sqrt

LINEAR_ABOVE = 0.999
"""Pressure ratio above which Eq. 8 is replaced by a line: its slope at one is infinite."""


def flow_function(r, k):
    """psi of Eq. 8 over the downstream to upstream pressure ratio."""
    if r > LINEAR_ABOVE:
        return flow_function(LINEAR_ABOVE, k) * (1.0 - r) / (1.0 - LINEAR_ABOVE)
    widest = 0.5 * (k - 1.0)
    mach_squared = min(1.0, (r ** ((1.0 - k) / k) - 1.0) / widest)
    return sqrt(k * mach_squared) * (1.0 + widest * mach_squared) ** (-0.5 * (k + 1.0) / (k - 1.0))


def inflow(air, area, inside, outside):
    """Mass [kg/s] and enthalpy [W] into a volume through a restriction (Eq. 7).

    Parameters
    ----------
    air : NamedTuple
        With a ``gas_constant`` [J/(kg K)] and a ``heat_capacity_ratio``.
    area : float
        Effective [m2].
    inside, outside : pair of float
        Pressure [Pa abs] and temperature [K].

    Returns
    -------
    mass, enthalpy : float
    """
    if area <= 0.0:
        return 0.0, 0.0
    into = outside[0] > inside[0]
    up, down = (outside, inside) if into else (inside, outside)
    k, gas = air.heat_capacity_ratio, air.gas_constant
    mass = area * flow_function(down[0] / up[0], k) * up[0] / sqrt(gas * up[1])
    mass = mass if into else -mass
    return mass, mass * k / (k - 1.0) * gas * up[1]


def gas_rates(air, state, volume, growth, mass, heat):
    """Rates of pressure [Pa/s] and temperature [K/s] of a volume of gas (Eqs. 3-6).

    Parameters
    ----------
    air : NamedTuple
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
    k = air.heat_capacity_ratio
    rise = ((k - 1.0) * heat - k * p * growth) / volume
    return [rise, warm * (rise / p + (growth - mass * air.gas_constant * warm / p) / volume)]
