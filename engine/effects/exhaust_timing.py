"""Exhaust camshaft that stands later, or earlier, than the machine file says."""

from operator import add
from typing import TYPE_CHECKING, Annotated, NamedTuple

from apesim.effect import Effect, Misstated, Search
from apesim.quantities import Quantity

if TYPE_CHECKING:
    from apesim.engine.cycle.state import Cycle, CycleTables
    from apesim.engine.exhaust import AnyExhaust


class ExhaustTiming(NamedTuple):
    """Angle by which each exhaust valve opens and closes later; negative: earlier."""

    angle: Annotated[float, Quantity("deg", -45, 45, "teeth of a belt; lash; another cam")] = 0.0


def adjust(effect: ExhaustTiming, cycle: "Cycle", tables: "CycleTables") -> tuple["Cycle", "CycleTables"]:
    """Turn the exhaust cams, so that both ends of each valve's window come later by one angle."""

    def turn(valve: "AnyExhaust") -> "AnyExhaust":
        return valve._replace(opens=valve.opens + effect.angle, closes=valve.closes + effect.angle)

    return cycle._replace(engine=cycle.engine.replace_exhausts(turn)), tables


EFFECT = Effect(
    "exhaust_timing",
    ExhaustTiming,
    equation="S_x(phi) = S_x(phi - angle), of each exhaust valve",
    source="Heywood, Internal Combustion Engine Fundamentals",
    seen_in="blow-down and recompression; confused with exhaust restriction",
    isolated_by="a dial gauge on the exhaust valve over crank angle",
    adjust=adjust,
    search=Search(
        misstated=(
            Misstated("engine.exhaust.opens", add),
            Misstated("engine.exhaust.closes", add),
            Misstated("engine.exhaust_2.opens", add),
            Misstated("engine.exhaust_2.closes", add),
        )
    ),
)
