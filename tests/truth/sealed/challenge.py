"""Sealed cases: data of a rig with something hidden, the nominal machine file, and the answer, stored apart.

A seed's place in its schedule says what kind of case it is; all else is drawn from the seed.
"""

import json
from functools import partial
from pathlib import Path

import numpy as np

from tests.truth.simulator.effects import EFFECTS

from .cases import Case, described, nominal_rig, setting_of, suites_for, write
from .hiding import LIMIT, SMALLEST, hidden_clutter, hidden_effect, hidden_foreign
from .library import ENGINE, library_at
from .look_alikes import class_of, look_alikes
from .nuisances import drawn, nuisances_for
from .observation import Laboratory
from .phases import gap_shares
from .schedule import DOUBLE, FOREIGNER, NONE, REMOVED, plan_of
from .second_case import draw_second
from .second_schedule import SECOND
from .setting import draw_setting

TRIES = 6
ALIKE = 0.9
"""Cosine above which two effects are too alike to be hidden together."""


def make(seed, folder, bank=None):
    """Make a case.

    Parameters
    ----------
    seed : int
    folder : path
        Gets ``case`` with the data, the nominal machine and the answer's hash, and ``answer.json``.
    bank : truth.sealed.bank.Bank, optional
        Keeps what the default engine does at operating points, for other cases.

    Returns
    -------
    dict
        The answer.
    """
    case = draw_case(seed, bank)
    write(case, folder)
    return case.answer


def draw_case(seed, bank=None):
    """Draw what the data of a case of either benchmark are made of, see `make`."""
    return draw(seed, bank) if seed < SECOND else draw_second(seed, bank)


def draw(seed, bank=None):
    """Draw what the data of a case of the first benchmark are made of."""
    rng = np.random.default_rng(seed)
    plan = plan_of(seed)
    lab, hidden, facts = hide(rng, plan, nominal_rig(rng, plan.bench), library_at(seed), bank)
    setting = lab.setting
    answer = {
        "seed": seed,
        "kind": plan.kind,
        "bench": setting.bench,
        "hidden": [one.told for one in hidden],
        **facts,
        "nuisances": drawn(nuisances_for(setting.bench, setting.channels), rng),
        "setting": described(setting),
    }
    return Case(answer, tuple(one.add for one in hidden), lab, rng)


def keep(case, path):
    """Write what leads to a case's data again; what is hidden is of the library. The search for its size is spared."""
    Path(path).write_text(json.dumps({"answer": case.answer, "random": case.rng.bit_generator.state}, indent=1) + "\n")


def restore(path):
    """Read what a case's data are made of, see `keep`."""
    found = json.loads(Path(path).read_text())
    answer, rng = found["answer"], np.random.default_rng()
    rng.bit_generator.state = found["random"]
    hidden = tuple(partial(EFFECTS[one["name"]], **one["parameters"]) for one in answer["hidden"])
    return Case(answer, hidden, Laboratory(setting_of(answer["setting"])), rng)


def hide(rng, plan, nominal, library, bank):
    """A setting and what is hidden in it; drawn anew until the case shows what its kind is about.

    Returns
    -------
    Laboratory, list of Hidden, dict
        What the answer tells besides.
    """
    for number in range(1, TRIES + 1):
        lab = Laboratory(
            draw_setting(rng, plan.bench, suites_for(plan, library)), bank if plan.bench == ENGINE else None
        )
        points = [point for point in lab.setting.points if point.role == "fit"]
        hidden = hidden_in(rng, plan, lab, nominal, points)
        if number < TRIES and plan.kind != NONE and any(one.deviations < SMALLEST * LIMIT for one in hidden):
            continue
        facts = facts_of(plan, lab, nominal, points, hidden, library)
        apart = plan.kind not in (REMOVED, FOREIGNER) or facts["distance"] >= LIMIT
        if apart and facts.get("cosine", 0.0) < ALIKE:
            break
    return lab, hidden, facts


def hidden_in(rng, plan, lab, nominal, points):
    """What a case hides, the first of it in full, each of a size of its own."""
    if plan.kind == NONE:
        return [hidden_clutter(rng, lab, nominal, points, plan.clutter)] if plan.clutter else []
    if plan.kind == FOREIGNER:
        return [hidden_foreign(rng, lab, nominal, points, name) for name in plan.effects]
    min_size = SMALLEST if len(plan.effects) == 1 and plan.kind != REMOVED else 1.0
    return [hidden_effect(rng, lab, nominal, points, name, min_size) for name in plan.effects]


def facts_of(plan, lab, nominal, points, hidden, library):
    """What the answer tells besides: all deviations, where the gap lies, and what could stand in for the hidden."""
    if not hidden:
        return {"deviations": 0.0, "without": [], "class": [], "gap": []}
    left = sum(one.left for one in hidden)
    samples = len(left) - len(lab.nuisances)
    facts = {
        "deviations": float(np.linalg.norm(left)),
        "rms": float(np.sqrt(np.mean(left[:samples] ** 2))),
        "gap": gap_shares(lab, nominal, points, left),
        "without": [],
        "class": [],
    }
    if plan.kind == NONE:
        return facts
    alike = look_alikes(lab, nominal, points, hidden, library)
    names = [one.told["name"] for one in hidden]
    if plan.kind == DOUBLE:
        first, second = (one.left / one.deviations for one in hidden)
        facts["cosine"] = float(abs(first @ second))
    elif plan.kind != FOREIGNER:
        facts["class"] = class_of(names[0], alike)
    if plan.kind == REMOVED:
        facts["without"] = facts["class"]
    left_out = facts["without"] or names
    facts["alike"] = {one.name: one.left for one in alike[:5]}
    facts["distance"] = min((one.left for one in alike if one.name not in left_out), default=0.0)
    return facts
