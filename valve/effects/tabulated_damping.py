"""Friction over the speed that has no name, as a table."""

from math import log2

import numpy as np

from apesim.cubic_table import interpolate_clamped, table
from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import BREAKAWAY, DRY, ValveState

PLACES = 0, 100, 300, 700, 1500, 3100
"""Speed at the values of the table [mm/s]: equally spaced in log2(1 + v/(100 mm/s))."""

TabulatedDamping = table(
    "TabulatedDamping",
    __name__,
    friction=(PLACES, Quantity("N", -40, 40, "as much as the viscous friction at 0.4 m/s")),
    seal=((1000,), Quantity("N", -40, 40, "seals that the air presses to the wall: up to 1e-4 N/Pa, 100 N/MPa")),
)
TabulatedDamping.__doc__ = "Against the motion: a force over the speed, and one for 1000 kPa of both chambers together."


@law.for_type(TabulatedDamping)
@kernel
def tabulated_damping(effect: tuple[float, ...], state: ValveState, balance: np.ndarray) -> None:
    """Add a friction over the speed, and one in proportion to the chambers' pressures.

    ``F_f = R(|v|) + seal (|p_A - p_0| + |p_B - p_0|)/(1 MPa)`` against the motion; R(0) and the seals hold at rest.
    Chosen.

    Parameters
    ----------
    effect : TabulatedDamping
        Parameters of the effect.
    state : apesim.valve.terms.ValveState
        State of the valve.
    balance : (TERMS,) float array
        Balance of the valve that is added to, see `apesim.valve.terms`.

    Examples
    --------
    >>> import apesim
    >>> from apesim.air import GasState
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.supply import ValveSupply
    >>> from apesim.valve.terms import TERMS
    >>> actuator, _ = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> state = state_of(actuator, closed_at_rest(actuator, supply.control), supply)
    >>> balance = np.zeros(TERMS)
    >>> tabulated_damping(TabulatedDamping(friction_at_100=3.0), state._replace(speed=-0.1), balance)
    >>> round(float(balance[DRY]), 6), float(balance[BREAKAWAY])
    (3.0, 0.0)
    """
    ambient = state.ambient.pressure
    seal = effect[6] * 1e-6 * (abs(state.chamber_a.pressure - ambient) + abs(state.chamber_b.pressure - ambient))
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
