"""Coulomb friction of the piston rings."""

from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, Search, law
from apesim.kernel import kernel
from apesim.quantities import Quantity
from apesim.valve.terms import BREAKAWAY, DRY, ValveState


class CoulombFriction(NamedTuple):
    """Constant friction against the motion, and what must be overcome from rest."""

    force: Annotated[float, Quantity("N", 0, 12, "paper: below 1.1 N, neglected")] = 0.0
    breakaway: Annotated[float, Quantity("N", 0, 50, "at least the force; smaller values count as the force")] = 0.0


@law.for_type(CoulombFriction)
@kernel
def coulomb_friction(effect: CoulombFriction, state: ValveState, balance: np.ndarray) -> None:
    """Add dry friction: a constant force against the motion, and what holds the piston at rest.

    ``F_f = F_d sign(dL/dt)`` in motion, up to F_s at rest: Eq. 2 of the EPV paper [1]_, which has it from Richer and
    Hurmuzlu [2]_.

    Parameters
    ----------
    effect : CoulombFriction
        Parameters of the effect.
    state : apesim.valve.terms.ValveState
        State of the valve.
    balance : (TERMS,) float array
        Balance of the valve that is added to, see `apesim.valve.terms`.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eq. 2.
    .. [2] E. Richer and Y. Hurmuzlu, "A high performance pneumatic force actuator system: Part I - Nonlinear
       mathematical model", J. Dyn. Syst. Meas. Control 122, 2000, pp. 416-425.

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
    >>> coulomb_friction(CoulombFriction(force=5.0, breakaway=8.0), state, balance)
    >>> float(balance[DRY]), float(balance[BREAKAWAY])
    (5.0, 8.0)
    """
    balance[DRY] += effect.force
    balance[BREAKAWAY] += max(effect.force, effect.breakaway)


EFFECT = Effect(
    "coulomb_friction",
    CoulombFriction,
    equation="F_f = F_d sign(dL/dt) in motion, up to F_s at rest",
    source="EPV paper (doi 10.1631/jzus.A0820373), Eq. 2; "
    "Richer and Hurmuzlu 2000, J. Dyn. Syst. Meas. Control 122, 416",
    seen_in="flight at low pressure; confused with the springs",
    isolated_by="slow strokes at low supply pressure, with both chamber pressures measured",
    strengths=("force", "breakaway"),
    search=Search(
        shapes=("breakaway",),
        unseen_on_rig=("breakaway",),
        strengths=("force",),
        isolated_on_rig="strokes at two pressures, and at two speeds with a factor of five between them",
    ),
)
