"""Flow through a restriction, from the higher pressure to the lower, with the enthalpy of the upstream gas.

The law is Eq. 7 of the EPV paper (doi 10.1631/jzus.A0820373), ``mdot = S psi(r) p_up/sqrt(R T_up)``, with the effective
area S and the flow function psi of `apesim.flow_function`. It is smooth within a regime only: choked, subsonic, nearly
equal pressures; each in either direction. The march holds a regime through a step, its law carried on smoothly beyond
the ends, and ends the step where the regime ends.
"""

from math import inf, sqrt
from typing import NamedTuple

from apesim.air import ANR_DENSITY, Gas, GasState, enthalpy, heat_capacity_ratio
from apesim.flow_function import (
    NEARLY_EQUAL,
    choked_flow_function,
    critical_ratio,
    subsonic_flow_function,
    subsonic_slope,
)
from apesim.kernel import kernel

SHUT, NEAR, SUBSONIC, CHOKED = range(4)
"""Regimes of a flow from side 1 to side 2; negative numbers are the same regimes from side 2 to side 1."""
ROOM = 1e-6
"""Distance that a pressure ratio passes the end of a regime before the next one begins; chosen well above rounding, so
that a flow does not chatter between two regimes."""
ROOM_TO_TURN = 1e-11
"""That distance for a flow that turns, which so far carries air of the wrong side; chosen below all that a wide valve
needs to pass what a slow engine draws, and far above rounding."""
AREA_OF_CONDUCTANCE = 5.02e-6 / 1e-8
"""Effective area of a sonic conductance, 5.02 mm2 for 1 dm3/(s bar) [m2 / (m3/(s Pa))]."""


class Sides(NamedTuple):
    """Both sides of a restriction; a flow is positive from the air before it to that behind it."""

    before: GasState
    """State of the air on side 1."""
    behind: GasState
    """State of the air on side 2."""


class Flow(NamedTuple):
    """Flow of air with the enthalpy that it carries; or both summed over time [kg, J]."""

    mass: float
    """Mass flow [kg/s]."""
    enthalpy: float
    """Enthalpy flow [W]."""


NO_FLOW = Flow(0.0, 0.0)
"""Flow of what is shut."""


@kernel
def ends_of(gas: Gas, regime: float, temperature: float) -> tuple[float, float]:
    """Return the pressure ratios between which a regime holds.

    The choked regime ends at the critical ratio of Eq. 8 of the EPV paper [1]_; the regime of nearly equal pressures is
    chosen.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    regime : int
        NEAR, SUBSONIC or CHOKED, without direction.
    temperature : float
        Temperature upstream [K]; it matters only where cp depends on it.

    Returns
    -------
    low, high : float
        Lowest and highest pressure ratio; -inf below choked flow.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 8.

    Examples
    --------
    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> [round(end, 4) for end in ends_of(gas, SUBSONIC, 287.0)]
    [0.5283, 0.999]
    """
    if regime == NEAR:
        return NEARLY_EQUAL, 1.0
    critical = critical_ratio(heat_capacity_ratio(gas, temperature)) if gas.perfect else gas.critical_ratio
    if regime == SUBSONIC:
        return critical, NEARLY_EQUAL
    return -inf, critical


@kernel
def flow_function_in(gas: Gas, regime: float, ratio: float, temperature: float) -> float:
    """Return the flow function of a regime, carried on smoothly beyond the ends of the regime.

    psi(r) is Eq. 8 of the EPV paper [1]_ up to r = 0.999, and from there linear to 0 at equal pressures.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    regime : int
        NEAR, SUBSONIC or CHOKED, without direction.
    ratio : float
        Downstream over upstream pressure.
    temperature : float
        Temperature upstream [K].

    Returns
    -------
    float
        psi.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 8.

    Examples
    --------
    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> round(flow_function_in(gas, CHOKED, 0.2, 287.0), 4), round(flow_function_in(gas, SUBSONIC, 0.8, 287.0), 4)
    (0.6847, 0.5607)
    >>> flow_function_in(gas, NEAR, 1.0, 287.0)
    0.0
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
def flow_function(gas: Gas, ratio: float, temperature: float) -> float:
    """Return the flow function psi(r) in the regime that the pressure ratio lies in.

    It is Eq. 8 of the EPV paper [1]_, but linear above r = 0.999.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    ratio : float
        Downstream over upstream pressure, 0...1.
    temperature : float
        Temperature upstream [K].

    Returns
    -------
    float
        psi, Eq. 8 of the EPV paper; linear above r = 0.999.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 8.

    Examples
    --------
    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> [round(flow_function(gas, ratio, 287.0), 4) for ratio in (0.3, 0.8, 1.0)]
    [0.6847, 0.5607, 0.0]
    """
    regime = SUBSONIC
    if ratio > NEARLY_EQUAL:
        regime = NEAR
    elif ratio <= ends_of(gas, CHOKED, temperature)[1]:
        regime = CHOKED
    return flow_function_in(gas, regime, ratio, temperature)


@kernel(inline=False)
def regime_between(gas: Gas, sides: Sides) -> int:
    """Return the regime of the flow between two volumes.

    Choked and subsonic are the two branches of Eq. 8 of the EPV paper (doi 10.1631/jzus.A0820373).

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    sides : Sides
        State of the air on both sides.

    Returns
    -------
    int
        NEAR, SUBSONIC or CHOKED; negative from side 2 to side 1.

    Examples
    --------
    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> regime_between(gas, Sides(GasState(6e5, 287.0), GasState(1e5, 287.0))) == CHOKED
    True
    >>> regime_between(gas, Sides(GasState(1e5, 287.0), GasState(1.2e5, 287.0))) == -SUBSONIC
    True
    """
    direction = 1 if sides.before.pressure >= sides.behind.pressure else -1
    ratio, temperature = upstream_of(direction, sides)
    if ratio > NEARLY_EQUAL:
        return direction * NEAR
    if ratio > ends_of(gas, CHOKED, temperature)[1]:
        return direction * SUBSONIC
    return direction * CHOKED


@kernel
def upstream_of(regime: float, sides: Sides) -> tuple[float, float]:
    """Return downstream over upstream pressure and the upstream temperature [K] in the direction of a regime.

    Only the sign of the regime counts.

    >>> upstream_of(CHOKED, Sides(GasState(4e5, 300.0), GasState(1e5, 287.0)))
    (0.25, 300.0)
    """
    if regime > 0.0:
        return sides.behind.pressure / sides.before.pressure, sides.before.temperature
    return sides.before.pressure / sides.behind.pressure, sides.behind.temperature


@kernel(inline=False)
def beyond_regime(gas: Gas, regime: float, sides: Sides) -> float:
    """Return by how much the pressure ratio lies outside a regime; above zero the flow has left it.

    It is the distance from the nearer end of the regime, less `ROOM`, or at equal pressures, where the flow turns, less
    `ROOM_TO_TURN`; -1 where it is shut. A negative regime is a flow from side 2 to side 1.
    """
    if regime == SHUT:
        return -1.0
    ratio, temperature = upstream_of(regime, sides)
    low, high = ends_of(gas, abs(regime), temperature)
    return max(low - ratio - ROOM, ratio - high - (ROOM_TO_TURN if abs(regime) == NEAR else ROOM))


@kernel(inline=False)
def next_regime(gas: Gas, regime: float, sides: Sides) -> float:
    """Return the neighbouring regime that a flow goes over to where it leaves one; negative from side 2 to side 1.

    Beyond nearly equal pressures it is the same regime in the other direction.
    """
    direction = 1.0 if regime > 0.0 else -1.0
    ratio, temperature = upstream_of(regime, sides)
    low, high = ends_of(gas, abs(regime), temperature)
    if ratio - high < low - ratio:
        return regime + direction
    return -regime if abs(regime) == NEAR else regime - direction


@kernel
def flow_in(gas: Gas, regime: float, area: float, sides: Sides) -> Flow:
    """Return the flow through a restriction between two volumes, held in a regime.

    ``mdot = S psi(r) p_up/sqrt(R T_up)``, Eq. 7 of the EPV paper [1]_, with the density p_up/(R T_up) of an ideal gas
    and the coefficient mu within S.

    S is the effective area, psi the flow function of the pressure ratio r = p_down/p_up, R the gas constant; p_up and
    T_up are pressure and temperature upstream.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    regime : int
        Regime of the flow; negative from side 2 to side 1.
    area : float
        Effective area S [m2].
    sides : Sides
        State of the air on both sides.

    Returns
    -------
    Flow
        From side 1 to side 2, negative the other way, with the enthalpy of the air upstream.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eqs. 7 and 8.

    Examples
    --------
    1 mm2 * 0.6847 * 1 MPa/sqrt(287.05 J/(kg K) * 300 K) = 2.333 g/s:

    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> flow = flow_in(gas, CHOKED, 1e-6, Sides(GasState(1e6, 300.0), GasState(1e5, 287.0)))
    >>> round(flow.mass * 1e3, 3)
    2.333
    """
    if regime == SHUT or area <= 0.0:
        return NO_FLOW
    ratio, temperature = upstream_of(regime, sides)
    mass = area * flow_function_in(gas, abs(regime), ratio, temperature) / sqrt(gas.gas_constant * temperature)
    mass *= sides.before.pressure if regime > 0.0 else -sides.behind.pressure
    return Flow(mass, mass * enthalpy(gas, temperature))


@kernel
def flow_between(gas: Gas, area: float, sides: Sides) -> Flow:
    """Return the flow through a restriction between two volumes, from the higher pressure to the lower.

    ``mdot = S psi(r) p_up/sqrt(R T_up)``, Eq. 7 of the EPV paper [1]_, with the density p_up/(R T_up) of an ideal gas
    and the coefficient mu within S.

    S is the effective area, psi the flow function of the pressure ratio r = p_down/p_up, R the gas constant; p_up and
    T_up are pressure and temperature upstream.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    area : float
        Effective area S [m2].
    sides : Sides
        State of the air on both sides.

    Returns
    -------
    Flow
        From side 1 to side 2, negative the other way, with the enthalpy of the air upstream.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eqs. 7 and 8.

    Examples
    --------
    The enthalpy flow is 2.333 g/s times 1004.675 J/(kg K) times 300 K:

    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> flow = flow_between(gas, 1e-6, Sides(GasState(1e6, 300.0), GasState(1e5, 287.0)))
    >>> round(flow.mass * 1e3, 3), round(flow.enthalpy, 1)
    (2.333, 703.3)
    """
    if area <= 0.0:
        return NO_FLOW
    return flow_in(gas, regime_between(gas, sides), area, sides)


def iso6358_flow(
    conductance: float, critical: float, pressure_up: float, pressure_down: float, temperature: float = 293.15
) -> float:
    """Return the mass flow by sonic conductance and critical pressure ratio (ISO 6358-1).

    ``mdot = C rho_0 p_up sqrt(T_0/T) sqrt(1 - ((r - b)/(1 - b))^2)``, with r = p_down/p_up [1]_. The second root is 1
    where the flow is choked, r <= b; that it is a root is the subsonic index 0.5 of the standard. rho_0 and T_0 are
    those of the reference atmosphere [2]_.

    Parameters
    ----------
    conductance : float
        Sonic conductance C [m3/(s Pa) ANR].
    critical : float
        Critical pressure ratio b.
    pressure_up, pressure_down : float
        Pressures before and behind the restriction [Pa abs].
    temperature : float
        Temperature upstream [K].

    Returns
    -------
    float
        Mass flow [kg/s].

    References
    ----------
    .. [1] ISO 6358-1:2013, "Pneumatic fluid power - Determination of flow-rate characteristics of components using
       compressible fluids - Part 1: General rules and test methods for steady-state flow".
    .. [2] ISO 8778, "Pneumatic fluid power - Standard reference atmosphere".

    Examples
    --------
    C = 2 dm3/(s bar) and b = 0.3 between 0.5 and 0.4 MPa abs, as a standard volume flow in L/min ANR:

    >>> mass_flow = iso6358_flow(2e-8, 0.3, 5e5, 4e5)
    >>> round(mass_flow / ANR_DENSITY * 6e4, 1)
    419.9
    """
    choked = conductance * ANR_DENSITY * pressure_up * sqrt(293.15 / temperature)
    ratio = pressure_down / pressure_up
    if ratio <= critical:
        return choked
    return choked * sqrt(1.0 - ((ratio - critical) / (1.0 - critical)) ** 2)
