"""Heat from the walls into the gas, which is colder than they are."""

from math import pi
from typing import Annotated, NamedTuple

from apesim.air import heat_capacity
from apesim.effect import Effect, law
from apesim.engine.cylinder import ENERGY, HEAT, WALL_EXERGY
from apesim.engine.kinematics import piston_face
from apesim.exergy import heat_exergy
from apesim.kernel import kernel
from apesim.quantities import Choice, Quantity

WOSCHNI, HOHENBERG, ANNAND, COMPRESSOR = range(4)
PRANDTL = 0.71


class CylinderWallHeat(NamedTuple):
    """A coefficient over two piston areas and the liner: a constant plus a share of a correlation."""

    h: Annotated[float, Quantity("W/(m^2 K)", 0, 500, "constant part")] = 0.0
    factor: Annotated[float, Quantity("", 0, 5, "on the correlation")] = 0.0
    correlation: Annotated[int, Choice(("woschni", "hohenberg", "annand", "compressor"), "cold gas")] = WOSCHNI
    wall_temperature: Annotated[float, Quantity("K", 200, 500, "near ambient")] = 300.0


@kernel
def viscosity(temperature):
    """Sutherland's law for air [Pa s]."""
    return 1.716e-5 * (temperature / 273.15) ** 1.5 * (273.15 + 110.4) / (temperature + 110.4)


@kernel
def woschni(pressure, temperature, bore, piston_speed):
    """Woschni 1967 (SAE 670931) without combustion: 3.26 B^-0.2 p^0.8 T^-0.55 w^0.8, p in kPa, w = 2.28 S_p."""
    return 3.26 * bore**-0.2 * (pressure / 1e3) ** 0.8 * temperature**-0.55 * (2.28 * piston_speed) ** 0.8


@kernel
def hohenberg(pressure, temperature, volume, piston_speed):
    """Hohenberg 1979 (SAE 790825): 130 V^-0.06 p^0.8 T^-0.4 (S_p + 1.4)^0.8, p in bar."""
    return 130.0 * volume**-0.06 * (pressure / 1e5) ** 0.8 * temperature**-0.4 * (piston_speed + 1.4) ** 0.8


@kernel
def nusselt(state, piston_speed, a, b, c):
    """Coefficient of Nu = a Re^b Pr^c over the bore, with the mean piston speed."""
    mu = viscosity(state.temperature)
    density = state.pressure / (state.gas.gas_constant * state.temperature)
    conductivity = mu * heat_capacity(state.gas, state.temperature) / PRANDTL
    reynolds = density * piston_speed * state.engine.bore / mu
    return a * reynolds**b * PRANDTL**c * conductivity / state.engine.bore


@kernel
def correlated(effect, state):
    """Heat transfer coefficient of the chosen correlation [W/(m2 K)]."""
    speed = state.engine.stroke * state.speed / pi
    if effect.correlation == WOSCHNI:
        return woschni(state.pressure, state.temperature, state.engine.bore, speed)
    if effect.correlation == HOHENBERG:
        return hohenberg(state.pressure, state.temperature, state.volume, speed)
    if effect.correlation == ANNAND:
        return nusselt(state, speed, 0.5, 0.7, 0.0)
    return nusselt(state, speed, 0.053, 0.8, 0.6)


@law.for_type(CylinderWallHeat)
@kernel
def cylinder_wall_heat(effect, state, balance):
    """Q = h (2 A_p + 4 V/B) (T_w - T)."""
    h = effect.h
    if effect.factor > 0.0:
        h += effect.factor * correlated(effect, state)
    area = 2.0 * piston_face(state.engine) + 4.0 * state.volume / state.engine.bore
    heat = h * area * (effect.wall_temperature - state.temperature)
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
)
