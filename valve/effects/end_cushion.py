"""Cushions at both ends of the stroke."""

from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, Search, law, note_branch
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import BRANCH, FORCE, ValveState


class EndCushion(NamedTuple):
    """Damping towards a stop over the last of the travel, rising to the stop; none on the way back."""

    damping: Annotated[float, Quantity("N s/m", 0, 200, "at the stop; air squeezed out of a gap")] = 0.0
    length: Annotated[float, Quantity("mm", 0.2, 2, "of the travel before each stop")] = 0.5e-3


@law.for_type(EndCushion)
@kernel
def end_cushion(effect: EndCushion, state: ValveState, balance: np.ndarray) -> None:
    """Add the damping of a cushion ahead of a stop, ``F = -c (1 - d/length) v`` at a distance d below the length.

    Source: cushions of pneumatic cylinders with check valves; the line over the distance is chosen. On the way back the
    cushion does nothing.

    Parameters
    ----------
    effect : EndCushion
        Parameters of the effect.
    state : apesim.valve.terms.ValveState
        State of the valve.
    balance : (TERMS,) float array
        Balance of the valve that is added to, see `apesim.valve.terms`.

    Examples
    --------
    Halfway into the cushion of the open stop, half of 100 N s/m against 1 m/s:

    >>> import apesim
    >>> from apesim.air import GasState
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.supply import ValveSupply
    >>> from apesim.valve.terms import TERMS
    >>> actuator, _ = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> state = state_of(actuator, closed_at_rest(actuator, supply.control), supply)
    >>> balance = np.zeros(TERMS)
    >>> state = state._replace(position=0.25e-3, speed=-1.0)
    >>> end_cushion(EndCushion(damping=100.0, length=0.5e-3), state, balance)
    >>> float(balance[FORCE])
    50.0
    """
    ahead = state.position if state.speed < 0.0 else state.valve.stroke - state.position
    if effect.damping > 0.0:
        cushioned = ahead < effect.length and state.speed != 0.0
        note_branch(balance, BRANCH, 1 if cushioned else 0)
        if cushioned:
            balance[FORCE] -= effect.damping * (1.0 - ahead / effect.length) * state.speed


EFFECT = Effect(
    "end_cushion",
    EndCushion,
    equation="F = -c (1 - d/length) v",
    source="cushions of pneumatic cylinders, with check valves; squeezed films",
    seen_in="last millimetre before a stop; confused with bounce",
    isolated_by="lift sampled at 20 kHz or more around the contact",
    search=Search(shapes=("length",)),
)
