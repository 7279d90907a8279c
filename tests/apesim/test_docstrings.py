"""Docstrings: each stands alone; what users and authors call names its parameters and units, and shows an example."""

import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import apesim
from docs.extensions.reference import SHARED, result_classes
from tests.folders import ROOT

FOLDERS = "apesim", "valve", "engine", "studies"
AUTHORS = (
    *("apesim/effect.py", "apesim/kernel.py", "apesim/results.py", "apesim/march/hybrid_system.py"),
    *(
        "apesim/quantities/declarations.py",
        "studies/execution/calls.py",
        "studies/commands/options.py",
        "studies/terminal/console.py",
    ),
    *(
        "studies/archives/grid_result.py",
        "studies/archives/archive_result.py",
        "studies/terminal/tables.py",
        "studies/execution/output.py",
    ),
)
"""Files with what authors of effects, commands and studies call."""
FORBIDDEN = re.compile(r"(Of|The same|By|For which|As|Where|Likewise)\b")
"""Beginnings that lean on what a tool tip does not show."""
SECTION = re.compile(r"^(Parameters|Returns|Yields|Raises|Notes|References|Examples)\n-+\n", re.MULTILINE)

CITATION = re.compile(r"\[(\d+)\]_")
"""Mark of a work in the text of a docstring; the work stands in its References."""
REFERENCE = re.compile(r"^\.\. \[(\d+)\] ", re.MULTILINE)
EQUATION = re.compile(r"``[^`]* = [^`]*``")
SOURCED = re.compile(r"\[\d+\]_|\bdoi 10\.|\bchosen\b|\bdefined here\b|\bplain geometry\b", re.IGNORECASE)
"""Source of an equation, as a docstring has it: a work that is cited, or that it is ours."""
LAWS = "apesim", "valve", "engine"
"""Layers that hold the laws."""


def files(*folders: str) -> list[str]:
    """Paths of the Python files below some folders, from the checkout."""
    return sorted(path.relative_to(ROOT).as_posix() for folder in folders for path in (ROOT / folder).rglob("*.py"))


def functions(node: ast.AST, prefix: str = "") -> dict[str, ast.FunctionDef]:
    """Public functions of a module, and public methods of its public classes, by their qualified names."""
    found = {}
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.ClassDef) and not child.name.startswith("_"):
            found |= functions(child, f"{prefix}{child.name}.")
        elif isinstance(child, ast.FunctionDef) and not child.name.startswith("_"):
            found[f"{prefix}{child.name}"] = child
    return found


def face() -> set[str]:
    """Qualified names of the functions of `apesim` itself, and of the classes that they return or that users meet."""
    functions = {getattr(apesim, name) for name in apesim.__all__}
    named = {f"{each.__module__}.{each.__qualname__}" for each in functions}
    return named | {*result_classes().values(), *SHARED.values()}


def is_shown(name: str, shown: set[str]) -> bool:
    """Whether a qualified name, or the class that it is a method of, is among others."""
    return name in shown or name.rpartition(".")[0] in shown


def parts(function: ast.FunctionDef) -> dict[str, str]:
    """Sections of a docstring, by their names."""
    found = SECTION.split(ast.get_docstring(function) or "")
    return dict(zip(found[1::2], found[2::2], strict=True))


def described(section: str) -> list[str]:
    """Names that a section of a docstring describes."""
    heads = [line for line in section.splitlines() if line and not line.startswith(" ")]
    return [name.strip().lstrip("*") for head in heads for name in head.partition(" : ")[0].split(",")]


def arguments(function: ast.FunctionDef) -> list[ast.arg]:
    """Arguments of a function but for self, and cls of a class method."""
    bound = "cls" if any(ast.unparse(each) == "classmethod" for each in function.decorator_list) else "self"
    every = function.args
    found = [*every.posonlyargs, *every.args, *every.kwonlyargs, every.vararg, every.kwarg]
    return [argument for argument in found if argument is not None and argument.arg != bound]


def gives(function: ast.FunctionDef) -> set[str]:
    """Sections that what a function gives is due in: Returns, Yields or none."""
    found, nodes = set(), list(function.body)
    while nodes:
        node = nodes.pop()
        if isinstance(node, ast.FunctionDef | ast.Lambda | ast.ClassDef):
            continue
        if isinstance(node, ast.Yield | ast.YieldFrom):
            found.add("Yields")
        elif isinstance(node, ast.Return) and node.value is not None:
            found.add("Returns")
        nodes += ast.iter_child_nodes(node)
    return {"Yields"} if "Yields" in found else found


def lacking(function: ast.FunctionDef) -> list[str]:
    """Lines for what the docstring of a function lacks that has to be whole."""
    if any(ast.unparse(each).endswith(("property", "overload")) for each in function.decorator_list):
        return []
    sections, names = parts(function), [argument.arg for argument in arguments(function)]
    found = []
    if described(sections.get("Parameters", "")) != names:
        found.append(f"its parameters are {names}")
    found += [f"no {section}" for section in gives(function) if section not in sections]
    return found + ["no example"] * (">>> " not in sections.get("Examples", ""))


def not_annotated(function: ast.FunctionDef) -> list[str]:
    """Lines for the arguments, and for the return, that have no annotation."""
    found = [f"{each.arg} is not annotated" for each in arguments(function) if each.annotation is None]
    return found + ["its return is not annotated"] * (function.returns is None)


def is_law(function: ast.FunctionDef) -> bool:
    """Whether the text of a function shows an equation."""
    return bool(EQUATION.search(SECTION.split(ast.get_docstring(function) or "")[0]))


def texts(tree: ast.Module) -> list[tuple[int, str]]:
    """Docstrings of a module, its classes and functions, and strings below assignments, each with its line."""
    found = []
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        for child in body if isinstance(body, list) else []:
            if isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant):
                found += [(child.lineno, child.value.value)] if isinstance(child.value.value, str) else []
    return found


def test_sections_are_read_as_they_stand():
    """A function that lacks everything is found to, and a whole one is not."""
    bare = ast.parse('def f(a, b=1):\n    """Add."""\n    return a + b\n').body[0]
    assert lacking(bare) == ["its parameters are ['a', 'b']", "no Returns", "no example"]
    assert not_annotated(bare) == ["a is not annotated", "b is not annotated", "its return is not annotated"]
    whole = '''def f(a: float, b: float = 1.0) -> float:
    """Add.

    Parameters
    ----------
    a, b : float
        What is added [m].

    Returns
    -------
    float
        Sum [m].

    Examples
    --------
    >>> f(1.0)
    2.0
    """
    return a + b
'''
    assert lacking(ast.parse(whole).body[0]) == []


@pytest.mark.parametrize("folder", FOLDERS)
def test_face_and_laws_and_what_authors_call_say_what_they_take_and_give_and_show_an_example(folder):
    shown, found = face(), {}
    for path, module in zip(files(folder), module_names(files(folder)), strict=True):
        for name, function in functions(ast.parse((ROOT / path).read_text())).items():
            faults = not_annotated(function)
            is_of_a_law = folder in LAWS and is_law(function)
            if path in AUTHORS or is_shown(f"{module}.{name}", shown) or is_of_a_law:
                faults += lacking(function)
            if faults:
                found[f"{path}: {name}"] = faults
    assert found == {}


@pytest.mark.parametrize("folder", [*FOLDERS, "tests"])
def test_no_docstring_leans_on_what_stands_elsewhere(folder):
    leaning = [
        f"{path}:{line}: {text.strip().splitlines()[0]}"
        for path in files(folder)
        for line, text in texts(ast.parse((ROOT / path).read_text()))
        if FORBIDDEN.match(text.strip())
    ]
    assert leaning == []


def module_names(paths: list[str]) -> list[str]:
    """Names under which files of the checkout are imported."""
    parts = [Path(path).with_suffix("").parts for path in paths]
    names = [".".join(each if each[0] == "apesim" else ("apesim", *each)) for each in parts]
    return [name.removesuffix(".__init__") for name in names]


def run_examples(paths: list[str], folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run the examples of some files in an interpreter of its own, but for those of the face: tests of it run them."""
    shutil.copytree(ROOT / "docs" / "examples" / "data", folder / "docs" / "examples" / "data")
    environment = os.environ | {"MPLBACKEND": "Agg"} | variables
    environment["PYTHONPATH"] = os.pathsep.join([str(ROOT), environment.get("PYTHONPATH", "")])
    code = (
        "import doctest, importlib, sys\n"
        "import apesim\n"
        "face = {getattr(apesim, name) for name in apesim.__all__ if callable(getattr(apesim, name))}\n"
        "faces = {f'{each.__module__}.{each.__qualname__}' for each in face if each.__module__.count('studies')}\n"
        "runner, finder = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE), doctest.DocTestFinder()\n"
        "for name in sys.argv[1:]:\n"
        "    for test in finder.find(importlib.import_module(name)):\n"
        "        test.name in faces or runner.run(test)\n"
        "print(runner.tries, 'examples')\n"
        "sys.exit(runner.failures > 0)\n"
    )
    command = [sys.executable, "-c", code, *module_names(paths)]
    return subprocess.run(command, cwd=folder, env=environment, text=True, capture_output=True)


def uncited(text: str) -> list[str]:
    """Numbers of a docstring that are cited without a reference, or the other way round."""
    listed = REFERENCE.findall(text)
    assert listed == [str(number) for number in range(1, len(listed) + 1)], listed
    return sorted({*CITATION.findall(text)} ^ {*listed})


def test_citations_are_read_as_they_stand():
    text = "Fall, as Galilei [1]_ and Newton [2]_ have it.\n\nReferences\n----------\n.. [1] G. Galilei, 1638.\n"
    assert uncited(text) == ["2"]
    assert uncited(text.replace(" and Newton [2]_", "")) == []


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_citation_has_its_reference(folder):
    found = {}
    for path in files(folder):
        nodes = ast.walk(ast.parse((ROOT / path).read_text()))
        named = [each for each in nodes if isinstance(each, ast.FunctionDef | ast.ClassDef)]
        found |= {f"{path}: {each.name}": uncited(ast.get_docstring(each) or "") for each in named}
    assert {name: numbers for name, numbers in found.items() if numbers} == {}


@pytest.mark.parametrize("folder", LAWS)
def test_every_equation_names_its_source(folder):
    """A law, a definition or a choice: a reader of an equation is told which, and where it is from."""
    heads = {
        f"{path}: {name}": SECTION.split(ast.get_docstring(each) or "")[0]
        for path in files(folder)
        for name, each in functions(ast.parse((ROOT / path).read_text())).items()
    }
    assert [name for name, head in heads.items() if EQUATION.search(head) and not SOURCED.search(head)] == []


@pytest.mark.plain
@pytest.mark.slow
@pytest.mark.parametrize("folder", ["apesim", "valve", "engine"])
def test_examples_of_the_layers_below_run_as_plain_python(folder, tmp_path):
    """Examples are compared with what they print where nothing is compiled."""
    ended = run_examples(files(folder), tmp_path, NUMBA_DISABLE_JIT="1", APESIM_CACHE_DIR=str(tmp_path))
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert int(ended.stdout.split()[-2]) > 0


def test_examples_of_the_studies_run(tmp_path):
    ended = run_examples(files("studies"), tmp_path)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert int(ended.stdout.split()[-2]) > 0
