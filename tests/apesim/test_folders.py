"""The docstring of a folder's ``__init__`` names its files."""

import ast
import re

import pytest

from tests.folders import ROOT

FOLDERS = sorted(
    path for layer in ("apesim", "valve", "engine", "studies") for path in (ROOT / layer).rglob("__init__.py")
)


def names_of(folder):
    """Files and folders of a folder, as they are imported."""
    files = {path.stem for path in folder.glob("*.py")} - {"__init__"}
    return files | {path.parent.name for path in folder.glob("*/__init__.py")}


def names_in(text):
    """Words of a docstring, and what the code below it imports: a list by hand, such as that of the effects."""
    tree = ast.parse(text)
    words = set(re.findall(r"\w+", ast.get_docstring(tree) or ""))
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            words |= {alias.name for alias in node.names} | set((node.module or "").split("."))
    return words


@pytest.mark.parametrize("path", FOLDERS, ids=lambda path: path.parent.relative_to(ROOT).as_posix())
def test_a_folder_names_its_files(path):
    assert sorted(names_of(path.parent) - names_in(path.read_text(encoding="utf-8"))) == []
