"""Intake pipe between receiver and groove, which throttles the engine air."""

from collections.abc import Iterator
from typing import Annotated, NamedTuple

from apesim.effect import Effect, FedVolume, Search
from apesim.quantities import Quantity

MIN_AREA = 30e-6
"""Smallest area of a pipe [m2]."""


class IntakePipeLoss(NamedTuple):
    """Pipe with a gas volume, fed from the receiver through an area; the larger the area, the less it loses."""

    area: Annotated[float, Quantity("mm^2", 0, 500, "effective, from 30 mm2 on: bends and fittings; 0: no pipe")] = 0.0
    volume: Annotated[float, Quantity("L", 0.05, 2, "half a metre of 16 mm")] = 0.1e-3

    def faults(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with the pipe, beyond the ranges of its single keys: key, wrong, right."""
        if 0.0 < self.area < MIN_AREA:
            yield "area", "starves the engine", "30 to 500 mm^2, or 0 for no pipe"


def volume(effect: IntakePipeLoss) -> FedVolume:
    """Get the gas volume of the pipe and the effective area of its feed.

    The pipe is a volume with the balances of a chamber, Eqs. 3 to 8 of the EPV paper (doi 10.1631/jzus.A0820373).

    Parameters
    ----------
    effect : IntakePipeLoss
        Parameters of the effect.

    Returns
    -------
    apesim.effect.FedVolume
        Volume of the pipe, and effective area of its feed from the receiver.

    Examples
    --------
    >>> volume(IntakePipeLoss(area=100e-6, volume=0.2e-3))
    FedVolume(volume=0.0002, feed_area=0.0001)
    """
    return FedVolume(effect.volume, effect.area)


EFFECT = Effect(
    "intake_pipe_loss",
    IntakePipeLoss,
    equation="dm/dt = S psi(r) p_r / sqrt(R T_r) - mdot through the groove; S = area",
    source="EPV paper (doi 10.1631/jzus.A0820373), Eqs. 3-8, for a gas volume of its own",
    seen_in="receiver pressure over the crank angle; cylinder pressure in admission",
    isolated_by="pressure right before the groove against that in the receiver",
    volume=volume,
    search=Search(min_area=MIN_AREA),
)
