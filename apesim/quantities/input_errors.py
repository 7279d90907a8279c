"""Faults: what is reported of bad input, one line for each fault, with its remedy."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple, TypeVar

from apesim.terminal import visible

MAX_LINES = 100
"""Faults that the text of an error shows: more fill a screen, and nobody reads them."""
MAX_NAMED = 50
"""Unknown names of one table for which the nearest right one is looked for, which takes half a millisecond each."""
Name = TypeVar("Name")


class InvalidValue(ValueError):
    """Value that cannot be taken, with what is wrong and what would be right ("" where an example says it best).

    `parts` holds, for a table, every key in it that is wrong; `wrong` and `right` are those of the first.
    """

    def __init__(self, wrong: str, right: str = "", parts: "tuple[tuple[str, InvalidValue], ...]" = ()) -> None:
        super().__init__(wrong, right)
        self.wrong, self.right, self.parts = wrong, right, parts


class Fault(NamedTuple):
    """One fault of the input, printed on one line."""

    file: str
    """File, command line or function that the input came from; "" leaves it out."""
    key: str
    """Key, option or argument that is wrong; "" leaves it out."""
    wrong: str
    """What is wrong."""
    right: str
    """What would be right."""

    def __str__(self) -> str:
        line = ": ".join(part for part in (self.file, _shortened(self.key), self.wrong) if part) + f"; {self.right}"
        return visible(line)


class InputError(Exception):
    """Error for bad input; its text has one line for each fault.

    Parameters
    ----------
    faults : iterable of Fault
        Every fault found; kept as the list ``faults``.
    """

    def __init__(self, faults: Iterable[Fault]) -> None:
        self.faults = list(faults)
        super().__init__(self.faults)

    def __str__(self) -> str:
        lines = [str(fault) for fault in self.faults[:MAX_LINES]]
        if more := len(self.faults) - len(lines):
            lines.append(f"{more} more {'faults are' if more > 1 else 'fault is'} not shown; mend these first")
        return "\n".join(lines)


def name_unknown(names: Sequence[Name], fault_of: Callable[[Name], Fault], file: str, section: str) -> Iterator[Fault]:
    """Find the faults of unknown names: one for each of the first `MAX_NAMED`, and one for all others.

    `fault_of` gives the fault of one of them, with the nearest right name; they stand in the table `section` of `file`.

    >>> faults = name_unknown([f"a{i}" for i in range(60)], lambda name: Fault("", name, "", ""), "mine.toml", "engine")
    >>> print(list(faults)[-1])
    mine.toml: engine: 10 more unknown keys; mend the first 50 of them
    """
    yield from map(fault_of, names[:MAX_NAMED])
    if (more := len(names) - MAX_NAMED) > 0:
        yield Fault(file, section, f"{more} more unknown keys", f"mend the first {MAX_NAMED} of them")


def quoted(raw: Any) -> str:
    """Return what the user wrote, on one line: its representation, shortened in the middle above 60 characters."""
    try:
        text = repr(raw)
    except ValueError:  # Python refuses to print integers of thousands of digits
        return "a huge number"
    return _shortened(text)


def _shortened(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:24]}…{text[-34:]}"


def make_fault(
    file: str,
    key: str,
    wrong: InvalidValue,
    declaration: Any,
    default: Any = math.nan,
    ambient_pressure: float | None = None,
) -> Fault:
    """Make the `Fault` of an `InvalidValue`; where that names no right form, the default (in SI) shows one.

    `file` may be a part of the command line, and `key` an option; gauge pressures stand above `ambient_pressure` [Pa].

    >>> from apesim.quantities import Quantity
    >>> stroke = Quantity("mm", 1, 50, "chosen")
    >>> print(make_fault("mine.toml", "valve.stroke", InvalidValue("has no unit"), stroke, 9e-3))
    mine.toml: valve.stroke: has no unit; write e.g. "9 mm"
    """
    return Fault(file, key, wrong.wrong, wrong.right or declaration.example(default, ambient_pressure))
