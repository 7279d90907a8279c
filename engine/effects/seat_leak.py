"""Leakage past the closed groove."""

from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, law
from apesim.engine.cylinder import BRANCH, GROOVE_ENERGY, GROOVE_MASS, CylinderState
from apesim.kernel import kernel
from apesim.leak import leak
from apesim.quantities import Quantity
from apesim.restriction import Sides


class SeatLeak(NamedTuple):
    """Orifice beside the groove, open at every lift."""

    area: Annotated[float, Quantity("mm^2", 0, 1, "a gap of some hundredths of a millimetre round the piston")] = 0.0


@law.for_type(SeatLeak)
@kernel
def seat_leak(effect: SeatLeak, state: CylinderState, balance: np.ndarray) -> None:
    """Add the flow from before the groove into the cylinder through an effective area.

    ``mdot = S psi(r) p/sqrt(R T)`` (Eq. 7 of the EPV paper [1]_), with the effective area S, the flow function psi of
    the pressure ratio r, and pressure p and temperature T upstream. The gap as an orifice is chosen.

    Parameters
    ----------
    effect : SeatLeak
        Parameters of the effect.
    state : apesim.engine.cylinder.CylinderState
        State of the cylinder.
    balance : (TERMS,) float array
        Balance of the cylinder that is added to, see `apesim.engine.cylinder`.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eqs. 7 and 8.

    Examples
    --------
    >>> from apesim.air import GasState
    >>> from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
    >>> from apesim.engine.cycle.state import cylinder_state, instant_at
    >>> from apesim.engine.cylinder import TERMS
    >>> from apesim.engine.machine import Machine
    >>> cycle, _, _ = cycle_of(Machine(), speed=100.0)
    >>> y, _ = charged_at_rest(cycle)
    >>> state, _ = cylinder_state(cycle, instant_at(cycle, 0.0, y), y)
    >>> state = state._replace(intake=GasState(1e6, 300.0), air=GasState(1e5, 300.0))
    >>> balance = np.zeros(TERMS)

    A choked flow, 1 mm2 * 0.6847 * 1 MPa/sqrt(287.05 J/(kg K) * 300 K) = 2.333 g/s, enters the cylinder:

    >>> seat_leak(SeatLeak(area=1e-6), state, balance)
    >>> print(round(balance[GROOVE_MASS] * 1e3, 3))
    2.333
    """
    past = leak(state.gas, effect.area, Sides(state.intake, state.air), balance, BRANCH)
    balance[GROOVE_MASS] += past.mass
    balance[GROOVE_ENERGY] += past.enthalpy


EFFECT = Effect(
    "seat_leak",
    SeatLeak,
    equation="mdot = S psi(r) p / sqrt(R T), from before the groove into the cylinder",
    source="EPV paper (doi 10.1631/jzus.A0820373), Eqs. 7-8, for the gap between groove and ports",
    seen_in="cylinder pressure before opening, air; confused with blow-by",
    isolated_by="a cylinder at rest with the groove closed and intake pressure on: rise of its pressure",
)
