"""Friction of the rings that fades with speed."""

from math import exp
from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, Search, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import BREAKAWAY, DRY, ValveState


class StribeckFriction(NamedTuple):
    """What friction at rest and at low speed has above that at high speed."""

    force: Annotated[float, Quantity("N", 0, 6, "as large as the Coulomb friction of a small piston")] = 0.0
    speed: Annotated[float, Quantity("m/s", 0.02, 0.2, "at which it has fallen to 1/e; lubricated elastomers")] = 0.05


@law.for_type(StribeckFriction)
@kernel
def stribeck_friction(effect: StribeckFriction, state: ValveState, balance: np.ndarray) -> None:
    """Add dry friction that fades with the speed, ``F_f = F exp(-(v/v_s)^2)``; all of it holds at rest.

    It is Stribeck's curve in its Gaussian form [1]_, with the speed v and Stribeck's speed v_s.

    Parameters
    ----------
    effect : StribeckFriction
        Parameters of the effect.
    state : apesim.valve.terms.ValveState
        State of the valve.
    balance : (TERMS,) float array
        Balance of the valve that is added to, see `apesim.valve.terms`.

    References
    ----------
    .. [1] B. Armstrong-Helouvry, P. Dupont and C. Canudas de Wit, "A survey of models, analysis tools and compensation
       methods for the control of machines with friction", Automatica 30, 1994, pp. 1083-1138,
       doi 10.1016/0005-1098(94)90209-7.

    Examples
    --------
    At the speed v_s a share 1/e = 0.3679 is left:

    >>> import apesim
    >>> from apesim.air import GasState
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.supply import ValveSupply
    >>> from apesim.valve.terms import TERMS
    >>> actuator, _ = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> state = state_of(actuator, closed_at_rest(actuator, supply.control), supply)
    >>> balance = np.zeros(TERMS)
    >>> stribeck_friction(StribeckFriction(force=2.0, speed=0.05), state._replace(speed=0.05), balance)
    >>> round(float(balance[DRY]), 4), float(balance[BREAKAWAY])
    (0.7358, 2.0)
    """
    if effect.force > 0.0:
        balance[DRY] += effect.force * exp(-((state.speed / effect.speed) ** 2))
        balance[BREAKAWAY] += effect.force


EFFECT = Effect(
    "stribeck_friction",
    StribeckFriction,
    equation="F_f = F exp(-(v/v_s)^2) sign(v)",
    source="Armstrong-Helouvry, Dupont and Canudas de Wit 1994, Automatica 30, 1083",
    seen_in="first 2 ms of flight; confused with a delay",
    isolated_by="slow strokes at low supply pressure, lift sampled at 20 kHz or more",
    search=Search(shapes=("speed",), isolated_on_rig="strokes at one pressure, at speeds from 1 mm/s to some 100 mm/s"),
)
