"""The work that an ideal machine takes from compressed air: what efficiencies are related to, and bounds."""

from math import log

from apesim.air import enthalpy, heat_capacity


def isothermal_work(gas, temperature, ratio):
    """Work of isothermal expansion to ambient pressure, R T ln r [J/kg]; exergy for a supply at ambient temperature."""
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
