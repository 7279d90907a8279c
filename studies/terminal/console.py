"""What a command shows, and how it ends: exit codes, one line per fault, progress with time left."""

import contextlib
import errno
import json
import logging
import math
import os
import sys
import time
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import wait
from typing import TYPE_CHECKING, Any, ParamSpec, TextIO, TypeVar

import typer

from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.execution.progress import LINE_EVERY, progress_bar, show_progress, write_stages
from apesim.terminal import visible

if TYPE_CHECKING:
    from rich.console import Console as RichConsole
    from rich.console import ConsoleOptions
    from rich.segment import Segment

P = ParamSpec("P")
R = TypeVar("R")
Report = Callable[[int, int], object]
"""Function that takes how much is done, and how much there is in all."""
StageReport = Callable[[str, int, int], object]
"""Function that takes the name of a stage, how much of it is done, and how much of it there is."""

DONE, FAULT_OF_OURS, BAD_INPUT, INCOMPLETE, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit codes."""
COMMAND_LINE = "command line"
"""What stands for a file where an option is wrong."""
LAYOUT = "\n\t"
"""Characters of control that are ours; all others in what is shown come from files."""
PATIENCE = 1.0
"""Time before anything is said of what is at work [s]: shorter work needs no message."""


class _LogMessages(logging.Handler):
    """Shows what libraries log as messages of a console, a line each."""

    def __init__(self, console: "Console") -> None:
        super().__init__(logging.WARNING)
        self.console = console

    def emit(self, record: logging.LogRecord) -> None:
        """Show a record."""
        self.console.message(f"warning: {' '.join(record.getMessage().split())} (of {record.name})")


class Console:
    """Standard output for results, standard error for messages.

    Parameters
    ----------
    as_json : bool
        Whether results are one JSON object, and nothing else.
    quiet : bool
        Whether there are no messages.
    """

    def __init__(self, as_json: bool = False, quiet: bool = False) -> None:
        self.as_json = as_json
        self.quiet = quiet

    def result(self, data: Any, *renderables: Any) -> None:
        """Show a result on standard output.

        Parameters
        ----------
        data : object
            What JSON shows, see `plain`.
        *renderables : str or rich.table.Table
            What readers are shown instead.

        Examples
        --------
        >>> Console(as_json=True).result({"torque_Nm": 31.2, "angles_deg": (float("nan"), 70.0)}, "torque 31.2 N m")
        {"torque_Nm": 31.2, "angles_deg": [null, 70.0]}
        >>> Console().result({"torque_Nm": 31.2}, "torque 31.2 N m")
        torque 31.2 N m
        """
        if self.as_json:
            print(json.dumps(plain(data), allow_nan=False))  # ASCII, so that any terminal and encoding can take it
            return
        from rich.console import Console as Terminal

        terminal = Terminal(width=None if sys.stdout.isatty() else 120, highlight=False)
        with terminal.capture() as captured:
            for renderable in renderables:
                terminal.print(_Visible(renderable), markup=False, soft_wrap=isinstance(renderable, str))
        print(captured.get(), end="")  # rich itself would end the process where nobody listens any more

    def message(self, text: object) -> None:
        r"""Write a line on standard error, unless the console is quiet.

        Parameters
        ----------
        text : object
            Something that has a text.

        Examples
        --------
        >>> import io
        >>> with contextlib.redirect_stderr(io.StringIO()) as lines:
        ...     Console().message("warning: one point failed")
        ...     Console(quiet=True).message("warning: one point failed")
        >>> lines.getvalue()
        'warning: one point failed\n'
        """
        if not self.quiet:
            _tell(text)

    def notes(self, texts: Iterable[object]) -> None:
        r"""Write notes on standard error, a line for each, unless the console is quiet.

        Parameters
        ----------
        texts : iterable of object
            What was guessed of the input, or done to it.

        Examples
        --------
        >>> import io
        >>> with contextlib.redirect_stderr(io.StringIO()) as lines:
        ...     Console().notes(["p040.csv: 1 row is left out"])
        >>> lines.getvalue()
        'note: p040.csv: 1 row is left out\n'
        """
        for text in texts:
            self.message(f"note: {text}")

    @contextlib.contextmanager
    def library_warnings(self) -> Iterator[None]:
        r"""Show what libraries warn of as messages, a line each, and old names as notes; nothing to a quiet console.

        Yields
        ------
        None
            A context in which a command runs.

        Examples
        --------
        >>> import io
        >>> from apesim.quantities.old_names import warn_of_old_name
        >>> with contextlib.redirect_stderr(io.StringIO()) as lines, Console().library_warnings():
        ...     warnings.showwarning("no such glyph", UserWarning, "font.py", 7)
        ...     warn_of_old_name("cantera", "thermally_perfect", "another law")
        >>> print(lines.getvalue(), end="")
        warning: no such glyph (UserWarning in font.py)
        note: "cantera" is read as "thermally_perfect": another law
        """
        from apesim.quantities.old_names import OldNameWarning

        def show(
            message: Warning | str,
            category: type[Warning],
            filename: str,
            lineno: int,
            file: TextIO | None = None,
            line: str | None = None,
        ) -> None:
            if issubclass(category, OldNameWarning):
                self.notes([message])
                return
            self.message(
                f"warning: {' '.join(str(message).split())} ({category.__name__} in {os.path.basename(filename)})"
            )

        last, logging.lastResort = logging.lastResort, _LogMessages(self)  # takes what has no other handler
        with warnings.catch_warnings():
            warnings.simplefilter("default", OldNameWarning)
            warnings.showwarning = show
            try:
                yield
            finally:
                logging.lastResort = last

    @contextlib.contextmanager
    def progress(self, what: str) -> Iterator[Report]:
        """Show progress with time left on a terminal, in lines elsewhere.

        See `apesim.studies.execution.progress.write_stages`.

        Parameters
        ----------
        what : str
            What is at work, in a word.

        Yields
        ------
        function
            To be called with how much is done, and how much there is in all.

        Examples
        --------
        Nothing is shown to a quiet console:

        >>> with Console(quiet=True).progress("sweep") as report:
        ...     for done in range(3):
        ...         report(done + 1, 3)
        """
        if self.quiet or sys.stderr.isatty():
            with show_progress(not self.quiet, what) as report:
                yield report
            return
        with write_stages(what, self.message) as stage_report:
            yield lambda done, total: stage_report(what, done, total)

    @contextlib.contextmanager
    def stages(self, what: str) -> Iterator[StageReport]:
        """Show progress of work in stages, with time left on a terminal, elsewhere a line for each stage.

        Parameters
        ----------
        what : str
            Name of the first stage.

        Yields
        ------
        function
            To be called with the name of the stage, how much of it is done, and how much of it there is.

        Examples
        --------
        Nothing is shown to a quiet console:

        >>> with Console(quiet=True).stages("paper") as report:
        ...     report("frictions", 1, 3)
        """
        if self.quiet:
            yield lambda stage, done, total: None
            return
        if not sys.stderr.isatty():
            with write_stages(what, self.message) as report:
                yield report
            return
        with progress_bar() as progress:
            task = progress.add_task(what, total=None)

            def report(stage: str, done: int, total: int) -> None:
                if stage != progress.tasks[0].description:
                    progress.reset(task, description=stage, completed=done, total=total)
                else:
                    progress.update(task, completed=done)

            yield report

    def run(self, what: str, function: Callable[P, R], *arguments: P.args, **options: P.kwargs) -> R:
        """Call a function in a thread of its own, see `apesim.studies.execution.own_thread`.

        Parameters
        ----------
        what : str
            Name of the work, shown on a terminal with the time it has taken, where it takes longer than `PATIENCE`;
            elsewhere in a line from time to time.
        function : function
            Work to do.
        *arguments, **options
            What it is called with.

        Returns
        -------
        object
            What the function returns.

        Examples
        --------
        >>> Console(quiet=True).run("powers", pow, 2, exp=10)
        1024
        """
        future = call_in_thread(function, *arguments, **options)
        wait([future], PATIENCE)
        if future.done() or self.quiet:
            return future.result()
        if not sys.stderr.isatty():
            begin = time.perf_counter()
            while not wait([future], LINE_EVERY).done:
                self.message(f"{what}: {time.perf_counter() - begin + PATIENCE:.0f} s so far")
            return future.result()
        from rich.console import Console as Terminal
        from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

        columns = (TextColumn(what), SpinnerColumn(), TimeElapsedColumn())
        with Progress(*columns, console=Terminal(stderr=True), transient=True) as progress:
            progress.add_task(what, total=None)
            return future.result()

    @contextlib.contextmanager
    def announce_compiling(self) -> Iterator[None]:
        """Say, while within, what has to be compiled, and how long that took last time, see `apesim.compiling`.

        Yields
        ------
        None
            A context in which functions are called that may compile.

        Examples
        --------
        >>> with Console(quiet=True).announce_compiling():
        ...     print("marching")
        marching
        """
        from apesim.cache import explain_temporary
        from apesim.compiling import when_compiling

        explained: set[str] = set()

        def tell(line: str) -> None:
            for text in (line, explain_temporary()):
                if text and text not in explained:
                    self.message(text)
                    explained.add(text)

        with when_compiling(tell):
            yield

    def warm_up(self, march: Callable[P, object], *arguments: P.args, **options: P.kwargs) -> None:
        """Run a march once, so that what is timed after it is compiled.

        Parameters
        ----------
        march : function
            March to run.
        *arguments, **options
            What it is called with.

        Examples
        --------
        >>> marches = []
        >>> Console(quiet=True).warm_up(marches.append, "from rest")
        >>> marches
        ['from rest']
        """
        self.run("first march", march, *arguments, **options)


def plain(data: Any) -> Any:
    """Turn data into what JSON knows: NaN and infinity become null, NumPy's numbers Python's.

    Parameters
    ----------
    data : object
        Dicts, lists, tuples, arrays, numbers and texts, one within the other.

    Returns
    -------
    object
        Dicts, lists, numbers, texts and None.

    Examples
    --------
    >>> plain({"torque": float("nan"), "angles": (1.0, 2.0)})
    {'torque': None, 'angles': [1.0, 2.0]}
    """
    data = to_builtins(data)
    if isinstance(data, dict):
        return {key: plain(value) for key, value in data.items()}
    if isinstance(data, list):
        return [plain(value) for value in data]
    if isinstance(data, float) and not math.isfinite(data):
        return None
    return data


def to_builtins(data: Any) -> Any:
    """Turn NumPy's numbers and arrays into Python's; NaN and infinity stay.

    Parameters
    ----------
    data : object
        Dicts, lists, tuples, arrays, numbers and texts, one within the other.

    Returns
    -------
    object
        Dicts, lists, numbers, texts and None.

    Examples
    --------
    >>> import numpy as np
    >>> to_builtins({"speed": np.float64(2.5), "edges": (np.int64(1), np.nan)})
    {'speed': 2.5, 'edges': [1, nan]}
    """
    if isinstance(data, dict):
        return {key: to_builtins(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [to_builtins(value) for value in data]
    return data.tolist() if hasattr(data, "tolist") else data


def main_of(app: typer.Typer) -> int:
    """Run a command line on the arguments of the process, and say how it ended.

    Parameters
    ----------
    app : typer.Typer
        Commands; what one returns is the exit code, None for 0.

    Returns
    -------
    int
        0 done, 1 a fault of ours, 2 bad input, 3 the work ended with points failed or archives differ or are damaged,
        130 interrupted.

    Examples
    --------
    >>> app = typer.Typer(add_completion=False)
    >>> @app.command()
    ... def count(number: int) -> int:
    ...     print(*range(number))
    ...     return DONE
    >>> arguments, sys.argv = sys.argv, ["apesim", "3"]
    >>> main_of(app)
    0 1 2
    0
    >>> sys.argv = arguments
    """
    if sys.stderr is None:  # closed: what is printed to None goes to standard output
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115
    if sys.stdout is None:
        return _bad_input("standard output: is closed; send it elsewhere, e.g. > /dev/null")

    # Texts hold characters that not every encoding has, such as that of m²: they are shown as ?, and end no command.
    streams: tuple[Any, ...] = (sys.stdout, sys.stderr)
    for stream in streams:
        if getattr(stream, "errors", None) in ("strict", "surrogateescape"):  # where the encoding lacks a character
            stream.reconfigure(errors="replace")

    # The work itself. The flush stands within: at the interpreter's exit a failure could no longer become an exit code.
    try:
        with contextlib.redirect_stdout(_Output(sys.stdout)):
            code = _run(app)
            sys.stdout.flush()
        return code
    except typer.TyperException as error:
        return _bad_input(_parser_line(error))
    except (KeyboardInterrupt, typer.Abort):
        _tell("interrupted")
        return INTERRUPTED
    except MemoryError:
        right = "compute fewer points at a time, with fewer --jobs, or on a larger machine"
        return _bad_input(f"{COMMAND_LINE}: takes more memory than is available; {right}")
    except Exception as error:
        known = _known(error)
        if known is not None:
            return known

        # Nothing that a user could mend: the traceback is what a report needs.
        _tell(traceback.format_exc().rstrip())
        _tell("apesim: this is a fault of ours; please report it with the lines above")
        return FAULT_OF_OURS


class OutputError(Exception):
    """Standard output cannot be written; its cause says why."""


class _Visible:
    """What rich can draw, less the control characters in its texts; see `apesim.terminal`."""

    def __init__(self, renderable: Any) -> None:
        self.renderable = renderable

    def __rich_console__(self, terminal: "RichConsole", options: "ConsoleOptions") -> "Iterator[Segment]":
        from rich.segment import Segment

        for text, style, control in terminal.render(self.renderable, options):
            yield Segment(text if control else visible(text, keep=LAYOUT), style, control)


class _Output:
    """Standard output, its errors distinguishable from those of other files."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text; raises `OutputError`."""
        try:
            return self._stream.write(text)
        except OSError as error:
            raise OutputError from error

    def flush(self) -> None:
        """Write what is buffered; raises `OutputError`."""
        try:
            self._stream.flush()
        except OSError as error:
            raise OutputError from error


def _run(app: typer.Typer) -> int:
    """Run a command line; its own parser would end in its own ways."""
    command = typer.main.get_command(app)
    try:
        with command.make_context("apesim", sys.argv[1:]) as context:
            return command.invoke(context) or DONE
    except typer.Exit as end:
        return end.exit_code
    except typer.TyperException as error:
        group = getattr(error, "ctx", None)
        if not group or error.message != group.get_help():
            raise
        print(error.message)  # a group was called without a command
        return DONE


def _known(error: Exception) -> int | None:
    """Exit code of an error that says itself what is wrong; None for any other."""
    if isinstance(error, OutputError) and isinstance(error.__cause__, OSError):
        return _unheard(error.__cause__)
    from apesim.quantities import InputError

    if isinstance(error, InputError):
        return _bad_input(str(error))
    from apesim.results import NotConverged

    if isinstance(error, NotConverged):
        _tell(error)
        return INCOMPLETE
    if "apesim.archive" in sys.modules:  # imported only where it can have been raised
        from apesim.archive import ArchiveError, DamagedError, IncompleteError

        if isinstance(error, ArchiveError):
            _tell(error)
            return INCOMPLETE if isinstance(error, DamagedError | IncompleteError) else BAD_INPUT
    if "apesim.studies.execution.pool" in sys.modules:
        from apesim.studies.execution.pool import Died

        if isinstance(error, Died):
            _tell(error)
            return INCOMPLETE
    return None


def _unheard(error: OSError) -> int:
    """Exit code where standard output fails; that nobody listens any more, as behind head, is no fault."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())  # or the interpreter's last flush would fail as well
    os.close(nowhere)
    if error.errno == errno.EPIPE:
        return DONE
    return _bad_input(f"standard output: cannot be written: {error.strerror}; make room, or send it elsewhere")


def _bad_input(lines: str) -> int:
    """Print what is wrong, and return the exit code of bad input."""
    _tell(lines)
    return BAD_INPUT


def _tell(text: object) -> None:
    """Print on standard error."""
    print(visible(str(text), keep=LAYOUT), file=sys.stderr, flush=True)


def _parser_line(error: typer.TyperException) -> str:
    """Error of the parser on one line: what is wrong, and where the right form stands."""
    context = getattr(error, "ctx", None)
    command = context.command_path if context else "apesim"
    message = " ".join(error.format_message().split()).rstrip(".")
    return f"{COMMAND_LINE}: {message[:1].lower()}{message[1:]}; see {command} --help"
