"""The commands as pages: each with its synopsis and options, and the Python function that it calls."""

import ast
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from docs.extensions.markdown import escape

COMMANDS = Path(__file__).parent.parent.parent / "studies" / "commands"
TYPES = {"str": "text", "int": "whole number", "float": "number", "Path": "path"}
"""What an option takes, in words."""
IN_PLACE_OF_A_FUNCTION = {"machine": "Machine"}
"""What stands for a command in Python where that is no function."""
ONLY_COMMANDS = {"doctor"}
"""Commands that nothing stands for in Python."""
PREPARING = {"read_measured", "read_archive", "run_many"}
"""Functions that only read what a command is given; they do not stand for it."""


def groups() -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Name, description and commands of each group, in the order of `apesim --help`; first those without a group."""
    import typer

    from apesim.studies.commands.cli import app

    root: Any = typer.main.get_command(app)
    yield "", "", {name: each for name, each in root.commands.items() if not hasattr(each, "commands")}
    for name, each in root.commands.items():
        if hasattr(each, "commands"):
            yield name, each.help, {f"{name} {inner}": command for inner, command in each.commands.items()}


def python_name(command: str) -> str:
    """The name of `apesim.__all__` that a command calls, found in the command's file.

    Raises
    ------
    ValueError
        The file names none, or several.
    """
    import apesim

    if command in IN_PLACE_OF_A_FUNCTION:
        return IN_PLACE_OF_A_FUNCTION[command]
    path = COMMANDS.joinpath(*command.replace("-", "_").split()).with_suffix(".py")
    functions = {name for name in apesim.__all__ if name.islower()} - PREPARING
    called = set()
    for node in ast.walk(ast.parse(path.read_text())):
        name = getattr(node.func, "attr", getattr(node.func, "id", "")) if isinstance(node, ast.Call) else ""
        passed = node.args if isinstance(node, ast.Call) else []  # console.run("…", engine_run.run_engine, …)
        names = [name, *(getattr(each, "attr", getattr(each, "id", "")) for each in passed)]
        called |= functions.intersection(names)
    if len(called) != 1:
        raise ValueError(f"{path}: calls {sorted(called) or 'none'} of apesim.__all__, and should call one")
    return called.pop()


def label(command: str) -> str:
    """The label by which other pages refer to a command."""
    return "command-" + command.replace(" ", "-")


def write_commands() -> str:
    """Every command, with its options; those that all commands take stand once, in the head of the page."""
    from apesim.studies.commands.options import COMMON

    parts = []
    for group, about, commands in groups():
        heading = f"`apesim {group}`" if group else "Machine and paper"
        parts.append(f"## {heading}\n\n{escape(about)}".rstrip())
        parts += [_command(name, each, set(COMMON)) for name, each in commands.items()]
    return "\n\n".join(parts) + "\n"


def write_common_options() -> str:
    """The options that every command takes."""
    from apesim.studies.commands.options import COMMON

    command = next(iter(next(groups())[2].values()))
    return _table([each for each in command.params if each.name in COMMON])


def write_python_names() -> str:
    """A table of all commands and their functions."""
    rows = ["| command | from Python | it returns |", "|---|---|---|"]
    for _, _, commands in groups():
        for command in (each for each in commands if each not in ONLY_COMMANDS):
            name = python_name(command)
            role = "py:func" if name.islower() else "py:class"
            rows.append(f"| [`apesim {command}`](#{label(command)}) | {{{role}}}`apesim.{name}` | {_returned(name)} |")
    return "\n".join(rows) + "\n"


def _returned(name: str) -> str:
    """The class of what a function returns, linked where it is ours."""
    import apesim

    if not name.islower():
        return "itself"
    found = typing.get_type_hints(getattr(apesim, name))["return"]
    if getattr(found, "__module__", "").startswith("apesim"):
        return f"{{py:class}}`~{found.__module__}.{found.__qualname__}`"
    if found is type(None):
        return "nothing"
    return "paths of the files"


def _command(name: str, command: Any, shared: set[str]) -> str:
    """Heading, help, synopsis, options and function of a command."""
    own = [each for each in command.params if each.name not in shared]
    shared_options = "the [options of every command](#command-options)."
    from_python = f"It has no function in Python. It takes {shared_options}"
    if name not in ONLY_COMMANDS:
        python = python_name(name)
        role = "py:func" if python.islower() else "py:class"
        from_python = f"From Python: {{{role}}}`apesim.{python}`. It takes {shared_options}"
    parts = [
        f"({label(name)})=\n\n### `apesim {name}`",
        *(escape(paragraph) for paragraph in command.help.split("\n\n")),
        f"```text\n{_synopsis(name, own)}\n```",
        _table(own) if own else "It has no options of its own.",
        from_python,
    ]
    return "\n\n".join(parts)


def _synopsis(name: str, parameters: list[Any]) -> str:
    """The form of a call: what may be left out stands in brackets."""
    words = []
    for each in parameters:
        if each.param_type_name == "argument":
            form = _metavar(each)
        else:
            form = each.opts[0] if each.is_flag else f"{each.opts[0]} {_metavar(each)}"
            form += " ..." * bool(each.multiple)
        words.append(form if each.required else f"[{form}]")
    lines, line = [], f"apesim {name}"
    for word in words:
        if len(line) + len(word) > 95:
            lines.append(line)
            line = "   "
        line += f" {word}"
    return "\n".join([*lines, line])


def _table(parameters: list[Any]) -> str:
    """A row for each option or argument: type, default and help."""
    rows = ["| option | takes | default | meaning |", "|---|---|---|---|"]
    for each in parameters:
        if each.param_type_name == "argument":
            names = _code(_metavar(each))
        else:
            names = ", ".join(f"`{name}`" for name in (*each.opts, *each.secondary_opts))
            names += "" if each.is_flag else f" {_code(_metavar(each))}"
        rows.append(f"| {names} | {_type(each)} | {_default(each)} | {escape(each.help or '')} |")
    return ":::{div} options\n\n" + "\n".join(rows) + "\n\n:::"


def _metavar(parameter: Any) -> str:
    return parameter.metavar or parameter.name.upper()


def _type(parameter: Any) -> str:
    """What an option takes, with its bound and whether it may be repeated."""
    if getattr(parameter, "is_flag", False):
        return "switch"
    annotation = parameter.type_descriptor.annotation
    single = (*typing.get_args(annotation), annotation)[0]  # list[Path] takes paths
    word = TYPES[single.__name__]
    if parameter.min is not None:
        word += f", at least {parameter.min:g}"
    many = getattr(parameter, "multiple", False) or parameter.nargs != 1
    return word + ", one or more" * many


def _default(parameter: Any) -> str:
    if parameter.required:
        return "required"
    value = parameter.default() if callable(parameter.default) else parameter.default
    if getattr(parameter, "is_flag", False):
        chosen = parameter.opts if value else parameter.secondary_opts
        return f"`{chosen[0]}`" if chosen else "off"
    return "not given" if value in (None, (), []) else f"`{value}`"


def _code(text: str) -> str:
    r"""A text as code within a table, where a bar would end the cell."""
    return "`" + text.replace("|", r"\|") + "`"
