"""Flow through the solenoids that has no name."""

from apesim.cubic_table import interpolate_clamped, table
from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.solenoid_flow import SUPPLY_A, SUPPLY_B, VENT_A, VENT_B
from apesim.valve.terms import FLOW_SHARE

PLACES = 20, 40, 60, 80, 100
"""Lower over higher pressure [%]."""
SIZE = Quantity("", -0.5, 0.5, "discharge coefficients: 0.6 to 0.9")

TabulatedArea = table("TabulatedArea", __name__, filling=(PLACES, SIZE), venting=(PLACES, SIZE))
TabulatedArea.__doc__ = "Shares by which the solenoids let more air in and out, over the pressure ratio."


@kernel
def ratio_node(pressure, other):
    """Place of a pressure ratio among the nodes."""
    return 5.0 * min(pressure, other) / max(pressure, other) - 1.0


@law.for_type(TabulatedArea)
@kernel
def tabulated_area(effect, state, balance):
    """Flows from the supply are larger by s(r), those to the vent by another, r the lower over the higher pressure."""
    supply, vent, a, b = state.supply_pressure, state.vent_pressure, state.pressure_a, state.pressure_b
    balance[FLOW_SHARE + SUPPLY_A] += interpolate_clamped(effect[:5], ratio_node(supply, a))
    balance[FLOW_SHARE + VENT_A] += interpolate_clamped(effect[5:], ratio_node(vent, a))
    balance[FLOW_SHARE + SUPPLY_B] += interpolate_clamped(effect[:5], ratio_node(supply, b))
    balance[FLOW_SHARE + VENT_B] += interpolate_clamped(effect[5:], ratio_node(vent, b))


EFFECT = Effect(
    "tabulated_area",
    TabulatedArea,
    equation="S(r) = S (1 + s(r)), one s filling and one venting, cubic between nodes every fifth",
    source="no law: what effective area would close a gap",
    seen_in="shape of charge and discharge",
    isolated_by="discharge and charge tests of a solenoid",
    strengths=TabulatedArea._fields,
    tabulated="area",
)
