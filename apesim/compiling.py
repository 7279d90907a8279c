"""What is compiled: which kind of march it is, who is told of it, and how long it took last time."""

import contextlib
import json
import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from apesim.cache import cache_root

TIMES_FILE = "compile_times.json"
"""File in the cache's root, beside the folders of compiled kernels: it outlives them."""
MODULES = {"apesim.valve.": "valve", "apesim.engine.drivetrain.": "drivetrain", "apesim.engine.": "engine"}
"""Kinds of march by the modules of their parameters, the first match counts."""
MAX_SECONDS = 1e5
"""Longest time that is believed [s]: a day; what is more comes from a damaged file."""

_listeners: list[Callable[[str], object]] = []
"""Functions that are told what is compiled, the outermost first."""


@contextlib.contextmanager
def when_compiling(tell: Callable[[str], object]) -> Iterator[None]:
    """Tell a function, within a ``with`` statement, of each march that has to be compiled, by a line of text.

    What is loaded from the cache is not told. Of nested statements the outermost is told alone, so that a command that
    calls public functions says each line once.

    >>> with when_compiling(print), when_compiling(lambda line: print("told twice")):
    ...     tell_of_compiling("model")
    compiling the model for this processor, once: takes 15 to 60 s
    """
    _listeners.append(tell)
    try:
        yield
    finally:
        _listeners.remove(tell)


def tell_of_compiling(kind: str, target: str = "this processor") -> None:
    """Tell whoever listens that a march of a kind, see `kind_of_march_types`, is compiled now for a target."""
    for tell in _listeners[:1]:
        tell(explain_compiling(kind, target))


def explain_compiling(kind: str, target: str = "this processor") -> str:
    """Say in a line that a march of a kind is compiled, and how long that took last time, or else usually takes."""
    seconds = compile_times().get(kind)
    told = "takes 15 to 60 s" if seconds is None else f"took {seconds:.0f} s last time"
    return f"compiling the {kind} for {target}, once: {told}"


def kind_of_march_types(arguments: Iterable[Any]) -> str:
    """Return the kind of march that an entry is compiled for, from the Numba types of the call's arguments.

    It is "valve", "engine" or "drivetrain", and what it is with: what the machine, or a drivetrain's cylinder, has more
    than one of, as in "engine with 2 exhausts"; "effects" where their laws are compiled in, or "an effect of your own"
    where one is from outside. It is "model" for what is none of them. The first type is that of the parameters.
    """
    types = tuple(arguments)
    module = getattr(getattr(types[0], "instance_class", None), "__module__", "") if types else ""
    kind = next((kind for start, kind in MODULES.items() if module.startswith(start)), "")
    if not kind:
        return "model"
    classes = list(_classes_in(types))
    parts = list(_counts_of(types[0].types[0] if kind == "drivetrain" else types[0]))
    if any(getattr(cls, "outside_hash", "") for cls in classes):
        parts.append("an effect of your own")
    elif any(getattr(cls, "is_of_laws", False) for cls in classes):
        parts.append("effects")
    return f"{kind} with {' and '.join(parts)}" if parts else kind


def _counts_of(machine: Any) -> Iterator[str]:
    """What a machine has more than one of, each with its number: plain tuples in the Numba type of its parameters."""
    for name, kind in zip(machine.fields, machine.types, strict=True):
        count = 0 if hasattr(kind, "instance_class") else len(getattr(kind, "types", ()))
        if count > 1:
            yield f"{count} {name}"


def _classes_in(types: Iterable[Any]) -> Iterator[type]:
    """NamedTuple classes among the types of a call's arguments, at any depth."""
    for kind in types:
        if cls := getattr(kind, "instance_class", None):
            yield cls
        if hasattr(kind, "types"):  # a tuple's
            yield from _classes_in(kind.types)


def compile_times() -> dict[str, float]:
    """Return how long compiling took last time [s], by kind of march; what a damaged file holds beside is left out."""
    try:
        noted = json.loads((cache_root() / TIMES_FILE).read_text(encoding="utf-8"))
    except (OSError, RuntimeError, ValueError, RecursionError):  # RuntimeError: there is no home
        return {}
    pairs = noted.items() if isinstance(noted, dict) else ()
    return {kind: float(s) for kind, s in pairs if isinstance(s, int | float) and 0.0 <= s <= MAX_SECONDS}


def note_compile_time(kind: str, seconds: float) -> None:
    """Note how long compiling took [s]; where that cannot be written, nothing is noted.

    The times of kind "model", which is any other function than a march, are not noted.
    """
    if kind == "model":
        return
    noted = compile_times() | {kind: round(seconds, 2)}
    with contextlib.suppress(OSError, RuntimeError):
        path = cache_root() / TIMES_FILE
        # Replaced as a whole, as several processes may compile at once.
        part = Path(f"{path}.{os.getpid()}")
        part.write_text(json.dumps(noted, indent=1, sort_keys=True) + "\n", encoding="utf-8")
        part.replace(path)
