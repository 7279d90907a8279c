"""The blind benchmark: makes sealed cases, lets a program explain each by its command line, and scores its verdicts."""

import json
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from .diagrams import confusion_matrix, reliability
from .score import Scored, figures
from .tables import report

CASE, ANSWER, FOUND, VERDICT, WHY = "case", "answer.json", "found", "verdict.json", "why.txt"
LONGEST = 900.0
"""That a program may take for a case [s]."""


def benchmark(seeds, out, tool, jobs=1):
    """Make, solve and score cases; what is there already is kept.

    Parameters
    ----------
    seeds : sequence of int
    out : path
        Gets ``cases/SEED``, ``report.md``, ``figures.json``, and the diagrams.
    tool : sequence of str
        The program and its first arguments; ``gap explain CASE --machine FILE --out OUT`` follows.
    jobs : int
        Cases at a time.

    Returns
    -------
    list of Scored
    """
    out = Path(out)
    out.mkdir(parents=True, exist_ok=True)
    done = 0
    with ThreadPoolExecutor(jobs) as threads:
        for seed, why in threads.map(lambda seed: (seed, solve(seed, out, tool)), seeds):
            done += 1
            print(f"{done} of {len(seeds)}: seed {seed}: {why}", file=sys.stderr, flush=True)
    scored, missing = read(seeds, out)
    if scored:
        publish(scored, missing, out)
    return scored


def solve(seed, out, tool):
    """Make a case and let the program explain it; returns what it says, or why there is no verdict."""
    folder = out / "cases" / str(seed)
    if not (folder / ANSWER).exists():
        made = subprocess.run(
            [
                sys.executable,
                "-m",
                "tests.truth",
                "challenge",
                "--seed",
                str(seed),
                "--out",
                folder,
                "--bank",
                out / "bank",
            ],
            capture_output=True,
            text=True,
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        )
        if made.returncode:
            return f"no case: {last_line(made.stderr)}"
    answer = json.loads((folder / ANSWER).read_text())
    verdict = folder / FOUND / VERDICT
    if not verdict.exists():
        shutil.rmtree(folder / FOUND, ignore_errors=True)
        case = folder / CASE
        without = [word for name in answer["without"] for word in ("--without", name)]
        command = [*tool, "gap", "explain", case, "--machine", case / "machine.toml", "--out", folder / FOUND, *without]
        try:
            run = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST)
            why = "" if verdict.exists() else f"exit code {run.returncode}: {last_line(run.stderr)}"
        except subprocess.TimeoutExpired:
            why = f"longer than {LONGEST:g} s"
        if why:
            (folder / WHY).write_text(why)
            return why
    (folder / WHY).unlink(missing_ok=True)
    return json.loads(verdict.read_text())["verdict"]


def last_line(text):
    """The last that a program said."""
    return next(reversed(text.strip().splitlines()), "nothing said")


def read(seeds, out):
    """The cases that have a verdict, and why others have none, by seed."""
    scored, missing = [], {}
    for seed in seeds:
        folder = Path(out) / "cases" / str(seed)
        verdict = folder / FOUND / VERDICT
        if verdict.exists():
            scored.append(Scored(*(json.loads(path.read_text()) for path in (folder / ANSWER, verdict))))
        else:
            missing[seed] = (folder / WHY).read_text() if (folder / WHY).exists() else "no case"
    return scored, missing


def publish(scored, missing, out):
    """Write the page, the figures as data, and the diagrams."""
    (out / "report.md").write_text(report(scored, missing))
    data = [one._asdict() | {"interval": one.interval if one.cases else None} for one in figures(scored)]
    (out / "figures.json").write_text(json.dumps(data, indent=1))
    reliability(scored, out)
    confusion_matrix(scored, out)
