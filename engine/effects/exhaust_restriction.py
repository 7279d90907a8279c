"""An exhaust that lets through less than the machine file says."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity


class ExhaustRestriction(NamedTuple):
    """A share by which the exhaust's effective area is smaller."""

    share: Annotated[float, Quantity("", 0, 0.4, "manifold and silencer in series")] = 0.0


def adjust(effect, cycle, tables):
    """Take a share off the exhaust's effective area.

    Parameters
    ----------
    effect : ExhaustRestriction
    cycle : apesim.engine.cycle.state.Cycle
    tables : apesim.engine.cycle.state.CycleTables

    Returns
    -------
    apesim.engine.cycle.state.Cycle, apesim.engine.cycle.state.CycleTables
    """
    engine = cycle.engine
    exhaust = engine.exhaust._replace(effective_area=(1.0 - effect.share) * engine.exhaust.effective_area)
    return cycle._replace(engine=engine._replace(exhaust=exhaust)), tables


EFFECT = Effect(
    "exhaust_restriction",
    ExhaustRestriction,
    equation="S_e = (1 - share) S_e",
    source="ISO 6358-3: restrictions in series",
    seen_in="exhaust pressure; confused with exhaust timing",
    isolated_by="steady flow test of the exhaust, or cylinder pressure in the exhaust stroke at two speeds",
    adjust=adjust,
)
