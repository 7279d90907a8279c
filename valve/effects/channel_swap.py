"""Pressures of both chambers that are recorded under each other's name."""

from typing import Annotated, NamedTuple

import numpy as np

from apesim.effect import Effect, Search
from apesim.quantities import Quantity
from apesim.reading import Reading

SWAPPED = "pressure_a", "pressure_b"
"""Channels that may stand for each other."""


class ChannelSwap(NamedTuple):
    """A share of the other chamber's pressure that each channel shows: 1 where the names are swapped."""

    share: Annotated[float, Quantity("", 0, 1, "0: right, 1: swapped; between: crosstalk")] = 0.0


def sensor(effect: ChannelSwap, reading: Reading) -> Reading:
    """Mix the pressures of both chambers, ``recorded_a = (1 - share) p_A + share p_B``, and the other way round.

    It is chosen, as the simplest law that has both: names that are right and names that are swapped.

    Parameters
    ----------
    effect : ChannelSwap
        Parameters of the effect.
    reading : apesim.reading.Reading
        What the sensors would record without the effect.

    Returns
    -------
    apesim.reading.Reading
        What they record with it.

    Examples
    --------
    >>> import numpy as np
    >>> reading = Reading(at=lambda times: {"pressure_a": 5e5 + times, "pressure_b": 1e5 + times})
    >>> shown = sensor(ChannelSwap(share=1.0), reading).at(np.zeros(1))
    >>> shown["pressure_a"].tolist(), shown["pressure_b"].tolist()
    ([100000.0], [500000.0])
    """
    first, second = SWAPPED

    def at(times: np.ndarray) -> dict[str, np.ndarray]:
        channels = reading.at(times)
        if first not in channels or second not in channels:
            return channels
        a, b = channels[first], channels[second]
        mixed = {first: a + effect.share * (b - a), second: b + effect.share * (a - b)}
        return channels | mixed

    return reading._replace(at=at)


EFFECT = Effect(
    "channel_swap",
    ChannelSwap,
    equation="recorded_a = (1 - share) p_A + share p_B; recorded_b = (1 - share) p_B + share p_A",
    source="chosen",
    seen_in="both chamber pressures of one file; never physics",
    isolated_by="the control air on one chamber alone",
    sensor=sensor,
    search=Search(is_nuisance=True),
)
