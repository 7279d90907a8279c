"""A supply line whose pressure falls while the solenoids draw from it."""

from collections.abc import Iterator
from typing import Annotated, NamedTuple

from apesim.effect import Effect, FedVolume, Search
from apesim.quantities import Quantity

MIN_AREA = 2e-6
"""Smallest feed of a line [m2]; a smaller one starves the solenoids."""


class SupplyDroop(NamedTuple):
    """A volume before both solenoids, fed from the control air through an area; the larger, the less it droops."""

    feed_area: Annotated[float, Quantity("mm^2", 0, 50, "effective; from 2 mm2 on: a regulator; 0: no line")] = 0.0
    volume: Annotated[float, Quantity("L", 0.02, 1, "a metre of hose of 6 mm: 0.03 L")] = 0.1e-3

    def faults(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with the line, beyond the ranges of its single keys: key, wrong, right."""
        if 0.0 < self.feed_area < MIN_AREA:
            yield "feed_area", "starves the solenoids", "2 to 50 mm^2, or 0 for no line"


def volume(effect: SupplyDroop) -> FedVolume:
    """Return the gas volume of the supply line and its feed.

    The line is a volume with the balances of a chamber, Eqs. 3 to 8 of the EPV paper (doi 10.1631/jzus.A0820373).

    Parameters
    ----------
    effect : SupplyDroop
        Parameters of the effect.

    Returns
    -------
    apesim.effect.FedVolume
        Volume of the line, and effective area of its feed.

    Examples
    --------
    >>> volume(SupplyDroop(feed_area=5e-6, volume=0.2e-3))
    FedVolume(volume=0.0002, feed_area=5e-06)
    """
    return FedVolume(effect.volume, effect.feed_area)


EFFECT = Effect(
    "supply_droop",
    SupplyDroop,
    equation="dm/dt = S psi(r) p_c / sqrt(R T_c) - mdot to the solenoids; S = feed_area",
    source="EPV paper (doi 10.1631/jzus.A0820373), Eqs. 3-8, for a volume of its own",
    seen_in="rise of the filling chamber; confused with the solenoids' effective area",
    isolated_by="pressure right before the solenoids over a stroke",
    volume=volume,
    search=Search(shapes=("volume",), min_area=MIN_AREA),
)
