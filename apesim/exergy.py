"""Exergy of air against the ambient: the work that a reversible machine would take from it.

Equations: Bejan, Advanced Engineering Thermodynamics, 4th ed., chapters 3 and 5. The dead state is that of the
ambient; a restriction keeps the temperature of a stream.
"""

from math import log
from typing import NamedTuple

from apesim.air import Gas, GasContent, GasState, enthalpy, thermal_entropy
from apesim.kernel import kernel
from apesim.restriction import Sides, upstream_of


class Stream(NamedTuple):
    """Stream of air: how much flows, and how hot it is."""

    mass: float
    """Mass flow [kg/s]."""
    temperature: float
    """Temperature [K]."""


@kernel
def entropy_above(gas: Gas, ambient: GasState, state: GasState) -> float:
    """Return the specific entropy above that of ambient air, ``s - s_0 = cp ln(T/T_0) - R ln(p/p_0)`` for constant cp.

    Entropy of an ideal gas [1]_, with the temperature T, the pressure p, the gas constant R and the heat capacity cp;
    index 0: ambient air.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    ambient : apesim.air.GasState
        State of the surroundings, the dead state.
    state : apesim.air.GasState
        Pressure and temperature.

    Returns
    -------
    float
        Specific entropy difference [J/(kg K)].

    References
    ----------
    .. [1] M. J. Moran, H. N. Shapiro, D. D. Boettner and M. B. Bailey, "Fundamentals of Engineering Thermodynamics",
       8th ed., Wiley, 2014, ISBN 978-1-118-41293-0, chapter 6.

    Examples
    --------
    -287.05 J/(kg K) * ln(10):

    >>> from apesim.air import Air, GasState, gas_of
    >>> gas, ambient = gas_of(Air()), GasState(1e5, 300.0)
    >>> round(entropy_above(gas, ambient, GasState(1e6, 300.0)), 2)
    -660.96
    """
    thermal = thermal_entropy(gas, state.temperature) - thermal_entropy(gas, ambient.temperature)
    return thermal - gas.gas_constant * log(state.pressure / ambient.pressure)


@kernel
def flow_exergy(gas: Gas, ambient: GasState, state: GasState) -> float:
    """Return the specific exergy of a stream, ``e = h - h_0 - T_0 (s - s_0)``.

    h is the specific enthalpy, s the specific entropy, T_0 the ambient's temperature; index 0: the dead state [1]_.
    Kinetic and potential energy are left out.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    ambient : apesim.air.GasState
        State of the surroundings, the dead state.
    state : apesim.air.GasState
        Pressure and temperature.

    Returns
    -------
    float
        Specific flow exergy [J/kg].

    References
    ----------
    .. [1] A. Bejan, "Advanced Engineering Thermodynamics", 4th ed., Wiley, 2016, doi 10.1002/9781119245964, chapter 5.

    Examples
    --------
    At ambient temperature it is R T_0 ln(p/p_0), 287.05 * 300 * ln(10) J/kg:

    >>> from apesim.air import Air, GasState, gas_of
    >>> gas, ambient = gas_of(Air()), GasState(1e5, 300.0)
    >>> round(flow_exergy(gas, ambient, GasState(1e6, 300.0)) / 1e3, 2)
    198.29
    """
    heat = enthalpy(gas, state.temperature) - enthalpy(gas, ambient.temperature)
    return heat - ambient.temperature * entropy_above(gas, ambient, state)


@kernel
def exergy_stored(gas: Gas, ambient: GasState, content: GasContent, state: GasState, volume: float) -> float:
    """Return the exergy of the gas in a volume, ``U - m u_0 + p_0 (V - m v_0) - T_0 m (s - s_0)``.

    U is the internal energy, m the mass, V the volume, s the specific entropy, u and v are the specific internal energy
    and volume; index 0: the dead state [1]_. It is computed with the enthalpy h_0 = u_0 + p_0 v_0.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    ambient : apesim.air.GasState
        State of the surroundings, the dead state.
    content : apesim.air.GasContent
        Mass and internal energy of the gas.
    state : apesim.air.GasState
        Pressure and temperature.
    volume : float
        Volume [m3].

    Returns
    -------
    float
        Exergy [J].

    References
    ----------
    .. [1] A. Bejan, "Advanced Engineering Thermodynamics", 4th ed., Wiley, 2016, doi 10.1002/9781119245964, chapter 5.

    Examples
    --------
    1 L at ten times the ambient pressure holds p V (ln(10) - 1 + 1/10) = 1000 J * 1.4026:

    >>> from apesim.air import Air, GasContent, GasState, gas_of
    >>> gas, ambient = gas_of(Air()), GasState(1e5, 300.0)
    >>> mass = 1e6 * 1e-3 / (gas.gas_constant * 300.0)
    >>> round(exergy_stored(gas, ambient, GasContent(mass, mass * 717.625 * 300.0), GasState(1e6, 300.0), 1e-3), 1)
    1402.6
    """
    entropy = content.mass * entropy_above(gas, ambient, state)
    dead = content.mass * enthalpy(gas, ambient.temperature)
    return content.energy + ambient.pressure * volume - ambient.temperature * entropy - dead


@kernel
def stream_through(regime: float, sides: Sides, mass_flow: float) -> Stream:
    """Return the stream through a restriction: its mass flow [kg/s] from side 1 to 2, and its upstream temperature.

    Only the sign of the regime counts, see `apesim.restriction`.

    >>> stream_through(-1, Sides(GasState(1e5, 300.0), GasState(2e5, 280.0)), -0.01)
    Stream(mass=-0.01, temperature=280.0)
    """
    _, temperature = upstream_of(regime, sides)
    return Stream(mass_flow, temperature)


@kernel
def stream_exergy(gas: Gas, ambient: GasState, stream: Stream, pressure: float) -> float:
    """Return the exergy that a stream carries at a pressure, ``mdot e(p, T)``.

    e is the specific flow exergy [1]_, see `flow_exergy`.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    ambient : apesim.air.GasState
        State of the surroundings, the dead state.
    stream : Stream
        Mass flow and temperature.
    pressure : float
        Pressure [Pa abs].

    Returns
    -------
    float
        Exergy flow [W].

    References
    ----------
    .. [1] A. Bejan, "Advanced Engineering Thermodynamics", 4th ed., Wiley, 2016, doi 10.1002/9781119245964, chapter 5.

    Examples
    --------
    >>> from apesim.air import Air, GasState, gas_of
    >>> gas, ambient = gas_of(Air()), GasState(1e5, 300.0)
    >>> round(stream_exergy(gas, ambient, Stream(0.01, 300.0), 1e6), 1)
    1982.9
    """
    if stream.mass == 0.0:  # most streams, most of the time: no logarithm for them
        return 0.0
    return stream.mass * flow_exergy(gas, ambient, GasState(pressure, stream.temperature))


@kernel
def throttling_loss(gas: Gas, ambient: GasState, stream: Stream, pressure_1: float, pressure_2: float) -> float:
    """Return the exergy that a restriction destroys, ``T_0 mdot R ln(p_1/p_2)``.

    A loss of exergy is T_0 times the entropy made (theorem of Gouy and Stodola) [1]_; a throttle keeps the enthalpy,
    and an ideal gas then its temperature.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    ambient : apesim.air.GasState
        State of the surroundings, the dead state.
    stream : Stream
        Mass flow from 1 to 2, negative the other way, and temperature.
    pressure_1, pressure_2 : float
        Pressures on both sides [Pa abs].

    Returns
    -------
    float
        Exergy destroyed [W].

    References
    ----------
    .. [1] A. Bejan, "Advanced Engineering Thermodynamics", 4th ed., Wiley, 2016, doi 10.1002/9781119245964, chapter 3.

    Examples
    --------
    From 1 MPa to ambient pressure a stream at ambient temperature loses all that it has:

    >>> from apesim.air import Air, GasState, gas_of
    >>> gas, ambient = gas_of(Air()), GasState(1e5, 300.0)
    >>> round(throttling_loss(gas, ambient, Stream(0.01, 300.0), 1e6, 1e5), 1)
    1982.9
    """
    if stream.mass == 0.0:
        return 0.0
    return ambient.temperature * stream.mass * gas.gas_constant * log(pressure_1 / pressure_2)


@kernel
def mixing_loss(gas: Gas, ambient: GasState, stream: Stream, temperature: float) -> float:
    """Return the exergy destroyed where a stream mixes with the gas of a volume at its pressure.

    ``T_0 mdot ((h_1 - h)/T - (s_1 - s))``, with the stream's state 1.

    A loss of exergy is T_0 times the entropy made (theorem of Gouy and Stodola) [1]_: what the gas gains by the energy
    h_1 - h at its temperature T, less what the stream had. h is the specific enthalpy, s the part of the specific
    entropy that temperature makes.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    ambient : apesim.air.GasState
        State of the surroundings, the dead state.
    stream : Stream
        Mass flow into the volume and its temperature. One that leaves the volume has the temperature of the
        volume, and destroys nothing.
    temperature : float
        Temperature of the volume [K].

    Returns
    -------
    float
        Exergy destroyed [W].

    References
    ----------
    .. [1] A. Bejan, "Advanced Engineering Thermodynamics", 4th ed., Wiley, 2016, doi 10.1002/9781119245964, chapter 3.

    Examples
    --------
    With twice the temperature, T_0 mdot cp (2 - 1 - ln(2)):

    >>> from apesim.air import Air, GasState, gas_of
    >>> gas, ambient = gas_of(Air()), GasState(1e5, 300.0)
    >>> round(mixing_loss(gas, ambient, Stream(0.01, 600.0), 300.0), 1)
    924.9
    """
    if stream.mass == 0.0:
        return 0.0
    heat = enthalpy(gas, stream.temperature) - enthalpy(gas, temperature)
    entropy = thermal_entropy(gas, stream.temperature) - thermal_entropy(gas, temperature)
    return ambient.temperature * stream.mass * (heat / temperature - entropy)


@kernel
def exergy_brought(gas: Gas, ambient: GasState, mass_flow: float, energy_flow: float, state: GasState) -> float:
    """Return by how much a flow of mass and energy raises the exergy of a volume, whatever carries it.

    ``E - T_0 (E - mu m)/T - g_0 m``, with mu = h - T s of the volume and g_0 of ambient air.

    E is the energy flow, m the mass flow, T the temperature of the volume, g = h - T_0 s the specific free enthalpy at
    T_0. It is the rate of `exergy_stored` [1]_ at constant volume, with dS = (dU - mu dm)/T.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    ambient : apesim.air.GasState
        State of the surroundings, the dead state.
    mass_flow : float
        Mass flow into the volume [kg/s].
    energy_flow : float
        Energy flow into the volume [W].
    state : apesim.air.GasState
        Pressure and temperature of the volume.

    Returns
    -------
    float
        Rise of the exergy [W].

    References
    ----------
    .. [1] A. Bejan, "Advanced Engineering Thermodynamics", 4th ed., Wiley, 2016, doi 10.1002/9781119245964, chapters 3
       and 5.

    Examples
    --------
    A stream in the state of the volume brings its flow exergy:

    >>> from apesim.air import Air, GasState, gas_of
    >>> gas, ambient = gas_of(Air()), GasState(1e5, 300.0)
    >>> round(exergy_brought(gas, ambient, 0.01, 0.01 * 1004.675 * 300.0, GasState(1e6, 300.0)), 1)
    1982.9
    """
    if mass_flow == 0.0 and energy_flow == 0.0:
        return 0.0
    entropy, temperature = entropy_above(gas, ambient, state), state.temperature
    potential = ambient.temperature * (enthalpy(gas, temperature) / temperature - entropy)
    return heat_exergy(ambient, energy_flow, temperature) + mass_flow * (potential - enthalpy(gas, ambient.temperature))


@kernel
def heat_exergy(ambient: GasState, heat: float, temperature: float) -> float:
    """Return the exergy of a heat flow at a temperature, ``Q (1 - T_0/T)``.

    It is the work of a reversible engine between T and the ambient's T_0 [1]_; below T_0 it is negative for heat that
    flows in.

    Parameters
    ----------
    ambient : apesim.air.GasState
        State of the surroundings, the dead state.
    heat : float
        Heat flow [W].
    temperature : float
        Temperature at which the heat flows [K].

    Returns
    -------
    float
        Exergy flow [W].

    References
    ----------
    .. [1] A. Bejan, "Advanced Engineering Thermodynamics", 4th ed., Wiley, 2016, doi 10.1002/9781119245964, chapters 3
       and 5.

    Examples
    --------
    >>> from apesim.air import GasState
    >>> heat_exergy(GasState(1e5, 300.0), 100.0, 600.0)
    50.0
    """
    return heat * (1.0 - ambient.temperature / temperature)
