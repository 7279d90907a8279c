"""Blow-by: leakage past the engine's piston rings."""

from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, law
from apesim.engine.cylinder import BRANCH, ENERGY, MASS, CylinderState
from apesim.kernel import kernel
from apesim.leak import leak
from apesim.quantities import Quantity
from apesim.restriction import Sides


class BlowBy(NamedTuple):
    """Orifice between cylinder and ambient."""

    area: Annotated[float, Quantity("mm^2", 0, 1, "a ring gap of some tenths of a millimetre")] = 0.0


@law.for_type(BlowBy)
@kernel
def blow_by(effect: BlowBy, state: CylinderState, balance: np.ndarray) -> None:
    """Add the flow from the cylinder to ambient through an effective area.

    ``mdot = S psi(r) p/sqrt(R T)`` (Eq. 7 of the EPV paper [1]_), with the effective area S, the flow function psi of
    the pressure ratio r, and pressure p and temperature T upstream. The ring gap as an orifice is chosen.

    Parameters
    ----------
    effect : BlowBy
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
    >>> state, balance = state._replace(air=GasState(2.5e5, 300.0)), np.zeros(TERMS)

    A choked flow, 1 mm2 * 0.6847 * 0.25 MPa/sqrt(287.05 J/(kg K) * 300 K) = 0.583 g/s, leaves the cylinder:

    >>> blow_by(BlowBy(area=1e-6), state, balance)
    >>> print(round(balance[MASS] * 1e3, 3))
    -0.583
    """
    out = leak(state.gas, effect.area, Sides(state.air, state.ambient), balance, BRANCH)
    balance[MASS] -= out.mass
    balance[ENERGY] -= out.enthalpy


EFFECT = Effect(
    "blow_by",
    BlowBy,
    equation="mdot = S psi(r) p / sqrt(R T), from cylinder to ambient",
    source="EPV paper (doi 10.1631/jzus.A0820373), Eqs. 7-8, for a ring gap",
    seen_in="decay of the cylinder pressure, air balance; confused with a leak past the groove",
    isolated_by="a pressurised cylinder at rest with both valves closed",
)
