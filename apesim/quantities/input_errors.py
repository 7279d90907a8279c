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
    """Value that cannot be taken.

    Parameters
    ----------
    wrong : str
        What is wrong with it.
    right : str
        What would be right; "" where an example says it best.
    parts : tuple of (str, InvalidValue)
        Of a table, every key in it that is wrong; `wrong` and `right` are those of the first.
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

    Parameters
    ----------
    names : sequence
        Names that nobody knows.
    fault_of : function
        Fault of one of them, with the nearest right name.
    file, section : str
        File and table that they stand in.

    Yields
    ------
    Fault

    Examples
    --------
    >>> faults = name_unknown([f"a{i}" for i in range(60)], lambda name: Fault("", name, "", ""), "mine.toml", "engine")
    >>> print(list(faults)[-1])
    mine.toml: engine: 10 more unknown keys; mend the first 50 of them
    """
    yield from map(fault_of, names[:MAX_NAMED])
    if (more := len(names) - MAX_NAMED) > 0:
        yield Fault(file, section, f"{more} more unknown keys", f"mend the first {MAX_NAMED} of them")


def quoted(raw: Any) -> str:
    """Return what the user wrote, on one line and not too long.

    Parameters
    ----------
    raw : object
        What the user wrote.

    Returns
    -------
    str
        Its representation, shortened in the middle above 60 characters.

    Examples
    --------
    >>> print(quoted("9 mm"), quoted(9))
    '9 mm' 9
    """
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
    """Make the `Fault` of an `InvalidValue`; where that names no right form, the default shows one.

    Parameters
    ----------
    file : str
        File, or part of the command line.
    key : str
        Key of the machine file, or option.
    wrong : InvalidValue
        What is wrong.
    declaration : apesim.quantities.declarations.Declaration
        What the value may be.
    default : object
        Default value in SI, shown as a right form.
    ambient_pressure : float, optional
        Pressure that gauge pressures stand above [Pa].

    Returns
    -------
    Fault
        Fault with its remedy.

    Examples
    --------
    >>> from apesim.quantities import Quantity
    >>> stroke = Quantity("mm", 1, 50, "chosen")
    >>> print(make_fault("mine.toml", "valve.stroke", InvalidValue("has no unit"), stroke, 9e-3))
    mine.toml: valve.stroke: has no unit; write e.g. "9 mm"
    """
    return Fault(file, key, wrong.wrong, wrong.right or declaration.example(default, ambient_pressure))
