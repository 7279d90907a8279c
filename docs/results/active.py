"""Added runs until a case that is refused or tied is named: chosen by expected information, and drawn at random.

The seeds are development's. Those are taken whose case is likely to be open, by a rule that looks at what the seed
draws first, and at no verdict, see `tests.truth.scoring.active.is_likely_open`: in their order, as many as there was
time for. Each open case takes up to seven explanations: 24 cases take some 40 minutes on two cores.
"""

import datetime
import subprocess
import sys

from docs.results import Number, Table
from docs.results._kept import find_kept
from tests.folders import ROOT, find_commit
from tests.truth.scoring.active import ARMS, MOST, OPEN, count_named, read_scored, run_loops, seeds_from
from tests.truth.scoring.score import clopper_pearson

RECORD = True
FIRST, CASES = 70050, 24


def compute():
    """Counts of names after each added run in both arms, with intervals, and the course of each open case."""
    folder = find_kept("active")
    options = ["--first", str(FIRST), "--cases", str(CASES), "--out", folder]
    subprocess.run([sys.executable, "-m", "tests.truth", "active", *options], cwd=ROOT, check=True)
    seeds = seeds_from(FIRST, CASES)
    loops = [courses for _, courses in run_loops(seeds, folder) if courses]
    return {
        "about": describe_cases(seeds, folder),
        "named": count_names(loops),
        "courses": Table(
            ["seed", "hidden", "sigmas", "at first", *ARMS], [describe_courses(courses) for courses in loops]
        ),
    }


def describe_cases(seeds, folder):
    """When it was made, and how many cases there were."""
    said = [read_scored(folder / str(seed) / "0").said for seed in seeds]
    made = [["made on", datetime.date.today().isoformat()], ["by commit", f"`{find_commit()}`"]]
    rows = [*made, ["cases", Number(len(said))]]
    rows += [[f"at first `{verdict}`", Number(said.count(verdict))] for verdict in sorted(set(said))]
    rows.append(["open: refused or tied", Number(sum(verdict in OPEN for verdict in said))])
    return Table(["what", "value"], rows)


def count_names(loops):
    """Right and wrong names after no to `MOST` added runs, in both arms."""
    rows = []
    for runs in range(MOST + 1):
        row = [Number(runs)]
        for arm in ARMS:
            courses = [courses[arm] for courses in loops]
            hits, cases = count_named(courses, runs)
            low, high = clopper_pearson(hits, cases)
            wrong = count_named(courses, runs, right=False)[0]
            row += [f"{hits} of {cases} ({100.0 * low:.0f} to {100.0 * high:.0f} %)", Number(wrong)]
        rows.append(row)
    heads = [f"{arm}: {what}" for arm in ARMS for what in ("right (95 % interval)", "wrong")]
    return Table(["added runs", *heads], rows)


def describe_courses(courses):
    """The course of a case in both arms, in words."""
    first = courses[ARMS[0]].scored[0]
    cells = [str(courses[ARMS[0]].seed), f"`{first.hidden[0]}`", f"{first.deviations:.1f}", f"`{first.said}`"]
    for arm in ARMS:
        course = courses[arm]
        steps = zip(course.added, course.scored[1:], strict=True)
        cells.append("; ".join(f"{run}: `{one.said}` {' with '.join(one.first)}" for run, one in steps))
    return cells
