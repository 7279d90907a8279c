"""The second benchmark's mixture: what each seed from `SECOND` on makes; any stretch of seeds is a fair sample."""

from itertools import product
from typing import NamedTuple

import numpy as np

from .foreign import CLUTTER, FOREIGN
from .library import CALIBRATED, ENGINE, LIBRARY, VALVE
from .schedule import DOUBLE, FOREIGNER, NONE, REMOVED, SINGLE

SECOND = 100000
"""First seed of the second benchmark; smaller seeds make the cases of the first one, which have been published."""
TRIPLE, FAULTY = "triple", "faulty"
KINDS = NONE, SINGLE, DOUBLE, TRIPLE, FAULTY, REMOVED, FOREIGNER
NONES = {VALVE: 132, ENGINE: 68}
SINGLES = 175
ON_ENGINE = 3
"""One in so many singles of an effect that acts on both benches is on the engine."""
DOUBLES = {VALVE: 26, ENGINE: 14}
CONFUSABLE = {VALVE: 40, ENGINE: 20}
"""Doubles that do nearly the same to the data of their case, where any two do."""
TRIPLES = {VALVE: 26, ENGINE: 14}
FAULTS = {VALVE: 97, ENGINE: 48}
"""A fifth of all cases."""
WITH_EFFECT = 5, 9
"""So many of so many faulty cases hide an effect, too."""
REMOVALS = 40
FOREIGNERS = {VALVE: 16, ENGINE: 9}
FAULT_KINDS = {
    VALVE: ("offset", "gain", "clock", "time_zero", "supply", "temperature", "swap", "spikes", "drift", "stuck"),
    ENGINE: ("offset", "gain", "angle", "supply", "temperature", "swap", "spikes", "drift", "stuck"),
}
"""Faults of measurement, see `truth.sealed.faults`."""


class Plan(NamedTuple):
    """What a seed's case is to be."""

    kind: str
    bench: str
    effects: tuple = ()
    """Names of what is hidden; of a confusable pair one, which gives way where no other effect is like it."""
    confusable: bool = False
    """Two effects are hidden that do nearly the same."""
    fault: str = ""
    """Kind of the fault of one file."""
    clutter: str = ""
    scatter: bool = False
    """Runs differ from their record and from one another."""
    stated: bool = False
    """The folder states how far the numbers of the rig are known."""


def second_schedule():
    """The block, every stratum spread evenly over it.

    Returns
    -------
    list of Plan
    """
    rng = np.random.default_rng(21)
    spread = []
    for plans in strata(rng):
        plans = [plans[i] for i in rng.permutation(len(plans))]
        flags = [*product((False, True), repeat=3)]
        clutter = [*CLUTTER]
        for i, plan in enumerate(plans):
            if i % len(flags) == 0:
                flags = [flags[j] for j in rng.permutation(len(flags))]
            cluttered, scatter, stated = flags[i % len(flags)]
            name = clutter[int(rng.integers(len(clutter)))] if cluttered else ""
            plan = plan._replace(clutter=name, scatter=scatter, stated=stated)
            spread.append(((i + rng.uniform()) / len(plans), plan))
    return [plan for _, plan in sorted(spread, key=lambda one: one[0])]


def strata(rng):
    """Plans by kind and bench, without what differs in every stratum."""
    physics = [name for name in LIBRARY if name not in CALIBRATED]
    on = {bench: [name for name in physics if bench in LIBRARY[name].benches] for bench in (VALVE, ENGINE)}
    own = {bench: [name for name in physics if LIBRARY[name].benches[0] == bench] for bench in (VALVE, ENGINE)}

    def some(bench, number):
        """Different effects, the first of them of the bench alone, where it has some."""
        first = str(rng.choice(own[bench]))
        others = [name for name in on[bench] if name != first]
        return first, *map(str, rng.choice(others, number - 1, replace=False))

    yield from ([Plan(NONE, bench)] * number for bench, number in NONES.items())
    singles = [single(list(LIBRARY), i) for i in range(SINGLES)]
    yield from ([plan for plan in singles if plan.bench == bench] for bench in (VALVE, ENGINE))
    yield from ([Plan(DOUBLE, bench, some(bench, 2)) for _ in range(number)] for bench, number in DOUBLES.items())
    for bench, number in CONFUSABLE.items():
        yield [Plan(DOUBLE, bench, some(bench, 1), confusable=True) for _ in range(number)]
    yield from ([Plan(TRIPLE, bench, some(bench, 3)) for _ in range(number)] for bench, number in TRIPLES.items())
    some_of, every = WITH_EFFECT
    for bench, number in FAULTS.items():
        kinds = FAULT_KINDS[bench]
        hide = [(some_of * (i + 1)) // every > (some_of * i) // every for i in range(number)]
        yield [
            Plan(FAULTY, bench, some(bench, 1) if with_effect else (), fault=kinds[i % len(kinds)])
            for i, with_effect in enumerate(hide)
        ]
    removals = [single(physics, i)._replace(kind=REMOVED) for i in range(REMOVALS)]
    yield from ([plan for plan in removals if plan.bench == bench] for bench in (VALVE, ENGINE))
    for bench, number in FOREIGNERS.items():
        names = [name for name, foreign in FOREIGN.items() if bench in foreign.benches]
        yield [Plan(FOREIGNER, bench, (names[i % len(names)],)) for i in range(number)]


def single(names, i):
    """The i-th single of a row that goes through all names again and again."""
    name, round_ = names[i % len(names)], i // len(names) + i % len(names)
    benches = LIBRARY[name].benches
    return Plan(SINGLE, benches[-1] if len(benches) > 1 and round_ % ON_ENGINE == 0 else benches[0], (name,))


SECOND_SCHEDULE = second_schedule()


def second_plan(seed):
    """What the case of a seed of the second benchmark is to be."""
    return SECOND_SCHEDULE[(seed - SECOND) % len(SECOND_SCHEDULE)]
