"""Sealed cases: data of a rig with something hidden, the nominal machine file, and the answer, stored apart.

A seed's place in `SCHEDULE` says what kind of case it is; all else is drawn from the seed.
"""

import json
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .effects import EFFECTS, Rig
from .files import write_case
from .library import ENGINE, LIBRARY
from .nuisances import drawn, nuisances_for, with_nuisances
from .observation import Laboratory, at_point, noisy
from .schedule import SCHEDULE
from .setting import SUITES, draw_setting

LIMIT = 5.0
"""Deviations at which an effect counts as seen."""
SMALLEST, LARGEST = 0.5, 20.0
"""Sizes of what is hidden, over that limit."""
NEAR = 1.15
"""Factor to the size asked for that is let pass."""
TRIES = 8


class Found(NamedTuple):
    """A hidden effect and how it shows."""

    name: str
    parameters: dict
    """SI."""
    value: float
    """Of the hidden parameter, in the library's unit."""
    deviations: float
    left: np.ndarray
    """Of each sample of the runs to fit, over the noise."""

    def add(self, rig):
        """A rig with it."""
        return EFFECTS[self.name](rig, **self.parameters)


def make(seed, folder):
    """Make a case.

    Parameters
    ----------
    seed : int
    folder : path
        Gets ``case`` with the data, the nominal machine and the answer's hash, and ``answer.json``.

    Returns
    -------
    dict
        The answer.
    """
    rng = np.random.default_rng(seed)
    plan = SCHEDULE[seed % len(SCHEDULE)]
    nominal = nominal_rig(rng, plan.bench)
    setting, hidden = hide(rng, plan, nominal)
    nuisances = nuisances_for(setting.bench, setting.channels)
    values = drawn(nuisances, rng)
    answer = {
        "seed": seed,
        "kind": plan.kind,
        "bench": setting.bench,
        "hidden": [told(one) for one in hidden],
        "without": [],
        "nuisances": values,
        "setting": described(setting),
    }
    lab, runs = Laboratory(setting), []
    for point in setting.points:
        rig = with_nuisances(at_point(nominal, point), nuisances, values)
        for one in hidden:
            rig = one.add(rig)
        true = lab.read(rig, point, lab.run(rig, point))
        runs += [(point, noisy(setting, point, true, rng)) for _ in range(point.repeats)]
    text = json.dumps(answer, indent=1)
    folder = Path(folder)
    write_case(folder / "case", setting, nominal, runs)
    (folder / "case" / "answer.sha256").write_text(sha256(text.encode()).hexdigest() + "\n")
    (folder / "answer.json").write_text(text)
    return answer


def nominal_rig(rng, bench):
    """The rig that the machine file describes: a bench of its own each time, the default engine."""
    rig = Rig()
    if bench == ENGINE:
        return rig
    return rig.valve(
        viscous_friction=round(rng.uniform(90.0, 140.0), 1),
        effective_area=round(rng.uniform(8.0, 12.0), 2) * 1e-6,
        dead_time=round(rng.uniform(1.2, 2.0), 2) * 1e-3,
        ramp_time=round(rng.uniform(1.0, 2.0), 2) * 1e-3,
    )


def hide(rng, plan, nominal):
    """A setting, and what is hidden in it; drawn anew until the setting shows the least that is asked for.

    Returns
    -------
    Setting, list of Found
    """
    for _ in range(TRIES):
        setting = draw_setting(rng, plan.bench, suites_for(plan))
        lab = Laboratory(setting)
        hidden = [sized(rng, lab, nominal, name) for name in plan.effects]
        if all(one.deviations >= SMALLEST * LIMIT for one in hidden):
            break
    return setting, hidden


def suites_for(plan):
    """Sensor suites that could show what is hidden."""
    known = [name for name in SUITES if plan.bench == ENGINE or not set(SUITES[name]) - set(SUITES["chambers"])]
    needs = [LIBRARY[name].needs for name in plan.effects if LIBRARY[name].needs]
    return [name for name in known if all(set(SUITES[name]) & set(need) for need in needs)]


def sized(rng, lab, nominal, name):
    """An effect of a size drawn by the deviations that it makes on the runs to fit.

    Returns
    -------
    Found
    """
    entry = LIBRARY[name]
    wanted = LIMIT * float(np.exp(rng.uniform(np.log(SMALLEST), np.log(LARGEST))))
    end = float(rng.choice(entry.ends))
    besides = {key: float(rng.uniform(*ends)) for key, ends in entry.besides.items()}
    fits = [point for point in lab.setting.points if point.role == "fit"]
    share, tried = 0.3, []
    for _ in range(TRIES):
        value = entry.size(share, end)
        parameters = besides | {entry.parameter: value * entry.scale}
        left, deviations = lab.deviations(nominal, lambda rig, p=parameters: EFFECTS[name](rig, **p), fits)
        tried.append((share, deviations))
        met = 1.0 / NEAR < deviations / wanted < NEAR
        if met or (share == 1.0 and deviations < wanted):
            break
        share = min(1.0, following(tried, wanted))
    return Found(name, parameters, value, deviations, left)


def following(tried, wanted):
    """The share to try next: by the two nearest on a doubly logarithmic scale, else in proportion."""
    shares, sizes = np.log(np.maximum(np.array(tried), 1e-9)).T
    aim = np.log(wanted)
    slope = 1.0
    if len(tried) > 1 and abs(shares[-1] - shares[-2]) > 1e-6:
        slope = np.clip((sizes[-1] - sizes[-2]) / (shares[-1] - shares[-2]), 0.5, 4.0)
    return float(np.exp(shares[-1] + np.clip((aim - sizes[-1]) / slope, -3.0, 3.0)))


def told(found):
    """A hidden effect as the answer tells it."""
    entry = LIBRARY[found.name]
    return {
        "name": found.name,
        "parameter": entry.parameter,
        "value": found.value,
        "unit": entry.unit,
        "parameters": found.parameters,
        "deviations": found.deviations,
    }


def described(setting):
    """A setting as the answer tells it."""
    return setting._asdict() | {
        "points": [point._asdict() for point in setting.points],
        "noise": setting.noise._asdict(),
    }
