"""A leak of an effect's own: a restriction between two volumes whose regime is noted for the march."""

from apesim.effect import note_branch
from apesim.kernel import kernel
from apesim.restriction import NEAR, flow_in, regime_between


@kernel
def leak(gas, area, sides, balance, branch):
    """Flow of an effect's own between two volumes (Eq. 7), its regime noted.

    Parameters
    ----------
    gas : Gas
    area : float
        Effective area [m2].
    sides : tuple of float
        See `apesim.restriction.regime_between`.
    balance : (n,) float array
        What the effect adds to.
    branch : int
        See `apesim.effect.note_branch`.

    Returns
    -------
    mass_flow, enthalpy_flow : float
        See `apesim.restriction.flow_between`.
    """
    if area <= 0.0:
        return 0.0, 0.0
    regime = regime_between(gas, sides)
    note_branch(balance, branch, NEAR if abs(regime) == NEAR else regime)
    return flow_in(gas, regime, area, sides)
