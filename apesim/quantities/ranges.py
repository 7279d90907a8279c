"""Ranges: single texts, and ranges and lists of them, as on a command line."""

import re
from collections.abc import Sequence
from decimal import Decimal, localcontext
from typing import Any

from apesim.quantities.curves import MAX_POINTS, Curve
from apesim.quantities.declarations import DECIMAL_COMMA, Choice, Quantity
from apesim.quantities.input_errors import InputError, InvalidValue, make_fault, quoted
from apesim.quantities.units import NUMBER

Declared = Quantity | Choice | Curve
"""Type of a declaration: what a value may be."""


def parse(
    text: Any, declaration: Declared, ambient_pressure: float | None = None, where: str = "", file: str = ""
) -> Any:
    """Return the value in SI of a single text, such as an option of the command line: "9 mm", "0.49 MPa gauge", "epv".

    A choice gives its index, a curve, named by its path, its two columns (n, 2). Gauge pressures stand above
    `ambient_pressure` [Pa abs]. Raises InputError, which names `where` and `file`, where the text is refused.
    """
    try:
        return declaration.read(text, ambient_pressure)
    except InvalidValue as wrong:
        wrong = wrong if wrong.right else _several(text, declaration, ambient_pressure) or wrong
        raise InputError([make_fault(file, where, wrong, declaration)]) from None


def _several(text: Any, declaration: Declared, ambient_pressure: float | None) -> InvalidValue | None:
    """The `InvalidValue` of a good range or list where a single text is due; else None."""
    if not isinstance(text, str) or not isinstance(declaration, Quantity):
        return None
    try:
        items = _steps(text, declaration) if ":" in text else _listed(text, declaration)
        declaration.read(items[0], ambient_pressure)
    except InvalidValue:
        return None
    return InvalidValue(f"{quoted(text)} is more than one value", f'write one, e.g. "{items[0].strip()}"')


def parse_range(
    text: str | Sequence[Any],
    declaration: Declared,
    ambient_pressure: float | None = None,
    where: str = "",
    file: str = "",
) -> list[Any]:
    """Return the values in SI, at most `MAX_POINTS`, of a range "300:3000:100 rpm", a list "500, 600 rpm", or texts.

    A range is start:stop:step, the stop included if a step meets it; a unit at the end alone is that of all. Gauge
    pressures stand above `ambient_pressure` [Pa abs]. Raises InputError, which names `where` and `file`, where there is
    no value or too many, or some are refused: a fault for each wrong item of a list, or the one of a start:stop:step.

    >>> from apesim.quantities import Quantity
    >>> stroke = Quantity("mm", 1, 50, "chosen")
    >>> parse_range("2:6:2 mm", stroke), parse_range("2, 5 mm", stroke)
    ([0.002, 0.004, 0.006], [0.002, 0.005])
    """
    try:
        return _values(text, declaration, ambient_pressure, where, file)
    except InputError as error:
        raise _with_points(text, declaration, ambient_pressure, where, file) or error from None


def _with_points(
    text: Any, declaration: Declared, ambient_pressure: float | None, where: str, file: str
) -> InputError | None:
    """The `InputError` of a range or list that is right with decimal points for commas; else None."""
    meant = re.sub(DECIMAL_COMMA, ".", text) if isinstance(text, str) else text
    if meant == text:
        return None
    try:
        _values(meant, declaration, ambient_pressure, where, file)
    except InputError:
        return None
    wrong = InvalidValue(f"{quoted(text)} has a comma between digits", f'write "{meant}", or give each value its unit')
    return InputError([make_fault(file, where, wrong, declaration)])


def _values(text: Any, declaration: Declared, ambient_pressure: float | None, where: str, file: str) -> list[Any]:
    """The values of a range or list, see `parse_range`."""
    values, faults, items = [], [], _listed(text, declaration) if isinstance(text, str) else text
    try:
        if isinstance(text, str) and ":" in text and isinstance(declaration, Quantity):
            items = _steps(text, declaration)
            for end in (items[0], items[-1]):  # what lies between good ends is good
                declaration.read(end, ambient_pressure)
        if not isinstance(items, list | tuple) or not 0 < len(items) <= MAX_POINTS:
            raise InvalidValue(f"{quoted(text)} is no list of 1 to {MAX_POINTS} texts")
    except InvalidValue as wrong:
        raise InputError([make_fault(file, where, wrong, declaration)]) from None
    for item in items:
        try:
            values.append(declaration.read(item, ambient_pressure))
        except InvalidValue as wrong:
            faults.append(make_fault(file, where, wrong, declaration))
    if faults:
        raise InputError(faults)
    return values


def _listed(text: str, declaration: Declared) -> list[str]:
    """The items of a list in a text; where the last one alone has a unit, it is that of all, as in a range.

    With a comma between digits, which may be a decimal one, each item has to say its own.
    """
    items = text.split(",")
    last = re.match(rf"\s*{NUMBER}\s*", items[-1])
    name = items[-1][last.end() :].strip() if last else ""
    bare = all(re.fullmatch(NUMBER, item.strip()) for item in items[:-1])
    if not isinstance(declaration, Quantity) or not name or not bare or re.search(DECIMAL_COMMA, text):
        return items
    return [*(f"{item.strip()} {name}" for item in items[:-1]), items[-1]]


def _steps(text: str, quantity: Quantity) -> list[str]:
    """The texts of the points of start:stop:step, computed in decimals."""
    found = re.fullmatch(rf"{NUMBER}\s*:\s*{NUMBER}\s*:\s*{NUMBER}\s*(.*)", text.strip()[:400])
    if not found:
        form = f"start:stop:step {quantity.unit}{quantity.suffix}".strip()
        raise InvalidValue(f"{quoted(text)} is no range", f'write e.g. "300:3000:100 rpm", here {form}')
    *numbers, name = found.groups()
    if quantity.unit and not name:
        form = f"{':'.join(numbers)} {quantity.unit}{quantity.suffix}"
        raise InvalidValue(f"{quoted(text)} has no unit", f'write e.g. "{form}"')
    with localcontext(prec=60):
        start, stop, step = map(Decimal, numbers)
        if not step:
            raise InvalidValue(f"{quoted(text)}: the step is 0", "give a step that leads from start to stop")
        if (stop - start) / step < 0:
            raise InvalidValue(f"{quoted(text)}: steps of {step} do not lead to {stop}", "turn the sign of the step")
        count = (stop - start) / step + Decimal("1e-9")
        if count >= MAX_POINTS:
            raise InvalidValue(f"{quoted(text)} has more than {MAX_POINTS} points", "take a larger step")
        nearer = min if step > 0 else max
        return [f"{nearer(start + i * step, stop)} {name}" for i in range(int(count) + 1)]
