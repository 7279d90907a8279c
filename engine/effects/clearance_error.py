"""Clearance volume that differs from the machine file's."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity


class ClearanceError(NamedTuple):
    """An error of the clearance volume."""

    share: Annotated[float, Quantity("", -0.08, 0.08, "gasket and deposits")] = 0.0


def adjust(effect, cycle, tables):
    """Change the clearance volume by a share.

    Parameters
    ----------
    effect : ClearanceError
    cycle : apesim.engine.cycle.state.Cycle
    tables : apesim.engine.cycle.state.CycleTables

    Returns
    -------
    apesim.engine.cycle.state.Cycle, apesim.engine.cycle.state.CycleTables
    """
    clearance = (1.0 + effect.share) * cycle.crank.clearance
    return cycle._replace(crank=cycle.crank._replace(clearance=clearance)), tables


EFFECT = Effect(
    "clearance_error",
    ClearanceError,
    equation="V_c = (1 + share) V_c",
    source="Heywood, Internal Combustion Engine Fundamentals",
    seen_in="compression; confused with the angle of dead centre",
    isolated_by="filling the clearance with oil at dead centre, or motored compression",
    adjust=adjust,
)
