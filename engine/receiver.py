"""Receiver: the vessel between regulator and groove."""

from collections.abc import Iterator
from math import inf
from typing import Annotated, NamedTuple

from apesim.quantities import Choice, Quantity

NO = 0
"""No check valve in the feed."""
MAX_VOLUME = 1.0
"""Largest finite volume of the receiver [m3]; measured: up to here a periodic state is found within 2e-6."""


class Receiver(NamedTuple):
    """Receiver: the vessel between regulator and groove, from which the engine breathes."""

    volume: Annotated[
        float, Quantity("L", 0.01, inf, 'chosen; "inf": intake pressure is constant, there is no receiver')
    ] = 1.0e-3
    feed_area: Annotated[float, Quantity("mm^2", 0.1, 10000, "chosen; from the regulator, effective")] = 200.0e-6
    check_valve: Annotated[int, Choice(("no", "yes"), "chosen; yes: no air flows back to the regulator")] = NO

    def faults(self) -> Iterator[tuple[str, str, str]]:
        """Find what is wrong with the receiver, beyond the ranges of its single keys: key, wrong, right."""
        if MAX_VOLUME < self.volume < inf:
            wrong = "is so large that its pressure takes millions of cycles to settle"
            yield "volume", wrong, f'at most {MAX_VOLUME * 1e3:g} L, or "inf"'
