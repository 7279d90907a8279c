"""Calls: what the public functions share, from the check of their arguments to the text of the call."""

import inspect
import time
from collections.abc import Callable, Mapping
from os import PathLike
from typing import TYPE_CHECKING, Any

from apesim.engine.machine import Machine
from apesim.quantities import Arguments
from apesim.quantities.checking import check
from apesim.quantities.settings import differences

if TYPE_CHECKING:
    from apesim.archive import Archive


def arguments_of(function: str, machine: Machine) -> Arguments:
    """Make the reader of the arguments of a public function, whose machine is checked first.

    Parameters
    ----------
    function : str
        Name of the function, for messages.
    machine : Machine
        Machine that the function was given.

    Returns
    -------
    Arguments
        Reader that collects the faults of all arguments.

    Raises
    ------
    InputError
        The machine holds what no machine file could say.

    Examples
    --------
    >>> from apesim.quantities import Quantity
    >>> arguments = arguments_of("run_engine", Machine())
    >>> round(arguments.quantity("speed", "1000 rpm", Quantity("rpm", 1, 30000, "a call")), 2)
    104.72
    """
    own_class = type(machine) if isinstance(machine, Machine) else Machine  # effects from outside make one
    check(machine, own_class, f"{function}()")
    return Arguments(function, machine.ambient.pressure)


def computed(
    compute: Callable[..., "Archive"],
    first_march: tuple[Any, ...],
    out: str | PathLike[str] | None,
    *,
    overwrite: bool,
    report: Callable[[int, int], object],
) -> tuple["Archive", float]:
    """Compute an archive, and write it where it was asked for; a bad target is refused before anything is computed.

    Parameters
    ----------
    compute : function
        Takes ``report`` and returns the archive.
    first_march : tuple
        Function and arguments of one march, which compiles what all the others need.
    out : path, optional
        The archive to write; None: nothing is written.
    overwrite : bool
        Replace an archive that is there.
    report : function
        Called with the numbers of points done and in all.

    Returns
    -------
    archive : Archive
        What was computed.
    wall_time : float
        Computing time, warm [s].

    Raises
    ------
    ArchiveError
        The target exists, or cannot be written.

    Examples
    --------
    >>> from apesim.archive import Archive
    >>> from apesim.archive.columns import run_axis
    >>> def compute(report):
    ...     report(1, 1)
    ...     return Archive("", {}, {"run": run_axis(1)})
    >>> archive, wall_time = computed(compute, (abs, -1.0), None, overwrite=False, report=print)
    1 1
    >>> len(archive.runs), wall_time < 10.0
    (1, True)
    """
    from apesim.studies.execution.own_thread import call_in_thread
    from apesim.studies.output import publish, refuse_to_replace

    if out is not None:
        refuse_to_replace(out, overwrite=overwrite)
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
        Machine to run; its model of air and its effects make its kind.
    march : function
        Takes the machine, and what follows here.
    *arguments, **options
        Further arguments of the march.

    Examples
    --------
    >>> def short_march(machine, end):
    ...     print(f"a march of {end:g} s")
    >>> compile_first(Machine(), short_march, 0.01)
    a march of 0.01 s
    >>> compile_first(Machine(), short_march, 0.01)  # compiled already
    """
    effects = {key.split(".")[1] for key, _ in differences(machine) if key.startswith("effects.")}
    kind = march.__name__, machine.air.model, frozenset(effects)
    if kind not in _compiled:
        march(machine, *arguments, **options)
        _compiled.add(kind)


_compiled: set[tuple[str, int, frozenset[str]]] = set()
"""Kinds of marches that were run in this process."""


def call_text(function: Callable[..., Any], arguments: Mapping[str, Any]) -> str:
    """Write a call from Python for the provenance of an archive.

    Parameters
    ----------
    function : function
        Function that was called.
    arguments : mapping of str
        Arguments by name, "machine" among them. Those that are as by default are left out. Paths shrink to their last
        part, as they name users.

    Returns
    -------
    str
        Call, e.g. ``apesim.sweep(machine, speed='600 rpm')``.

    Examples
    --------
    >>> def run_valve(machine, pulse="50 ms", out=None): ...
    >>> call_text(run_valve, {"machine": Machine(), "pulse": "20 ms", "out": None})
    "apesim.run_valve(machine, pulse='20 ms')"
    """
    words = ["machine"]
    for name, parameter in inspect.signature(function).parameters.items():
        value = arguments[name]
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
