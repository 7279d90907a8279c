"""What a sealed case is made of, and how its folder is written."""

import json
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests.truth.simulator.effects import Rig

from .faults import Fault
from .files import write_case
from .laboratories import draw_heavy, run_scatter, scattered
from .library import ENGINE
from .nuisances import with_nuisances
from .observation import Laboratory, at_point, noisy
from .setting import SUITES, Noise, Point, Setting


class Case(NamedTuple):
    """What a case's data are made of."""

    answer: dict
    hidden: tuple
    """Changes from rig to rig, one for each that is hidden."""
    lab: Laboratory
    rng: np.random.Generator
    """Generator of the readings' noise."""
    scatters: bool = False
    """Runs differ by `truth.sealed.laboratories.run_scatter`."""
    fault: Fault | None = None
    """What is wrong with one record."""
    at: int = -1
    """Number of that record, from 0."""
    stated: tuple = ()
    """Lines of measured.toml that say how far the rig is known."""


def write(case, folder):
    """Simulate a case's runs and write its folder, see `make`."""
    answer, setting = case.answer, case.lab.setting
    nominal = nominal_rig(np.random.default_rng(answer["seed"]), setting.bench)
    runs = []
    for point in setting.points:
        rig = with_nuisances(at_point(nominal, point), case.lab.nuisances, answer["nuisances"])
        true = None
        for _ in range(point.repeats):
            fault = case.fault if len(runs) == case.at else None
            if case.scatters or fault or true is None:
                true = seen_in_run(case, rig, point, fault)
            found = noisy(setting, point, true, case.rng)
            runs.append((point, fault.spoil(found) if fault else found))
            true = None if fault else true
    text = json.dumps(answer, indent=1)
    folder = Path(folder)
    write_case(folder / "case", setting, nominal, runs, case.stated)
    (folder / "case" / "answer.sha256").write_text(sha256(text.encode()).hexdigest() + "\n")
    (folder / "answer.json").write_text(text)


def seen_in_run(case, rig, point, fault):
    """Channels of one run without noise, SI."""
    if case.scatters:
        rig = scattered(rig, {one.name: draw_heavy(case.rng, one) for one in run_scatter()})
    for add in case.hidden:
        rig = add(rig)
    rig = fault.rig(rig) if fault else rig
    grid = case.lab.setting.grid(point)
    return case.lab.read(rig, point, case.lab.run(rig, point), fault.grid(grid) if fault else grid)


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


def suites_for(plan, library):
    """Sensor suites that could show what is hidden."""
    known = [name for name in SUITES if plan.bench == ENGINE or not set(SUITES[name]) - set(SUITES["chambers"])]
    needs = [library[name].needs for name in plan.effects if name in library and library[name].needs]
    return [name for name in known if all(set(SUITES[name]) & set(need) for need in needs)]


def described(setting):
    """A setting as the answer tells it."""
    return setting._asdict() | {
        "points": [point._asdict() for point in setting.points],
        "noise": setting.noise._asdict(),
    }


def setting_of(described):
    """The setting that an answer tells of, see `described`."""
    points = tuple(Point(**point) for point in described["points"])
    return Setting(**described | {"points": points, "noise": Noise(**described["noise"])})
