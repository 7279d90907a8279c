"""What commands of the command line share: the options that every one takes, and how one is registered."""

import inspect
from pathlib import Path
from typing import Annotated, NamedTuple

import typer

from apesim.studies.console import Console

Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace what is there.")]
Figures = Annotated[bool, typer.Option(help="Draw the figures, into F.figures.")]
Traces = Annotated[Path | None, typer.Option(metavar="F", help="Write the traces as CSV.")]
Pressures = Annotated[str, typer.Option(metavar="RANGE", help="Control pressures, start:stop:step or list.")]
Temperatures = Annotated[str, typer.Option(metavar="RANGE", help="Of the control air.")]
Speeds = Annotated[str, typer.Option(metavar="R", help="Range start:stop:step, or list.")]
SupplyPressures = Annotated[str, typer.Option(metavar="R", help="Of the supply, start:stop:step or list.")]
SupplyTemperatures = Annotated[str, typer.Option(metavar="R", help="Of the supply.")]
Pulse = Annotated[str, typer.Option(metavar="TIME", help="For which the solenoids are energised.")]
Out = Annotated[Path, typer.Option(metavar="F.h5", help="Archive to write.")]
Jobs = Annotated[
    int | None, typer.Option(metavar="N", min=1, help="Processes; as many as the work is worth if left out.")
]
ArchivePath = Annotated[Path, typer.Argument(metavar="F.h5", help="Archive.")]


class Common(NamedTuple):
    """What every command is given."""

    console: Console
    machine_file: Path | None
    settings: list[str] | None


def common(
    machine_file: Annotated[
        Path | None,
        typer.Option("--machine", metavar="FILE", help="Machine file (TOML); the embedded one if left out."),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help='A key of the machine, e.g. engine.bore="90 mm". Repeatable.'),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="One JSON object on standard output, nothing else.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress and no messages on standard error.")] = False,
):
    """The options that every command takes, and what becomes of them."""
    return Common(Console(json, quiet), machine_file, settings)


COMMON = inspect.signature(common).parameters


def command(group, name=None):
    """Register a command; behind its own options it takes those of `common`.

    Parameters
    ----------
    group : typer.Typer
    name : str, optional
        The function's if left out.

    Returns
    -------
    function
        Decorator of a function of `Common` and its own options. Its docstring is the help, what it returns the exit
        code, None for 0.
    """

    def register(function):
        _, *own = inspect.signature(function).parameters.values()

        def run(**given):
            shared = {key: given.pop(key) for key in COMMON}
            return function(common(**shared), **given)

        run.__signature__ = inspect.Signature([*own, *COMMON.values()])  # type: ignore[attr-defined]
        group.command(name or function.__name__, help=inspect.getdoc(function))(run)
        return function

    return register
