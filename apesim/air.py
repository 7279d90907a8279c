"""Air and its thermal state.

Pressures are absolute, everything is SI. The gas of a volume is known by its mass and internal energy.
"""

import functools
from math import log
from typing import Annotated, NamedTuple

from apesim.flow_function import NEARLY_EQUAL, choked_flow_function, critical_ratio, subsonic_flow_function
from apesim.kernel import kernel
from apesim.quantities import Choice, Pressure, Quantity

IDEAL, CANTERA = 0, 1
CP_UP_TO = 1000.0
"""End of the range of the polynomial of air.yaml that is used [K]."""
ANR_DENSITY = 1.185
"""Density of air at the standard reference atmosphere of ISO 8778 (100 kPa, 20 °C, 65 % RH) [kg/m3]."""


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
def thermal_entropy(gas, temperature):
    """Specific entropy but for the part of the pressure, the integral of cp/T [J/(kg K)]."""
    t = temperature
    if gas.perfect:
        powers = t * (gas.a1 + t * (gas.a2 / 2.0 + t * (gas.a3 / 3.0 + t * gas.a4 / 4.0)))
        return gas.gas_constant * (gas.a0 * log(t) + powers)
    return gas.a0 * gas.gas_constant * log(t)


def temperature_at_enthalpy(gas, specific_enthalpy):
    """Temperature of a specific enthalpy [J/kg], by Newton's method where cp depends on it [K]."""
    k = gas.heat_capacity_ratio
    temperature = specific_enthalpy * (k - 1.0) / (k * gas.gas_constant)
    for _ in range(20 if gas.perfect else 0):
        temperature -= (enthalpy(gas, temperature) - specific_enthalpy) / heat_capacity(gas, temperature)
    return temperature


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
