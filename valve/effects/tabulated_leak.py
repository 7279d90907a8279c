"""Leaks that have no name, as tables over the lift."""

import numpy as np

from apesim.cubic_table import interpolate_clamped, table
from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.leak import leak
from apesim.quantities import Quantity
from apesim.restriction import Sides
from apesim.valve.terms import BRANCH, ENERGY_A, ENERGY_B, MASS_A, MASS_B, ValveState

PLACES = 0, 50, 100
"""Share of the stroke at the values of the tables [%]."""
SIZE = Quantity("mm^2", 0, 1, "worn seals")
"""Declaration of a value: an effective area."""

TabulatedLeak = table("TabulatedLeak", __name__, a=(PLACES, SIZE), b=(PLACES, SIZE), between=(PLACES, SIZE))
TabulatedLeak.__doc__ = "Effective areas over the lift, from chamber A and B to ambient and between the two."


@law.for_type(TabulatedLeak)
@kernel
def tabulated_leak(effect: tuple[float, ...], state: ValveState, balance: np.ndarray) -> None:
    """Add flows through effective areas over the lift: from each chamber to ambient, and from A to B.

    ``mdot = S(lift) psi(r) p/sqrt(R T)``: the EPV paper (doi 10.1631/jzus.A0820373), Eq. 7; the tables are chosen.

    Parameters
    ----------
    effect : TabulatedLeak
        Parameters of the effect.
    state : apesim.valve.terms.ValveState
        State of the valve.
    balance : (TERMS,) float array
        Balance of the valve that is added to, see `apesim.valve.terms`.

    Examples
    --------
    0.1 mm2 * 0.6847 * 1 MPa/sqrt(287.05 J/(kg K) * 300 K) = 0.2333 g/s leave chamber A:

    >>> import apesim
    >>> from apesim.air import GasState
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.supply import ValveSupply
    >>> from apesim.valve.terms import TERMS
    >>> actuator, _ = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> state = state_of(actuator, closed_at_rest(actuator, supply.control), supply)
    >>> balance = np.zeros(TERMS)
    >>> tabulated_leak(TabulatedLeak(a_at_0=0.1e-6), state, balance)
    >>> round(float(balance[MASS_A]) * 1e3, 4)
    -0.2333
    """
    place = 2.0 * (1.0 - state.position / state.valve.stroke)
    gas, a, b, ambient = state.gas, state.chamber_a, state.chamber_b, state.ambient
    out_a = leak(gas, interpolate_clamped(effect[:3], place), Sides(a, ambient), balance, BRANCH)
    out_b = leak(gas, interpolate_clamped(effect[3:6], place), Sides(b, ambient), balance, BRANCH)
    between = leak(gas, interpolate_clamped(effect[6:], place), Sides(a, b), balance, BRANCH)
    balance[MASS_A] -= out_a.mass + between.mass
    balance[ENERGY_A] -= out_a.enthalpy + between.enthalpy
    balance[MASS_B] += between.mass - out_b.mass
    balance[ENERGY_B] += between.enthalpy - out_b.enthalpy


EFFECT = Effect(
    "tabulated_leak",
    TabulatedLeak,
    equation="mdot = S(lift) psi(r) p / sqrt(R T), cubic between nodes every half of the stroke",
    source="no law: what leaks would close a gap",
    seen_in="standing pressures of the chambers",
    isolated_by="a charged chamber shut off, piston held at several lifts: pressure over time",
    strengths=TabulatedLeak._fields,
    tabulated="leak",
)
