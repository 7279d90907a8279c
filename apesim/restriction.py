"""Flow through a restriction (Eq. 7): from the higher pressure to the lower, with the upstream gas's enthalpy.

The law is smooth within a regime only: choked, subsonic, nearly equal pressures; each in either direction. The march
holds a regime through a step, its law carried on smoothly beyond the ends, and ends the step where the regime ends.
"""

from math import inf, sqrt

from apesim.air import ANR_DENSITY, enthalpy, heat_capacity_ratio
from apesim.flow_function import (
    NEARLY_EQUAL,
    choked_flow_function,
    critical_ratio,
    subsonic_flow_function,
    subsonic_slope,
)
from apesim.kernel import kernel

SHUT, NEAR, SUBSONIC, CHOKED = range(4)
"""Regimes of flow from 1 to 2; negative: from 2 to 1."""
ROOM = 1e-6
"""By so much a pressure ratio passes the end of a regime before the next one begins: rounding does not chatter."""
AREA_OF_CONDUCTANCE = 5.02e-6 / 1e-8
"""Effective area of a sonic conductance: 5.02 mm2 for 1 dm3/(s bar) [m2 / (m3/(s Pa))]."""


@kernel
def ends_of(gas, regime, temperature):
    """Lowest and highest pressure ratio of a regime, without its direction; temperature upstream [K]."""
    if regime == NEAR:
        return NEARLY_EQUAL, 1.0
    critical = critical_ratio(heat_capacity_ratio(gas, temperature)) if gas.perfect else gas.critical_ratio
    if regime == SUBSONIC:
        return critical, NEARLY_EQUAL
    return -inf, critical


@kernel
def flow_function_in(gas, regime, ratio, temperature):
    """psi(r) of a regime (Eq. 8), linear where pressures are nearly equal; carried on smoothly beyond the ends.

    Parameters
    ----------
    gas : Gas
    regime : int
        NEAR, SUBSONIC or CHOKED.
    ratio : float
        Downstream over upstream pressure.
    temperature : float
        Upstream [K].

    Returns
    -------
    float
    """
    k = heat_capacity_ratio(gas, temperature) if gas.perfect else gas.heat_capacity_ratio
    if regime == CHOKED:
        return choked_flow_function(k) if gas.perfect else gas.choked_flow
    if regime == SUBSONIC and ratio <= NEARLY_EQUAL:
        return subsonic_flow_function(ratio, k)
    near = subsonic_flow_function(NEARLY_EQUAL, k) if gas.perfect else gas.near_flow
    if regime == SUBSONIC:
        return near + (ratio - NEARLY_EQUAL) * subsonic_slope(NEARLY_EQUAL, k)
    return near * (1.0 - ratio) / (1.0 - NEARLY_EQUAL)


@kernel
def flow_function(gas, ratio, temperature):
    """psi(r) of Eq. 8, in the regime of the ratio, 0...1; temperature upstream [K]."""
    regime = SUBSONIC
    if ratio > NEARLY_EQUAL:
        regime = NEAR
    elif ratio <= ends_of(gas, CHOKED, temperature)[1]:
        regime = CHOKED
    return flow_function_in(gas, regime, ratio, temperature)


@kernel(inline=False)
def regime_between(gas, sides):
    """Regime of the flow between two volumes.

    Parameters
    ----------
    gas : Gas
    sides : tuple of float
        Pressure and temperature of the one, then of the other [Pa abs, K, Pa abs, K].

    Returns
    -------
    int
        NEAR, SUBSONIC or CHOKED; negative from the second to the first.
    """
    direction = 1 if sides[0] >= sides[2] else -1
    ratio, temperature = upstream_of(direction, sides)
    if ratio > NEARLY_EQUAL:
        return direction * NEAR
    if ratio > ends_of(gas, CHOKED, temperature)[1]:
        return direction * SUBSONIC
    return direction * CHOKED


@kernel
def upstream_of(regime, sides):
    """Pressure ratio and upstream temperature in the direction of a regime."""
    if regime > 0.0:
        return sides[2] / sides[0], sides[1]
    return sides[0] / sides[2], sides[3]


@kernel(inline=False)
def beyond_regime(gas, regime, sides):
    """By how much the pressure ratio lies outside a regime, above zero where it has left it; see `regime_between`."""
    if regime == SHUT:
        return -1.0
    ratio, temperature = upstream_of(regime, sides)
    low, high = ends_of(gas, abs(regime), temperature)
    return max(low - ratio, ratio - high) - ROOM


@kernel(inline=False)
def next_regime(gas, regime, sides):
    """The regime that a flow goes over to where it leaves one; see `regime_between`."""
    direction = 1.0 if regime > 0.0 else -1.0
    ratio, temperature = upstream_of(regime, sides)
    low, high = ends_of(gas, abs(regime), temperature)
    if ratio - high < low - ratio:
        return regime + direction
    return -regime if abs(regime) == NEAR else regime - direction


@kernel
def flow_in(gas, regime, area, sides):
    """Flow through a restriction between two volumes, held in a regime.

    Parameters
    ----------
    gas : Gas
    regime : int
    area : float
        Effective area [m2].
    sides : tuple of float
        See `regime_between`.

    Returns
    -------
    mass_flow, enthalpy_flow : float
        See `flow_between`.
    """
    if regime == SHUT or area <= 0.0:
        return 0.0, 0.0
    ratio, temperature = upstream_of(regime, sides)
    mass = area * flow_function_in(gas, abs(regime), ratio, temperature) / sqrt(gas.gas_constant * temperature)
    mass *= sides[0] if regime > 0.0 else -sides[2]
    return mass, mass * enthalpy(gas, temperature)


@kernel
def flow_between(gas, area, pressure_1, temperature_1, pressure_2, temperature_2):
    """Flow through a restriction between two volumes (Eq. 7), from the higher pressure to the lower.

    Parameters
    ----------
    gas : Gas
    area : float
        Effective area [m2].
    pressure_1, pressure_2 : float
        [Pa abs]
    temperature_1, temperature_2 : float
        [K]

    Returns
    -------
    mass_flow : float
        From 1 to 2; negative the other way [kg/s].
    enthalpy_flow : float
        Carried along, at the upstream temperature [W].
    """
    if area <= 0.0:
        return 0.0, 0.0
    sides = pressure_1, temperature_1, pressure_2, temperature_2
    return flow_in(gas, regime_between(gas, sides), area, sides)


def iso6358_flow(conductance, critical, pressure_up, pressure_down, temperature=293.15):
    """Mass flow by sonic conductance and critical pressure ratio (ISO 6358-1).

    Parameters
    ----------
    conductance : float
        Sonic conductance C [m3/(s Pa) ANR].
    critical : float
        Critical pressure ratio b.
    pressure_up, pressure_down : float
        [Pa abs]
    temperature : float
        Upstream [K].

    Returns
    -------
    float
        [kg/s]
    """
    choked = conductance * ANR_DENSITY * pressure_up * sqrt(293.15 / temperature)
    ratio = pressure_down / pressure_up
    if ratio <= critical:
        return choked
    return choked * sqrt(1.0 - ((ratio - critical) / (1.0 - critical)) ** 2)
