"""Command: the crank angles at which the valve is switched, and those that are intended."""

from collections.abc import Iterator
from math import pi
from typing import Annotated, NamedTuple

from apesim.engine.angles import DEGREE
from apesim.quantities import Quantity


def window_fault(early: str, late: str, angles: tuple[float, float]) -> tuple[str, str] | None:
    """Find what is wrong with a window of the crank: wrong, right; None where nothing is.

    `early` and `late` name its ends, `angles` are their crank angles [rad].

    >>> window_fault("energise", "release", (0.0, 1.0)) is None
    True
    >>> wrong, right = window_fault("energise", "release", (1.0, 1.0))
    >>> right
    'give more than 0 and less than 360 deg after it'
    """
    duration = angles[1] - angles[0]
    if 0.0 < duration < 2.0 * pi:
        return None
    first, last = (f"{angle / DEGREE:g} deg" for angle in angles)
    side = f"{abs(duration) / DEGREE:g} deg {'after' if duration > 0.0 else 'before'}" if duration else "no later than"
    return f"{late} at {last} is {side} {early} at {first}", "give more than 0 and less than 360 deg after it"


class Command(NamedTuple):
    """Command: crank angles at which the solenoids are switched, and the opening and closing intended by it."""

    energise: Annotated[float, Quantity("deg", -360, 360, "chosen: 5 deg before TDC")] = -5.0 * DEGREE
    release: Annotated[float, Quantity("deg", -360, 720, "chosen")] = 70.0 * DEGREE
    open_target: Annotated[float, Quantity("deg", -360, 360, "chosen: the intended opening")] = -5.0 * DEGREE
    close_target: Annotated[float, Quantity("deg", -360, 720, "chosen: the intended closing")] = 70.0 * DEGREE

    def faults(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with the command, beyond the ranges of its single keys: key, wrong, right."""
        for early, late in (("energise", "release"), ("open_target", "close_target")):
            if fault := window_fault(early, late, (getattr(self, early), getattr(self, late))):
                yield late, *fault
