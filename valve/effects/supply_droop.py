"""A supply line whose pressure falls while the solenoids draw from it."""

from typing import Annotated, NamedTuple

from apesim.effect import Effect
from apesim.quantities import Quantity

MIN_AREA = 2e-6
"""Smallest feed that is one [m2]."""


class SupplyDroop(NamedTuple):
    """A volume before both solenoids, fed from the control air through an area; the larger, the less it droops."""

    feed_area: Annotated[float, Quantity("mm^2", 0, 50, "effective; from 2 mm2 on: a regulator; 0: no line")] = 0.0
    volume: Annotated[float, Quantity("L", 0.02, 1, "a metre of hose of 6 mm: 0.03 L")] = 0.1e-3

    def faults(self):
        """Faults that the range does not show."""
        if 0.0 < self.feed_area < MIN_AREA:
            yield "feed_area", "starves the solenoids", "2 to 50 mm^2, or 0 for no line"


def volume(effect):
    """Volume of the line [m3] and effective area of its feed [m2]."""
    return effect.volume, effect.feed_area


EFFECT = Effect(
    "supply_droop",
    SupplyDroop,
    equation="dm/dt = S psi(r) p_c / sqrt(R T_c) - mdot to the solenoids; S = feed_area",
    source="paper, Eqs. 3-8, for a volume of its own",
    seen_in="rise of the filling chamber; confused with the solenoids' effective area",
    isolated_by="pressure right before the solenoids over a stroke",
    volume=volume,
)
