"""Air and its thermal state.

Pressures are absolute and all values are in SI units. The gas of a volume is known by its mass and internal energy.
Equations are those of an ideal gas, with constant or temperature-dependent heat capacity.
"""

import functools
from math import exp, expm1, log
from typing import Annotated, NamedTuple

from apesim.flow_function import NEARLY_EQUAL, choked_flow_function, critical_ratio, subsonic_flow_function
from apesim.kernel import kernel
from apesim.quantities import Choice, Pressure, Quantity

IDEAL, THERMALLY_PERFECT = 0, 1
"""Models of the working gas: constant heat capacities, or Lemmon's, which depend on temperature."""
COLDEST, HOTTEST = 100.0, 1000.0
"""Temperatures between which cp follows its polynomial [K]; beyond them it stays what it is there.

Below 100 K cp of air no longer changes (by 5e-5 down to 60 K); above 1000 K no engine of this kind comes.
"""
ANR_DENSITY = 1.185
"""Density of air at the standard reference atmosphere of ISO 8778 (100 kPa, 20 °C, 65 % RH) [kg/m3]."""


class Air(NamedTuple):
    """The working gas."""

    model: Annotated[
        int,
        Choice(
            ("ideal", "thermally_perfect"),
            "the paper's assumption; thermally_perfect: cp(T) of Lemmon and others, 2000",
            (("cantera", "thermally_perfect", "cp(T) of air is Lemmon's now, which holds in the cold, too"),),
        ),
    ] = IDEAL
    gas_constant: Annotated[float, Quantity("J/(kg K)", 200, 400, "dry air; model = ideal only")] = 287.05
    heat_capacity_ratio: Annotated[float, Quantity("", 1.05, 1.67, "dry air, 300 K; model = ideal only")] = 1.4


class GasState(NamedTuple):
    """State of the air at a place: its pressure and temperature, which travel together."""

    pressure: float
    """Pressure [Pa abs]."""
    temperature: float
    """Temperature [K]."""


class GasContent(NamedTuple):
    """Gas that a volume holds; or its change, or its rates [kg/s, W]."""

    mass: float
    """Mass [kg]."""
    energy: float
    """Internal energy [J]."""


class Ambient(NamedTuple):
    """The surroundings: exhaust, vents, and what flows back through them."""

    pressure: Annotated[float, Pressure(20, 500, "standard atmosphere", unit="kPa", show="ambient")] = 101325.0
    temperature: Annotated[float, Quantity("K", 200, 350, "20 °C")] = 293.15


LEMMON_REDUCING = 132.6312
"""Temperature that Lemmon's equation is reduced by [K]."""
LEMMON_GAS_CONSTANT = 8.31451 / 28.9586e-3
"""Gas constant over molar mass, as Lemmon's equation has them [J/(kg K)]."""
DEGREE = 8
"""Degree of the polynomial that stands for Lemmon's cp: it keeps within 1.3e-5, that of degree 7 within 7.8e-5."""


class Gas(NamedTuple):
    """Properties of the working gas that the kernels take, made by `gas_of`."""

    perfect: int
    """Whether cp depends on temperature (1) or is constant (0)."""
    gas_constant: float
    """Specific gas constant [J/(kg K)]."""
    heat_capacity_ratio: float
    """Ratio of the heat capacities k where cp is constant."""
    critical_ratio: float
    """Critical pressure ratio where cp is constant."""
    choked_flow: float
    """Flow function psi of choked flow."""
    near_flow: float
    """Flow function psi at a pressure ratio of 0.999."""
    per_heat_capacity: float
    """Reciprocal of cv; an estimate where cp depends on temperature [kg K/J]."""
    a0: float
    """First coefficient of cp/R = a0 + a1 T + ... + a8 T^8, with T in K."""
    a1: float
    a2: float
    a3: float
    a4: float
    a5: float
    a6: float
    a7: float
    a8: float


def lemmon_heat_capacity(temperature: float) -> float:
    """Return the heat capacity of air at constant pressure as an ideal gas, by Lemmon and others.

    ``cp/R = 1 + N7 + sum N_i (u/(e^u - 1))^2 e^u - N10 w^2 z/(1 + z)^2 - sum N_j j (j - 1) tau^j``, with
    tau = 132.6312 K/T, u = N11 tau and N12 tau, w = N13 tau, z = 2/3 e^-w, and j = -3, -2, -1 and 1.5.

    It is -tau^2 times the second derivative of the ideal part of the Helmholtz energy [1]_, plus 1. It holds from 60 to
    2000 K.

    Parameters
    ----------
    temperature : float
        Temperature [K].

    Returns
    -------
    float
        cp over the gas constant.

    References
    ----------
    .. [1] E. W. Lemmon, R. T Jacobsen, S. G. Penoncello and D. G. Friend, "Thermodynamic properties of air and mixtures
       of nitrogen, argon, and oxygen from 60 to 2000 K at pressures to 2000 MPa", J. Phys. Chem. Ref. Data 29, 2000,
       pp. 331-385, doi 10.1063/1.1285884, section 3 and Table 12.

    Examples
    --------
    >>> [round(lemmon_heat_capacity(temperature), 4) for temperature in (100.0, 300.0, 1000.0)]
    [3.4914, 3.5004, 3.9746]
    """
    tau = LEMMON_REDUCING / temperature
    powers = ((0.605719400e-7, -3.0), (-0.210274769e-4, -2.0), (-0.158860716e-3, -1.0), (-0.195363420e-3, 1.5))
    ratio = 1.0 + 2.490888032 - sum(n * j * (j - 1.0) * tau**j for n, j in powers)
    for n, rate in ((0.791309509, 25.36365), (0.212236768, 16.90741)):
        u = rate * tau
        ratio += n * (u / expm1(u)) ** 2 * exp(u)
    w = 87.31279 * tau
    z = 2.0 / 3.0 * exp(-w)
    return ratio + 0.197938904 * w * w * z / (1.0 + z) ** 2


@kernel
def heat_capacity(gas: Gas, temperature: float) -> float:
    """Return the heat capacity at constant pressure, ``cp = R (a0 + a1 T + ... + a8 T^8)``.

    The polynomial stands for the cp of `lemmon_heat_capacity`, whose source is [1]_; with the ideal model it is the
    constant k R/(k - 1). Below `COLDEST` and above `HOTTEST` cp stays what it is there.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    temperature : float
        Temperature [K].

    Returns
    -------
    float
        Specific heat capacity cp [J/(kg K)].

    References
    ----------
    .. [1] E. W. Lemmon, R. T Jacobsen, S. G. Penoncello and D. G. Friend, "Thermodynamic properties of air and mixtures
       of nitrogen, argon, and oxygen from 60 to 2000 K at pressures to 2000 MPa", J. Phys. Chem. Ref. Data 29, 2000,
       pp. 331-385, doi 10.1063/1.1285884.

    Examples
    --------
    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> round(heat_capacity(gas, 300.0), 3)
    1004.675
    """
    t = min(max(temperature, COLDEST), HOTTEST)
    high = t * (gas.a4 + t * (gas.a5 + t * (gas.a6 + t * (gas.a7 + t * gas.a8))))
    return gas.gas_constant * (gas.a0 + t * (gas.a1 + t * (gas.a2 + t * (gas.a3 + high))))


@kernel
def heat_capacity_ratio(gas: Gas, temperature: float) -> float:
    """Return the ratio of the heat capacities at a temperature, ``k = cp/(cp - R)``.

    An ideal gas has cp - cv = R (Mayer's relation) [1]_.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    temperature : float
        Temperature [K].

    Returns
    -------
    float
        k, the exponent of isentropic changes.

    References
    ----------
    .. [1] M. J. Moran, H. N. Shapiro, D. D. Boettner and M. B. Bailey, "Fundamentals of Engineering Thermodynamics",
       8th ed., Wiley, 2014, ISBN 978-1-118-41293-0, chapter 3.

    Examples
    --------
    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> round(heat_capacity_ratio(gas, 300.0), 6)
    1.4
    """
    cp = heat_capacity(gas, temperature)
    return cp / (cp - gas.gas_constant)


@kernel
def enthalpy(gas: Gas, temperature: float) -> float:
    """Return the specific enthalpy, the integral of cp over T; ``h = cp T`` where cp is constant.

    The enthalpy of an ideal gas depends on the temperature alone [1]_. Only differences mean something.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    temperature : float
        Temperature [K].

    Returns
    -------
    float
        Specific enthalpy [J/kg].

    References
    ----------
    .. [1] M. J. Moran, H. N. Shapiro, D. D. Boettner and M. B. Bailey, "Fundamentals of Engineering Thermodynamics",
       8th ed., Wiley, 2014, ISBN 978-1-118-41293-0, chapter 3.

    Examples
    --------
    The ideal cp of 1004.675 J/(kg K) times 300 K:

    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> round(enthalpy(gas, 300.0), 3)
    301402.5
    """
    if gas.perfect:
        t = min(max(temperature, COLDEST), HOTTEST)
        high = t * (gas.a4 / 5.0 + t * (gas.a5 / 6.0 + t * (gas.a6 / 7.0 + t * (gas.a7 / 8.0 + t * gas.a8 / 9.0))))
        within = t * (gas.a0 + t * (gas.a1 / 2.0 + t * (gas.a2 / 3.0 + t * (gas.a3 / 4.0 + high))))
        return gas.gas_constant * within + heat_capacity(gas, t) * (temperature - t)
    return gas.a0 * gas.gas_constant * temperature


@kernel
def internal_energy(gas: Gas, temperature: float) -> float:
    """Return the specific internal energy, ``u = h - R T``.

    It is h - p v with p v = R T of an ideal gas [1]_.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    temperature : float
        Temperature [K].

    Returns
    -------
    float
        Specific internal energy [J/kg].

    References
    ----------
    .. [1] M. J. Moran, H. N. Shapiro, D. D. Boettner and M. B. Bailey, "Fundamentals of Engineering Thermodynamics",
       8th ed., Wiley, 2014, ISBN 978-1-118-41293-0, chapter 3.

    Examples
    --------
    The ideal cv of 717.625 J/(kg K) times 300 K:

    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> round(internal_energy(gas, 300.0), 3)
    215287.5
    """
    return enthalpy(gas, temperature) - gas.gas_constant * temperature


@kernel
def temperature_of(gas: Gas, energy: float) -> float:
    """Return the temperature at which air has a specific internal energy, ``u(T) = energy``.

    Where cp depends on temperature, four steps of Newton's method [1]_ from a constant cv lead to it.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    energy : float
        Specific internal energy [J/kg].

    Returns
    -------
    float
        Temperature [K].

    References
    ----------
    .. [1] W. H. Press, S. A. Teukolsky, W. T. Vetterling and B. P. Flannery, "Numerical Recipes", 3rd ed., Cambridge
       University Press, 2007, section 9.4.

    Examples
    --------
    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> round(temperature_of(gas, 717.625 * 300.0), 6)
    300.0
    """
    t = energy * gas.per_heat_capacity
    if gas.perfect:
        for _ in range(4):
            t -= (internal_energy(gas, t) - energy) / (heat_capacity(gas, t) - gas.gas_constant)
    return t


@kernel
def thermal_entropy(gas: Gas, temperature: float) -> float:
    """Return the part of the specific entropy that temperature makes, the integral of cp/T.

    ``s = cp ln(T)`` where cp is constant. Only differences mean something; the part of the pressure is -R ln(p) [1]_.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    temperature : float
        Temperature [K].

    Returns
    -------
    float
        Specific entropy without the part of the pressure [J/(kg K)].

    References
    ----------
    .. [1] M. J. Moran, H. N. Shapiro, D. D. Boettner and M. B. Bailey, "Fundamentals of Engineering Thermodynamics",
       8th ed., Wiley, 2014, ISBN 978-1-118-41293-0, chapter 6.

    Examples
    --------
    cp ln(2) from 300 K to 600 K:

    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> round(thermal_entropy(gas, 600.0) - thermal_entropy(gas, 300.0), 2)
    696.39
    """
    if gas.perfect:
        t = min(max(temperature, COLDEST), HOTTEST)
        high = t * (gas.a4 / 4.0 + t * (gas.a5 / 5.0 + t * (gas.a6 / 6.0 + t * (gas.a7 / 7.0 + t * gas.a8 / 8.0))))
        powers = t * (gas.a1 + t * (gas.a2 / 2.0 + t * (gas.a3 / 3.0 + high)))
        return gas.gas_constant * (gas.a0 * log(t) + powers) + heat_capacity(gas, t) * log(temperature / t)
    return gas.a0 * gas.gas_constant * log(temperature)


def temperature_at_enthalpy(gas: Gas, specific_enthalpy: float) -> float:
    """Return the temperature at which air has a specific enthalpy, ``h(T) = specific_enthalpy``.

    Where cp depends on temperature, twenty steps of Newton's method [1]_ from a constant cp lead to it.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    specific_enthalpy : float
        Specific enthalpy [J/kg].

    Returns
    -------
    float
        Temperature [K].

    References
    ----------
    .. [1] W. H. Press, S. A. Teukolsky, W. T. Vetterling and B. P. Flannery, "Numerical Recipes", 3rd ed., Cambridge
       University Press, 2007, section 9.4.

    Examples
    --------
    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> round(temperature_at_enthalpy(gas, 1004.675 * 300.0), 6)
    300.0
    """
    k = gas.heat_capacity_ratio
    temperature = specific_enthalpy * (k - 1.0) / (k * gas.gas_constant)
    for _ in range(20 if gas.perfect else 0):
        temperature -= (enthalpy(gas, temperature) - specific_enthalpy) / heat_capacity(gas, temperature)
    return temperature


@functools.cache
def gas_of(air: Air) -> Gas:
    """Prepare the working gas for the kernels.

    With ``model = "thermally_perfect"`` the heat capacity is that of Lemmon and others [1]_, as the polynomial of
    degree 8 that meets it at the nodes of Chebyshev between 100 and 1000 K: within 1.3e-5 of it there. Beyond these
    ends cp stays constant, which is within 5e-5 of it down to 60 K.

    Parameters
    ----------
    air : Air
        Model and constants of the working gas.

    Returns
    -------
    Gas
        What the kernels take.

    References
    ----------
    .. [1] E. W. Lemmon, R. T Jacobsen, S. G. Penoncello and D. G. Friend, "Thermodynamic properties of air and mixtures
       of nitrogen, argon, and oxygen from 60 to 2000 K at pressures to 2000 MPa", J. Phys. Chem. Ref. Data 29, 2000,
       pp. 331-385, doi 10.1063/1.1285884.

    Examples
    --------
    >>> gas = gas_of(Air())
    >>> round(gas.critical_ratio, 4), round(gas.choked_flow, 4), round(gas.a0, 6)
    (0.5283, 0.6847, 3.5)
    """
    if air.model == THERMALLY_PERFECT:
        import numpy as np
        from numpy.polynomial import Chebyshev, Polynomial

        r = LEMMON_GAS_CONSTANT
        law = Chebyshev.interpolate(np.vectorize(lemmon_heat_capacity), DEGREE, domain=[COLDEST, HOTTEST])
        coefficients = tuple(float(c) for c in law.convert(kind=Polynomial).coef)
        cp_room = float(law(293.15))
        k = cp_room / (cp_room - 1.0)
    else:
        r, k = air.gas_constant, air.heat_capacity_ratio
        coefficients = (k / (k - 1.0), *[0.0] * DEGREE)
    return Gas(
        int(air.model == THERMALLY_PERFECT),
        float(r),
        k,
        critical_ratio(k),
        choked_flow_function(k),
        subsonic_flow_function(NEARLY_EQUAL, k),
        (k - 1.0) / float(r),
        *coefficients,
    )
