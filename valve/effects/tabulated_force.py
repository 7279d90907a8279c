"""Force over the lift that has no name, as a table."""

import numpy as np

from apesim.cubic_table import interpolate_clamped, table
from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import BREAKAWAY, DRY, FORCE, ValveState

PLACES = range(0, 101, 10)
"""Share of the stroke at the values of the table [%]."""
SIZE = Quantity("N", -40, 40, "some times the springs' preload")
"""Declaration of a value: a force."""

TabulatedForce = table("TabulatedForce", __name__, force=(PLACES, SIZE), friction=(PLACES, SIZE))
TabulatedForce.__doc__ = "Over the lift: a force to closed, and one against the motion, which also holds at rest."


@law.for_type(TabulatedForce)
@kernel
def tabulated_force(effect: tuple[float, ...], state: ValveState, balance: np.ndarray) -> None:
    """Add a force over the lift, to closed, and a friction over the lift, which holds at rest where it is above zero.

    ``F(lift) - R(lift) sign(v)``, both tables; chosen.

    Parameters
    ----------
    effect : TabulatedForce
        Parameters of the effect.
    state : apesim.valve.terms.ValveState
        State of the valve.
    balance : (TERMS,) float array
        Balance of the valve that is added to, see `apesim.valve.terms`.

    Examples
    --------
    At rest, closed, the lift is 0:

    >>> import apesim
    >>> from apesim.air import GasState
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.supply import ValveSupply
    >>> from apesim.valve.terms import TERMS
    >>> actuator, _ = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> state = state_of(actuator, closed_at_rest(actuator, supply.control), supply)
    >>> balance = np.zeros(TERMS)
    >>> tabulated_force(TabulatedForce(force_at_0=3.0, friction_at_0=2.0), state, balance)
    >>> float(balance[FORCE]), float(balance[DRY]), float(balance[BREAKAWAY])
    (3.0, 2.0, 2.0)
    """
    place = 10.0 * (1.0 - state.position / state.valve.stroke)
    balance[FORCE] += interpolate_clamped(effect[:11], place)
    friction = interpolate_clamped(effect[11:], place)
    balance[DRY] += friction
    balance[BREAKAWAY] += max(0.0, friction)


EFFECT = Effect(
    "tabulated_force",
    TabulatedForce,
    equation="M d2L/dt2 = ... + F(lift) - R(lift) sign(dL/dt), cubic between nodes every tenth of the stroke",
    source="no law: what force over the lift would close a gap",
    seen_in="flight",
    isolated_by="force over travel, pushed slowly both ways with both chambers open",
    strengths=TabulatedForce._fields,
    tabulated="force",
)
