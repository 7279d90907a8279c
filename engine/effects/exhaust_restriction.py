"""Exhaust that lets through less than the machine file says."""

from typing import TYPE_CHECKING, Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity

if TYPE_CHECKING:
    from apesim.engine.cycle.state import Cycle, CycleTables
    from apesim.engine.exhaust import AnyExhaust


class ExhaustRestriction(NamedTuple):
    """Share by which the effective area of each exhaust valve is smaller."""

    share: Annotated[float, Quantity("", 0, 0.4, "manifold and silencer in series")] = 0.0


def adjust(effect: ExhaustRestriction, cycle: "Cycle", tables: "CycleTables") -> tuple["Cycle", "CycleTables"]:
    """Take a share off the effective area of each exhaust valve, ``S' = (1 - share) S``.

    Restrictions in series are ISO 6358-3 [1]_; a share of the area in place of a second one is chosen.

    Parameters
    ----------
    effect : ExhaustRestriction
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
    .. [1] ISO 6358-3:2014, "Pneumatic fluid power - Determination of flow-rate characteristics of components using
       compressible fluids - Part 3: Method for calculating steady-state flow-rate characteristics of systems".

    Examples
    --------
    >>> from apesim.engine.cycle.operating_point import cycle_of
    >>> from apesim.engine.machine import Machine
    >>> cycle, tables, _ = cycle_of(Machine(), speed=100.0)
    >>> smaller, _ = adjust(ExhaustRestriction(share=0.2), cycle, tables)
    >>> round(smaller.engine.exhaust.effective_area / cycle.engine.exhaust.effective_area, 9)
    0.8
    """

    def narrow(valve: "AnyExhaust") -> "AnyExhaust":
        return valve._replace(effective_area=(1.0 - effect.share) * valve.effective_area)

    return cycle._replace(engine=cycle.engine.replace_exhausts(narrow)), tables


EFFECT = Effect(
    "exhaust_restriction",
    ExhaustRestriction,
    equation="S_x = (1 - share) S_x, of each exhaust valve",
    source="ISO 6358-3: restrictions in series",
    seen_in="exhaust pressure; confused with exhaust timing",
    isolated_by="steady flow test of the exhaust, or cylinder pressure in the exhaust stroke at two speeds",
    adjust=adjust,
)
