"""What a command prints on standard output, for the text of the documentation."""

import contextlib
import io
import os
import re
import sys
import tempfile
import textwrap
from collections.abc import Iterator
from pathlib import Path

from docs.results import Text

WIDTH = 104
"""Characters of a line, those of the widest table; a terminal breaks longer lines, too."""
_WALL_TIME = re.compile(r"(?<=[;n] )[\d.]+ m?s\b")
_DIGEST = re.compile(r"\b[0-9a-f]{64}\b")


@contextlib.contextmanager
def _captured() -> Iterator[tuple[io.StringIO, io.StringIO]]:
    out, error = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
        yield out, error


def session(*lines: str) -> Text:
    """Show what Python answers to lines of input, one after the other.

    Parameters
    ----------
    *lines : str
        Statements and expressions, each on a line.

    Returns
    -------
    Text
        The lines behind the prompt, each expression with its value below.
    """
    names: dict[str, object] = {}
    shown = []
    for line in lines:
        shown.append(f">>> {line}")
        try:
            value = eval(line, names)
        except SyntaxError:
            exec(line, names)
            continue
        if value is not None:
            shown.append(repr(value))
    return Text("\n".join(shown))


def run(*arguments: str, ending: int = 0) -> Text:
    """Run a command in an empty folder, and return what it printed; what differs from run to run is an ellipsis.

    Parameters
    ----------
    *arguments : str
        What stands behind `apesim` on the command line.
    ending : int
        Exit code that is expected.

    Returns
    -------
    Text
        Standard output; standard error where the command is expected to fail.

    Raises
    ------
    RuntimeError
        The exit code is another.
    """
    from apesim.studies.commands.cli import app
    from apesim.studies.terminal.console import main_of

    before, argv = Path.cwd(), sys.argv
    with tempfile.TemporaryDirectory() as folder, _captured() as (out, error):
        try:
            os.chdir(folder)
            sys.argv = ["apesim", *arguments]
            code = main_of(app)
        finally:
            os.chdir(before)
            sys.argv = argv
    if code != ending:
        raise RuntimeError(f"apesim {' '.join(arguments)} ended with {code}: {error.getvalue()}")
    printed = (error if ending else out).getvalue().splitlines()
    lines = (part for line in printed for part in textwrap.wrap(line, WIDTH, drop_whitespace=False) or [""])
    return Text(_DIGEST.sub("…", _WALL_TIME.sub("… s", "\n".join(line.rstrip() for line in lines))).strip("\n"))
