"""Leaks that have no name, as tables over the lift."""

import numpy as np

from apesim.cubic_table import interpolate_clamped, table
from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.leak import leak
from apesim.quantities import Quantity
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
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.terms import TERMS
    >>> actuator, _ = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> state = state_of(actuator, closed_at_rest(actuator, (1e6, 300.0)), (1e6, 300.0, 1e5))
    >>> balance = np.zeros(TERMS)
    >>> tabulated_leak(TabulatedLeak(a_at_0=0.1e-6), state, balance)
    >>> round(float(balance[MASS_A]) * 1e3, 4)
    -0.2333
    """
    place = 2.0 * (1.0 - state.position / state.valve.stroke)
    a, b = (state.pressure_a, state.temperature_a), (state.pressure_b, state.temperature_b)
    ambient = state.ambient.pressure, state.ambient.temperature
    mass_a, energy_a = leak(state.gas, interpolate_clamped(effect[:3], place), (*a, *ambient), balance, BRANCH)
    mass_b, energy_b = leak(state.gas, interpolate_clamped(effect[3:6], place), (*b, *ambient), balance, BRANCH)
    mass, energy = leak(state.gas, interpolate_clamped(effect[6:], place), (*a, *b), balance, BRANCH)
    balance[MASS_A] -= mass_a + mass
    balance[ENERGY_A] -= energy_a + energy
    balance[MASS_B] += mass - mass_b
    balance[ENERGY_B] += energy - energy_b


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
