"""Leakage from chamber A."""

from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, law
from apesim.kernel import kernel
from apesim.leak import leak
from apesim.quantities import Quantity
from apesim.restriction import Sides
from apesim.valve.terms import BRANCH, ENERGY_A, MASS_A, ValveState


class LeakageA(NamedTuple):
    """An orifice between chamber A and ambient."""

    area: Annotated[float, Quantity("mm^2", 0, 0.3, "a worn seal")] = 0.0


@law.for_type(LeakageA)
@kernel
def leakage_a(effect: LeakageA, state: ValveState, balance: np.ndarray) -> None:
    """Add the flow from chamber A to ambient through an effective area.

    ``mdot = S psi(r) p/sqrt(R T)``: Eqs. 7 and 8 of the EPV paper, which neglects it.

    S is the effective area, psi the flow function of the pressure ratio r, R the gas constant; p and T are pressure and
    temperature upstream [1]_.

    Parameters
    ----------
    effect : LeakageA
        Parameters of the effect.
    state : apesim.valve.terms.ValveState
        State of the valve.
    balance : (TERMS,) float array
        Balance of the valve that is added to, see `apesim.valve.terms`.

    References
    ----------
    .. [1] "Simulation and experimental study of electro-pneumatic valve used in air-powered engine", J. Zhejiang Univ.
       Sci. A, doi 10.1631/jzus.A0820373, Eqs. 7 and 8.

    Examples
    --------
    0.1 mm2 * 0.6847 * 1 MPa/sqrt(287.05 J/(kg K) * 300 K) = 0.2333 g/s leave the chamber:

    >>> import apesim
    >>> from apesim.air import GasState
    >>> from apesim.valve.actuator import actuator_of, closed_at_rest, state_of
    >>> from apesim.valve.supply import ValveSupply
    >>> from apesim.valve.terms import TERMS
    >>> actuator, _ = actuator_of(apesim.Machine(), edges=[0.0], period=1.0)
    >>> supply = ValveSupply(GasState(1e6, 300.0), intake_pressure=1e5)
    >>> state = state_of(actuator, closed_at_rest(actuator, supply.control), supply)
    >>> balance = np.zeros(TERMS)
    >>> leakage_a(LeakageA(area=0.1e-6), state, balance)
    >>> round(float(balance[MASS_A]) * 1e3, 4)
    -0.2333
    """
    out = leak(state.gas, effect.area, Sides(state.chamber_a, state.ambient), balance, BRANCH)
    balance[MASS_A] -= out.mass
    balance[ENERGY_A] -= out.enthalpy


EFFECT = Effect(
    "leakage_a",
    LeakageA,
    equation="mdot = S psi(r) p / sqrt(R T), from A to ambient",
    source="EPV paper (doi 10.1631/jzus.A0820373), Eqs. 7-8; the paper neglects it",
    seen_in="standing pressure of chamber A; confused with a leak of chamber B on lift alone",
    isolated_by="chamber A charged and shut off, piston on its stop: pressure over time",
)
