"""Arguments: what a function is called with from Python, refused in the words of a file or of the command line."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from apesim.quantities.curves import Curve
from apesim.quantities.declarations import Choice, Quantity
from apesim.quantities.input_errors import Fault, InputError, InvalidValue, make_fault
from apesim.quantities.ranges import parse, parse_range

Declared = Quantity | Choice | Curve


class Arguments:
    """The arguments of one call: all are read, and what is wrong is raised for all of them at once.

    Parameters
    ----------
    function : str
        Name of the function, for messages.
    ambient_pressure : float, optional
        What gauge pressures stand above [Pa].

    Examples
    --------
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
        """An argument in SI, from a text with a unit or a float in SI; None where it is wrong or None itself."""
        if given is None:
            return None
        try:
            return value_of(given, declaration, self.ambient_pressure, name, self.where)
        except InputError as error:
            self.faults += error.faults
            return None

    def range(self, name: str, given: Any, declaration: Declared) -> list[Any]:
        """Values in SI, from a range or list in a text, or a sequence of texts and floats; [] where it is wrong."""
        try:
            return values_of(given, declaration, self.ambient_pressure, name, self.where)
        except InputError as error:
            self.faults += error.faults
            return []

    def fault(self, name: str, wrong: str, right: str) -> None:
        """Note a fault that only several arguments show."""
        self.faults.append(Fault(self.where, name, wrong, right))

    def refuse(self) -> None:
        """Raise `InputError` with all that is wrong, if anything is."""
        if self.faults:
            raise InputError(self.faults)


def value_of(
    given: Any, declaration: Declared, ambient_pressure: float | None = None, where: str = "", file: str = ""
) -> Any:
    """The SI value of a text with its unit, or of a number in SI; a choice is its word, or the index of it.

    Parameters
    ----------
    given : str, float, int or array
    declaration : Quantity, Choice or Curve
    ambient_pressure : float, optional
        What gauge pressures stand above [Pa].
    where, file : str
        The key and what it was given to, for the message.

    Returns
    -------
    float, int or (n, 2) float array

    Raises
    ------
    InputError
        With the one fault.
    """
    if isinstance(given, str):
        return parse(given, declaration, ambient_pressure, where, file)
    try:
        return checked_value(given, declaration, ambient_pressure)
    except InvalidValue as wrong:
        raise InputError([make_fault(file, where, wrong, declaration)]) from None


def checked_value(given: Any, declaration: Declared, ambient_pressure: float | None = None) -> Any:
    """The SI value of a text or number as the kernels are compiled for it; raises `InvalidValue`."""
    if isinstance(given, str) or hasattr(given, "__fspath__"):
        return declaration.read(given, ambient_pressure)
    declaration.check(given)
    if isinstance(declaration, Curve):
        return np.array(given, dtype=float)
    return int(given) if isinstance(declaration, Choice) else float(given)


def values_of(
    given: Any, declaration: Declared, ambient_pressure: float | None = None, where: str = "", file: str = ""
) -> list[Any]:
    """Values in SI of a range or list in a text, of one number, or of a sequence of texts and numbers.

    Parameters
    ----------
    given : str, float, or iterable of them
    declaration, ambient_pressure, where, file
        See `value_of`.

    Returns
    -------
    list of float, or of int for a choice

    Raises
    ------
    InputError
        With a fault for each wrong item.
    """
    if isinstance(given, str):
        return parse_range(given, declaration, ambient_pressure, where, file)
    items = list(given) if isinstance(given, Iterable) else [given]
    if not items or all(isinstance(item, str) for item in items):
        return parse_range(items, declaration, ambient_pressure, where, file)
    values, all_faults = [], []
    for item in items:
        try:
            values.append(value_of(item, declaration, ambient_pressure, where, file))
        except InputError as error:
            all_faults += error.faults
    if all_faults:
        raise InputError(all_faults)
    return values
