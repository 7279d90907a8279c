"""Everything is annotated: parameters and return of every function of the layers."""

import ast
from collections.abc import Iterator

import pytest

from tests.folders import ROOT

FOLDERS = "apesim", "valve", "engine", "studies"


def functions(node: ast.AST) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    """All functions below a node, but for overloads of Numba, whose parameters it compares with those of their body."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            if any(ast.unparse(each).startswith("overload(") for each in child.decorator_list):
                continue
            yield child
        yield from functions(child)


def lacking(function: ast.FunctionDef | ast.AsyncFunctionDef) -> list[str]:
    """What a function lacks: names of parameters, and "return"."""
    given = function.args
    every = [*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg]
    found = [each.arg for each in every if each and each.annotation is None and each.arg not in ("self", "cls")]
    return found + ["return"] * (function.returns is None)


def test_what_lacks_an_annotation_is_found():
    text = "def f(a, *b: int) -> int:\n    def g(c: int):\n        return c\n    return g\n"
    assert [lacking(each) for each in functions(ast.parse(text))] == [["a"], ["return"]]
    assert list(functions(ast.parse("@overload(f)\ndef g(a):\n    def h(a):\n        return a\n    return h\n"))) == []


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_function_is_annotated(folder):
    found = [
        f"{path.relative_to(ROOT)}:{each.lineno} {each.name}: {', '.join(lacking(each))}"
        for path in sorted((ROOT / folder).rglob("*.py"))
        for each in functions(ast.parse(path.read_text(encoding="utf-8")))
        if lacking(each)
    ]
    assert found == []
