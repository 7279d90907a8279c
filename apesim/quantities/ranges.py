"""Ranges: single texts, and ranges and lists of them, as on a command line."""

import re
from decimal import Decimal, localcontext

from apesim.quantities.curves import MAX_POINTS
from apesim.quantities.declarations import DECIMAL_COMMA, Quantity
from apesim.quantities.input_errors import InputError, InvalidValue, make_fault, quoted
from apesim.quantities.units import NUMBER


def parse(text, declaration, ambient_pressure=None, where="", file=""):
    """The inner value of a single text, say of a command-line option.

    Parameters
    ----------
    text : str
        E.g. "9 mm", "0.49 MPa gauge", "epv".
    declaration : Quantity, Choice or Curve
    ambient_pressure : float, optional
        What gauge pressures stand above [Pa].
    where, file : str
        The option or key, and the file, for the message.

    Returns
    -------
    float, int or (n, 2) float array
        In SI; a choice as its index.

    Raises
    ------
    InputError
        With the one fault.
    """
    try:
        return declaration.read(text, ambient_pressure)
    except InvalidValue as wrong:
        wrong = wrong if wrong.right else _several(text, declaration, ambient_pressure) or wrong
        raise InputError([make_fault(file, where, wrong, declaration)]) from None


def _several(text, declaration, ambient_pressure):
    """The `InvalidValue` of a good range or list where a single text is due; else None."""
    if not isinstance(text, str) or not isinstance(declaration, Quantity):
        return None
    try:
        items = _steps(text, declaration) if ":" in text else text.split(",")
        declaration.read(items[0], ambient_pressure)
    except InvalidValue:
        return None
    return InvalidValue(f"{quoted(text)} is more than one value", f'write one, e.g. "{items[0].strip()}"')


def parse_range(text, declaration, ambient_pressure=None, where="", file=""):
    """The values of a range or list.

    Parameters
    ----------
    text : str or list of str
        "300:3000:100 rpm" (start:stop:step; the stop is included if a step meets it),
        "0.4:1.0:0.2 MPa gauge", "500 rpm, 600 rpm", or a list of single texts.
    declaration, ambient_pressure, where, file
        As in `parse`.

    Returns
    -------
    list of float
        At most 100 000; of int for a choice.

    Raises
    ------
    InputError
        With a fault for each wrong item of a list, or the one of a start:stop:step.
    """
    try:
        return _values(text, declaration, ambient_pressure, where, file)
    except InputError as error:
        raise _with_points(text, declaration, ambient_pressure, where, file) or error from None


def _with_points(text, declaration, ambient_pressure, where, file):
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


def _values(text, declaration, ambient_pressure, where, file):
    """The values of a range or list, see `parse_range`."""
    values, faults, items = [], [], text.split(",") if isinstance(text, str) else text
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


def _steps(text, quantity):
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
