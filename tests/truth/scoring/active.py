"""The next test in a loop: how many added runs lead from a refusal or a tie to a name, chosen or drawn at random.

A sealed case of the valve's bench is explained. While it is refused or tied, the independent simulator records one
more run of the same rig, with the same hidden effect, the same errors of the rig and fresh noise, and all is explained
again. One arm records the run that the program asks for, the other one that is drawn at random from the same list.
"""

import json
import shutil
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests.truth.sealed.challenge import draw, keep, nominal_rig, restore, suites_for, write
from tests.truth.sealed.files import conditions, reading, write_run
from tests.truth.sealed.hiding import LARGEST, SMALLEST, drawn_size
from tests.truth.sealed.library import CALIBRATED, LIBRARY, VALVE, library_at
from tests.truth.sealed.nuisances import drawn, nuisances_for, with_nuisances
from tests.truth.sealed.observation import Laboratory, at_point, noisy
from tests.truth.sealed.schedule import SINGLE, plan_of
from tests.truth.sealed.setting import Point, Setting, draw_setting

from .benchmark import ANSWER, CASE, TOOLS, VERDICT, explained
from .score import Scored
from .tables import markdown, rate

OPEN = "REFUSED", "AMBIGUOUS", "NAMED_CLASS"
"""Verdicts after which another run is recorded."""
ARMS = CHOSEN, RANDOM = "chosen", "random"
MOST = 3
"""Runs that are added at most."""
FEWEST_SIGMAS, MOST_SIGMAS = 5.0, 20.0
"""Sizes of what is hidden, as a seed draws them first [deviations]: smaller ones are hardly seen, larger ones mostly
named."""
MOST_SAMPLES = 501
"""Samples of a run: more take longer, and are no other case."""
KEPT, FIRST_CASE = "kept.json", "0"


class Course(NamedTuple):
    """What was said of a case after no, one, two and three added runs."""

    seed: int
    arm: str
    scored: list
    """Cases with their verdicts, see `truth.scoring.score.Scored`."""
    added: list
    """The added runs in words."""

    def named(self, runs):
        """Whether one name was given after so many added runs at most; None: none was."""
        last = self.scored[min(runs, len(self.scored) - 1)]
        if last.said == "NAMED" or (last.said == "CALIBRATION" and last.calibrated):
            return bool(last.right)
        return False if last.named and last.said not in OPEN else None


def seeds_from(first, cases):
    """The first seeds whose cases are likely to be refused or tied, see `is_likely_open`."""
    found, seed = [], first
    while len(found) < cases:
        found += [seed] * is_likely_open(seed)
        seed += 1
    return found


def is_likely_open(seed):
    """Whether a seed hides one small effect of a valve of which the lift alone is measured.

    It is judged by what the seed draws first: a case that does not show what it is about is drawn anew.
    """
    plan = plan_of(seed)
    if plan.kind != SINGLE or plan.bench != VALVE or plan.effects[0] in CALIBRATED:
        return False
    rng = np.random.default_rng(seed)
    nominal_rig(rng, plan.bench)
    setting = draw_setting(rng, plan.bench, suites_for(plan, library_at(seed)))
    entry = LIBRARY[plan.effects[0]]
    rng.choice(entry.ends)
    for ends in entry.besides.values():
        rng.uniform(*ends)
    size = drawn_size(rng, SMALLEST, LARGEST)
    return setting.suite == "lift" and setting.samples <= MOST_SAMPLES and FEWEST_SIGMAS <= size <= MOST_SIGMAS


def run_loops(seeds, out, tool=TOOLS["apesim"]):
    """Let cases run through the loop in both arms; what is there already is kept.

    Parameters
    ----------
    seeds : sequence of int
    out : path
        Gets a folder for each seed, and in it one for each explanation.
    tool : sequence of str
        Program with its first arguments.

    Yields
    ------
    int, dict of Course
        Seed, and the course of each arm; none where the case was not open, or had no verdict.
    """
    for seed in seeds:
        folder = Path(out) / str(seed)
        if not (folder / KEPT).exists():
            folder.mkdir(parents=True, exist_ok=True)
            keep(draw(seed), folder / KEPT)
        if not (folder / FIRST_CASE / ANSWER).exists():
            write(restore(folder / KEPT), folder / FIRST_CASE)
        said = explained(folder / FIRST_CASE, "apesim", tool)
        courses = {arm: follow(seed, folder, arm, tool) for arm in ARMS} if said in OPEN else {}
        print(f"seed {seed}: {said}", *map(told, courses.values()), sep="; ", file=sys.stderr, flush=True)
        yield seed, courses


def follow(seed, folder, arm, tool):
    """The course of an open case in one arm."""
    last, added = folder / FIRST_CASE, []
    scored = [read_scored(last)]
    for number in range(1, MOST + 1):
        wanted = choose(scored[-1].verdict, np.random.default_rng([seed, number]) if arm == RANDOM else None)
        if scored[-1].said not in OPEN or not wanted:
            break
        here = folder / f"{arm}{number}"
        if not (here / ANSWER).exists():
            rng = np.random.default_rng([seed, ARMS.index(arm), number])
            add_run(restore(folder / KEPT), last, here, wanted, rng)
        if not (said := explained(here, "apesim", tool)).isupper():
            print(f"seed {seed}, {here.name}: {said}", file=sys.stderr, flush=True)
            break
        scored.append(read_scored(here))
        added.append(wanted["text"])
        last = here
    return Course(seed, arm, scored, added)


def read_scored(folder):
    """A case and its verdict."""
    return Scored(*(json.loads(path.read_text()) for path in (folder / ANSWER, folder / "apesim" / VERDICT)))


def choose(verdict, rng=None):
    """The run that a verdict asks for, or with a generator any of its list; None: it lists none."""
    test = verdict["next_test"]
    runs = [*test.get("experiments", ()), *test.get("others", ())]
    if rng is None or not runs:
        return runs[0] if runs else None
    return runs[int(rng.integers(len(runs)))]


class Recorder(Setting):
    """A setting that records other channels, at another interval."""

    @classmethod
    def wanted(cls, setting, wanted):
        """The setting with the sensors and the interval that are asked for."""
        recorder = cls(*setting)
        recorder.sensors, recorder.step = tuple(wanted["sensors"]), wanted["interval_s"]
        recorder.last = wanted["recorded_s"]
        return recorder

    @property
    def channels(self):
        return self.sensors

    def grid(self, point):
        return np.arange(-int(self.before / self.step), round(self.last / self.step) + 1) * self.step


def add_run(case, before, folder, wanted, rng):
    """Record one more run of a case's rig, and write the folder with it.

    Parameters
    ----------
    case : truth.sealed.challenge.Case
    before : path
        The case so far.
    folder : path
        The case with the run.
    wanted : dict
        The run, as ``next_test`` of ``verdict.json`` describes it.
    rng : numpy.random.Generator
        Generator of the readings' noise.
    """
    setting, answer = case.lab.setting, case.answer
    point = Point(wanted["role"], wanted["supply_Pa_abs"], wanted["temperature_K"], wanted["pulse_s"])
    recorder = Recorder.wanted(setting._replace(points=(*setting.points, point)), wanted)
    nuisances = nuisances_for(setting.bench, recorder.channels)
    values = drawn(nuisances, np.random.default_rng([answer["seed"], MOST])) | answer["nuisances"]
    rig = at_point(nominal_rig(np.random.default_rng(answer["seed"]), setting.bench), point)
    rig = with_nuisances(rig, nuisances, values)
    for add in case.hidden:
        rig = add(rig)
    lab = Laboratory(recorder)
    found = noisy(recorder, point, lab.read(rig, point, lab.run(rig, point)), rng)
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(before / CASE, folder / CASE)
    file = folder / CASE / "measured.toml"
    text = file.read_text()
    name = f"run{text.count('[[run]]') + 1:02d}.csv"
    write_run(folder / CASE / name, recorder, point, found)
    lines = ["[[run]]", f'data = "{name}"', *conditions(recorder, point)]
    for sensor in recorder.channels if setting.noise.stated else ():
        if f"[sensor.{sensor}]" not in text:
            unit, factor = reading(sensor)
            lines += [f"[sensor.{sensor}]", f'noise = "{setting.deviation(sensor) * factor:.6g} {unit}"']
    file.write_text(text + "\n".join(lines) + "\n")
    shutil.copy(before / ANSWER, folder / ANSWER)


def told(course):
    """A course in a line."""
    steps = [
        f"{what} -> {one.said} {' with '.join(one.first)}"
        for what, one in zip(course.added, course.scored[1:], strict=True)
    ]
    return f"{course.arm}: {', '.join(steps)}"


def count_named(courses, runs, right=True):
    """In how many courses one name was given after so many added runs at most, and how many courses there are."""
    return sum(course.named(runs) is right for course in courses), len(courses)


def table(loops):
    """Named and right, and named and wrong, after no to three added runs, in both arms, as Markdown.

    Parameters
    ----------
    loops : sequence of dict of Course
        Of the cases that were open.
    """
    rows = []
    for runs in range(MOST + 1):
        row = [runs]
        for arm in ARMS:
            courses = [courses[arm] for courses in loops]
            share, counts, interval = rate(*count_named(courses, runs))
            row += [f"{counts} ({share})", interval, count_named(courses, runs, right=False)[0]]
        rows.append(row)
    heads = [f"{arm}: {what}" for arm in ARMS for what in ("named, and right", "95 % interval", "named, but wrong")]
    return markdown(["added runs", *heads], rows)
