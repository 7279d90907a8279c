"""Second stage: a low-pressure cylinder behind the first one, and the inter-receiver between them."""

from collections.abc import Iterator
from math import isnan, nan
from typing import Annotated, NamedTuple

from apesim.engine.angles import DEGREE
from apesim.engine.cam import Cam
from apesim.engine.command import Command
from apesim.engine.cylinder import crank_faults
from apesim.engine.exhaust import Exhaust
from apesim.quantities import Quantity
from apesim.valve.groove import Groove

MIN_BORE = 5.0e-3
"""Smallest bore of a cylinder [m], that of the first stage."""


class SecondStage(NamedTuple):
    """Second stage: a cylinder on the same shaft that expands the exhaust of the first; off where its bore is 0.

    Its valve is as the first one's, its groove, exhaust, cam and timing are its own.
    """

    phase: Annotated[float, Quantity("deg", -360, 360, "chosen; the shaft's angle at angle 0 of this cylinder")] = (
        180.0 * DEGREE
    )
    bore: Annotated[float, Quantity("mm", 0, 1000, "chosen; 0: there is none")] = 0.0
    stroke: Annotated[float, Quantity("mm", 5, 2000, "chosen: as the first stage of the default machine")] = 88.0e-3
    rod_length: Annotated[float, Quantity("mm", 5, 5000, "chosen")] = 150.0e-3
    pin_offset: Annotated[float, Quantity("mm", -100, 100, "chosen; sign as in engine.pin_offset")] = 0.0
    compression_ratio: Annotated[float, Quantity("", 1.5, 100, "chosen; (swept + clearance)/clearance")] = 18.0
    groove: Groove = Groove()
    exhaust: Exhaust = Exhaust()
    cam: Cam = Cam()
    command: Command = Command()

    @property
    def is_on(self) -> bool:
        """Whether the engine has this stage."""
        return self.bore > 0.0

    def faults(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with the stage's dimensions, beyond the ranges of single keys: key, wrong, right."""
        if 0.0 < self.bore < MIN_BORE:
            right = f"at least {MIN_BORE * 1e3:g} mm, or 0 mm: there is none"
            yield "bore", f"{self.bore * 1e3:g} mm is no cylinder", right
        yield from crank_faults(self)

    def overruled(self) -> Iterator[tuple[str, str]]:
        """Find the keys that are not used because there is no second stage, and why.

        >>> [key for key, reason in SecondStage().overruled()][:3]
        ['phase', 'stroke', 'rod_length']
        """
        if not self.is_on:
            yield from ((key, ".bore is 0") for key in self._fields if key != "bore")


class InterReceiver(NamedTuple):
    """Inter-receiver: the vessel between the two stages, with a heat exchanger before it."""

    volume: Annotated[float, Quantity("L", 0.01, 1000, "chosen: four swept volumes of the default")] = 2.0e-3
    effectiveness: Annotated[
        float, Quantity("", 0, 1, "chosen: no exchanger; share of the way to its temperature, of what flows forward")
    ] = 0.0
    temperature: Annotated[
        float, Quantity("K", 150, 1200, "of exchanger and wall", text="the ambient's", optional=True)
    ] = nan
    wall_conductance: Annotated[float, Quantity("W/K", 0, 10000, "chosen: none; of the wall to its air")] = 0.0

    def resolve_temperature(self, ambient: float) -> float:
        """Return the temperature [K] of exchanger and wall: its own, or else that of the ambient [K]."""
        return ambient if isnan(self.temperature) else self.temperature
