"""A case of the second benchmark: the first setting that its seed draws is taken, whatever hides in it then shows.

Nothing is drawn anew: pairs that are hardly distinguishable and physics that an effect of the library imitates stay in,
and the answer says so. The deviations of what is hidden count all that is uncertain, as wide as it is drawn, and the
scatter of each run.
"""

import numpy as np

from .cases import Case, described, nominal_rig, suites_for
from .faults import NAMED_FAULTS, draw_fault
from .files import file_of
from .hiding import LARGEST, LIMIT, SMALLEST, drawn_size, hidden_clutter, hidden_effect, hidden_foreign
from .laboratories import GEOMETRY, SCATTER, assumed, draw_heavy, key_of, rig_nuisances, run_scatter, stated_lines
from .library import CALIBRATED, ENGINE, LIBRARY
from .look_alikes import change_of, class_of, look_alikes
from .observation import Laboratory
from .phases import gap_shares
from .schedule import DOUBLE, FOREIGNER, REMOVED, SINGLE
from .second_schedule import FAULTY, TRIPLE, second_plan
from .setting import draw_setting

ALIKE = 0.9
"""Cosine above which a pair is confusable."""
SMALL = 0.05
"""Share of an effect's range at which it is compared with others; what is hidden is rarely much larger."""
MIN_SIZES = {SINGLE: SMALLEST, FAULTY: 1.0, DOUBLE: 1.0, TRIPLE: 2.0, REMOVED: 1.0}
"""Smallest sizes that are asked for [limits]; a range may end before."""
MIN_FILES = 3
"""Files to fit where one of them is faulty: of two that differ, none is the odd one."""
BREAKAWAY = 1.0, 2.0
"""Breakaway over the dry friction under way."""
TAPER = -0.2, 0.2
"""Taper of a groove whose area is another one."""


def draw_second(seed, bank=None):
    """Draw what a case's data are made of.

    Parameters
    ----------
    seed : int
    bank : truth.sealed.bank.Bank, optional
        Keeps what the default engine does at operating points, for other cases.

    Returns
    -------
    truth.sealed.cases.Case
    """
    rng, plan = np.random.default_rng(seed), second_plan(seed)
    nominal, setting = nominal_rig(rng, plan.bench), second_setting(rng, plan)
    nuisances = rig_nuisances(plan.bench, setting.channels, plan.stated)
    scatter = run_scatter() if plan.scatter else ()
    lab = Laboratory(setting, bank if plan.bench == ENGINE else None, nuisances, scatter)
    points = [point for point in setting.points if point.role == "fit"]
    hidden = what_hides(rng, plan, lab, nominal, points)
    clutter = [hidden_clutter(rng, lab, nominal, points, plan.clutter, straight=True)] if plan.clutter else []
    fault, at, told = what_is_wrong(rng, plan, lab, nominal, points)
    values = {one.name: draw_heavy(rng, one) for one in nuisances}
    known = assumed(nuisances, plan.stated)
    answer = {
        "seed": seed,
        "kind": plan.kind,
        "bench": plan.bench,
        "hidden": [one.told for one in hidden],
        "clutter": clutter[0].told if clutter else None,
        "fault": told,
        **second_facts(plan, lab, nominal, points, hidden),
        "scatter": SCATTER if plan.scatter else None,
        "stated": plan.stated,
        "nuisances": values,
        "pulls": {key_of(name): value / known[key_of(name)] for name, value in values.items() if known[key_of(name)]},
        "geometry": geometry(lab, nominal, points, {} if plan.stated else values),
        "setting": described(setting),
    }
    lines = tuple(stated_lines(nuisances)) if plan.stated else ()
    return Case(answer, tuple(one.add for one in (*hidden, *clutter)), lab, rng, plan.scatter, fault, at, lines)


def second_setting(rng, plan):
    """A setting; a scatter of runs shows in repeats, and where one file is faulty there are `MIN_FILES` at least."""
    suites = suites_for(plan, LIBRARY)
    if plan.fault == "swap":
        suites = [name for name in suites if name in ("chambers", "all")]
    setting = draw_setting(rng, plan.bench, suites, min_fits=MIN_FILES if plan.fault else 2)
    if not plan.scatter:
        return setting
    repeats = 2 if plan.bench == ENGINE else int(rng.integers(2, 4))
    points = (point._replace(repeats=repeats if point.role == "fit" else 1) for point in setting.points)
    return setting._replace(points=tuple(points))


def what_hides(rng, plan, lab, nominal, points):
    """What a case hides, each of a size of its own."""
    if plan.kind == FOREIGNER:
        return [hidden_foreign(rng, lab, nominal, points, name, straight=True) for name in plan.effects]

    def hide(name):
        least = MIN_SIZES[plan.kind]
        return hidden_effect(rng, lab, nominal, points, name, least, straight=True, with_shape=shape_of)

    names = confusable_pair(rng, lab, nominal, points, plan.effects[0]) if plan.confusable else plan.effects
    return [hide(name) for name in names]


def shape_of(rng, name):
    """What a shape parameter is beside a strength [SI], for effects whose shape the first benchmark did not draw."""
    share = float(rng.uniform())

    def between(ends):
        return ends[0] + share * (ends[1] - ends[0])

    if name == "coulomb_friction":
        return lambda force: {"breakaway": between(BREAKAWAY) * force}
    if name == "groove_area_error":
        return lambda _: {"taper": between(TAPER)}
    return lambda _: {}


def confusable_pair(rng, lab, nominal, points, wanted):
    """Names of two effects that do nearly the same, as far as the case's sensors and runs can tell.

    One of the pairs whose cosine is above `ALIKE`, with the effect that is wanted where there is one; the pair with the
    largest cosine where no pair is above.
    """
    names = [name for name, entry in LIBRARY.items() if lab.setting.bench in entry.benches and name not in CALIBRATED]
    probes = [lab.left(nominal, change_of(LIBRARY[name], SMALL), points, True, f"{name} {SMALL:g}") for name in names]
    cosines = {(names[i], names[j]): cosine(probes[i], probes[j]) for i in range(len(names)) for j in range(i)}
    alike = [pair for pair, value in cosines.items() if value > ALIKE]
    own = [pair for pair in alike if wanted in pair]
    pairs = own or alike or [max(cosines, key=cosines.get)]
    return pairs[int(rng.integers(len(pairs)))]


def cosine(left, other):
    """How alike what two changes leave is, whatever their signs; 0: one of them leaves nothing."""
    size = float(np.linalg.norm(left) * np.linalg.norm(other))
    return abs(float(left @ other)) / size if size else 0.0


def what_is_wrong(rng, plan, lab, nominal, points):
    """The fault of one record, its number among all runs from 0, and what the answer says of it."""
    if not plan.fault:
        return None, -1, None
    fault, at, deviations = draw_fault(rng, lab, nominal, points, plan.fault, drawn_size(rng, 1.0, LARGEST))
    # Runs to fit come first in a folder, so their numbers are those of all runs.
    told = {
        "kind": fault.kind,
        "name": NAMED_FAULTS.get(fault.kind),
        "file": file_of(at + 1),
        "channel": fault.channel,
        "size": fault.size,
        "deviations": deviations,
    }
    return fault, at, told


def second_facts(plan, lab, nominal, points, hidden):
    """All deviations, where the gap lies, how alike the hidden ones are, and what could stand in for them."""
    facts = {"deviations": 0.0, "rms": 0.0, "gap": [], "without": [], "class": []}
    if not hidden:
        return facts
    left = sum(one.left for one in hidden)
    samples = left[: len(left) - len(lab.nuisances)]
    facts |= {
        "deviations": float(np.linalg.norm(left)),
        "rms": float(np.sqrt(np.mean(samples**2))),
        "gap": gap_shares(lab, nominal, points, left),
    }
    if len(hidden) > 1:
        pairs = [(i, j) for i in range(len(hidden)) for j in range(i)]
        return facts | {"cosine": max(cosine(hidden[i].left, hidden[j].left) for i, j in pairs)}
    alike = look_alikes(lab, nominal, points, hidden, LIBRARY)
    names = [one.told["name"] for one in hidden]
    if plan.kind != FOREIGNER:
        facts["class"] = class_of(names[0], alike)
    facts["without"] = facts["class"] if plan.kind == REMOVED else []
    facts["alike"] = {one.name: one.left for one in alike[:5]}
    away = facts["without"] or names
    facts["distance"] = min((one.left for one in alike if one.name not in away), default=0.0)
    facts["near"] = bool(plan.kind in (REMOVED, FOREIGNER) and facts["distance"] < LIMIT)
    return facts


def geometry(lab, nominal, points, values):
    """Deviations of what is off in the geometry and that nobody states, by the key of the machine file, and of all."""
    columns = lab.sensitivities(nominal, points)
    off = {one.name for one in GEOMETRY}
    free = [i for i, one in enumerate(lab.nuisances) if one.name not in off]
    found, whole = {}, np.zeros(len(columns))
    for i, one in enumerate(lab.nuisances):
        if i in free or not values:
            continue
        change = columns[:, i] * values[one.name] / one.deviation
        found[one.name] = float(np.linalg.norm(taken_up(columns[:, free], change)))
        whole = whole + change
    return {"deviations": float(np.linalg.norm(taken_up(columns[:, free], whole))) if found else 0.0, "by": found}


def taken_up(columns, change):
    """What nuisances of normal priors leave of a change, and what they cost."""
    slopes, target = np.vstack((columns, np.eye(columns.shape[1]))), np.append(change, np.zeros(columns.shape[1]))
    return target - slopes @ np.linalg.lstsq(slopes, target, rcond=None)[0]
