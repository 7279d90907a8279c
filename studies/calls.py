"""Calls: what the public functions share; arguments are checked, progress is shown on demand."""

import contextlib
import inspect
import time
from collections.abc import Callable, Iterator, Mapping
from os import PathLike
from typing import TYPE_CHECKING, Any

from apesim.engine.machine import Machine
from apesim.quantities import Arguments
from apesim.quantities.checking import check
from apesim.quantities.settings import differences

if TYPE_CHECKING:
    from apesim.archive import Archive

Progress = bool | Callable[[int, int], object]
"""False: nothing is shown; True: a bar on standard error; a function: it is called with what is done and with all."""


def arguments_of(function: str, machine: Machine) -> Arguments:
    """Reader of the arguments of a public function, whose machine is checked first.

    Parameters
    ----------
    function : str
        Its name, for messages.
    machine : Machine

    Returns
    -------
    Arguments

    Raises
    ------
    InputError
        The machine holds what no machine file could say.
    """
    own_class = type(machine) if isinstance(machine, Machine) else Machine  # effects from outside make one
    check(machine, own_class, f"{function}()")
    return Arguments(function, machine.ambient.pressure)


@contextlib.contextmanager
def shown(progress: Progress, task: str) -> Iterator[Callable[[int, int], object]]:
    """Show the progress of a task as it was asked for; yields ``report(done, total)``."""
    if callable(progress):
        yield progress
        return
    if not progress:
        yield lambda done, total: None
        return
    from apesim.studies.console import progress_bar

    with progress_bar() as bar:
        line = bar.add_task(task, total=None)
        yield lambda done, total: bar.update(line, completed=done, total=total)


def computed(
    compute: Callable[..., "Archive"],
    first_march: tuple[Any, ...],
    out: str | PathLike[str] | None,
    *,
    overwrite: bool,
    report: Callable[[int, int], object],
) -> tuple["Archive", float]:
    """Compute an archive, and write it where it was asked for; what is there is refused before anything is computed.

    Parameters
    ----------
    compute : function
        Takes ``report``; returns the archive.
    first_march : tuple
        Function and arguments of one march, which compiles what all the others need.
    out : path, optional
    overwrite : bool
        Replace one that is there.
    report : function

    Returns
    -------
    archive : Archive
    wall_time : float
        Computing time, warm [s].
    """
    from apesim.studies.execution.own_thread import call_in_thread
    from apesim.studies.output import publish, refuse_folder, refuse_to_replace

    if out is not None:
        (refuse_folder if overwrite else refuse_to_replace)(out)
    call_in_thread(*first_march).result()
    start = time.perf_counter()
    archive = call_in_thread(compute, report=report).result()
    wall_time = time.perf_counter() - start
    if out is not None:
        publish(archive, out, overwrite)
    return archive, wall_time


def compile_first(machine: Machine, march: Callable[..., Any], *arguments: Any, **options: Any) -> None:
    """Run a short march, once in a process for each kind of machine, so that what is timed after it is compiled.

    Parameters
    ----------
    machine : Machine
    march : function
        Takes the machine, and what follows here.
    """
    effects = {key.split(".")[1] for key, _ in differences(machine) if key.startswith("effects.")}
    kind = march.__name__, machine.air.model, frozenset(effects)
    if kind not in _compiled:
        march(machine, *arguments, **options)
        _compiled.add(kind)


_compiled: set[tuple[str, int, frozenset[str]]] = set()
"""Kinds of marches that were run in this process."""


def call_text(function: Callable[..., Any], given: Mapping[str, Any]) -> str:
    """A call from Python for the provenance, e.g. ``apesim.sweep(machine, speed='600 rpm')``.

    Parameters
    ----------
    function : function
    given : mapping of str
        Its arguments; those that are as by default are left out, and paths shrink to their last part, as they name
        users.
    """
    words = ["machine"]
    for name, parameter in inspect.signature(function).parameters.items():
        value = given[name]
        is_plain = isinstance(value, str | int | float | tuple | None)
        if name not in ("machine", "progress", "call") and not (is_plain and value == parameter.default):
            words.append(f"{name}={_argument_text(value)}")
    return f"apesim.{function.__name__}({', '.join(words)})"


def _argument_text(value: Any) -> str:
    from apesim.archive import command_line

    if isinstance(value, str | PathLike):
        return repr(command_line([str(value)]))
    text = repr(value)
    return text if len(text) <= 200 else f"{text[:199]}…"
