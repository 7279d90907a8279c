"""Which kind of case a seed makes: a block of seeds, whichever it begins with, holds every kind its number of times."""

from typing import NamedTuple

import numpy as np

from .foreign import CLUTTER, FOREIGN
from .library import CALIBRATED, ENGINE, FIRST_WITH_ALL, VALVE, library_at

KINDS = NONE, SINGLE, DOUBLE, REMOVED, FOREIGNER = "none", "single", "double", "removed", "foreign"
EACH = 5
"""Singles of each effect."""
NONES = {VALVE: 75, ENGINE: 30}
DOUBLES = {VALVE: 45, ENGINE: 15}
FOREIGNERS = {VALVE: 24, ENGINE: 8}
REMOVALS = 40
CLUTTERED = 4
"""One in so many cases with nothing hidden is cluttered."""


class Plan(NamedTuple):
    """What a seed's case is to be."""

    kind: str
    bench: str
    effects: tuple = ()
    """Names of what is hidden."""
    clutter: str = ""


def schedule(library):
    """The block of a library, well shuffled."""
    rng = np.random.default_rng(20)
    plans, clutter = [], list(CLUTTER)
    for bench, number in NONES.items():
        for i in range(number):
            plans.append(Plan(NONE, bench, (), "" if i % CLUTTERED else clutter[i // CLUTTERED % len(clutter)]))
    singles = {name: entry.benches[0] for name, entry in library.items()}
    plans += [Plan(SINGLE, bench, (name,)) for name, bench in singles.items()] * EACH
    physics = [name for name in singles if name not in CALIBRATED]
    for bench, number in DOUBLES.items():
        own = [name for name in physics if singles[name] == bench]
        either = [name for name in physics if bench in library[name].benches]
        for _ in range(number):
            first = str(rng.choice(own))
            plans.append(Plan(DOUBLE, bench, (first, str(rng.choice([name for name in either if name != first])))))
    for i in range(REMOVALS):
        name = physics[i % len(physics)]
        plans.append(Plan(REMOVED, singles[name], (name,)))
    for bench, number in FOREIGNERS.items():
        own = [name for name, foreign in FOREIGN.items() if foreign.benches[-1 if bench == ENGINE else 0] == bench]
        plans += [Plan(FOREIGNER, bench, (own[i % len(own)],)) for i in range(number)]
    return [plans[i] for i in rng.permutation(len(plans))]


SCHEDULES = {first: schedule(library_at(first)) for first in (0, FIRST_WITH_ALL)}
"""Blocks by the first seed that they hold for."""


def schedule_at(seed):
    """The block that a seed is one of."""
    return SCHEDULES[max(first for first in SCHEDULES if seed >= first)]


def plan_of(seed):
    """What a seed's case is to be."""
    block = schedule_at(seed)
    return block[seed % len(block)]
