"""Air and its thermal state.

Pressures are absolute and all values are in SI units. The gas of a volume is known by its mass and internal energy.
Equations are those of an ideal gas, with constant or temperature-dependent heat capacity.
"""

import functools
from math import log
from typing import Annotated, NamedTuple

from apesim.flow_function import NEARLY_EQUAL, choked_flow_function, critical_ratio, subsonic_flow_function
from apesim.kernel import kernel
from apesim.quantities import Choice, Pressure, Quantity

IDEAL, CANTERA = 0, 1
"""Models of the working gas: constant heat capacities, or those of Cantera's air."""
CP_UP_TO = 1000.0
"""Highest temperature at which the polynomial of Cantera's air.yaml is used [K]."""
ANR_DENSITY = 1.185
"""Density of air at the standard reference atmosphere of ISO 8778 (100 kPa, 20 °C, 65 % RH) [kg/m3]."""


class Air(NamedTuple):
    """The working gas."""

    model: Annotated[int, Choice(("ideal", "cantera"), "the paper's assumption; cantera: cp(T) of air.yaml")] = IDEAL
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

    pressure: Annotated[float, Pressure(20, 500, "standard atmosphere", unit="kPa")] = 101325.0
    temperature: Annotated[float, Quantity("K", 200, 350, "20 °C")] = 293.15


HOTTEST = 1000.0
"""Temperature up to which cp follows its polynomial [K]: beyond 1200 K that falls, to R at 1887 K."""


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
    """First coefficient of cp/R = a0 + a1 T + a2 T^2 + a3 T^3 + a4 T^4, with T in K."""
    a1: float
    a2: float
    a3: float
    a4: float


@kernel
def heat_capacity(gas: Gas, temperature: float) -> float:
    """Return the heat capacity at constant pressure, ``cp = R (a0 + a1 T + a2 T^2 + a3 T^3 + a4 T^4)``.

    The form is that of NASA's polynomials [1]_, the numbers are those of Cantera's ``air.yaml`` [2]_ at 300...1000 K;
    with the ideal model it is the constant k R/(k - 1). Above `HOTTEST` it stays what it is there.

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
    .. [1] B. J. McBride, S. Gordon and M. A. Reno, "Coefficients for Calculating Thermodynamic and Transport Properties
       of Individual Species", NASA TM-4513, 1993.
    .. [2] D. G. Goodwin and others, "Cantera", https://www.cantera.org; its file air.yaml.

    Examples
    --------
    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> round(heat_capacity(gas, 300.0), 3)
    1004.675
    """
    t = min(temperature, HOTTEST)
    return gas.gas_constant * (gas.a0 + t * (gas.a1 + t * (gas.a2 + t * (gas.a3 + t * gas.a4))))


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
    """Return the specific enthalpy, the integral of cp from 0 K to T; ``h = cp T`` where cp is constant.

    The enthalpy of an ideal gas depends on the temperature alone [1]_.

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
        t = min(temperature, HOTTEST)
        below = t * (gas.a0 + t * (gas.a1 / 2.0 + t * (gas.a2 / 3.0 + t * (gas.a3 / 4.0 + t * gas.a4 / 5.0))))
        return gas.gas_constant * below + heat_capacity(gas, t) * (temperature - t)
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
        t = min(temperature, HOTTEST)
        powers = t * (gas.a1 + t * (gas.a2 / 2.0 + t * (gas.a3 / 3.0 + t * gas.a4 / 4.0)))
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

    With ``model = "cantera"`` the heat capacity is the NASA polynomial [1]_ of Cantera's ``air.yaml`` [2]_ at
    300...1000 K. It is extrapolated to the colder air of an expansion, where it is 1.2 % below the true cp at 180 K;
    above 1000 K cp stays constant.

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
    .. [1] B. J. McBride, S. Gordon and M. A. Reno, "Coefficients for Calculating Thermodynamic and Transport Properties
       of Individual Species", NASA TM-4513, 1993.
    .. [2] D. G. Goodwin and others, "Cantera", https://www.cantera.org; its file air.yaml.

    Examples
    --------
    >>> gas = gas_of(Air())
    >>> round(gas.critical_ratio, 4), round(gas.choked_flow, 4), round(gas.a0, 6)
    (0.5283, 0.6847, 3.5)
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
        a: np.ndarray = np.polynomial.Polynomial.fit(nodes, cp, 4).convert().coef
        cp_room = float(np.polyval(a[::-1].astype(float), 293.15))
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
