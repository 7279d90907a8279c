"""Command `apesim machine`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from apesim.studies.commands.options import Common, FigureFile, Overwrite
from apesim.studies.terminal.console import COMMAND_LINE

if TYPE_CHECKING:
    from apesim.engine.proportions import Unscaled


def print_machine(
    common: Common,
    check: Annotated[Path | None, typer.Option("--check", metavar="FILE", help="Check a machine file.")] = None,
    short: Annotated[
        bool, typer.Option("--short", help="Only the fifteen keys to fill in first, and what is not the default's.")
    ] = False,
    figure: FigureFile = None,
    overwrite: Overwrite = False,
) -> None:
    """Print the machine, every key commented; or draw it to scale; or check a machine file.

    The check also names keys that have no effect, and numbers that are still the default machine's beside a size that
    is not: the mass of a valve whose stroke was changed.

    Examples
    --------
    >>> from typer.testing import CliRunner
    >>> from apesim.studies.commands.cli import app
    >>> text = CliRunner().invoke(app, ["machine", "--set", "engine.bore=90 mm"]).stdout
    >>> next(line.split("#")[0].strip() for line in text.splitlines() if line.startswith("bore"))
    'bore = "90 mm"'
    """
    asked = [name for name, is_given in (("--short", short), ("--figure", figure), ("--check", check)) if is_given]
    if len(asked) > 1:
        from apesim.quantities import Fault, InputError

        raise InputError([Fault(COMMAND_LINE, asked[0], f"stands beside {asked[1]}", "give one of them")])
    if check:
        _check_file(common, check)
        return
    if figure is not None:
        from apesim.studies.drawing.machine import write_machine_figure

        write_machine_figure(common.load_machine(), figure, overwrite=overwrite)
        common.console.result({"figure": str(figure)}, f"{figure}: written")
        return
    text = common.load_machine().to_toml("first" if short else "all")
    common.console.result({"machine": text}, text.rstrip())


def _check_file(common: Common, path: Path) -> None:
    """Say whether a machine file is right, which of its keys have no effect, and which numbers were not scaled."""
    machine = common._replace(machine_file=path).load_machine()
    ignored, unscaled = machine.find_ignored_keys(), machine.find_unscaled_keys()
    lines = [f"{path}: {key}: is ignored: {reason}" for key, reason in ignored.items()]
    # One hint for each section that was changed, so that a size that several numbers belong to is named once.
    by_section: dict[str, list[Unscaled]] = {}
    for row in unscaled:
        by_section.setdefault(row.changed[0].split(".")[0], []).append(row)
    for rows in by_section.values():
        changed = ", ".join(dict.fromkeys(key for row in rows for key in row.changed))
        lines.append(f"{path}: hint: changed: {changed}; still the default machine's, though they belong to it:")
        width = max(len(f"{row.key} = {row.value}") for row in rows)
        lines += [f"  {f'{row.key} = {row.value}':{width}}  ({row.reason})" for row in rows]
    hints = [row._asdict() for row in unscaled]
    good = {"file": str(path), "good": True, "ignored": ignored, "hints": hints}
    common.console.result(good, *lines, f"{path}: good")
