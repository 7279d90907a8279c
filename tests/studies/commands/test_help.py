"""The help of every command is the text before the sections of its docstring, in which Python's users read on."""

import pytest
import typer
from typer.testing import CliRunner

from apesim.studies.commands.cli import app
from apesim.studies.commands.options import help_of

LIMIT = """\
Usage: apesim engine limit [OPTIONS]

  The highest speed at which the valve opens and closes at its targets, with complete strokes.

  For the machine's own supply and targets, and over a grid; with the time from lap to lap that decides
  it.

Options:
  --pressure R"""
"""Beginning of the help of `apesim engine limit`."""


def commands(group, *path):
    """Names of all commands below a group, each as a tuple."""
    for name, command in group.commands.items():
        yield from commands(command, *path, name) if hasattr(command, "commands") else [(*path, name)]


def shown(*path):
    """Help of a command, on a terminal of 105 columns."""
    return CliRunner().invoke(app, [*path, "--help"], prog_name="apesim", terminal_width=105).output


def test_the_help_of_a_command_is_what_its_users_know():
    assert shown("engine", "limit").startswith(LIMIT)


@pytest.mark.parametrize("path", list(commands(typer.main.get_command(app))), ids=" ".join)
def test_no_section_of_a_docstring_stands_in_a_help(path):
    text = shown(*path)
    assert "Options:" in text
    for section in ("Parameters", "Returns", "Raises", "Examples", "----\n", ">>>"):
        assert section not in text


def test_a_docstring_without_sections_is_its_help_as_a_whole():
    def command():
        """Do it.

        At once.
        """

    assert help_of(command) == "Do it.\n\nAt once."
    assert help_of(lambda: None) == ""


@pytest.mark.parametrize("group", ["valve", "engine", "archive", "gap"])
def test_a_list_of_commands_shows_their_whole_summaries(group):
    """Typer would cut them at a full stop, as of "Eq.", or at the end of the line."""
    listed = "".join(shown(group).split())
    for command in typer.main.get_command(app).commands[group].commands.values():
        assert command.short_help.endswith(".") and "".join(command.short_help.split()) in listed
