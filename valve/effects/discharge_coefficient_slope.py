"""Discharge coefficient of the solenoids that falls with the pressure ratio."""

from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.solenoid_flow import SUPPLY_A, SUPPLY_B, VENT_A, VENT_B
from apesim.valve.terms import FLOW_SHARE, ValveState


class DischargeCoefficientSlope(NamedTuple):
    """Share by which the effective area at equal pressures is smaller than at high pressure difference."""

    fall: Annotated[
        float, Quantity("", -0.3, 0.3, "sharp-edged orifices: from 0.84 far beyond choking to 0.6 at equal pressures")
    ] = 0.0


@law.for_type(DischargeCoefficientSlope)
@kernel
def discharge_coefficient_slope(effect: DischargeCoefficientSlope, state: ValveState, balance: np.ndarray) -> None:
    """Make each flow through the solenoids smaller with the pressure ratio, ``S(r) = S (1 - fall r)``.

    r is the lower over the higher pressure. Jobson [1]_ shows that a jet contracts less at a higher pressure
    difference; the line over the ratio is chosen.

    Parameters
    ----------
    effect : DischargeCoefficientSlope
        Parameters of the effect.
    state : apesim.valve.terms.ValveState
        State of the valve.
    balance : (TERMS,) float array
        Balance of the valve that is added to, see `apesim.valve.terms`.

    References
    ----------
    .. [1] D. A. Jobson, "On the flow of a compressible fluid through orifices", Proc. IMechE 169, 1955, pp. 767-776,
       doi 10.1243/PIME_PROC_1955_169_077_02.

    Examples
    --------
    Supply and chamber A are at one pressure, so that the flow between them loses the whole share:

    >>> import apesim
    >>> from apesim.air import GasState
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.supply import ValveSupply
    >>> from apesim.valve.terms import TERMS
    >>> actuator, _ = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> state = state_of(actuator, closed_at_rest(actuator, supply.control), supply)
    >>> balance = np.zeros(TERMS)
    >>> discharge_coefficient_slope(DischargeCoefficientSlope(fall=0.2), state, balance)
    >>> round(float(balance[FLOW_SHARE + SUPPLY_A]), 6), round(float(balance[FLOW_SHARE + SUPPLY_B]), 6)
    (-0.2, -0.020265)
    """
    supply, vent = state.supply.control.pressure, state.vent_pressure
    a, b = state.chamber_a.pressure, state.chamber_b.pressure
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
