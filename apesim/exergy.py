"""Exergy of air against the ambient: the work that a reversible machine would take from it (Bejan, Advanced Engineering
Thermodynamics, 4th ed., chapters 3 and 5).

A stream is a tuple of its mass flow [kg/s] and its temperature [K]; a restriction keeps the temperature.
"""

from math import log

from apesim.air import enthalpy, thermal_entropy
from apesim.kernel import kernel
from apesim.restriction import upstream_of


@kernel
def entropy_above(gas, ambient, pressure, temperature):
    """Specific entropy above that of ambient air [J/(kg K)]."""
    thermal = thermal_entropy(gas, temperature) - thermal_entropy(gas, ambient.temperature)
    return thermal - gas.gas_constant * log(pressure / ambient.pressure)


@kernel
def flow_exergy(gas, ambient, pressure, temperature):
    """Specific exergy of a stream, h - h_0 - T_0 (s - s_0).

    Parameters
    ----------
    gas : apesim.air.Gas
    ambient : apesim.air.Ambient
        The dead state.
    pressure : float
        [Pa abs]
    temperature : float
        [K]

    Returns
    -------
    float
        [J/kg]
    """
    heat = enthalpy(gas, temperature) - enthalpy(gas, ambient.temperature)
    return heat - ambient.temperature * entropy_above(gas, ambient, pressure, temperature)


@kernel
def exergy_stored(gas, ambient, mass, energy, pressure, temperature, volume):
    """Exergy of the gas in a volume, U - m u_0 + p_0 (V - m v_0) - T_0 m (s - s_0).

    Parameters
    ----------
    gas : apesim.air.Gas
    ambient : apesim.air.Ambient
    mass : float
        [kg]
    energy : float
        Internal energy [J].
    pressure, temperature : float
        [Pa abs, K]
    volume : float
        [m3]

    Returns
    -------
    float
        [J]
    """
    entropy = mass * entropy_above(gas, ambient, pressure, temperature)
    dead = mass * enthalpy(gas, ambient.temperature)
    return energy + ambient.pressure * volume - ambient.temperature * entropy - dead


@kernel
def stream_through(regime, sides, mass_flow):
    """Stream through a restriction: mass flow and upstream temperature; see `apesim.restriction.flow_in`."""
    return mass_flow, upstream_of(regime, sides)[1]


@kernel
def stream_exergy(gas, ambient, stream, pressure):
    """Exergy that a stream carries at a pressure [W]."""
    return stream[0] * flow_exergy(gas, ambient, pressure, stream[1])


@kernel
def throttling_loss(gas, ambient, stream, pressure_1, pressure_2):
    """Exergy destroyed in a restriction, T_0 mdot R ln(p_1/p_2) [W]; a stream from 2 to 1 is negative."""
    return ambient.temperature * stream[0] * gas.gas_constant * log(pressure_1 / pressure_2)


@kernel
def mixing_loss(gas, ambient, stream, temperature):
    """Exergy destroyed where a stream mixes with the gas of a volume at its pressure [W].

    Parameters
    ----------
    gas : apesim.air.Gas
    ambient : apesim.air.Ambient
    stream : tuple of float
        Into the volume. One that leaves it has its temperature, and destroys nothing.
    temperature : float
        Of the volume [K].

    Returns
    -------
    float
        T_0 mdot ((h_1 - h)/T - (s_1 - s)).
    """
    heat = enthalpy(gas, stream[1]) - enthalpy(gas, temperature)
    entropy = thermal_entropy(gas, stream[1]) - thermal_entropy(gas, temperature)
    return ambient.temperature * stream[0] * (heat / temperature - entropy)


@kernel
def exergy_brought(gas, ambient, mass_flow, energy_flow, pressure, temperature):
    """By how much a flow of mass and energy raises the exergy of a volume, whatever carries it.

    Parameters
    ----------
    gas : apesim.air.Gas
    ambient : apesim.air.Ambient
    mass_flow, energy_flow : float
        [kg/s, W]
    pressure, temperature : float
        Of the volume [Pa abs, K].

    Returns
    -------
    float
        E - T_0 (E - mu m)/T - g_0 m, mu = h - T s of the volume and g_0 of ambient air [W].
    """
    entropy = entropy_above(gas, ambient, pressure, temperature)
    potential = ambient.temperature * (enthalpy(gas, temperature) / temperature - entropy)
    return heat_exergy(ambient, energy_flow, temperature) + mass_flow * (potential - enthalpy(gas, ambient.temperature))


@kernel
def heat_exergy(ambient, heat, temperature):
    """Exergy of a heat flow at a temperature, Q (1 - T_0/T) [W]."""
    return heat * (1.0 - ambient.temperature / temperature)
