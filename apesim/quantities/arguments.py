"""Arguments: what a function is called with from Python, refused in the words of a file or of the command line.

A quantity is a text with its unit, or numbers and their unit: ``(600, "rpm")``, ``(np.arange(600, 1801, 200), "rpm")``.
A bare number is in SI, but for a speed or an angle: there it is refused, as nobody means rad/s by 600.
"""

import re
from collections.abc import Iterable, Mapping, Sized
from numbers import Real
from typing import Any

import numpy as np

from apesim.quantities.declarations import Quantity
from apesim.quantities.input_errors import Fault, InputError, InvalidValue, make_fault, quoted
from apesim.quantities.lists import NO_LIST, QuantityList, as_parts
from apesim.quantities.ranges import Declared, parse, parse_range
from apesim.quantities.units import unit

MAX_SHOWN = 4
"""Numbers of a list that a message shows twice more with a unit; a longer one would fill the line."""
WithUnit = str | tuple[Any, str]
"""Text with its unit, or a number or an array of numbers with their unit."""
Given = WithUnit | float
"""What a quantity other than a speed or an angle is given as: with its unit, or a number in SI."""


class Arguments:
    """The arguments of one call: all are read, and what is wrong is raised for all of them at once.

    Messages name `function`; gauge pressures stand above `ambient_pressure` [Pa].

    >>> from apesim.quantities import Quantity
    >>> arguments = Arguments("run_pump")
    >>> speed = arguments.quantity("speed", "600 rpm", Quantity("rpm", 1, 3000, "a call"))
    >>> arguments.refuse()
    >>> round(speed, 3)
    62.832
    """

    def __init__(self, function: str, ambient_pressure: float | None = None) -> None:
        self.where = f"{function}()"
        self.ambient_pressure = ambient_pressure
        self.faults: list[Fault] = []

    def quantity(self, name: str, given: Any, declaration: Declared) -> Any:
        """Return an argument in SI as `value_of` does; None where it is None, or wrong: then its fault is noted.

        It may be a text with its unit, a number with its unit in a tuple, a number in SI (not for a speed or an angle),
        a word or its index, a path or an array.
        """
        if given is None:
            return None
        try:
            return value_of(given, declaration, self.ambient_pressure, name, self.where)
        except InputError as error:
            self.faults += error.faults
            return None

    def range(self, name: str, given: Any, declaration: Declared) -> list[Any]:
        """Return several values in SI, from a range or list; empty where some are wrong, whose faults are noted.

        It may be a range or list in a text, an array with its unit in a tuple, one number in SI, or a sequence of texts
        and numbers; a speed or an angle has to have its unit.
        """
        try:
            return values_of(given, declaration, self.ambient_pressure, name, self.where)
        except InputError as error:
            self.faults += error.faults
            return []

    def fault(self, name: str, wrong: str, right: str) -> None:
        """Note a fault that only several arguments show together; the message begins with the argument `name`."""
        self.faults.append(Fault(self.where, name, wrong, right))

    def refuse(self) -> None:
        """Refuse the call if any of its arguments is wrong: raises InputError with all faults that were noted."""
        if self.faults:
            raise InputError(self.faults)


def value_of(
    given: Any, declaration: Declared, ambient_pressure: float | None = None, where: str = "", file: str = ""
) -> Any:
    """Return the value in SI of a text or number with its unit, or of a number in SI; a choice is its word or index.

    A choice gives its index, a curve its two columns in SI (n, 2). Gauge pressures stand above `ambient_pressure` [Pa
    abs]. Raises InputError, which names `where` and `file`, where the value is refused.

    >>> from apesim.quantities import Pressure
    >>> supply = Pressure(0.1, 2, "chosen")
    >>> value_of("0.4 MPa gauge", supply, ambient_pressure=101325.0), value_of((5, "bar abs"), supply)
    (501325.0, 500000.0)
    >>> value_of(5e5, supply)
    500000.0
    """
    if isinstance(given, str):
        return parse(given, declaration, ambient_pressure, where, file)
    try:
        return checked_value(given, declaration, ambient_pressure)
    except InvalidValue as wrong:
        raise InputError([make_fault(file, where, wrong, declaration)]) from None


def checked_value(given: Any, declaration: Declared, ambient_pressure: float | None = None) -> Any:
    """Return the value in SI of a text or number, in the type that the kernels are compiled for.

    A text, a path or a number with its unit is read, anything else is checked; a choice gives its index, a curve its
    two columns (n, 2). Gauge pressures stand above `ambient_pressure` [Pa abs]. Raises InvalidValue where it is
    refused.
    """
    read_given = getattr(declaration, "read_given", None)  # of an array of tables
    if read_given and isinstance(given, list | tuple) and any(isinstance(each, Mapping) for each in given):
        return read_given(given, ambient_pressure)
    if isinstance(given, str) or hasattr(given, "__fspath__") or (declaration.is_table and isinstance(given, Mapping)):
        return declaration.read(given, ambient_pressure)
    if isinstance(declaration, Quantity):
        if _has_unit(given):
            texts = _texts_of(*given)
            if len(texts) != 1:
                raise InvalidValue(f"{quoted(given)} is not one value", f"write one, e.g. {_pair(1, declaration.unit)}")
            return declaration.read(texts[0], ambient_pressure)
        if declaration.needs_unit:
            raise _unit_missing(given, declaration)
    if isinstance(declaration, QuantityList):
        return _list_of(given, declaration, ambient_pressure)
    declaration.check(given)
    value = declaration.convert(given)
    if isinstance(declaration, Quantity):
        return declaration.as_said(value)
    return np.array(value) if value is given and isinstance(value, np.ndarray) else value  # the caller may edit his


def _list_of(given: Any, declaration: QuantityList, ambient_pressure: float | None) -> np.ndarray:
    """Numbers (n,) in SI of a sequence as `values_of` takes it; an empty one is no list."""
    if isinstance(given, Sized) and not len(given):
        return NO_LIST
    try:
        values = np.array(values_of(given, declaration.quantity, ambient_pressure))
    except InputError as error:
        raise as_parts(error) from None
    declaration.check(values)
    return values


def _has_unit(given: Any) -> bool:
    """Whether numbers have their unit beside them; a tuple of texts is a list, and "9 mm" is no unit."""
    return (
        isinstance(given, tuple)
        and len(given) == 2
        and isinstance(given[1], str)
        and not isinstance(given[0], str)
        and not re.match(r"\s*[-+.0-9]", given[1])
    )


def _texts_of(numbers: Any, name: str) -> list[str]:
    """A text for each of some numbers with their unit, so that they are read as texts are."""
    try:
        items = np.asarray(numbers).ravel().tolist()
    except ValueError:  # lists of different lengths
        items = [None]
    if any(isinstance(item, bool) or not isinstance(item, Real) for item in items):
        raise InvalidValue(f"{quoted(numbers)} is no number and no list of numbers", f"write e.g. {_pair(1, name)}")
    return [f"{item if isinstance(item, int) else float(item)!r} {name}".strip() for item in items]


def _pair(numbers: Any, name: str) -> str:
    """How numbers with the name of their unit are written."""
    return f'({quoted(numbers)}, "{name}")'


def _unit_missing(given: Any, quantity: Quantity) -> InvalidValue:
    """The `InvalidValue` of a speed or an angle that is given as bare numbers: their unit cannot be told."""
    units = quantity.unit, "rad" if unit(quantity.unit).dimension == unit("rad").dimension else "rad/s"
    given = given.tolist() if isinstance(given, np.ndarray | np.generic) else given
    items = given if isinstance(given, list | tuple) else [given]
    bare = [item for item in items if isinstance(item, Real) and not isinstance(item, bool)]
    if not bare:
        return InvalidValue(f"{quoted(given)} is no quantity")
    number = str(float(bare[0])).removesuffix(".0")
    forms = [f'"{number} {name}"' for name in units]
    if len(bare) == len(items) > 1:
        short = quoted(given) if len(items) <= MAX_SHOWN else "values"
        forms = [f'({short}, "{name}")' for name in units]
    return InvalidValue(f"{quoted(given)} has no unit", f"write e.g. {' or '.join(forms)}")


def values_of(
    given: Any, declaration: Declared, ambient_pressure: float | None = None, where: str = "", file: str = ""
) -> list[Any]:
    """Return the values in SI of a range or list in a text, of one number, or of a sequence of texts and numbers.

    Each is as `value_of` returns it; gauge pressures stand above `ambient_pressure` [Pa abs]. Raises InputError with a
    fault for each item that is refused; messages name `where` and `file`.
    """
    if isinstance(given, str):
        return parse_range(given, declaration, ambient_pressure, where, file)
    if isinstance(given, np.ndarray) and not given.ndim:
        given = given.item()

    # The unit of the whole, before items are read: one beside numbers holds for all, and a missing one is one fault.
    if isinstance(declaration, Quantity):
        try:
            if _has_unit(given):
                given = _texts_of(*given)
            elif declaration.needs_unit and isinstance(given, Iterable):
                given = [item.item() if isinstance(item, np.generic) else item for item in given]
                if any(isinstance(item, Real) for item in given):  # one fault for all of them
                    raise _unit_missing(given, declaration)
        except InvalidValue as wrong:
            raise InputError([make_fault(file, where, wrong, declaration)]) from None

    # Texts alone are a list, as in a text; so is an empty sequence, for which the fault is told there.
    items = list(given) if isinstance(given, Iterable) else [given]
    if not items or all(isinstance(item, str) for item in items):
        return parse_range(items, declaration, ambient_pressure, where, file)

    # Numbers, or numbers and texts: one by one, with the faults of all of them told at once.
    values, all_faults = [], []
    for item in items:
        try:
            values.append(value_of(item, declaration, ambient_pressure, where, file))
        except InputError as error:
            all_faults += error.faults
    if all_faults:
        raise InputError(all_faults)
    return values
