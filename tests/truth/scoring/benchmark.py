"""The blind benchmark: makes sealed cases, lets programs explain each by command line, and scores the verdicts."""

import json
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from .diagrams import confusion_matrix, reliability
from .figures import figures
from .score import BAD_INPUT, NO_VERDICT, Scored
from .tables import comparison, report

CASE, ANSWER, VERDICT, WHY = "case", "answer.json", "verdict.json", "why.txt"
BASELINES = "rms", "aic", "bic", "sindy"
TOOLS = {"apesim": ["apesim"]} | {name: [sys.executable, "-m", "tests.baselines", name] for name in BASELINES}
"""Commands by name; ``gap explain CASE --machine FILE --out OUT`` follows."""
LONGEST = 900.0
"""That a program may take for a case [s]."""
IMPOSSIBLE = "exit code 2"
"""Begins the reason where a program takes the data for impossible."""


def benchmark(seeds, out, tools=TOOLS, jobs=1):
    """Make, solve and score cases; what is there already is kept.

    Parameters
    ----------
    seeds : sequence of int
    out : path
        Gets ``cases/SEED``, for each program a folder with ``report.md``, ``figures.json`` and the diagrams, and
        ``table.md``, which compares them.
    tools : dict
        Programs with their first arguments, by name, see `TOOLS`.
    jobs : int
        Cases at a time.

    Returns
    -------
    dict of list of Scored
        By the program's name.
    """
    out = Path(out)
    out.mkdir(parents=True, exist_ok=True)
    done = 0
    with ThreadPoolExecutor(jobs) as threads:
        for seed, why in threads.map(lambda seed: (seed, solve(seed, out, tools)), seeds):
            done += 1
            print(f"{done} of {len(seeds)}: seed {seed}: {why}", file=sys.stderr, flush=True)
    found = {}
    for name in tools:
        found[name], missing = read(seeds, out, name)
        if found[name]:
            publish(found[name], missing, out / name)
    (out / "table.md").write_text(comparison(found) + "\n")
    return found


def solve(seed, out, tools):
    """Make a case and let the programs explain it; returns what they say, or why there is no verdict."""
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
    return ", ".join(f"{name} {explained(folder, name, tool)}" for name, tool in tools.items())


def explained(folder, name, tool, options=()):
    """Let one program explain a case; returns what it says, or why there is no verdict."""
    answer, out = json.loads((folder / ANSWER).read_text()), folder / name
    verdict = out / VERDICT
    if not verdict.exists():
        shutil.rmtree(out, ignore_errors=True)
        case = folder / CASE
        without = [word for effect in answer["without"] for word in ("--without", effect)]
        command = [*tool, "gap", "explain", case, "--machine", case / "machine.toml", "--out", out, *without, *options]
        try:
            run = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST)
            why = "" if verdict.exists() else f"exit code {run.returncode}: {run.stderr.strip() or last_line('')}"
        except subprocess.TimeoutExpired:
            why = f"longer than {LONGEST:g} s"
        if why:
            out.mkdir(exist_ok=True)
            (out / WHY).write_text(why)
            return last_line(why)
    return json.loads(verdict.read_text())["verdict"]


def last_line(text):
    """The last that a program said."""
    return next(reversed(text.strip().splitlines()), "nothing said")


def read(seeds, out, name):
    """The cases that a program was given, and why some have no verdict, by seed; a case without one counts, too."""
    scored, missing = [], {}
    for seed in seeds:
        folder = Path(out) / "cases" / str(seed)
        verdict, why = folder / name / VERDICT, folder / name / WHY
        if verdict.exists():
            scored.append(Scored(*(json.loads(path.read_text()) for path in (folder / ANSWER, verdict))))
            continue
        missing[seed] = why.read_text() if why.exists() else "no case"
        if why.exists():
            word = BAD_INPUT if missing[seed].startswith(IMPOSSIBLE) else NO_VERDICT
            said = {"verdict": word, "reason": missing[seed]}
            scored.append(Scored(json.loads((folder / ANSWER).read_text()), said))
    return scored, {seed: last_line(why) for seed, why in missing.items()}


def publish(scored, missing, out):
    """Write a program's page, its figures as data, and the diagrams."""
    out.mkdir(exist_ok=True)
    (out / "report.md").write_text(report(scored, missing))
    data = [one._asdict() | {"interval": one.interval} for one in figures(scored)]
    (out / "figures.json").write_text(json.dumps(data, indent=1))
    reliability(scored, out)
    confusion_matrix(scored, out)
