"""A block of sealed cases that this code solved, each counted: what was hidden, and what was said.

The seeds begin at 80000, which no development and no block before has used. The 64 cases follow the default mixture of
kinds (10 with nothing hidden, 36 with one effect, 9 with two, 3 with one that is taken out of the library, 6 with
physics of no library): fewer would leave kinds out, more would take longer than a release can wait for. Every case
counts; a case without a verdict is counted as such. The block was settled before any case was made.

It takes more than an hour on two cores, and wants a machine with nothing else to do: a program that takes more than
900 s for a case has no verdict there. The folder of the cases is named by the hash of all the code, so that a run that
was interrupted goes on, and verdicts of other code are never read.
"""

import hashlib
import importlib
import pkgutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from docs.results import ROOT, Number, Table
from tests.truth.benchmark import TOOLS, read
from tests.truth.schedule import DOUBLE, FOREIGNER, NONE, REMOVED, SINGLE, plan_of
from tests.truth.score import figures
from tests.truth.tables import rate, short

LONG = True
OPTIONAL = True
FIRST, CASES = 80000, 64
JOBS = 2
PACKAGES = "apesim.studies.gap.search", "apesim.studies.gap.decide", "apesim.studies.gap.tables", "tests.truth"
NAMES = {"apesim": "apesim", "rms": "rms", "aic": "aic", "sindy": "PySINDy"}
KINDS = {
    "nothing": "nothing",
    "clutter": "clutter",
    SINGLE: "one effect",
    DOUBLE: "two effects",
    REMOVED: "one, taken out",
    FOREIGNER: "foreign physics",
}
"""Heads of what is hidden."""
VERDICTS = "NO_GAP", "NAMED", "NAMED_CLASS", "TWO_EFFECTS", "AMBIGUOUS", "CALIBRATION", "REFUSED"
NO_VERDICT = "no verdict"


def compute():
    """Counts of verdicts by what was hidden, all figures with their intervals, and the same of simpler methods."""
    load_solver()
    folder = Path(tempfile.gettempdir()) / f"apesim_benchmark_{hash_sources()[:12]}"
    options = ["--first", str(FIRST), "--cases", str(CASES), "--jobs", str(JOBS)]
    subprocess.run([sys.executable, "-m", "tests.truth", "benchmark", *options, "--out", folder], cwd=ROOT, check=True)
    seeds = range(FIRST, FIRST + CASES)
    found = {name: read(seeds, folder, name) for name in TOOLS}
    scored, missing = found["apesim"]
    return {
        "cases": Number(len(seeds)),
        "without_verdict": Number(len(missing)),
        "engine_cases": Number(sum(plan_of(seed).bench == "engine" for seed in seeds)),
        "verdicts": count_verdicts(scored, missing),
        "figures": list_figures(scored),
        "methods": compare_methods({NAMES[name]: scored for name, (scored, _) in found.items()}),
        "wrong": list_wrong(scored),
    }


def load_solver():
    """Load all that decides a verdict, so that the hash of this result covers it."""
    importlib.import_module("apesim.studies.gap.workflow")
    for package in map(importlib.import_module, PACKAGES):
        for module in pkgutil.iter_modules(package.__path__, f"{package.__name__}."):
            if not module.name.split(".")[-1].startswith(("test_", "__main__")):
                importlib.import_module(module.name)


def hash_sources():
    """The SHA-256 of every Python file that makes or solves cases."""
    digest = hashlib.sha256()
    for folder in ("apesim", "valve", "engine", "studies", "tests/truth", "tests/baselines"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()


def find_kind(seed):
    """What a seed hides, as a key of `KINDS`."""
    plan = plan_of(seed)
    return plan.kind if plan.kind != NONE else "clutter" if plan.clutter else "nothing"


def count_verdicts(scored, missing):
    """How often each verdict was given, by what was hidden; cases without one in a row of their own."""
    said = [(find_kind(one.answer["seed"]), one.said) for one in scored]
    counts = Counter([*said, *((find_kind(seed), NO_VERDICT) for seed in missing)])
    rows = [[f"`{verdict}`", *(Number(counts[kind, verdict]) for kind in KINDS)] for verdict in VERDICTS]
    rows.append([NO_VERDICT, *(Number(counts[kind, NO_VERDICT]) for kind in KINDS)])
    every = Counter(kind for kind, _ in counts.elements())
    rows.append(["all", *(Number(every[kind]) for kind in KINDS)])
    return Table(["said", *KINDS.values()], rows)


def list_figures(scored):
    """Every figure that has cases, with counts, interval, floor and goal."""
    rows = []
    for one in figures(scored):
        if one.cases:
            interval = "–" if one.value is not None else rate(one.hits, one.cases)[2]
            rows.append([one.what, short(one), interval, one.floor or "–", one.goal or "–"])
    return Table(["figure", "apesim", "95 % interval", "floor", "goal"], rows)


def compare_methods(found):
    """Every figure that has cases, of each method."""
    rows = []
    for each in zip(*map(figures, found.values()), strict=True):
        if each[0].cases:
            rows.append([each[0].what, *map(short, each)])
    return Table(["figure", *found], rows)


def list_wrong(scored):
    """Each case in which something was said that is not so."""
    rows = [
        [
            str(one.answer["seed"]),
            ", ".join(f"`{name}`" for name in one.hidden) or "–",
            f"{one.deviations:.1f}",
            f"`{one.said}`",
            ", ".join(f"`{name}`" for name in one.first) or "–",
        ]
        for one in scored
        if one.wrong
    ]
    heads = ["seed", "hidden", "sigmas of the smaller one", "verdict", "named, or nearest"]
    return Table(heads, rows or [["–", "–", "–", "–", "–"]])
