"""The gas of a chamber (Eqs. 3-6): mass and internal energy, from which pressure and temperature follow."""

from apesim.air import flow_between, temperature_of
from apesim.kernel import kernel


@kernel
def chamber_state(gas, mass, energy, volume):
    """Pressure and temperature of a uniform gas volume (Eq. 3).

    Parameters
    ----------
    gas : Gas
    mass : float
        [kg]
    energy : float
        Internal energy [J].
    volume : float
        [m3]

    Returns
    -------
    pressure : float
        [Pa abs]
    temperature : float
        [K]
    """
    temperature = temperature_of(gas, energy / mass)
    if gas.perfect:
        return mass * gas.gas_constant * temperature / volume, temperature
    return (gas.heat_capacity_ratio - 1.0) * energy / volume, temperature


@kernel
def chamber_flows(gas, supply_area, vent_area, supply, ambient, pressure, temperature):
    """Flows into a chamber from its supply and out of it through its vent (Eqs. 4, 7).

    Parameters
    ----------
    gas : Gas
    supply_area, vent_area : float
        Effective areas [m2].
    supply, ambient : tuple of float
        Pressure [Pa abs] and temperature [K].
    pressure, temperature : float
        Of the chamber [Pa abs, K].

    Returns
    -------
    supplied, supplied_enthalpy, vented, vented_enthalpy : float
        [kg/s, W, kg/s, W]
    """
    supplied, supplied_enthalpy = flow_between(gas, supply_area, supply[0], supply[1], pressure, temperature)
    vented, vented_enthalpy = flow_between(gas, vent_area, pressure, temperature, ambient[0], ambient[1])
    return supplied, supplied_enthalpy, vented, vented_enthalpy
