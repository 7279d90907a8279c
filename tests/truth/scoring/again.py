"""Fresh data of the same rig: whether the machine that an explanation wrote explains them without anything missing.

The rig of a sealed case that got a name is measured once more: the same operating points, the same errors of the rig
and what hides in it, fresh noise and fresh scatter of the runs; the fault of a file is gone. The child machine stands
in place of the nominal one, with what was fitted of the sensors.
"""

import shutil
import sys
import tomllib
from itertools import islice
from pathlib import Path

import numpy as np

from tests.truth.sealed.cases import write
from tests.truth.sealed.challenge import draw_case

from .active import read_scored
from .benchmark import ANSWER, CASE, TOOLS, VERDICT, explained
from .score import NAMES

AGAIN, MACHINE, SENSORS = "again", "machine.toml", "sensors.toml"
HEADS = "seed", "hidden", "sigmas of the smaller one", "named", "said of fresh data"


def measure_again(case, folder):
    """Write fresh data of a case's rig.

    Parameters
    ----------
    case : truth.sealed.cases.Case
    folder : path
        Gets ``case`` and ``answer.json``, see `truth.sealed.cases.write`.
    """
    write(case._replace(rng=np.random.default_rng([case.answer["seed"], 1]), fault=None, at=-1), folder)


def settings_of(sensors):
    """Options that set what was fitted of the sensors: what a user copies into the machine file.

    Parameters
    ----------
    sensors : path
        ``sensors.toml``; there is none where nothing was moved.

    Returns
    -------
    list of str
    """
    if not sensors.exists():
        return []

    def leaves(tree, path=()):
        for name, branch in tree.items():
            if isinstance(branch, dict):
                yield from leaves(branch, (*path, name))
            else:
                yield ".".join((*path, name)), branch

    return [word for key, value in leaves(tomllib.loads(sensors.read_text())) for word in ("--set", f"{key}={value}")]


def explain_again(folder, tool=TOOLS["apesim"]):
    """Let the child machine of a solved case explain fresh data of its rig.

    Parameters
    ----------
    folder : path
        Of the case, solved, with the fresh data in its folder ``again``, which gets the verdict.
    tool : sequence of str
        Program with its first arguments.

    Returns
    -------
    str
        The verdict, or why there is none.
    """
    solved = Path(folder) / "apesim"
    shutil.copy(solved / MACHINE, Path(folder) / AGAIN / CASE / MACHINE)
    return explained(Path(folder) / AGAIN, "apesim", tool, settings_of(solved / SENSORS))


def repeat_named(out, cases, bank=None):
    """Let the child machines of the first cases that got a name explain fresh data.

    Parameters
    ----------
    out : path
        Folder of solved cases, see `truth.scoring.benchmark.benchmark`.
    cases : int
        How many.
    bank : truth.sealed.bank.Bank, optional

    Yields
    ------
    Scored, str
        The case with its verdict, and what the child machine says of the fresh data.
    """
    for folder, one in islice(named_cases(out), cases):
        if not (folder / AGAIN / ANSWER).exists():
            measure_again(draw_case(one.answer["seed"], bank), folder / AGAIN)
        said = explain_again(folder)
        print(f"seed {folder.name}: {one.said}, then {said}", file=sys.stderr, flush=True)
        yield one, said


def named_cases(out):
    """Folders of the solved cases that got a name, with the cases and their verdicts, by seed."""
    for folder in sorted((Path(out) / "cases").iterdir(), key=lambda path: int(path.name)):
        if (folder / "apesim" / VERDICT).exists() and (one := read_scored(folder)).said in NAMES:
            yield folder, one


def rows_again(found):
    """What was hidden and named, and what the child machines say of fresh data; rows below `HEADS`.

    Parameters
    ----------
    found : iterable of (Scored, str)
    """
    return [
        [
            str(one.answer["seed"]),
            ", ".join(f"`{name}`" for name in one.hidden) or "–",
            f"{one.deviations:.1f}",
            ", ".join(f"`{name}`" for name in one.first),
            f"`{said}`",
        ]
        for one, said in found
    ]
