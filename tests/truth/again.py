"""The machine that a verdict wrote, on fresh data of the same hidden rig: nothing more should be missing.

A case whose effects were named is made again: the same rig, the same hidden effects, operating points and sensors, but
fresh noise, and no faulty file. The machine file that the verdict wrote takes the place of the nominal one.
"""

import json
import shutil

import numpy as np

from .benchmark import ANSWER, CASE, VERDICT, explained
from .cases import write
from .challenge import draw
from .score import Scored

FOLDER, MACHINE = "again", "machine.toml"


def explain_again(seed, folder, tool, name="apesim"):
    """Explain fresh data of a case's rig by the machine that its verdict wrote; what is there already is kept.

    Parameters
    ----------
    seed : int
    folder : pathlib.Path
        The solved case.
    tool : sequence of str
        Program with its first arguments.
    name : str
        Name of the program that solved it.

    Returns
    -------
    str or None
        What is said of the fresh data, or why nothing is; None: nothing was named rightly.
    """
    first = Scored(*(json.loads((folder / path).read_text()) for path in (ANSWER, f"{name}/{VERDICT}")))
    if not (first.named and first.right):
        return None
    here = folder / FOLDER
    if not (here / ANSWER).exists():
        write(draw(seed)._replace(rng=np.random.default_rng([seed, 1]), fault=None, at=-1), here)
        shutil.copy(folder / name / MACHINE, here / CASE / MACHINE)
    return explained(here, name, tool)


def count_again(seeds, out, tool, name="apesim"):
    """What is said of fresh data of the cases of a benchmark whose effects were named rightly, by seed.

    Parameters
    ----------
    seeds : sequence of int
    out : pathlib.Path
        Folder of the benchmark.
    tool : sequence of str
    name : str

    Returns
    -------
    dict of str
    """
    folders = {seed: out / "cases" / str(seed) for seed in seeds}
    solved = {seed: folder for seed, folder in folders.items() if (folder / name / VERDICT).exists()}
    said = {seed: explain_again(seed, folder, tool, name) for seed, folder in solved.items()}
    return {seed: words for seed, words in said.items() if words}
