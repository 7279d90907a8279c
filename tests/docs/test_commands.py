"""Every command that README and pages print is one that apesim takes: its name, its options, its arguments."""

import re
import shlex
from itertools import takewhile

import pytest
import typer
from typer.core import TyperGroup

from apesim.studies.commands.cli import app
from tests.folders import ROOT

UsageError = typer.BadParameter.__base__
BLOCK = re.compile(r"^```(?:sh|shell|bash|console)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def commands_of(text):
    """Argument lists of the lines that call apesim, in blocks of shell; lines that end in a backslash go on."""
    for block in BLOCK.findall(text):
        for line in block.replace("\\\n", " ").splitlines():
            words = shlex.split(line, comments=True)
            while "apesim" in words:
                words = words[words.index("apesim") + 1 :]
                yield list(takewhile(lambda word: word not in (">", "|", "&&", ";"), words))


def parse(words):
    """Take words as the command line does, up to where the command would run.

    Raises
    ------
    UsageError
        No such command, option or argument, or one that is missing.
    """
    command, context, name, rest = typer.main.get_command(app), None, "apesim", list(words)
    while isinstance(command, TyperGroup):
        context = command.context_class(command, parent=context, info_name=name)
        name, command, rest = command.resolve_command(context, rest)
    command.make_context(name, rest, parent=context)


def pages():
    return sorted([ROOT / "README.md", *(ROOT / "docs").rglob("*.md")])


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_that_are_printed_are_taken(page):
    for words in commands_of(page.read_text(encoding="utf-8")):
        try:
            parse(words)
        except typer.Exit:  # of options that end the program at once, such as --version
            continue
        except UsageError as error:
            pytest.fail(f"apesim {shlex.join(words)}: {error.format_message()}")


def test_commands_are_found_in_the_readme():
    assert len(list(commands_of((ROOT / "README.md").read_text(encoding="utf-8")))) >= 10


@pytest.mark.parametrize("line", ["engine walk", "engine run --sped 3", "archive info", "engine run surplus"])
def test_what_apesim_does_not_take_is_noticed(line):
    with pytest.raises(UsageError):
        parse(line.split())
