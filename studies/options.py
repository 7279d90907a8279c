"""Options that commands share, and how a command is registered."""

import contextlib
import inspect
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from apesim.studies.console import COMMAND_LINE, Console

if TYPE_CHECKING:
    from apesim.engine.machine import Machine

Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace what is there.")]
Figures = Annotated[bool, typer.Option(help="Draw the figures, into F.figures.")]
Traces = Annotated[Path | None, typer.Option(metavar="F", help="Write the traces as CSV.")]
Pressures = Annotated[str, typer.Option(metavar="RANGE", help="Control pressures: start:stop:step, or a list.")]
Temperatures = Annotated[
    str, typer.Option(metavar="RANGE", help="Temperatures of the control air: start:stop:step, or a list.")
]
Speeds = Annotated[str, typer.Option(metavar="R", help="Speeds: start:stop:step, or a list.")]
SupplyPressures = Annotated[str, typer.Option(metavar="R", help="Supply pressures: start:stop:step, or a list.")]
SupplyTemperatures = Annotated[str, typer.Option(metavar="R", help="Supply temperatures: start:stop:step, or a list.")]
Pulse = Annotated[str, typer.Option(metavar="TIME", help="Time for which the solenoids are energised.")]
Out = Annotated[Path, typer.Option(metavar="F.h5", help="Archive to write.")]
Jobs = Annotated[
    int | None, typer.Option(metavar="N", min=1, help="Processes; as many as the work is worth if left out.")
]
ArchivePath = Annotated[Path, typer.Argument(metavar="F.h5", help="Archive.")]
MeasuredFolder = Annotated[Path, typer.Argument(metavar="DIR", help="Measured data: a folder with a measured.toml.")]
Without = Annotated[
    list[str] | None, typer.Option(metavar="EFFECT", help="Leave an effect of the library out. Repeatable.")
]


EFFECT_FILES = "effects.files"
"""Setting that names one effect file more, see `apesim.engine.outside_machine.load_machine`."""


class Common(NamedTuple):
    """What every command is given: where it shows its results, and its machine."""

    console: Console
    machine_file: Path | None = None
    settings: Sequence[str] | None = None

    def load_machine(self) -> "Machine":
        """Read the machine that the command line describes.

        Returns
        -------
        Machine
            The machine of the file, or the embedded one, with all settings made.

        Raises
        ------
        InputError
            The file or a setting is invalid; the error names every fault.
        """
        from apesim.engine.machine import Machine

        return Machine.load(self.machine_file, self.settings or ())


def common(
    machine_file: Annotated[
        Path | None,
        typer.Option("--machine", metavar="FILE", help="Machine file (TOML); the embedded one if left out."),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help='A key of the machine, e.g. engine.bore="90 mm". Repeatable.'),
    ] = None,
    effect_files: Annotated[
        list[Path] | None,
        typer.Option(
            "--effect-file", metavar="F", help="Python file with an effect of your own; its code runs. Repeatable."
        ),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="One JSON object on standard output, nothing else.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress and no messages on standard error.")] = False,
) -> Common:
    """The options that every command takes, and what becomes of them."""
    named = [f"{EFFECT_FILES}={path}" for path in effect_files or ()]
    return Common(Console(json, quiet), machine_file, [*named, *(settings or ())] if named else settings)


@contextlib.contextmanager
def as_options(function: str, **names: str) -> Iterator[None]:
    """Name options of the command line in the faults that a public function finds in its arguments.

    A context manager: an `InputError` raised inside it is raised again, its faults in the words of the command line.

    Parameters
    ----------
    function : str
        Name of the public function, e.g. "sweep".
    **names : str
        Option of an argument, where it is not ``--`` and the argument's name.

    Raises
    ------
    InputError
        The public function raised one.
    """
    from apesim.quantities import Fault, InputError

    def as_option(fault: Fault) -> Fault:
        if fault.file != f"{function}()":
            return fault
        wrong, right = (re.sub(r"`(\w+)`", r"--\1", text) for text in fault[2:])
        is_key = "." in fault.key  # of the machine
        return Fault(COMMAND_LINE, fault.key if is_key else names.get(fault.key, f"--{fault.key}"), wrong, right)

    try:
        yield
    except InputError as error:
        raise InputError([as_option(fault) for fault in error.faults]) from None


COMMON = inspect.signature(common).parameters


def group(about: str, commands: dict[str, Callable]) -> typer.Typer:
    """A group of the command line, such as ``apesim valve``.

    Parameters
    ----------
    about : str
        Help text of the group.
    commands : dict of str to function
        Functions of the commands by their names on the command line, see `register`.

    Returns
    -------
    typer.Typer
        The group; without a command it shows its help.
    """
    app = typer.Typer(no_args_is_help=True, help=about)
    for name, function in commands.items():
        register(app, name, function)
    return app


def register(app: typer.Typer, name: str, function: Callable) -> None:
    """Register a command; behind its own options it takes those of `common`.

    Parameters
    ----------
    app : typer.Typer
        Group that the command is added to.
    name : str
        Name of the command on the command line.
    function : function
        Takes `Common`, and its own options by keyword. Its docstring is the help, what it returns the exit code, None
        for 0. It imports what it computes with itself, so that ``--help`` answers at once.
    """
    _, *own = inspect.signature(function).parameters.values()

    def run(**given):
        shared = {key: given.pop(key) for key in COMMON}
        return function(common(**shared), **given)

    run.__signature__ = inspect.Signature([*own, *COMMON.values()])  # type: ignore[attr-defined]
    app.command(name, help=inspect.getdoc(function))(run)
