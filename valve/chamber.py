"""Gas of a chamber: mass and internal energy, from which pressure and temperature follow.

Equations: the EPV paper (doi 10.1631/jzus.A0820373), Eqs. 3-6. Its balance of the temperature, Eq. 5, is kept here as
one of the internal energy, which is the same law.
"""

from apesim.air import Gas, GasContent, GasState, internal_energy, temperature_of
from apesim.kernel import kernel


@kernel
def chamber_state(gas: Gas, content: GasContent, volume: float) -> GasState:
    """Return pressure and temperature of a uniform gas volume.

    ``u(T) = U/m`` and ``p V = m R T`` (Eq. 3 of the EPV paper [1]_).

    u is the specific and U the internal energy, m the mass, p the pressure, V the volume, R the gas constant and T the
    temperature. Where cp is constant, p V = (k - 1) U with the ratio k of the heat capacities.

    Real air at room temperature has p V/(m R T) = 0.99 at 2 MPa and 1.10 at 30 MPa [2]_.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    content : apesim.air.GasContent
        Mass and internal energy of the gas, both above 0.
    volume : float
        Volume, above 0 [m3].

    Returns
    -------
    apesim.air.GasState
        Pressure and temperature.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 3.
    .. [2] E. W. Lemmon and others, "Thermodynamic properties of air and mixtures of nitrogen, argon, and oxygen from 60
       to 2000 K at pressures to 2000 MPa", J. Phys. Chem. Ref. Data 29, 2000, pp. 331-385, doi 10.1063/1.1285884.

    Examples
    --------
    1 g of air with 215.2875 J, the 717.625 J/(kg K) of cv times 300 K, in 1 L:

    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> state = chamber_state(gas, GasContent(1e-3, 215.2875), 1e-3)
    >>> round(state.pressure, 1), round(state.temperature, 6)
    (86115.0, 300.0)
    """
    temperature = temperature_of(gas, content.energy / content.mass)
    if gas.perfect:
        return GasState(content.mass * gas.gas_constant * temperature / volume, temperature)
    return GasState((gas.heat_capacity_ratio - 1.0) * content.energy / volume, temperature)


@kernel
def filled(gas: Gas, volume: float, state: GasState) -> GasContent:
    """Return mass and internal energy of the gas in a volume.

    ``m = p V/(R T)`` (Eq. 3 of the EPV paper [1]_) and ``U = m u(T)``.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    volume : float
        Volume [m3].
    state : apesim.air.GasState
        Pressure and temperature of the gas.

    Returns
    -------
    apesim.air.GasContent
        Mass and internal energy.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 3.

    Examples
    --------
    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> mass, energy = filled(gas, 1e-3, GasState(86115.0, 300.0))
    >>> round(mass, 9), round(energy, 4)
    (0.001, 215.2875)
    """
    mass = state.pressure * volume / (gas.gas_constant * state.temperature)
    return GasContent(mass, mass * internal_energy(gas, state.temperature))
