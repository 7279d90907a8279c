"""An exhaust cam that stands later, or earlier, than the machine file says."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity


class ExhaustTiming(NamedTuple):
    """An angle by which the exhaust opens and closes later."""

    angle: Annotated[float, Quantity("deg", -8, 8, "a tooth of a belt; lash")] = 0.0


def adjust(effect, cycle, tables):
    """Turn the exhaust cam.

    Parameters
    ----------
    effect : ExhaustTiming
    cycle : apesim.engine.cycle.state.Cycle
    tables : apesim.engine.cycle.state.CycleTables

    Returns
    -------
    apesim.engine.cycle.state.Cycle, apesim.engine.cycle.state.CycleTables
    """
    engine = cycle.engine
    opens, closes = engine.exhaust.opens + effect.angle, engine.exhaust.closes + effect.angle
    exhaust = engine.exhaust._replace(opens=opens, closes=closes)
    return cycle._replace(engine=engine._replace(exhaust=exhaust)), tables


EFFECT = Effect(
    "exhaust_timing",
    ExhaustTiming,
    equation="A_e(phi) = A_e(phi - angle)",
    source="Heywood, Internal Combustion Engine Fundamentals",
    seen_in="blow-down and recompression; confused with exhaust restriction",
    isolated_by="a dial gauge on the exhaust valve over crank angle",
    adjust=adjust,
)
