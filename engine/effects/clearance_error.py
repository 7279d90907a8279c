"""Clearance volume that differs from the machine file's."""

from typing import TYPE_CHECKING, Annotated, NamedTuple

from apesim.effect import Effect, Misstated, Search
from apesim.quantities import Quantity

if TYPE_CHECKING:
    from apesim.engine.cycle.state import Cycle, CycleTables


class ClearanceError(NamedTuple):
    """Error of the clearance volume, as a share of it."""

    share: Annotated[float, Quantity("", -0.5, 0.5, "gasket and deposits; a bowl or a port left out")] = 0.0


def adjust(effect: ClearanceError, cycle: "Cycle", tables: "CycleTables") -> tuple["Cycle", "CycleTables"]:
    """Change the clearance volume by a share, ``V_c' = (1 + share) V_c``.

    V_c is the clearance volume of the compression ratio [1]_.

    Parameters
    ----------
    effect : ClearanceError
        Parameters of the effect.
    cycle : apesim.engine.cycle.state.Cycle
        Machine at a speed, as numbers for the kernels.
    tables : apesim.engine.cycle.state.CycleTables
        Arrays of the machine.

    Returns
    -------
    cycle : apesim.engine.cycle.state.Cycle
        Machine with the effect.
    tables : apesim.engine.cycle.state.CycleTables
        Arrays of the machine with the effect.

    References
    ----------
    .. [1] J. B. Heywood, "Internal Combustion Engine Fundamentals", McGraw-Hill, 1988, Eq. 2.1.

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), speed=100.0)
    >>> larger, _ = adjust(ClearanceError(share=0.05), cycle, tables)
    >>> round(larger.crank.clearance / cycle.crank.clearance, 9)
    1.05
    """
    clearance = (1.0 + effect.share) * cycle.crank.clearance
    return cycle._replace(crank=cycle.crank._replace(clearance=clearance)), tables


def correct_ratio(ratio: float, share: float) -> float:
    """The compression ratio whose clearance volume is larger by a share."""
    return 1.0 + (ratio - 1.0) / (1.0 + share)


EFFECT = Effect(
    "clearance_error",
    ClearanceError,
    equation="V_c = (1 + share) V_c",
    source="Heywood, Internal Combustion Engine Fundamentals",
    seen_in="compression; confused with the angle of dead centre",
    isolated_by="filling the clearance with oil at dead centre, or motored compression",
    adjust=adjust,
    search=Search(misstated=(Misstated("engine.compression_ratio", correct_ratio),)),
)
