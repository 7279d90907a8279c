"""Which kind of case a seed makes: a block of seeds, whichever it begins with, holds every kind its number of times."""

from typing import NamedTuple

import numpy as np

from .library import ENGINE, LIBRARY, VALVE

KINDS = NONE, SINGLE, DOUBLE, REMOVED, FOREIGN = "none", "single", "double", "removed", "foreign"
EACH = 5
"""Singles of each effect."""


class Plan(NamedTuple):
    """What a seed's case is to be."""

    kind: str
    bench: str
    effects: tuple = ()
    """Names of what is hidden."""
    clutter: str = ""


def schedule():
    """The block, well shuffled."""
    plans = [Plan(NONE, VALVE)] * 75 + [Plan(NONE, ENGINE)] * 30
    for entry in LIBRARY.values():
        plans += [Plan(SINGLE, entry.benches[0], (entry.name,))] * EACH
    order = np.random.default_rng(20).permutation(len(plans))
    return [plans[i] for i in order]


SCHEDULE = schedule()
