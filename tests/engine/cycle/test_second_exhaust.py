"""The list of what a second exhaust valve would touch names every file whose code knows of an exhaust."""

import ast
import re

from tests.folders import ROOT

LAYERS = "apesim", "valve", "engine", "studies"


def is_docstring(node):
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def knows_of(word, path):
    """Whether a word stands in the code of a file, not only in its docstrings and comments."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(getattr(node, "body", None), list):
            node.body = [each for each in node.body if not is_docstring(each)] or [ast.Pass()]
    return word in ast.unparse(tree).lower()


def test_every_file_that_knows_of_an_exhaust_is_in_the_list():
    text = ast.get_docstring(ast.parse((ROOT / "engine" / "cycle" / "__init__.py").read_text(encoding="utf-8")))
    named = set(re.findall(r"\w+", text))
    files = [path for layer in LAYERS for path in (ROOT / layer).rglob("*.py")]
    found = {path for path in files if path.stem != "__init__" and knows_of("exhaust", path)}
    assert sorted(path.relative_to(ROOT).as_posix() for path in found if path.stem not in named) == []
    assert len(found) > 15


def test_what_the_list_names_is_there():
    text = (ROOT / "engine" / "cycle" / "__init__.py").read_text(encoding="utf-8").partition("A second exhaust")[2]
    stems = {path.stem for layer in LAYERS for path in (ROOT / layer).rglob("*")}
    code = {each.split(".")[-1] if each.islower() else each for each in re.findall(r"`([\w.]+)`", text)}
    source = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "engine").rglob("*.py"))
    assert [
        each for each in sorted(code) if each.split(".")[-1] not in stems and each.split(".")[-1] not in source
    ] == []
