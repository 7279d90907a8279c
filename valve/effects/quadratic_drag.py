"""Drag that grows with the square of the speed."""

from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, Search, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import FORCE, ValveState


class QuadraticDrag(NamedTuple):
    """Drag of air and oil that the piston displaces."""

    coefficient: Annotated[
        float, Quantity("N s^2/m^2", 0, 40, "flow through the rings' gap and the groove at some m/s")
    ] = 0.0


@law.for_type(QuadraticDrag)
@kernel
def quadratic_drag(effect: QuadraticDrag, state: ValveState, balance: np.ndarray) -> None:
    """Add a drag that grows with the square of the speed, ``F = -c v |v|``.

    It is the law of turbulent resistance [1]_, with the speed v and a coefficient c that is chosen.

    Parameters
    ----------
    effect : QuadraticDrag
        Parameters of the effect.
    state : apesim.valve.terms.ValveState
        State of the valve.
    balance : (TERMS,) float array
        Balance of the valve that is added to, see `apesim.valve.terms`.

    References
    ----------
    .. [1] I. E. Idelchik, "Handbook of Hydraulic Resistance".

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
    >>> quadratic_drag(QuadraticDrag(coefficient=10.0), state._replace(speed=-2.0), balance)
    >>> float(balance[FORCE])
    40.0
    """
    balance[FORCE] -= effect.coefficient * state.speed * abs(state.speed)


EFFECT = Effect(
    "quadratic_drag",
    QuadraticDrag,
    equation="F = -c v |v|",
    source="turbulent drag; Idelchik, Handbook of Hydraulic Resistance",
    seen_in="fast flight; confused with viscous friction",
    isolated_by="strokes at high supply pressure, speed over position with both chamber pressures",
    search=Search(isolated_on_rig="strokes at one pressure, as fast as the drive can"),
)
