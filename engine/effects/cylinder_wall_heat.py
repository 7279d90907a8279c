"""Heat from the walls into the gas of the cylinder, which is colder than they are."""

from math import pi
from typing import Annotated, NamedTuple

import numpy as np

from apesim.air import heat_capacity
from apesim.effect import Effect, Search, law
from apesim.engine.cylinder import ENERGY, HEAT, WALL_EXERGY, CylinderState
from apesim.engine.kinematics import piston_face
from apesim.exergy import heat_exergy
from apesim.kernel import kernel
from apesim.quantities import Choice, Quantity

WOSCHNI, HOHENBERG, ANNAND, COMPRESSOR = range(4)
"""Correlations of the heat transfer coefficient."""
PRANDTL = 0.71
"""Prandtl number of air, taken as constant."""


class CylinderWallHeat(NamedTuple):
    """Heat transfer coefficient over two piston areas and the liner: a constant, plus a factor times a correlation."""

    h: Annotated[float, Quantity("W/(m^2 K)", 0, 500, "constant part")] = 0.0
    factor: Annotated[float, Quantity("", 0, 5, "on the correlation")] = 0.0
    correlation: Annotated[int, Choice(("woschni", "hohenberg", "annand", "compressor"), "cold gas")] = WOSCHNI
    wall_temperature: Annotated[float, Quantity("K", 200, 500, "near ambient")] = 300.0


@kernel
def viscosity(temperature: float) -> float:
    """Dynamic viscosity of air by Sutherland's law.

    ``mu = mu_0 (T/T_0)^1.5 (T_0 + C)/(T + C)`` with mu_0 = 17.16 uPa s, T_0 = 273.15 K and C = 110.4 K.

    The form is Sutherland's [1]_, the constants are those of the U.S. Standard Atmosphere [2]_, referred to 273.15 K.

    Parameters
    ----------
    temperature : float
        Temperature T of the air [K].

    Returns
    -------
    float
        Dynamic viscosity [Pa s].

    References
    ----------
    .. [1] W. Sutherland, "The viscosity of gases and molecular force", Phil. Mag. 36, 1893, pp. 507-531,
       doi 10.1080/14786449308620508.
    .. [2] "U.S. Standard Atmosphere, 1976", NOAA, NASA and U.S. Air Force, 1976, Eq. 51.

    Examples
    --------
    >>> round(viscosity(273.15) * 1e6, 2)
    17.16
    """
    return 1.716e-5 * (temperature / 273.15) ** 1.5 * (273.15 + 110.4) / (temperature + 110.4)


@kernel
def woschni(pressure: float, temperature: float, bore: float, piston_speed: float) -> float:
    """Heat transfer coefficient by Woschni's correlation, without its term of combustion.

    ``h = 3.26 B^-0.2 p^0.8 T^-0.55 (2.28 S_p)^0.8`` [1]_, with the bore B in m, the pressure p in kPa, the temperature
    T in K and the mean piston speed S_p in m/s. It stands as Eqs. 12.18 and 12.19 in Heywood's book [2]_.

    The factor 2.28 is that of closed valves; Woschni has 6.18 for the gas exchange, which is not used here. The
    correlation was fitted to engines with hot gas; air that is colder than the walls lies outside.

    Parameters
    ----------
    pressure : float
        Pressure in the cylinder [Pa abs].
    temperature : float
        Temperature in the cylinder [K].
    bore : float
        Bore of the cylinder [m].
    piston_speed : float
        Mean piston speed [m/s].

    Returns
    -------
    float
        Heat transfer coefficient [W/(m2 K)].

    References
    ----------
    .. [1] G. Woschni, "A universally applicable equation for the instantaneous heat transfer coefficient in the
       internal combustion engine", SAE 670931, 1967, doi 10.4271/670931.
    .. [2] J. B. Heywood, "Internal Combustion Engine Fundamentals", McGraw-Hill, 1988, Eqs. 12.18 and 12.19.

    Examples
    --------
    With B = 1 m, p = 1 kPa, T = 1 K and 2.28 S_p = 1 m/s the factor of the correlation is left:

    >>> round(woschni(1e3, 1.0, 1.0, 1.0 / 2.28), 9)
    3.26
    """
    return 3.26 * bore**-0.2 * (pressure / 1e3) ** 0.8 * temperature**-0.55 * (2.28 * piston_speed) ** 0.8


@kernel
def hohenberg(pressure: float, temperature: float, volume: float, piston_speed: float) -> float:
    """Heat transfer coefficient by Hohenberg's correlation.

    ``h = 130 V^-0.06 p^0.8 T^-0.4 (S_p + 1.4)^0.8`` [1]_, with the volume V in m3, the pressure p in bar, the
    temperature T in K and the mean piston speed S_p in m/s.

    It was fitted to diesel engines; air that is colder than the walls lies outside.

    Parameters
    ----------
    pressure : float
        Pressure in the cylinder [Pa abs].
    temperature : float
        Temperature in the cylinder [K].
    volume : float
        Volume of the cylinder [m3].
    piston_speed : float
        Mean piston speed [m/s].

    Returns
    -------
    float
        Heat transfer coefficient [W/(m2 K)].

    References
    ----------
    .. [1] G. F. Hohenberg, "Advanced approaches for heat transfer calculations", SAE 790825, 1979, doi 10.4271/790825.

    Examples
    --------
    With V = 1 m3, p = 1 bar, T = 1 K and S_p + 1.4 m/s = 1 m/s the factor of the correlation is left:

    >>> round(hohenberg(1e5, 1.0, 1.0, -0.4), 6)
    130.0
    """
    return 130.0 * volume**-0.06 * (pressure / 1e5) ** 0.8 * temperature**-0.4 * (piston_speed + 1.4) ** 0.8


@kernel
def nusselt(state: CylinderState, piston_speed: float, a: float, b: float, c: float) -> float:
    """Heat transfer coefficient by a correlation of the Nusselt number, ``Nu = a Re^b Pr^c``.

    ``h = Nu lambda/B`` and ``Re = rho S_p B/mu``, with the bore B, the mean piston speed S_p, the density rho, the
    viscosity mu and the conductivity ``lambda = mu cp/Pr`` of the air in the cylinder.

    The form is that of Annand [1]_; the constants are those that are given.

    Parameters
    ----------
    state : apesim.engine.cylinder.CylinderState
        State of the cylinder.
    piston_speed : float
        Mean piston speed [m/s].
    a, b, c : float
        Factor, exponent of the Reynolds number and exponent of the Prandtl number.

    Returns
    -------
    float
        Heat transfer coefficient [W/(m2 K)].

    References
    ----------
    .. [1] W. J. D. Annand, "Heat transfer in the cylinders of reciprocating internal combustion engines", Proc. IMechE
       177, 1963, pp. 973-996, doi 10.1243/PIME_PROC_1963_177_069_02.

    Examples
    --------
    Nu = 1 is the conductivity over the bore, 18.47 uPa s * 1004.7 J/(kg K)/0.71/85 mm = 0.307 W/(m2 K) at 300 K:

    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.cycle.state import cylinder_state, instant_at
    >>> from apesim.engine.cylinder import TERMS
    >>> from apesim.engine.machine import Machine
    >>> cycle, _, _ = cycle_of(Machine(), speed=100.0)
    >>> y, _ = charged_at_rest(cycle)
    >>> state, _ = cylinder_state(cycle, instant_at(cycle, 0.0, y), y)
    >>> print(round(nusselt(state._replace(air=state.air._replace(temperature=300.0)), 3.0, 1.0, 0.0, 0.0), 3))
    0.307
    """
    mu = viscosity(state.air.temperature)
    density = state.air.pressure / (state.gas.gas_constant * state.air.temperature)
    conductivity = mu * heat_capacity(state.gas, state.air.temperature) / PRANDTL
    reynolds = density * piston_speed * state.engine.bore / mu
    return a * reynolds**b * PRANDTL**c * conductivity / state.engine.bore


@kernel
def correlated_coefficient(effect: CylinderWallHeat, state: CylinderState) -> float:
    """Heat transfer coefficient by the correlation that the effect names.

    Annand's form [1]_ is ``Nu = 0.5 Re^0.7``, with a factor between his 0.35 and 0.8 and without his term of radiation;
    that of compressors ``Nu = 0.053 Re^0.8 Pr^0.6`` has the constants of Adair, Qvale and Pearson [2]_, but over bore
    and mean piston speed. For the others see `woschni` and `hohenberg`.

    Parameters
    ----------
    effect : CylinderWallHeat
        Parameters of the effect; its correlation is used.
    state : apesim.engine.cylinder.CylinderState
        State of the cylinder.

    Returns
    -------
    float
        Heat transfer coefficient [W/(m2 K)].

    References
    ----------
    .. [1] W. J. D. Annand, "Heat transfer in the cylinders of reciprocating internal combustion engines", Proc. IMechE
       177, 1963, pp. 973-996, doi 10.1243/PIME_PROC_1963_177_069_02.
    .. [2] R. P. Adair, E. B. Qvale and J. T. Pearson, "Instantaneous heat transfer to the cylinder wall in
       reciprocating compressors", Int. Compressor Eng. Conf., Purdue, 1972, p. 521.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.cycle.state import cylinder_state, instant_at
    >>> from apesim.engine.cylinder import TERMS
    >>> from apesim.engine.machine import Machine
    >>> cycle, _, _ = cycle_of(Machine(), speed=100.0)
    >>> y, _ = charged_at_rest(cycle)
    >>> state, _ = cylinder_state(cycle, instant_at(cycle, 0.0, y), y)
    >>> speed = state.engine.stroke * state.speed / pi
    >>> effect = CylinderWallHeat(correlation=HOHENBERG)
    >>> expected = hohenberg(state.air.pressure, state.air.temperature, state.volume, speed)
    >>> print(correlated_coefficient(effect, state) / expected)
    1.0
    """
    speed = state.engine.stroke * state.speed / pi
    if effect.correlation == WOSCHNI:
        return woschni(state.air.pressure, state.air.temperature, state.engine.bore, speed)
    if effect.correlation == HOHENBERG:
        return hohenberg(state.air.pressure, state.air.temperature, state.volume, speed)
    if effect.correlation == ANNAND:
        return nusselt(state, speed, 0.5, 0.7, 0.0)
    return nusselt(state, speed, 0.053, 0.8, 0.6)


@law.for_type(CylinderWallHeat)
@kernel
def cylinder_wall_heat(effect: CylinderWallHeat, state: CylinderState, balance: np.ndarray) -> None:
    """Add the heat from the walls to the gas of the cylinder.

    ``Q = h (2 A_p + 4 V/B) (T_w - T)``, with the heat transfer coefficient h, the piston's area A_p, the volume V, the
    bore B, the wall's temperature T_w and the gas's temperature T. The areas are those of piston, head and liner.

    It is Newton's law of cooling over the surface of the chamber [1]_, with a flat head and piston.

    Parameters
    ----------
    effect : CylinderWallHeat
        Parameters of the effect.
    state : apesim.engine.cylinder.CylinderState
        State of the cylinder.
    balance : (TERMS,) float array
        Balance of the cylinder that is added to, see `apesim.engine.cylinder`.

    References
    ----------
    .. [1] J. B. Heywood, "Internal Combustion Engine Fundamentals", McGraw-Hill, 1988, Eq. 2.7 on the surface,
       chapter 12 on the heat.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.cycle.state import cylinder_state, instant_at
    >>> from apesim.engine.cylinder import TERMS
    >>> from apesim.engine.machine import Machine
    >>> cycle, _, _ = cycle_of(Machine(), speed=100.0)
    >>> y, _ = charged_at_rest(cycle)
    >>> state, _ = cylinder_state(cycle, instant_at(cycle, 0.0, y), y)
    >>> state, balance = state._replace(air=state.air._replace(temperature=200.0)), np.zeros(TERMS)
    >>> cylinder_wall_heat(CylinderWallHeat(h=100.0, wall_temperature=300.0), state, balance)
    >>> area = 2.0 * piston_face(state.engine) + 4.0 * state.volume / state.engine.bore
    >>> print(round(balance[HEAT] / area, 6))
    10000.0
    """
    h = effect.h
    if effect.factor > 0.0:
        h += effect.factor * correlated_coefficient(effect, state)
    area = 2.0 * piston_face(state.engine) + 4.0 * state.volume / state.engine.bore
    heat = h * area * (effect.wall_temperature - state.air.temperature)
    balance[ENERGY] += heat
    balance[HEAT] += heat
    balance[WALL_EXERGY] += heat_exergy(state.ambient, heat, effect.wall_temperature)


EFFECT = Effect(
    "cylinder_wall_heat",
    CylinderWallHeat,
    equation="Q = h (2 A_p + 4 V/B) (T_w - T)",
    source="Woschni SAE 670931; Hohenberg SAE 790825; Annand 1963, Proc. IMechE 177, 973; compressor: the constants of "
    "Adair, Qvale and Pearson 1972 (Int. Compressor Eng. Conf., Purdue, 521), over bore and mean piston speed",
    seen_in="compression and expansion",
    isolated_by="motored compression and expansion with both valves closed, at two speeds",
    strengths=("h", "factor"),
    search=Search(strengths=("h",)),
)
