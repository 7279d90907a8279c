"""Heat between the chambers' walls and their air."""

from math import pi, sqrt
from typing import Annotated, NamedTuple

from apesim.effect import Effect, law
from apesim.exergy import heat_exergy
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import ENERGY_A, ENERGY_B, HEAT_A, HEAT_B, WALL_EXERGY


class ChamberWallHeat(NamedTuple):
    """A heat transfer coefficient over piston, cover and wall of each chamber."""

    h: Annotated[float, Quantity("W/(m^2 K)", 0, 400, "forced convection in small cylinders: 50 to 200")] = 0.0
    wall_temperature: Annotated[float, Quantity("K", 200, 400, "near ambient")] = 293.15


@law.for_type(ChamberWallHeat)
@kernel
def chamber_wall_heat(effect, state, balance):
    """Q = h (2 A + 4 V/D) (T_w - T), D of the piston area A."""
    if effect.h > 0.0:
        valve = state.valve
        diameter = sqrt(4.0 * valve.piston_area / pi)
        area_a = 2.0 * valve.piston_area + 4.0 * state.volume_a / diameter
        area_b = 2.0 * valve.piston_area + 4.0 * state.volume_b / diameter
        heat_a = effect.h * area_a * (effect.wall_temperature - state.temperature_a)
        heat_b = effect.h * area_b * (effect.wall_temperature - state.temperature_b)
        balance[ENERGY_A] += heat_a
        balance[ENERGY_B] += heat_b
        balance[HEAT_A] += heat_a
        balance[HEAT_B] += heat_b
        balance[WALL_EXERGY] += heat_exergy(state.ambient, heat_a + heat_b, effect.wall_temperature)


EFFECT = Effect(
    "chamber_wall_heat",
    ChamberWallHeat,
    equation="Q = h (2 A + 4 V/D) (T_w - T)",
    source="Carneiro and Gomes de Almeida 2006, Proc. IMechE I 220, 301: heat between air and cylinder walls",
    seen_in="chamber pressures in dwell; confused with leaks on lift alone",
    isolated_by="a charged chamber, solenoids held, piston on its stop: pressure over a second",
)
