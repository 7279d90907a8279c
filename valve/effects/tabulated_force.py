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
    """Add a force over the lift, to closed, and a friction over it, which holds at rest where it is above zero.

    ``F(lift) - R(lift) sign(v)``, both tables; chosen. Changes the valve's `balance` (TERMS,), see
    `apesim.valve.terms`.
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
