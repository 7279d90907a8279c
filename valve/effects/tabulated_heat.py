"""Heat into the chambers that has no name, as tables over their temperature."""

import numpy as np

from apesim.cubic_table import interpolate_clamped, table
from apesim.effect import Effect, law
from apesim.exergy import heat_exergy
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import ENERGY_A, ENERGY_B, HEAT_A, HEAT_B, WALL_EXERGY, ValveState

PLACES = "minus_80", "minus_40", 0, 40, 80
"""Temperature of the air above ambient at the values of the tables [K]."""
COLDEST, HOTTEST, STEP = -80.0, 80.0, 40.0
"""The first and the last of them, and the distance between two [K]."""
SIZE = Quantity("W", -200, 200, "400 W/(m2 K) over 60 cm2 and 80 K")
"""Declaration of a value: a heat flow."""

TabulatedHeat = table("TabulatedHeat", __name__, a=(PLACES, SIZE), b=(PLACES, SIZE))
TabulatedHeat.__doc__ = "Heat into chamber A and chamber B over the temperature of their air above ambient."


@kernel
def heat_at(values: tuple[float, ...], temperature: float, ambient: float) -> float:
    """Return the heat into the air [W] of a table over the temperature of the air [K] above ambient [K].

    Heat at the nodes `PLACES` is `values` [W]. Beyond the ends it is constant, but for heat taken from air that is
    colder than the first node, and heat put into air that is hotter than the last. These fall off as ``x^2 (3 - 2 x)``,
    to nothing at half of the first node's and twice the last node's absolute temperature: no wall cools air to 0 K, or
    heats it without end. Chosen.

    >>> values = (-100.0, 0.0, 0.0, 0.0, 100.0)
    >>> [heat_at(values, temperature, 280.0) for temperature in (150.0, 200.0, 240.0, 360.0, 540.0, 720.0)]
    [-50.0, -100.0, 0.0, 100.0, 50.0, 0.0]
    """
    heat = interpolate_clamped(values, 2.0 + (temperature - ambient) / STEP)
    beyond = 2.0 * temperature / (ambient + COLDEST) - 1.0 if heat < 0.0 else 2.0 - temperature / (ambient + HOTTEST)
    share = min(max(beyond, 0.0), 1.0)
    return heat * share * share * (3.0 - 2.0 * share)


@law.for_type(TabulatedHeat)
@kernel
def tabulated_heat(effect: tuple[float, ...], state: ValveState, balance: np.ndarray) -> None:
    """Add the heat that tables give over the temperature of each chamber's air, ``Q(T - T_0)``, see `heat_at`. Chosen.

    The walls are not known; they count as ones with the temperature of the air. Changes the valve's `balance` (TERMS,),
    see `apesim.valve.terms`.
    """
    ambient = state.ambient.temperature
    heat_a = heat_at(effect[:5], state.chamber_a.temperature, ambient)
    heat_b = heat_at(effect[5:], state.chamber_b.temperature, ambient)
    balance[ENERGY_A] += heat_a
    balance[ENERGY_B] += heat_b
    balance[HEAT_A] += heat_a
    balance[HEAT_B] += heat_b
    balance[WALL_EXERGY] += heat_exergy(state.ambient, heat_a, state.chamber_a.temperature)
    balance[WALL_EXERGY] += heat_exergy(state.ambient, heat_b, state.chamber_b.temperature)


EFFECT = Effect(
    "tabulated_heat",
    TabulatedHeat,
    equation="dU/dt = ... + Q(T - T_0), of each chamber, cubic between nodes every 40 K",
    source="no law: what heat would close a gap",
    seen_in="chamber pressures",
    isolated_by="a charged chamber, solenoids held, piston on its stop: pressure over a second",
    strengths=TabulatedHeat._fields,
    tabulated="heat",
)
