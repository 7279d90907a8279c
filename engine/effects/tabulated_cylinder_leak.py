"""Leaks of the cylinder as tables over the crank angle, for leaks that no law of the library explains."""

from math import pi

import numpy as np

from apesim.cubic_table import interpolate_periodic, table
from apesim.effect import Effect, law
from apesim.engine.cylinder import BRANCH, ENERGY, GROOVE_ENERGY, GROOVE_MASS, MASS, CylinderState
from apesim.engine.exhaust import exhaust_area
from apesim.kernel import kernel
from apesim.leak import leak
from apesim.quantities import Quantity
from apesim.restriction import Sides

PLACES = range(0, 360, 30)
"""Crank angles of the nodes of the leak to ambient [deg]."""
QUARTERS = range(0, 360, 90)
"""Crank angles of the nodes of the leak past the groove [deg]."""

TabulatedCylinderLeak = table(
    "TabulatedCylinderLeak",
    __name__,
    out=(PLACES, Quantity("mm^2", -20, 20, "a part of an exhaust valve")),
    past_groove=(QUARTERS, Quantity("mm^2", 0, 2, "worn seals")),
)
TabulatedCylinderLeak.__doc__ = (
    "Effective areas over the crank angle: to ambient, or off the exhaust valves, and past the groove."
)


@law.for_type(TabulatedCylinderLeak)
@kernel
def tabulated_cylinder_leak(effect: tuple[float, ...], state: CylinderState, balance: np.ndarray) -> None:
    """Add the flows through tabulated areas: out of the cylinder, and from before the groove into it.

    ``mdot = S(phi) psi(r) p/sqrt(R T)`` (Eq. 7 of the EPV paper, doi 10.1631/jzus.A0820373), with the effective area S
    at the crank angle phi. An area above zero leads to ambient; one below zero is taken off the exhaust valves', of
    which it leaves no less than nothing.

    Parameters
    ----------
    effect : TabulatedCylinderLeak
        Parameters of the effect.
    state : apesim.engine.cylinder.CylinderState
        State of the cylinder.
    balance : (TERMS,) float array
        Balance of the cylinder that is added to, see `apesim.engine.cylinder`.

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
    >>> effect = TabulatedCylinderLeak(*[1e-6] * len(PLACES), *[0.0] * len(QUARTERS))
    >>> state, balance = state._replace(air=GasState(2.5e5, 300.0)), np.zeros(TERMS)

    A choked flow, 1 mm2 * 0.6847 * 0.25 MPa/sqrt(287.05 J/(kg K) * 300 K) = 0.583 g/s, leaves the cylinder:

    >>> tabulated_cylinder_leak(effect, state, balance)
    >>> print(round(balance[MASS] * 1e3, 3))
    -0.583
    """
    turns = 0.5 * state.angle / pi
    out = interpolate_periodic(effect[:12], 12.0 * turns)
    if out < 0.0:
        open_area = exhaust_area(state.engine.exhaust, state.angle) + exhaust_area(state.engine.exhaust_2, state.angle)
        taken = min(-out, open_area)
        held = leak(state.gas, taken, Sides(state.air, state.behind_exhaust), balance, BRANCH)
        balance[MASS] += held.mass
        balance[ENERGY] += held.enthalpy
    else:
        leaving = leak(state.gas, out, Sides(state.air, state.ambient), balance, BRANCH)
        balance[MASS] -= leaving.mass
        balance[ENERGY] -= leaving.enthalpy
    area = interpolate_periodic(effect[12:], 4.0 * turns)
    past = leak(state.gas, area, Sides(state.intake, state.air), balance, BRANCH)
    balance[GROOVE_MASS] += past.mass
    balance[GROOVE_ENERGY] += past.enthalpy


EFFECT = Effect(
    "tabulated_cylinder_leak",
    TabulatedCylinderLeak,
    equation="mdot = S(angle) psi(r) p / sqrt(R T), cubic between nodes every 30 deg, past the groove every 90 deg",
    source="no law: what leaks would close a gap",
    seen_in="cylinder pressure, air",
    isolated_by="a pressurised cylinder at rest, turned to several angles",
    strengths=TabulatedCylinderLeak._fields,
    tabulated="leak",
)
