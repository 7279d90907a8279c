"""The gas of a chamber (Eqs. 3-6): mass and internal energy, from which pressure and temperature follow."""

from apesim.air import internal_energy, temperature_of
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


def filled(gas, volume, pressure, temperature):
    """Mass [kg] and internal energy [J] of the gas in a volume [m3] at a pressure [Pa abs] and temperature [K]."""
    mass = pressure * volume / (gas.gas_constant * temperature)
    return mass, mass * internal_energy(gas, temperature)
