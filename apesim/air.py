"""Air: its thermal state, its flow through a restriction, and the work an ideal machine could take from it.

Pressures are absolute, everything is SI. The gas of a volume is known by its mass and internal energy.
"""

import functools
from math import exp, log, sqrt
from typing import Annotated, NamedTuple

from apesim.kernel import kernel
from apesim.quantities import Choice, Pressure, Quantity

IDEAL, CANTERA = 0, 1
NEARLY_EQUAL = 0.999
ANR_DENSITY = 1.185
"""Density of air at the standard reference atmosphere of ISO 8778 (100 kPa, 20 °C, 65 % RH) [kg/m3]."""
AREA_OF_CONDUCTANCE = 5.02e-6 / 1e-8
"""Effective area of a sonic conductance: 5.02 mm2 for 1 dm3/(s bar) [m2 / (m3/(s Pa))]."""


class Air(NamedTuple):
    """The working gas."""

    model: Annotated[int, Choice(("ideal", "cantera"), "the paper's assumption; cantera: cp(T) of air.yaml")] = IDEAL
    gas_constant: Annotated[float, Quantity("J/(kg K)", 200, 400, "dry air; model = ideal only")] = 287.05
    heat_capacity_ratio: Annotated[float, Quantity("", 1.05, 1.67, "the paper's assumption; model = ideal only")] = 1.4


class Ambient(NamedTuple):
    """The surroundings: exhaust, vents, and what flows back through them."""

    pressure: Annotated[float, Pressure(20, 500, "standard atmosphere", unit="kPa")] = 101325.0
    temperature: Annotated[float, Quantity("K", 200, 350, "20 °C")] = 293.15


class Gas(NamedTuple):
    """What the kernels know of the air; made by `gas_of`."""

    perfect: int
    """1: cp depends on temperature, 0: constant."""
    gas_constant: float
    """[J/(kg K)]"""
    heat_capacity_ratio: float
    """At constant cp."""
    critical_ratio: float
    choked_flow: float
    """psi of choked flow."""
    near_flow: float
    """psi at a pressure ratio of 0.999."""
    per_heat_capacity: float
    """1/cv; an estimate where cp depends on temperature [kg K/J]."""
    a0: float
    """cp/R = a0 + a1 T + a2 T^2 + a3 T^3 + a4 T^4, T in K."""
    a1: float
    a2: float
    a3: float
    a4: float


@kernel
def critical_ratio(k):
    """Pressure ratio below which the flow is choked (Eq. 8)."""
    return (2.0 / (k + 1.0)) ** (k / (k - 1.0))


@kernel
def choked_flow_function(k):
    """psi of choked flow (Eq. 8)."""
    return (2.0 / (k + 1.0)) ** (1.0 / (k - 1.0)) * sqrt(2.0 * k / (k + 1.0))


@kernel
def subsonic_flow_function(ratio, k):
    """psi of flow that is not choked (Eq. 8), written with one power: a = r^(1/k)."""
    a = exp(log(ratio) / k)
    return sqrt(2.0 * k / (k - 1.0) * a * (a - ratio))


@kernel
def flow_function(gas, ratio, temperature):
    """psi(r) of Eq. 8, linear above r = 0.999, where Eq. 8 has an infinite slope.

    Parameters
    ----------
    gas : Gas
    ratio : float
        Downstream over upstream pressure, 0...1.
    temperature : float
        Upstream temperature [K].

    Returns
    -------
    float
    """
    if gas.perfect:
        k = heat_capacity_ratio(gas, temperature)
        critical = critical_ratio(k)
        choked = choked_flow_function(k)
        near = subsonic_flow_function(NEARLY_EQUAL, k)
    else:
        k = gas.heat_capacity_ratio
        critical = gas.critical_ratio
        choked = gas.choked_flow
        near = gas.near_flow
    if ratio <= critical:
        return choked
    if ratio > NEARLY_EQUAL:
        return near * (1.0 - ratio) / (1.0 - NEARLY_EQUAL)
    return subsonic_flow_function(ratio, k)


@kernel
def heat_capacity(gas, temperature):
    """cp(T) [J/(kg K)]."""
    t = temperature
    return gas.gas_constant * (gas.a0 + t * (gas.a1 + t * (gas.a2 + t * (gas.a3 + t * gas.a4))))


@kernel
def heat_capacity_ratio(gas, temperature):
    """cp/cv at T."""
    cp = heat_capacity(gas, temperature)
    return cp / (cp - gas.gas_constant)


@kernel
def enthalpy(gas, temperature):
    """Specific enthalpy, the integral of cp from 0 K [J/kg]."""
    t = temperature
    if gas.perfect:
        return (
            gas.gas_constant
            * t
            * (gas.a0 + t * (gas.a1 / 2.0 + t * (gas.a2 / 3.0 + t * (gas.a3 / 4.0 + t * gas.a4 / 5.0))))
        )
    return gas.a0 * gas.gas_constant * t


@kernel
def internal_energy(gas, temperature):
    """Specific internal energy h - R T [J/kg]."""
    return enthalpy(gas, temperature) - gas.gas_constant * temperature


@kernel
def temperature_of(gas, energy):
    """Temperature of a specific internal energy [J/kg]; four Newton steps where cp depends on it [K]."""
    t = energy * gas.per_heat_capacity
    if gas.perfect:
        for _ in range(4):
            t -= (internal_energy(gas, t) - energy) / (heat_capacity(gas, t) - gas.gas_constant)
    return t


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
    if area <= 0.0 or pressure_1 == pressure_2:
        return 0.0, 0.0
    if pressure_1 > pressure_2:
        psi = flow_function(gas, pressure_2 / pressure_1, temperature_1)
        mass = area * psi * pressure_1 / sqrt(gas.gas_constant * temperature_1)
        return mass, mass * enthalpy(gas, temperature_1)
    psi = flow_function(gas, pressure_1 / pressure_2, temperature_2)
    mass = -area * psi * pressure_2 / sqrt(gas.gas_constant * temperature_2)
    return mass, mass * enthalpy(gas, temperature_2)


@functools.cache
def gas_of(air):
    """The kernels' view of the working gas.

    Parameters
    ----------
    air : Air

    Returns
    -------
    Gas
        With ``model = "cantera"`` the NASA polynomial of Cantera's ``air.yaml`` at 300...1000 K, which is
        extrapolated to the colder air of an expansion: 1.2 % below the true cp at 180 K.
    """
    if air.model == CANTERA:
        import numpy as np
        from cantera import Solution, gas_constant

        cantera_air = Solution("air.yaml")
        nodes = np.linspace(300.0, 900.0, 5)
        r = gas_constant / cantera_air.mean_molecular_weight
        cp = []
        for node in nodes:
            cantera_air.TP = node, 1e5
            cp.append(cantera_air.cp_mass / r)
        a = np.polynomial.Polynomial.fit(nodes, cp, 4).convert().coef
        cp_room = float(np.polyval(a[::-1], 293.15))
        k = cp_room / (cp_room - 1.0)
        coefficients = tuple(float(c) for c in a)
    else:
        r, k = air.gas_constant, air.heat_capacity_ratio
        coefficients = (k / (k - 1.0), 0.0, 0.0, 0.0, 0.0)
    return Gas(
        int(air.model == CANTERA),
        float(r),
        k,
        critical_ratio(k),
        choked_flow_function(k),
        subsonic_flow_function(NEARLY_EQUAL, k),
        (k - 1.0) / float(r),
        *coefficients,
    )


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


def exergy(gas, temperature, ratio):
    """Work of isothermal expansion to ambient pressure, R T ln r [J/kg]; no machine takes more."""
    return gas.gas_constant * temperature * log(ratio)


def isentropic_work(gas, temperature, ratio):
    """Work of isentropic expansion to ambient pressure, h(T) - h(T_s) [J/kg]; no adiabatic machine takes more."""
    if not gas.perfect:
        k = gas.heat_capacity_ratio
        return enthalpy(gas, temperature) * (1.0 - ratio ** ((1.0 - k) / k))
    cold = temperature * ratio ** (1.0 / gas.heat_capacity_ratio - 1.0)
    for _ in range(20):
        cold += cold * (entropy_fall(gas, cold, temperature) - log(ratio)) * gas.gas_constant / heat_capacity(gas, cold)
    return enthalpy(gas, temperature) - enthalpy(gas, cold)


def entropy_fall(gas, cold, hot):
    """Integral of cp/(R T) from cold to hot, which is ln r along an isentrope."""
    terms = (gas.a1, gas.a2 / 2.0, gas.a3 / 3.0, gas.a4 / 4.0)
    return gas.a0 * log(hot / cold) + sum(a * (hot**n - cold**n) for n, a in enumerate(terms, start=1))


def full_admission_work(gas, temperature, ratio):
    """Work of admission over the whole stroke without expansion, R T (1 - 1/r) [J/kg]: a reference, no bound."""
    return gas.gas_constant * temperature * (1.0 - 1.0 / ratio)
