"""Exhaust valves: their keys and their effective area.

Each is a port of the gas exchange, from the cylinder to the pressure behind it, see `apesim.engine.cycle.gas_exchange`.
"""

from collections.abc import Iterator
from typing import Annotated, NamedTuple

from apesim.engine.angles import DEGREE
from apesim.engine.cam import raised_cosine, window_faults
from apesim.kernel import kernel
from apesim.quantities import Quantity

Angle = Annotated[float, Quantity("deg", -360, 720, "chosen")]
Flank = Annotated[float, Quantity("deg", 0.1, 180, "chosen; raised cosine, inside the window")]


class Exhaust(NamedTuple):
    """Exhaust valve, driven by a cam with raised-cosine flanks."""

    effective_area: Annotated[float, Quantity("mm^2", 0.1, 10000, "chosen")] = 500.0e-6
    opens: Angle = 165.0 * DEGREE
    closes: Angle = 340.0 * DEGREE
    flank: Flank = 25.0 * DEGREE

    def faults(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with the exhaust valve's window, see `window_faults`: key, wrong, right."""
        return window_faults(self)


class SecondExhaust(NamedTuple):
    """Second exhaust valve, with a window of its own; off where its effective area is 0."""

    effective_area: Annotated[float, Quantity("mm^2", 0, 10000, "chosen; 0: there is none")] = 0.0
    opens: Angle = 165.0 * DEGREE
    closes: Angle = 340.0 * DEGREE
    flank: Flank = 25.0 * DEGREE

    @property
    def is_on(self) -> bool:
        """Whether the engine has this valve."""
        return self.effective_area > 0.0

    def faults(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with the second exhaust valve's window, see `window_faults`: key, wrong, right."""
        return window_faults(self)


AnyExhaust = Exhaust | SecondExhaust
"""Keys of an exhaust valve, whichever it is."""


@kernel
def exhaust_area(valve: AnyExhaust, angle: float) -> float:
    """Effective area of the exhaust valve at a crank angle.

    ``S(phi) = S_full x(phi)``, with the share x of `raised_cosine`. Chosen.

    Parameters
    ----------
    valve : Exhaust or SecondExhaust
        Keys of the exhaust valve.
    angle : float
        Crank angle phi [rad].

    Returns
    -------
    float
        Effective area [m2].

    Examples
    --------
    >>> print([round(exhaust_area(Exhaust(), angle * DEGREE) * 1e6, 6) for angle in (0.0, 177.5, 250.0)])
    [0.0, 250.0, 500.0]
    """
    return valve.effective_area * raised_cosine(angle, valve.opens, valve.closes, valve.flank)
