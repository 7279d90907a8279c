"""What holds the documentation together, without building it: names, commands, links and numbers are there."""

import inspect
import re
import subprocess
import sys
import typing

import pytest

import apesim
from tests.folders import ROOT

DOCS = ROOT / "docs"
pytestmark = pytest.mark.skipif(not (DOCS / "conf.py").exists(), reason="the documentation is in a checkout only")

NO_PAGES = {"examples", "extensions", "generated", "results", "templates", "static", "gallery"}
"""Folders of docs that hold no pages of their own."""
AUTOSUMMARY = re.compile(r"^   ~?([\w.]+)$", re.MULTILINE)
"""A name in a list of the reference."""
TOCTREE = re.compile(r"^```\{toctree\}\n(.*?)^```", re.MULTILINE | re.DOTALL)
RESULT = re.compile(r"\{(?:val|num)\}`([^`]+)`|^```\{result-table\} (\S+)", re.MULTILINE)
FILE = re.compile(r"\btests/[\w./-]*\w")
"""A file or folder of the tests that a text names."""
WORKPLACE = re.compile(r"\b(sessions?|worktrees?|sub-?agents?)\b|\bshared/|/work/|/tmp/", re.IGNORECASE)
"""Words of the place where something was written, which no reader has."""


def pages():
    """Pages of the site that somebody wrote, by their path from docs."""
    if not DOCS.exists():
        return {}
    found = {path.relative_to(DOCS): path.read_text(encoding="utf-8") for path in DOCS.rglob("*.md")}
    return {
        path: text for path, text in found.items() if not NO_PAGES & set(path.parts) and "generated" not in str(path)
    }


def texts():
    """Pages and the texts at the top level of the checkout, by name."""
    top = {path.name: path.read_text(encoding="utf-8") for path in ROOT.glob("*.md")}
    return top | {f"docs/{path}": text for path, text in pages().items()}


def listed():
    """Names in the lists of the reference, without the package."""
    return {name.removeprefix("apesim.") for name in AUTOSUMMARY.findall((DOCS / "reference" / "index.md").read_text())}


def commands():
    """Every command, from what is registered."""
    from apesim.studies.commands.cli import app

    found = [each.name for each in app.registered_commands]
    for group in app.registered_groups:
        found += [f"{group.name} {each.name}" for each in group.typer_instance.registered_commands]
    return found


# --- the reference ---


def test_every_public_name_stands_in_the_reference():
    assert set(apesim.__all__) - listed() == set()


def test_the_class_of_what_each_function_returns_stands_in_the_reference():
    functions = [getattr(apesim, name) for name in apesim.__all__ if inspect.isfunction(getattr(apesim, name))]
    returned = {typing.get_type_hints(function)["return"] for function in functions}
    classes = {cls for cls in returned if cls.__module__.startswith("apesim")}
    assert len(classes) > 15
    names = {f"{cls.__module__}.{cls.__qualname__}".removeprefix("apesim.") for cls in classes}
    assert names - listed() == set()


def test_every_module_of_the_laws_is_there_and_every_law_has_its_module_there():
    """Modules that hold physics or numerics; what reads and writes files, and single effects, stand elsewhere."""
    import importlib

    named = set(AUTOSUMMARY.findall((DOCS / "reference" / "laws.md").read_text()))
    for name in named:
        importlib.import_module(name)
    folders = {
        "apesim.valve": ROOT / "valve",
        "apesim.engine": ROOT / "engine",
        "apesim.march": ROOT / "apesim" / "march",
    }
    there = {f"{package}.{path.stem}" for package, folder in folders.items() for path in folder.glob("*.py")}
    of_machine_files = {"engine.machine", "engine.stated_uncertainties", "engine.first_keys", "engine.proportions"}
    elsewhere = of_machine_files | {"engine.outside_machine", "engine.effect_trial"}
    missing = {name for name in there - named if not name.endswith("__init__")}
    assert missing == {f"apesim.{name}" for name in elsewhere}


def test_every_effect_of_the_library_has_its_law_in_the_reference():
    from apesim.engine.effects import ALL_EFFECTS
    from docs.extensions.generated import write_effect_laws

    assert "```{include} ../generated/effect_laws.md" in (DOCS / "reference" / "effect_laws.md").read_text()
    assert AUTOSUMMARY.findall(write_effect_laws()) == [effect.parameters.__module__ for effect in ALL_EFFECTS]


# --- commands ---


def test_every_command_has_a_heading_on_the_page_of_commands():
    from docs.extensions.commands import write_commands

    assert "```{include} ../generated/commands.md" in (DOCS / "guide" / "commands.md").read_text()
    headings = re.findall(r"^### `apesim (.+)`$", write_commands(), re.MULTILINE)
    assert sorted(headings) == sorted(commands())
    assert len(headings) > 20


def test_every_command_has_its_function_in_the_table_and_every_function_its_command():
    from docs.extensions.commands import ONLY_COMMANDS, write_python_names

    assert "```{include} ../generated/python_names.md" in (DOCS / "guide" / "python.md").read_text()
    rows = [line for line in write_python_names().splitlines() if line.startswith("| [")]
    assert [re.search(r"`apesim ([^`]+)`", row)[1] for row in rows] == [
        name
        for group in ("", "valve", "engine", "fmu", "archive", "gap", "measured")
        for name in commands()
        if in_group(name, group) and name not in ONLY_COMMANDS
    ]
    functions = {name for name in apesim.__all__ if inspect.isfunction(getattr(apesim, name))}
    without = {"read_archive", "read_measured", "run_many"}  # they read what a command is given, or take machines
    assert functions - {re.search(r"`apesim\.(\w+)`", row)[1] for row in rows} == without


def in_group(command, group):
    """Whether a command belongs to a group; "": to none."""
    return command.startswith(f"{group} ") if group else " " not in command


# --- the machine file ---


def test_every_key_of_the_machine_file_stands_in_its_tables():
    from apesim.quantities.trees import schema, spellings
    from docs.extensions.machine_keys import write_machine_keys

    section, found = "", set()
    for line in write_machine_keys().splitlines():
        if heading := re.match(r"### `\[(.+)\]`", line):
            section = heading[1]
        elif row := re.match(r"\| `([\w.]+)` \|", line):
            found.add(f"{section}.{row[1]}")
    keys = {leaf.key for leaf in schema(apesim.Machine) if not leaf.declaration.is_table}
    assert found == keys | set(spellings(apesim.Machine))


# --- pages ---


def test_every_page_is_in_a_table_of_contents():
    entries = set()
    for path, text in pages().items():
        for block in TOCTREE.findall(text):
            lines = [line.strip() for line in block.splitlines() if line.strip() and not line.startswith(":")]
            entries |= {(path.parent / line.rpartition("<")[2].rstrip(">")).as_posix() for line in lines}
    found = {path.with_suffix("").as_posix() for path in pages()}
    assert len(found) > 30
    assert found - entries == {"index"}
    assert {entry for entry in entries - found if not entry.startswith("gallery/")} == set()


@pytest.mark.parametrize("name", sorted(texts()))
def test_every_file_of_the_tests_that_a_text_names_exists(name):
    assert [path for path in FILE.findall(texts()[name]) if not (ROOT / path).exists()] == []


def test_every_number_that_a_page_quotes_was_computed():
    from docs import results

    wanted = {key for text in pages().values() for pair in RESULT.findall(text) for key in pair if key}
    wanted -= {"NAME.key"}  # how it is written
    assert len(wanted) > 10
    stored = {f"{name}.{key}" for name in results.names() for key in results.load(name).values}
    assert wanted - stored == set()


@pytest.mark.parametrize("name", sorted(texts()))
def test_no_text_speaks_of_the_place_where_it_was_written(name):
    assert [found[0] for found in WORKPLACE.finditer(texts()[name])] == []


# --- what the extensions write ---


def test_the_citation_on_the_first_page_is_that_of_the_file():
    from docs.extensions.citation import FILE, write_citation

    text, file = write_citation(), FILE.read_text(encoding="utf-8")
    assert "```{include} generated/citation.md" in (DOCS / "index.md").read_text()
    version, doi = (re.search(rf"^ *{key}: *(\S+)", file, re.MULTILINE)[1] for key in ("version", "doi"))
    assert f"version = {{{version}}}" in text and f"version {version}" in text
    assert text.count(doi) == 3
    assert text.count("{") == text.count("}")


def test_every_section_of_a_machine_is_described():
    """They stand in the base class of what users call."""
    code = (
        "from apesim.engine import machine\nfrom docs.extensions.reference import _keep_declarations as keep\n"
        "keep(machine.Sections), keep(machine.Machine)\n"
        "print(all(machine.Machine.declared_texts.get(name) for name in machine.Machine._fields))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert run.stdout.strip() == "True"


def test_a_text_that_describes_several_constants_is_said_once():
    from docs.extensions.reference import describe_once

    def described(name):
        lines = ["Its text.", ""]
        describe_once(None, "data", f"apesim.{name}", None, None, lines)
        return lines[0]

    assert described("restriction.SHUT") == "Its text."
    assert {described(f"restriction.{name}") for name in ("NEAR", "CHOKED")} == {
        "See :py:data:`~apesim.restriction.SHUT`."
    }
    assert described("valve.terms.BRANCH") == described("valve.terms.DRY") == "Its text."


def test_the_small_picture_of_an_example_has_words_for_those_who_do_not_see_it():
    from types import SimpleNamespace

    from docutils import nodes
    from docutils.utils import new_document

    from docs.extensions.gallery import describe_thumbnails

    page, title = new_document(""), nodes.title(text="A first run")
    page += nodes.image(uri="/gallery/images/thumb/sphx_glr_first_run_thumb.png", alt="")
    page += nodes.image(uri="/gallery/images/sphx_glr_first_run_001.png", alt="")
    describe_thumbnails(
        SimpleNamespace(env=SimpleNamespace(titles={"gallery/first_run": title})), page, "gallery/index"
    )
    assert [image["alt"] for image in page.findall(nodes.image)] == ["Figure of the example: A first run", ""]
