"""Heat between the chambers' walls and their air."""

from math import pi, sqrt
from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, law
from apesim.exergy import heat_exergy
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import ENERGY_A, ENERGY_B, HEAT_A, HEAT_B, WALL_EXERGY, ValveState


class ChamberWallHeat(NamedTuple):
    """A heat transfer coefficient over piston, cover and wall of each chamber."""

    h: Annotated[float, Quantity("W/(m^2 K)", 0, 400, "forced convection in small cylinders: 50 to 200")] = 0.0
    wall_temperature: Annotated[float, Quantity("K", 200, 400, "near ambient")] = 293.15


@law.for_type(ChamberWallHeat)
@kernel
def chamber_wall_heat(effect: ChamberWallHeat, state: ValveState, balance: np.ndarray) -> None:
    """Add the heat from the walls of both chambers to their air.

    ``Q = h (2 A + 4 V/D) (T_w - T)``, with the piston's area A and its diameter D, the chamber's volume V, the
    temperatures T_w of the wall and T of the air. Heat between air and cylinder walls is that of Carneiro and Gomes de
    Almeida [1]_; a constant h over piston, cover and wall is chosen.

    Parameters
    ----------
    effect : ChamberWallHeat
        Parameters of the effect.
    state : apesim.valve.terms.ValveState
        State of the valve.
    balance : (TERMS,) float array
        Balance of the valve that is added to, see `apesim.valve.terms`.

    References
    ----------
    .. [1] J. Falcao Carneiro and F. Gomes de Almeida, "Reduced-order thermodynamic models for servo-pneumatic actuator
       chambers", Proc. IMechE I 220, 2006, pp. 301-314, doi 10.1243/09596518JSCE203.

    Examples
    --------
    Chamber A, 21 589 mm3 over 38 mm of bore, has a wall of 4541 mm2; 100 W/(m2 K) times 20 K give 9.08 W:

    >>> import apesim
    >>> from apesim.air import GasState
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.supply import ValveSupply
    >>> from apesim.valve.terms import TERMS
    >>> actuator, _ = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> state = state_of(actuator, closed_at_rest(actuator, supply.control), supply)
    >>> balance = np.zeros(TERMS)
    >>> chamber_wall_heat(ChamberWallHeat(h=100.0, wall_temperature=320.0), state, balance)
    >>> round(float(balance[HEAT_A]), 2)
    9.08
    """
    if effect.h > 0.0:
        valve = state.valve
        diameter = sqrt(4.0 * valve.piston_area / pi)
        area_a = 2.0 * valve.piston_area + 4.0 * state.volume_a / diameter
        area_b = 2.0 * valve.piston_area + 4.0 * state.volume_b / diameter
        heat_a = effect.h * area_a * (effect.wall_temperature - state.chamber_a.temperature)
        heat_b = effect.h * area_b * (effect.wall_temperature - state.chamber_b.temperature)
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
