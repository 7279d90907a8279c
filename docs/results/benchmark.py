"""The fourth block of the second benchmark: sealed cases that one commit solved, each counted.

A block of 725 holds 200 cases with nothing hidden, 175 with one effect, 100 with two, 40 with three, 145 with a faulty
file, 40 with an effect that is taken out of the library and 25 with physics of no library. Every stretch of it holds
the kinds in these proportions, so that `CASES` may be a part of it. Every case counts; a case without a verdict is
counted as such. Seeds that have been opened say nothing of code that was changed since: the next block begins at
150000.

It wants a machine with nothing else to do: a program that takes more than 900 s for a case has no verdict there. The
folder of the cases is named by the commit, so that a run that was interrupted goes on, and verdicts of other code are
never read.
"""

import subprocess
import sys
from collections import Counter

from docs.results import Number, Table
from docs.results._kept import find_kept
from tests.folders import ROOT
from tests.truth.scoring.benchmark import read
from tests.truth.scoring.figures import figures
from tests.truth.scoring.score import BAD_INPUT, NO_VERDICT, STATEMENTS
from tests.truth.scoring.tables import say_interval, short
from tests.truth.sealed.schedule import DOUBLE, FOREIGNER, NONE, REMOVED, SINGLE
from tests.truth.sealed.second_schedule import FAULTY, TRIPLE

RECORD = True
FIRST, CASES = 140000, 100
"""First seed, and number of cases; fewer than a block, where a machine has no time for all, are a fair sample of it."""
JOBS = 2
KINDS = {
    "nothing": "nothing",
    "clutter": "clutter",
    SINGLE: "one effect",
    DOUBLE: "two effects",
    TRIPLE: "three effects",
    FAULTY: "faulty file",
    REMOVED: "one, taken out",
    FOREIGNER: "foreign physics",
}
"""Heads of what is hidden."""
VERDICTS = (*STATEMENTS, "AMBIGUOUS", BAD_INPUT, NO_VERDICT)
WORDS = {BAD_INPUT: "refused as impossible", NO_VERDICT: "no verdict"}


def compute():
    """Counts of verdicts by what was hidden, all figures with their intervals, and what was said that is not so."""
    folder = find_kept("benchmark")
    options = ["--first", str(FIRST), "--cases", str(CASES), "--jobs", str(JOBS), "--tools", "apesim"]
    subprocess.run([sys.executable, "-m", "tests.truth", "benchmark", *options, "--out", folder], cwd=ROOT, check=True)
    scored, _ = read(range(FIRST, FIRST + CASES), folder, "apesim")
    return {
        "verdicts": count_verdicts(scored),
        "figures": list_figures(scored),
        "wrong": list_wrong(scored),
    }


def find_kind(one):
    """What a case hides, as a key of `KINDS`."""
    return one.kind if one.kind != NONE else "clutter" if one.clutter else "nothing"


def count_verdicts(scored):
    """How often each verdict was given, by what was hidden; cases without one in a row of their own."""
    counts = Counter((find_kind(one), one.said) for one in scored)
    rows = [
        [WORDS.get(verdict, f"`{verdict}`"), *(Number(counts[kind, verdict]) for kind in KINDS)] for verdict in VERDICTS
    ]
    every = Counter(kind for kind, _ in counts.elements())
    rows.append(["all", *(Number(every[kind]) for kind in KINDS)])
    return Table(["said", *KINDS.values()], rows)


def list_figures(scored):
    """Every figure that has cases, with counts, interval, floor and goal."""
    rows = []
    for one in figures(scored):
        if one.cases:
            rows.append([one.what, short(one), say_interval(one), one.floor or "–", one.goal or "–"])
    return Table(["figure", "apesim", "95 % interval", "floor", "goal"], rows)


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
