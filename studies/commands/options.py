"""Options that commands share, and how a command is registered."""

import contextlib
import inspect
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from apesim.studies.terminal.console import COMMAND_LINE, Console

if TYPE_CHECKING:
    from apesim.engine.machine import Machine

Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace what is there.")]
Figures = Annotated[bool, typer.Option(help="Draw the figures, into F.figures.")]
FigureFile = Annotated[
    Path | None, typer.Option("--figure", metavar="FILE", help="Draw the machine to scale: a .png, .svg or .pdf.")
]
FigureFolder = Annotated[Path | None, typer.Option(metavar="DIR", help="Draw the figures into this folder.")]
Traces = Annotated[Path | None, typer.Option(metavar="F", help="Write the traces as CSV.")]
Pressures = Annotated[str, typer.Option(metavar="RANGE", help="Control pressures: start:stop:step, or a list.")]
Temperatures = Annotated[
    str, typer.Option(metavar="RANGE", help="Temperatures of the control air: start:stop:step, or a list.")
]
Speeds = Annotated[str, typer.Option(metavar="R", help="Speeds: start:stop:step, or a list.")]
SupplyPressures = Annotated[
    str | None,
    typer.Option(metavar="R", help="Supply pressures; if left out, 0.6, 1 and 1.4 times the machine's own gauge one."),
]
ControlPressures = Annotated[
    str | None,
    typer.Option(metavar="R", help="Control pressures, varied at one supply pressure; else as the machine has it."),
]
SupplyTemperatures = Annotated[
    str | None, typer.Option(metavar="R", help="Supply temperatures; 250 K, the machine's own and 322 K if left out.")
]
Pulse = Annotated[str, typer.Option(metavar="TIME", help="Time for which the solenoids are energised.")]
Out = Annotated[Path, typer.Option(metavar="F.h5", help="Archive to write.")]
FmuFile = Annotated[Path, typer.Option("--out", "-o", metavar="F.fmu", help="FMU to write.")]
FmiVersion = Annotated[int, typer.Option("--fmi", metavar="2|3", help="Version of the standard FMI.")]
Jobs = Annotated[
    int | None, typer.Option(metavar="N", min=1, help="Processes; as many as the work is worth if left out.")
]
Report = Annotated[
    Path | None, typer.Option("--report", metavar="F.html", help="Also write the results as a page, see apesim report.")
]
ArchivePath = Annotated[Path, typer.Argument(metavar="F.h5", help="Archive.")]
MeasuredFolder = Annotated[Path, typer.Argument(metavar="DIR", help="Measured data: a folder with a measured.toml.")]
Without = Annotated[
    list[str] | None, typer.Option(metavar="EFFECT", help="Leave an effect out, or a number by its key. Repeatable.")
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

        Examples
        --------
        >>> Common(Console(), settings=["engine.bore=90 mm"]).load_machine().engine.bore
        0.09
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
    """The options that every command takes, and what becomes of them.

    Parameters
    ----------
    machine_file : path, optional
        Machine file (TOML); the embedded one if left out.
    settings : list of str, optional
        Keys of the machine, each ``key=value``.
    effect_files : list of path, optional
        Python files with effects from outside; they become settings, before the others.
    json : bool
        One JSON object on standard output, nothing else.
    quiet : bool
        No progress and no messages on standard error.

    Returns
    -------
    Common
        Console and machine of the command line.

    Examples
    --------
    >>> common(settings=["engine.bore=90 mm"], effect_files=[Path("seal.py")]).settings
    ['effects.files=seal.py', 'engine.bore=90 mm']
    """
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

    Yields
    ------
    None
        A context in which the public function is called.

    Raises
    ------
    InputError
        The public function raised one.

    Examples
    --------
    >>> from apesim.quantities import Fault, InputError
    >>> try:
    ...     with as_options("optimise_commands", goal="--for"):
    ...         raise InputError([Fault("optimise_commands()", "goal", "is no goal", "write torque")])
    ... except InputError as error:
    ...     print(error)
    command line: --for: is no goal; write torque
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
"""Options of `common`, by name."""
SECTION = re.compile(r"^\w[\w ]*\n-+$", re.MULTILINE)
"""Head of a section of a docstring: a name, underlined."""


def group(about: str, commands: dict[str, Callable[..., Any]]) -> typer.Typer:
    r"""Make a group of the command line, such as ``apesim valve``.

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

    Examples
    --------
    >>> from typer.testing import CliRunner
    >>> def greet(common: Common) -> None:
    ...     '''Say hello.'''
    ...     common.console.result({}, "hello")
    >>> CliRunner().invoke(group("Greetings.", {"greet": greet, "bow": greet}), ["greet"]).stdout
    'hello\n'
    """
    app = typer.Typer(no_args_is_help=True, help=about)
    for name, function in commands.items():
        register(app, name, function)
    return app


def register(app: typer.Typer, name: str, function: Callable[..., Any]) -> None:
    r"""Register a command; behind its own options it takes those of `common`.

    Parameters
    ----------
    app : typer.Typer
        Group that the command is added to.
    name : str
        Name of the command on the command line.
    function : function
        Takes `Common`, and its own options by keyword. Its docstring is the help, see `help_of`; what it returns is the
        exit code, None for 0. It imports what it computes with itself, so that ``--help`` answers at once.

    Examples
    --------
    >>> from typer.testing import CliRunner
    >>> def show_bore(common: Common) -> None:
    ...     '''Show the bore.'''
    ...     common.console.result({"bore_m": common.load_machine().engine.bore})
    >>> app = typer.Typer()
    >>> register(app, "bore", show_bore)
    >>> CliRunner().invoke(app, ["--set", "engine.bore=90 mm", "--json"]).stdout
    '{"bore_m": 0.09}\n'
    """
    _, *parameters = inspect.signature(function).parameters.values()

    def run(**arguments: Any) -> Any:
        shared = {key: arguments.pop(key) for key in COMMON}
        given = common(**shared)
        with given.console.library_warnings(), given.console.announce_compiling():
            return function(given, **arguments)

    run.__signature__ = inspect.Signature([*parameters, *COMMON.values()])  # type: ignore[attr-defined]
    text = help_of(function)
    summary = " ".join(text.partition("\n\n")[0].split())
    app.command(name, help=text, short_help=summary)(run)  # typer would cut it at the first full stop, or short


def help_of(function: Callable[..., Any]) -> str:
    r"""Take the help of a command from its docstring: all that stands before the first section.

    Parameters
    ----------
    function : function
        Function of a command; its docstring is numpydoc.

    Returns
    -------
    str
        Summary and description; "" without a docstring.

    Examples
    --------
    >>> def run_engine(speed: float) -> None:
    ...     '''Run the engine.
    ...
    ...     To its periodic state.
    ...
    ...     Parameters
    ...     ----------
    ...     speed : float
    ...         Speed [rad/s].
    ...     '''
    >>> help_of(run_engine)
    'Run the engine.\n\nTo its periodic state.'
    """
    return SECTION.split(inspect.getdoc(function) or "", maxsplit=1)[0].rstrip()
