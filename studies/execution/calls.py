"""Calls: what the public functions share, from the check of their arguments to the text of the call."""

import inspect
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextvars import copy_context
from functools import partial, wraps
from os import PathLike
from pathlib import Path
from types import NoneType, UnionType
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar, get_args, get_origin

import numpy as np

from apesim.compiling import when_compiling
from apesim.effect import kind_of_march, library_for
from apesim.engine.effects import ENGINE_LIBRARY
from apesim.engine.machine import Machine
from apesim.quantities import Arguments, Fault, InputError, quoted
from apesim.quantities.checking import check
from apesim.quantities.settings import dumps
from apesim.quantities.trees import with_own_arrays
from apesim.valve.effects import VALVE_LIBRARY

if TYPE_CHECKING:
    from apesim.archive import Archive

P = ParamSpec("P")
R = TypeVar("R")
QUANTITIES = {float, int, tuple}
"""Types of what is read as a quantity or as a list of them, with its own words for what is wrong."""


def public(function: Callable[P, R]) -> Callable[P, R]:
    """Let a public function refuse None and other types than its annotations name, each argument by its name.

    Numbers are left to the function, which knows their units and ranges. While it runs, each march that has to be
    compiled is said in a line on standard error, unless a command says it, see `apesim.compiling`.

    Parameters
    ----------
    function : function
        Public function; its annotations are types, no texts.

    Returns
    -------
    function
        The same, which checks its arguments before it begins.

    Examples
    --------
    >>> @public
    ... def march(machine: Machine, out: str | None = None, traces: bool = True) -> None: ...
    >>> march(Machine(), traces=None)
    Traceback (most recent call last):
    ...
    apesim.quantities.input_errors.InputError: march(): traces: is None; write True or False
    """
    parameters = inspect.signature(function).parameters
    annotated = {name: each.annotation for name, each in parameters.items() if name != "self"}
    kinds = {name: _kinds_of(annotation) for name, annotation in annotated.items()}
    # A class is called by its name.
    called = function.__qualname__.removesuffix(".__init__").rsplit(".", 1)[-1]

    @wraps(function)
    def checked(*arguments: P.args, **named: P.kwargs) -> R:
        given = {**dict(zip(parameters, arguments, strict=False)), **named}
        faults = [
            Fault(f"{called}()", name, *fault)
            for name, value in given.items()
            if name in kinds
            for fault in _faults_of_type(value, kinds[name])
        ]
        if faults:
            raise InputError(faults)
        # What compiles is another thread: a notebook shows the line below the cell that the context is of.
        context = copy_context()
        with when_compiling(lambda line: context.run(_say, line)):
            return function(*arguments, **named)

    return checked


def _say(line: str) -> None:
    """Write a line on standard error, where there is one."""
    if sys.stderr is not None:
        print(line, file=sys.stderr, flush=True)


def _kinds_of(annotation: Any) -> tuple[Any, ...]:
    """Members of an annotation."""
    return get_args(annotation) if isinstance(annotation, UnionType) else (annotation,)


def _items_of(kind: Any) -> tuple[Any, ...]:
    """Type of the items of a list; none of any other type."""
    is_list = get_origin(kind) not in (None, Callable)
    return get_args(kind)[:1] if is_list else ()


def _faults_of_type(value: Any, kinds: tuple[Any, ...]) -> Iterator[tuple[str, str]]:
    """What is wrong with the type of an argument, and what would be right."""
    plain = {get_origin(kind) or kind for kind in kinds}
    if value is None:
        if NoneType not in plain:
            yield "is None", _right_form(kinds)
    elif plain & QUANTITIES or Machine in plain:  # the function itself reads these
        return
    elif len(plain - {NoneType}) == 1 and issubclass(next(iter(plain - {NoneType})), Iterable) and str not in plain:
        (texts,) = get_args(next(kind for kind in kinds if kind is not NoneType))
        if isinstance(value, str | PathLike | Machine) or not isinstance(value, Iterable):
            yield f"{quoted(value)} is no list", _right_form(kinds)
        elif isinstance(value, list | tuple | set):
            for item in value:
                if not _is_one_of(item, _kinds_of(texts)):
                    yield f"{quoted(item)} is no {'Machine' if texts is Machine else 'text'}", _right_form(kinds)
    elif not _is_one_of(value, kinds):
        yield f"{quoted(value)} is of the type {type(value).__name__}", _right_form(kinds)


def _is_one_of(value: Any, kinds: tuple[Any, ...]) -> bool:
    """Whether a value is of one of the types of an annotation."""
    plain = [get_origin(kind) or kind for kind in kinds]
    return any(callable(value) if kind is Callable else isinstance(value, kind) for kind in plain) or (
        bool in plain and isinstance(value, np.bool_)
    )


def _right_form(kinds: tuple[Any, ...]) -> str:
    """What an argument may be, in words."""
    plain = {get_origin(kind) or kind for kind in kinds}
    items = {get_origin(item) or item for kind in kinds for of in _items_of(kind) for item in _kinds_of(of)}
    words = {Machine: "a Machine", bool: "True or False", Callable: "a function", PathLike: "a path"}
    told = [word for kind, word in words.items() if kind in plain]
    if plain & QUANTITIES:
        told.append("a value with its unit")
    elif str in plain and PathLike not in plain:
        told.append("a text")
    elif not told:
        told.append(f"a list of {'Machines' if Machine in items else 'paths' if PathLike in items else 'texts'}")
    return f"write {' or '.join(told)}"


def arguments_of(function: str, machine: Machine) -> tuple[Arguments, Machine]:
    """Make the reader of the arguments of a public function, whose machine is checked first.

    Parameters
    ----------
    function : str
        Name of the function, for messages.
    machine : Machine
        Machine that the function was given.

    Returns
    -------
    arguments : Arguments
        Reader that collects the faults of all arguments.
    machine : Machine
        The machine; where it held an int or another kind of number, one with a float for it, as kernels need it.

    Raises
    ------
    InputError
        The machine holds what no machine file could say.

    Examples
    --------
    >>> from apesim.quantities import Quantity
    >>> arguments, machine = arguments_of("run_engine", Machine())
    >>> round(arguments.quantity("speed", "1000 rpm", Quantity("rpm", 1, 30000, "a call")), 2)
    104.72
    """
    own_class = type(machine) if isinstance(machine, Machine) else Machine  # effects from outside make one
    machine = check(machine, own_class, f"{function}()")
    return Arguments(function, machine.ambient.pressure), machine


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
    from apesim.studies.execution.output import publish, refuse_to_replace
    from apesim.studies.execution.own_thread import call_in_thread

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
        Machine to run; its model of air, its exhaust valves and its effects make its kind.
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
    from apesim.studies.execution.own_thread import call_in_thread

    effects = machine.effects
    libraries = library_for(effects, VALVE_LIBRARY, "valve"), library_for(effects, ENGINE_LIBRARY, "engine")
    laws = tuple(kind_of_march(library.effects, effects) for library in libraries)
    kind = march.__name__, machine.air.model, len(machine.engine.exhausts), type(effects), *laws
    if kind not in _compiled:
        call_in_thread(march, machine, *arguments, **options).result()
        _compiled.add(kind)


_compiled: set[tuple[Any, ...]] = set()
"""Kinds of marches that were run in this process."""


def text_writer(machine: Machine) -> Callable[[], str]:
    """Make the function that writes a machine as it is now, for a result that may never be asked for the text.

    Parameters
    ----------
    machine : Machine
        Machine that was run.

    Returns
    -------
    function
        Returns the text of `Machine.to_toml`, in the working directory of today.

    Examples
    --------
    >>> text_writer(Machine())() == Machine().to_toml()
    True
    """
    return partial(dumps, with_own_arrays(machine), Path.cwd())


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
        Call, e.g. ``apesim.sweep(machine, speed='600 rpm')``; a function is told by its name.

    Examples
    --------
    >>> def run_valve(machine, pulse="50 ms", out=None): ...
    >>> call_text(run_valve, {"machine": Machine(), "pulse": "20 ms", "out": None})
    "apesim.run_valve(machine, pulse='20 ms')"
    >>> call_text(run_valve, {"machine": Machine(), "pulse": print, "out": None})
    'apesim.run_valve(machine, pulse=print)'
    """
    words = ["machine"]
    for name, parameter in inspect.signature(function).parameters.items():
        value = arguments[name]
        is_plain = isinstance(value, str | int | float | tuple | None)
        if name not in ("machine", "progress", "call") and not (is_plain and value == parameter.default):
            words.append(f"{name}={_argument_text(value)}")
    return f"apesim.{function.__name__}({', '.join(words)})"


def _argument_text(value: Any) -> str:
    from apesim.archive.file import shorten_paths

    if isinstance(value, str | PathLike):
        return repr(shorten_paths(str(value)))
    if callable(value):
        return name_of_function(value)
    text = repr(value)
    return text if len(text) <= 200 else f"{text[:199]}…"


def name_of_function(function: Callable[..., Any]) -> str:
    """Name of a function, or of the class of an object that is called like one.

    Parameters
    ----------
    function : function
        Function or object.

    Returns
    -------
    str
        Name without its module.

    Examples
    --------
    >>> name_of_function(print)
    'print'
    """
    return str(getattr(function, "__name__", type(function).__name__))
