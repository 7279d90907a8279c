"""Heat into the chambers that has no name."""

from apesim.cubic_table import interpolate_clamped, table
from apesim.effect import Effect, law
from apesim.exergy import heat_exergy
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import ENERGY_A, ENERGY_B, HEAT_A, HEAT_B, WALL_EXERGY

PLACES = "minus_80", "minus_40", 0, 40, 80
"""Temperature of the air above ambient [K]."""
SIZE = Quantity("W", -200, 200, "400 W/(m2 K) over 60 cm2 and 80 K")

TabulatedHeat = table("TabulatedHeat", __name__, a=(PLACES, SIZE), b=(PLACES, SIZE))
TabulatedHeat.__doc__ = "Heat into chamber A and chamber B over the temperature of their air above ambient."


@law.for_type(TabulatedHeat)
@kernel
def tabulated_heat(effect, state, balance):
    """Q_A(T_A - T_0) and Q_B(T_B - T_0) into the chambers [W]; walls, unknown, count as of the air's temperature."""
    ambient = state.ambient.temperature
    heat_a = interpolate_clamped(effect[:5], 2.0 + (state.temperature_a - ambient) / 40.0)
    heat_b = interpolate_clamped(effect[5:], 2.0 + (state.temperature_b - ambient) / 40.0)
    balance[ENERGY_A] += heat_a
    balance[ENERGY_B] += heat_b
    balance[HEAT_A] += heat_a
    balance[HEAT_B] += heat_b
    balance[WALL_EXERGY] += heat_exergy(state.ambient, heat_a, state.temperature_a)
    balance[WALL_EXERGY] += heat_exergy(state.ambient, heat_b, state.temperature_b)


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
