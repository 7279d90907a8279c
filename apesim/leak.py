"""Leak of an effect: a restriction between two volumes, the regime of whose flow is noted for the march."""

import numpy as np

from apesim.air import Gas
from apesim.effect import note_branch
from apesim.kernel import kernel
from apesim.restriction import NEAR, flow_in, regime_between


@kernel
def leak(
    gas: Gas, area: float, sides: tuple[float, float, float, float], balance: np.ndarray, branch: int
) -> tuple[float, float]:
    """Return the flow of an effect between two volumes, and note its regime in the balance.

    ``mdot = S psi(r) p_up/sqrt(R T_up)``: the EPV paper (doi 10.1631/jzus.A0820373), Eq. 7.

    Parameters
    ----------
    gas : apesim.air.Gas
        Working gas, as the kernels know it.
    area : float
        Effective area S [m2]; 0 or less: nothing flows, nothing is noted.
    sides : tuple of float
        Pressure and temperature on side 1, then on side 2 [Pa abs, K, Pa abs, K].
    balance : (n,) float array
        What the effect adds to; its element `branch` is changed.
    branch : int
        Element of the balance that notes branches, see `apesim.effect.note_branch`.

    Returns
    -------
    mass_flow : float
        From side 1 to side 2; negative the other way [kg/s].
    enthalpy_flow : float
        Enthalpy carried along, at the upstream temperature [W].

    Examples
    --------
    >>> from apesim.air import Air, gas_of
    >>> gas = gas_of(Air())
    >>> balance = np.zeros(1)
    >>> mass_flow, _ = leak(gas, 1e-6, (1e6, 300.0, 1e5, 287.0), balance, 0)
    >>> round(mass_flow * 1e3, 3), balance.tolist()
    (2.333, [3.0])
    """
    if area <= 0.0:
        return 0.0, 0.0
    regime = regime_between(gas, sides)
    note_branch(balance, branch, NEAR if abs(regime) == NEAR else regime)
    return flow_in(gas, regime, area, sides)
