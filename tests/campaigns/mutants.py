"""Mutants of the physics: one operator, number or condition of a module is another one, and the tests have to notice.

Mutants are those of Cosmic Ray. The examples of the module run first, then the tests that pass as plain Python, the
quick ones first, uncompiled; last, what the tests of the module's name ask compiled. A mutant that no test notices
survives; its line is kept, to be read. What notices one has to pass where nothing is changed, or the trial ends with an
error.
"""

import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import NamedTuple

from cosmic_ray.ast import ast_nodes, get_ast_from_path
from cosmic_ray.mutating import apply_mutation
from cosmic_ray.plugins import get_operator, operator_names

from tests.folders import ROOT
from tests.plain import LONG, QUICK

from .campaign import Outcome

LONGEST = 3600.0
"""That a trial may take [s]: all these tests, for a mutant that survives."""
PHYSICS = ("valve", "engine", "apesim/march", "apesim/air.py", "apesim/restriction.py")
NUMBERS = "Add", "Sub", "Mul", "Div", "Pow"
NO_TESTS = 5
"""Exit code of pytest where none of the files' tests is chosen."""
PYTHON = sys.executable, "-B"
PYTEST = *PYTHON, "-m", "pytest", "-xq", "-n", "0", "-p", "no:cacheprovider", "-m"
PLAIN = "plain"
COMPILED = "not plain and not slow"
ORDERS = "Eq", "NotEq", "Lt", "LtE", "Gt", "GtE"
CHANGES = re.compile(
    rf"ReplaceBinaryOperator_({'|'.join((*NUMBERS, 'Mod', 'FloorDiv'))})_({'|'.join(NUMBERS)})"
    rf"|ReplaceComparisonOperator_({'|'.join(ORDERS)})_({'|'.join(ORDERS)})"
    r"|ReplaceUnaryOperator_Delete_(USub|Not)|Replace(AndWithOr|OrWithAnd|TrueWithFalse|FalseWithTrue)"
    r"|ReplaceBreakWithContinue|ReplaceContinueWithBreak|NumberReplacer|AddNot|ZeroIterationForLoop"
)
"""Operators of Cosmic Ray that change what is computed: not bits, decorators that compile, and names of exceptions."""
EXAMPLES = (
    "import doctest, importlib, sys; flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE; "
    "sys.exit(doctest.testmod(importlib.import_module(sys.argv[1]), optionflags=flags).failed > 0)"
)


class Mutant(NamedTuple):
    """One change of one module."""

    path: str
    """Path of the module from the root of the project."""
    operator: str
    """Name that Cosmic Ray gives the kind of change."""
    occurrence: int
    """Place among those that the operator finds in the module."""
    line: int


def trial(seed):
    """Change a module in a copy of the project, and run the tests there.

    Parameters
    ----------
    seed : int
        Place in the list of all mutants, which is shuffled.

    Returns
    -------
    Outcome
        A mutant that survives breaks no promise: it is to be read.
    """
    if seed >= len(mutants()):
        return Outcome("none: there are no more mutants")
    mutant = mutants()[seed]
    file = project() / mutant.path
    before = file.read_text()
    try:
        _, after = apply_mutation(file, get_operator(mutant.operator)(), mutant.occurrence)
        file.write_text(after)
        found = next(filter(None, map(find_failure, tests_of(mutant.path))), None)
    finally:
        file.write_text(before)
    if not found:
        return Outcome(f"{mutant.path}: survives", False, describe(mutant, after))
    if found.again and not passes_unchanged(found.again):
        raise RuntimeError(f"{' '.join(found.again)} fails where nothing is changed, too")
    return Outcome(f"{mutant.path}: {found.word}")


class Failure(NamedTuple):
    """What notices a mutant."""

    word: str
    again: tuple[str, ...] = ()
    """Command that repeats it; none for what takes too long."""


def describe(mutant, after):
    """Tell where a mutant is, and its line as it reads with the change."""
    name = mutant.operator.partition("/")[2]
    return f"{mutant.path}:{mutant.line}: {name}: {after.splitlines()[mutant.line - 1].strip()}"


@cache
def mutants():
    """All mutants, in an order that is always the same."""
    operators = {name: get_operator(name)() for name in operator_names() if CHANGES.fullmatch(name.partition("/")[2])}
    listed = []
    for file in modules():
        nodes = list(ast_nodes(get_ast_from_path(file)))
        for name, operator in sorted(operators.items()):
            places = (place for node in nodes for place in operator.mutation_positions(node))
            listed += [
                Mutant(str(file.relative_to(ROOT)), name, number, start[0]) for number, (start, _) in enumerate(places)
            ]
    random.Random(0).shuffle(listed)
    return listed


def modules():
    """Files of the physics."""
    paths = [ROOT / name for name in PHYSICS]
    return sorted(file for path in paths for file in (path.rglob("*.py") if path.is_dir() else [path]))


@cache
def project():
    """A copy of the project for this process."""
    folder = Path(tempfile.mkdtemp(prefix="apesim_mutants_"))
    for name in ("apesim", "valve", "engine", "studies", "tests", "docs"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__", "*.png"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    return folder


def tests_of(path):
    """Commands that test a module: its examples, the tests of its name, quick ones, long ones, its compiled ones."""
    name = ".".join(Path("" if path.startswith("apesim") else "apesim", path).with_suffix("").parts)
    yield *PYTHON, "-c", EXAMPLES, name
    files = sorted((project() / "tests").rglob("test_*.py"))
    own = {f"test_{Path(path).stem}", f"test_{Path(path).parent.name}"}
    plain = own & (QUICK | LONG), QUICK - own, LONG - own
    for stems, marks in (*((stems, PLAIN) for stems in plain), (own, COMPILED)):
        chosen = [str(file) for file in files if file.stem in stems]
        if chosen:
            yield *PYTEST, marks, *chosen


def find_failure(command):
    """What fails in a command of the copy, or that it takes far longer than it should; None where it passes."""
    places = {"PYTHONPATH": str(project()), "APESIM_CACHE_DIR": str(project() / "cache")}
    marks = COMPILED if COMPILED in command else PLAIN
    environment = os.environ | places | {"NUMBA_DISABLE_JIT": f"{int(marks == PLAIN)}"}
    process = subprocess.Popen(
        command,
        cwd=project(),
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        process_group=0,
    )
    try:
        said, _ = process.communicate(timeout=0.4 * LONGEST)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        return Failure("caught, takes too long")
    if process.returncode in (0, NO_TESTS):
        return None
    word = "caught compiled" if marks == COMPILED else "caught"
    if test := re.search(r"^FAILED (.+?)(?: - .*)?$", said, re.MULTILINE):
        return Failure(word, (*PYTEST, marks, test[1]))
    return Failure(word, command)


@cache
def passes_unchanged(command):
    """Whether a command of the copy passes while nothing is changed there."""
    return find_failure(command) is None
