"""Leak of an effect: a restriction between two volumes, the regime of whose flow is noted for the march."""

import numpy as np

from apesim.air import Gas
from apesim.effect import note_branch
from apesim.kernel import kernel
from apesim.restriction import NEAR, NO_FLOW, Flow, Sides, flow_in, regime_between


@kernel
def leak(gas: Gas, area: float, sides: Sides, balance: np.ndarray, branch: int) -> Flow:
    """Return the flow of an effect between two volumes, and note its regime in the balance.

    ``mdot = S psi(r) p_up/sqrt(R T_up)``: the EPV paper (doi 10.1631/jzus.A0820373), Eq. 7.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    area : float
        Effective area S [m2]; 0 or less: nothing flows, nothing is noted.
    sides : apesim.restriction.Sides
        State of the air on both sides.
    balance : (n,) float array
        What the effect adds to; its element `branch` is changed.
    branch : int
        Element of the balance that notes branches, see `apesim.effect.note_branch`.

    Returns
    -------
    apesim.restriction.Flow
        From side 1 to side 2, negative the other way, with the enthalpy of the air upstream.

    Examples
    --------
    >>> from apesim.air import Air, GasState, gas_of
    >>> gas, sides = gas_of(Air()), Sides(GasState(1e6, 300.0), GasState(1e5, 287.0))
    >>> balance = np.zeros(1)
    >>> flow = leak(gas, 1e-6, sides, balance, 0)
    >>> round(flow.mass * 1e3, 3), balance.tolist()
    (2.333, [3.0])
    """
    if area <= 0.0:
        return NO_FLOW
    regime = regime_between(gas, sides)
    note_branch(balance, branch, NEAR if abs(regime) == NEAR else regime)
    return flow_in(gas, regime, area, sides)
