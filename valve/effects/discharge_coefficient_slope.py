"""Discharge coefficient of the solenoids that falls with the pressure ratio."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.solenoid_flow import SUPPLY_A, SUPPLY_B, VENT_A, VENT_B
from apesim.valve.terms import FLOW_SHARE


class DischargeCoefficientSlope(NamedTuple):
    """By what share the effective area at equal pressures is smaller than at high pressure difference."""

    fall: Annotated[
        float, Quantity("", -0.3, 0.3, "sharp-edged orifices: from 0.84 far beyond choking to 0.6 at equal pressures")
    ] = 0.0


@law.for_type(DischargeCoefficientSlope)
@kernel
def discharge_coefficient_slope(effect, state, balance):
    """Each flow through the solenoids is larger by -fall r, r the lower over the higher pressure."""
    supply, vent, a, b = state.supply_pressure, state.vent_pressure, state.pressure_a, state.pressure_b
    balance[FLOW_SHARE + SUPPLY_A] -= effect.fall * (min(supply, a) / max(supply, a))
    balance[FLOW_SHARE + VENT_A] -= effect.fall * (min(vent, a) / max(vent, a))
    balance[FLOW_SHARE + SUPPLY_B] -= effect.fall * (min(supply, b) / max(supply, b))
    balance[FLOW_SHARE + VENT_B] -= effect.fall * (min(vent, b) / max(vent, b))


EFFECT = Effect(
    "discharge_coefficient_slope",
    DischargeCoefficientSlope,
    equation="S(r) = S (1 - fall r)",
    source="Jobson 1955, Proc. IMechE 169, 767: contraction of a jet of compressible fluid over its pressure ratio",
    seen_in="shape of charge and discharge; confused with the critical ratio",
    isolated_by="discharge test of a solenoid down to ambient pressure at two charging pressures",
)
