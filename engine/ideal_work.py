"""Ideal work: what an ideal machine takes from compressed air, the denominators of efficiencies."""

from math import log

from apesim.air import Gas, enthalpy, heat_capacity, thermal_entropy


def isothermal_work(gas: Gas, temperature: float, ratio: float) -> float:
    """Work of isothermal expansion of compressed air to ambient pressure, ``w = R T ln(r)``.

    It is the flow exergy of the air only where the air has the ambient's temperature.

    It is the flow exergy [1]_ of an ideal gas at the ambient's temperature, with the gas constant R, the temperature T
    and the pressure ratio r.

    Parameters
    ----------
    gas : apesim.air.Gas
        The working gas.
    temperature : float
        Temperature T of the air before the expansion, and during it [K].
    ratio : float
        Pressure of the air over ambient pressure r, both absolute; above 0.

    Returns
    -------
    float
        Specific work [J/kg].

    Raises
    ------
    ValueError
        If the pressure ratio is not above 0.

    References
    ----------
    .. [1] A. Bejan, "Advanced Engineering Thermodynamics", 4th ed., Wiley, 2016, doi 10.1002/9781119245964, chapter 5.

    Examples
    --------
    287.05 J/(kg K) * 293.15 K * ln(10) = 193.8 kJ/kg:

    >>> from apesim.air import Air, gas_of
    >>> round(isothermal_work(gas_of(Air()), 293.15, 10.0) / 1e3, 1)
    193.8
    """
    return gas.gas_constant * temperature * log(ratio)


def isentropic_work(gas: Gas, temperature: float, ratio: float) -> float:
    """Work of isentropic expansion of compressed air to ambient pressure, ``w = h(T) - h(T_s)``.

    ``T_s`` is the temperature after the expansion. With a constant heat capacity it is ``T r^((1 - k)/k)``, with the
    ratio k of the heat capacities; else it is found by Newton's method [2]_ from the integral of cp/(R T), which is
    ln(r) [1]_. No adiabatic machine without back-flow takes more.

    Parameters
    ----------
    gas : apesim.air.Gas
        The working gas.
    temperature : float
        Temperature T of the air before the expansion [K].
    ratio : float
        Pressure of the air over ambient pressure r, both absolute; above 0.

    Returns
    -------
    float
        Specific work [J/kg].

    References
    ----------
    .. [1] M. J. Moran, H. N. Shapiro, D. D. Boettner and M. B. Bailey, "Fundamentals of Engineering Thermodynamics",
       8th ed., Wiley, 2014, ISBN 978-1-118-41293-0, chapter 6.
    .. [2] W. H. Press, S. A. Teukolsky, W. T. Vetterling and B. P. Flannery, "Numerical Recipes", 3rd ed., Cambridge
       University Press, 2007, section 9.4.

    Examples
    --------
    With cp = 3.5 R, 1004.7 J/(kg K) * 293.15 K * (1 - 10^(-2/7)) = 142.0 kJ/kg:

    >>> from apesim.air import Air, gas_of
    >>> round(isentropic_work(gas_of(Air()), 293.15, 10.0) / 1e3, 1)
    142.0
    """
    if not gas.perfect:
        k = gas.heat_capacity_ratio
        return enthalpy(gas, temperature) * (1.0 - ratio ** ((1.0 - k) / k))
    cold = temperature * ratio ** (1.0 / gas.heat_capacity_ratio - 1.0)
    for _ in range(20):
        fall = thermal_entropy(gas, temperature) - thermal_entropy(gas, cold)
        cold += cold * (fall - gas.gas_constant * log(ratio)) / heat_capacity(gas, cold)
    return enthalpy(gas, temperature) - enthalpy(gas, cold)


def full_admission_work(gas: Gas, temperature: float, ratio: float) -> float:
    """Work of admission over the whole stroke, without expansion: ``w = R T (1 - 1/r)``.

    It is a reference for an air motor without cut-off, and no bound: a machine that expands the air takes more.

    It is defined here: the work ``p v = R T`` of letting the air in, less ``p_0 v`` against the ambient, with v = R T/p
    and r = p/p_0.

    Parameters
    ----------
    gas : apesim.air.Gas
        The working gas.
    temperature : float
        Temperature T of the air before the admission [K].
    ratio : float
        Pressure of the air over ambient pressure r, both absolute; not 0.

    Returns
    -------
    float
        Specific work [J/kg].

    Examples
    --------
    287.05 J/(kg K) * 293.15 K * 0.9 = 75.7 kJ/kg:

    >>> from apesim.air import Air, gas_of
    >>> round(full_admission_work(gas_of(Air()), 293.15, 10.0) / 1e3, 1)
    75.7
    """
    return gas.gas_constant * temperature * (1.0 - 1.0 / ratio)
