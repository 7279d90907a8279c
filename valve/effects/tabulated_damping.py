"""A force over the speed that has no name."""

from math import log2

from apesim.cubic_table import interpolate_clamped, table
from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import BREAKAWAY, DRY

PLACES = 0, 100, 300, 700, 1500, 3100
"""Speed [mm/s]: equally spaced in log2(1 + v/(100 mm/s))."""

TabulatedDamping = table(
    "TabulatedDamping",
    __name__,
    friction=(PLACES, Quantity("N", -40, 40, "as much as the viscous friction at 0.4 m/s")),
    seal=((1000,), Quantity("N", -40, 40, "seals that the air presses to the wall: up to 1e-4 N/Pa, 100 N/MPa")),
)
TabulatedDamping.__doc__ = "Against the motion: a force over the speed, and one for 1000 kPa of both chambers together."


@law.for_type(TabulatedDamping)
@kernel
def tabulated_damping(effect, state, balance):
    """R(v) against the motion, R(0) holding at rest, and more in proportion to |p_A - p_0| + |p_B - p_0| [N]."""
    ambient = state.ambient.pressure
    seal = effect[6] * 1e-6 * (abs(state.pressure_a - ambient) + abs(state.pressure_b - ambient))
    balance[DRY] += seal + interpolate_clamped(effect[:6], log2(1.0 + abs(state.speed) / 0.1))
    balance[BREAKAWAY] += max(0.0, seal + effect[0])


EFFECT = Effect(
    "tabulated_damping",
    TabulatedDamping,
    equation="M d2L/dt2 = ... - (R(|v|) + seal (|p_A - p_0| + |p_B - p_0|)/(1 MPa)) sign(v); "
    "R cubic in log(1 + |v|/(0.1 m/s)) between nodes",
    source="no law: what force over the speed would close a gap",
    seen_in="flight",
    isolated_by="strokes at several supply pressures, with both chamber pressures measured",
    strengths=TabulatedDamping._fields,
    tabulated="force",
)
