"""Command `apesim machine`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.options import Common


def print_machine(
    common: Common,
    check: Annotated[Path | None, typer.Option("--check", metavar="FILE", help="Check a machine file.")] = None,
) -> None:
    """Print the machine, every key commented; or check a machine file.

    Parameters
    ----------
    common : Common
        Console and machine of the command line.
    check : path, optional
        Machine file to check instead.

    Raises
    ------
    InputError
        The machine or the file to check cannot be used.

    Examples
    --------
    >>> from typer.testing import CliRunner
    >>> from apesim.studies.cli import app
    >>> text = CliRunner().invoke(app, ["machine", "--set", "engine.bore=90 mm"]).stdout
    >>> next(line.split("#")[0].strip() for line in text.splitlines() if line.startswith("bore"))
    'bore = "90 mm"'
    """
    if check:
        _check_file(common, check)
        return
    text = common.load_machine().to_toml()
    common.console.result({"machine": text}, text.rstrip())


def _check_file(common: Common, path: Path) -> None:
    """Say whether a machine file is right, and which of its keys have no effect because of others."""
    ignored = common._replace(machine_file=path).load_machine().find_ignored_keys()
    lines = (f"{path}: {key}: is ignored: {reason}" for key, reason in ignored.items())
    common.console.result({"file": str(path), "good": True, "ignored": ignored}, *lines, f"{path}: good")
