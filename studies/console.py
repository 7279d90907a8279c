"""What a command shows, and how it ends: exit codes, one line per culprit, progress with time left."""

import contextlib
import errno
import json
import math
import os
import sys
import traceback
from concurrent.futures import wait

import typer

from apesim.studies.execution.own_thread import call_in_thread
from apesim.terminal import visible

DONE, FAULT_OF_OURS, BAD_INPUT, INCOMPLETE, INTERRUPTED = 0, 1, 2, 3, 130
COMMAND_LINE = "command line"
LAYOUT = "\n\t"
"""Characters of control that are ours; all others in what is shown come from files."""
PATIENCE = 1.0
"""Time before anything is told of what is at work [s]."""
COMPILING = "compiling the model for this processor: once, some fifteen seconds"


class Console:
    """Standard output for results, standard error for messages.

    Parameters
    ----------
    as_json : bool
        Results are one JSON object, and nothing else.
    quiet : bool
        No messages.
    """

    def __init__(self, as_json=False, quiet=False):
        self.as_json = as_json
        self.quiet = quiet

    def result(self, data, *renderables):
        """Show a result: data as JSON, else renderables (texts, rich tables)."""
        if self.as_json:
            print(json.dumps(plain(data), allow_nan=False))  # ASCII, so that any terminal and encoding can take it
            return
        from rich.console import Console as Terminal

        terminal = Terminal(width=None if sys.stdout.isatty() else 120, highlight=False)
        with terminal.capture() as captured:
            for renderable in renderables:
                terminal.print(_Visible(renderable), markup=False, soft_wrap=isinstance(renderable, str))
        print(captured.get(), end="")  # rich itself would end the process where nobody listens any more

    def message(self, text):
        """A line on standard error."""
        if not self.quiet:
            _tell(text)

    @contextlib.contextmanager
    def progress(self, what):
        """Progress with time left on a terminal; yields ``report(done, total)``."""
        if self.quiet or not sys.stderr.isatty():
            yield lambda done, total: None
            return
        with progress_bar() as progress:
            task = progress.add_task(what, total=None)
            yield lambda done, total: progress.update(task, completed=done, total=total)

    @contextlib.contextmanager
    def stages(self, what):
        """Progress of work in stages; yields ``report(stage, done, total)``."""
        if self.quiet or not sys.stderr.isatty():
            yield lambda stage, done, total: None
            return
        with progress_bar() as progress:
            task = progress.add_task(what, total=None)

            def report(stage, done, total):
                if stage != progress.tasks[0].description:
                    progress.reset(task, description=stage, completed=done, total=total)
                else:
                    progress.update(task, completed=done)

            yield report

    def run(self, what, function, *arguments, **options):
        """Call a function in a thread of its own, see `apesim.studies.execution.own_thread`.

        Parameters
        ----------
        what : str
            What is told on a terminal, with the time it has taken, where it takes longer than `PATIENCE`.
        function : function

        Returns
        -------
        object
            What the function returns.
        """
        future = call_in_thread(function, *arguments, **options)
        wait([future], PATIENCE)
        if future.done() or self.quiet or not sys.stderr.isatty():
            return future.result()
        from rich.console import Console as Terminal
        from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

        columns = (TextColumn(what), SpinnerColumn(), TimeElapsedColumn())
        with Progress(*columns, console=Terminal(stderr=True), transient=True) as progress:
            progress.add_task(what, total=None)
            return future.result()

    @contextlib.contextmanager
    def compiling_told(self):
        """Within, tell once where something has to be compiled, as that takes long."""
        from apesim.kernel import when_compiling

        with when_compiling(lambda: self.message(COMPILING)):
            yield

    def warm_up(self, march, *arguments, **options):
        """Run a march once, so that what is timed after it is compiled; tell where that takes long."""
        with self.compiling_told():
            self.run("first march", march, *arguments, **options)


def plain(data):
    """Data as JSON knows it: NaN and infinity are null, numpy's numbers Python's."""
    if isinstance(data, dict):
        return {key: plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [plain(value) for value in data]
    if hasattr(data, "tolist"):
        return plain(data.tolist())
    if isinstance(data, float) and not math.isfinite(data):
        return None
    return data


def main_of(app):
    """Run a command line and say how it ended.

    Parameters
    ----------
    app : typer.Typer

    Returns
    -------
    int
        0 done, 1 a fault of ours, 2 bad input, 3 the work ended with points failed or archives differ or are damaged,
        130 interrupted.
    """
    if sys.stderr is None:  # closed: what is printed to None goes to standard output
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115
    if sys.stdout is None:
        return _bad_input("standard output: is closed; send it elsewhere, e.g. > /dev/null")
    for stream in (sys.stdout, sys.stderr):
        if getattr(stream, "errors", None) == "strict":  # where the encoding lacks a character
            stream.reconfigure(errors="replace")
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
        _tell(traceback.format_exc().rstrip())
        _tell("apesim: this is a fault of ours; please report it with the lines above")
        return FAULT_OF_OURS


class OutputError(Exception):
    """Standard output cannot be written; its cause says why."""


def progress_bar():
    """A bar with the name of what is at work, how much is done, and the time left."""
    from rich.console import Console as Terminal
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    name = TextColumn("{task.description}")
    columns = (name, BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("left"))
    return Progress(*columns, console=Terminal(stderr=True))


class _Visible:
    """What rich can draw, less the control characters in its texts; see `apesim.terminal`."""

    def __init__(self, renderable):
        self.renderable = renderable

    def __rich_console__(self, terminal, options):
        from rich.segment import Segment

        for text, style, control in terminal.render(self.renderable, options):
            yield Segment(text if control else visible(text, keep=LAYOUT), style, control)


class _Output:
    """Standard output, its errors told from those of other files."""

    def __init__(self, stream):
        self._stream = stream

    def __getattr__(self, name):
        return getattr(self._stream, name)

    def write(self, text):
        try:
            return self._stream.write(text)
        except OSError as error:
            raise OutputError from error

    def flush(self):
        try:
            self._stream.flush()
        except OSError as error:
            raise OutputError from error


def _run(app):
    """Run a command line; its own parser would end in its own ways."""
    command = typer.main.get_command(app)
    try:
        with command.make_context("apesim", sys.argv[1:]) as context:
            return command.invoke(context) or DONE
    except typer.Exit as end:
        return end.exit_code
    except typer.TyperException as error:
        context = getattr(error, "ctx", None)
        if not context or error.message != context.get_help():
            raise
        print(error.message)  # a group was called without a command
        return DONE


def _known(error):
    """Exit code of an error that says itself what is wrong; None for any other."""
    if isinstance(error, OutputError):
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


def _unheard(error):
    """Exit code where standard output fails; that nobody listens any more, as behind head, is no fault."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())  # or the interpreter's last flush would fail as well
    os.close(nowhere)
    if error.errno == errno.EPIPE:
        return DONE
    return _bad_input(f"standard output: cannot be written: {error.strerror}; make room, or send it elsewhere")


def _bad_input(lines):
    _tell(lines)
    return BAD_INPUT


def _tell(text):
    """Print on standard error."""
    print(visible(str(text), keep=LAYOUT), file=sys.stderr, flush=True)


def _parser_line(error):
    """The parser's error on one line: what is wrong, and where the right form stands."""
    context = getattr(error, "ctx", None)
    command = context.command_path if context else "apesim"
    message = " ".join(error.format_message().split()).rstrip(".")
    return f"{COMMAND_LINE}: {message[:1].lower()}{message[1:]}; see {command} --help"
