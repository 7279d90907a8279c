"""Uncertainties: standard deviations within which numbers of a machine are known."""

import math
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any, NamedTuple

from apesim.quantities.declarations import Quantity
from apesim.quantities.input_errors import InvalidValue, quoted
from apesim.quantities.units import Unit, respelt, split_number, unit

EXACT = "exact"
"""Word for a number that counts as exact."""
KELVIN = (("kelvin", 1),)
"""Dimension of a temperature: a share of it depends on where its scale begins."""
TYPICAL_SHARE = 0.01
"""Share of a value, or of its range, that a right form shows."""


class Uncertainty(NamedTuple):
    """Standard deviation within which a number is known; 0: it counts as exact."""

    deviation: float
    """A share of the value where `is_share`, else SI."""
    is_share: bool = False
    """Whether it is a share of the value."""


def read_uncertainty(raw: Any, declaration: Quantity, value: float = math.nan) -> Uncertainty:
    """Read a standard deviation as users write it: a share with "%", a number with its unit, or "exact".

    `declaration` is that of the number that is known to it, and `value` its usual value in SI, to show a right form.
    Raises InvalidValue where it is no number, is negative, has no unit or one of another dimension, or is wider than
    the range.

    >>> stroke = Quantity("mm", 1, 50, "chosen")
    >>> [read_uncertainty(text, stroke).deviation for text in ("50 um", "2 %", "exact")]
    [5e-05, 0.02, 0.0]
    >>> read_uncertainty("0.05", stroke, 9e-3)
    Traceback (most recent call last):
    ...
    apesim.quantities.input_errors.InvalidValue: ("'0.05' has no unit", 'write e.g. "1 %" or "0.09 mm"')
    """
    right = f"write e.g. {' or '.join(_right_forms(declaration, value))}"

    # A number or the word: a bool counts as an int in Python, and is none here.
    if isinstance(raw, bool) or not isinstance(raw, str | int | float):
        raise InvalidValue(f"{quoted(raw)} is no standard deviation", right)
    text = raw.strip() if isinstance(raw, str) else repr(float(raw))
    if text == EXACT:
        return Uncertainty(0.0)
    found = split_number(text)
    if not found:
        raise InvalidValue(f"{quoted(raw)} is no standard deviation", right)

    # The unit. A deviation is a difference: gauge and abs say nothing of it.
    number, name = found
    if declaration.unit and not name:
        raise InvalidValue(f"{quoted(raw)} has no unit", right)
    if name.endswith((" abs", " gauge")):
        meant = text.rpartition(" ")[0]
        raise InvalidValue(f"{quoted(raw)}: a difference is neither gauge nor abs", f'write "{meant}"')
    scale = _find_scale(raw, text, name, right)
    if float(number) < 0.0:
        raise InvalidValue(f"{quoted(raw)} is negative", f'{right}, or "{EXACT}"')
    deviation = scale.si(number)

    # What it is of. A share of a temperature would depend on where its scale begins.
    is_share = bool(name) and not scale.dimension
    if is_share and unit(declaration.unit).dimension == KELVIN:
        raise InvalidValue(f"{quoted(raw)} is a share of a temperature", right)
    if not is_share and scale.dimension != unit(declaration.unit).dimension:
        raise InvalidValue(
            f"{quoted(raw)}: {quoted(name)} cannot be converted to {declaration.unit or 'a share'}", right
        )

    # The size: a deviation that is wider than the range says less than the range does.
    if is_share and not deviation <= 1.0:
        raise InvalidValue(f"{quoted(raw)} is out of range", "allowed: 0 to 100 %")
    low, high = declaration.ends
    if not is_share and not deviation <= min(high - low, abs(high) if math.isinf(low) else math.inf, 1e300):
        raise InvalidValue(f"{quoted(raw)} is wider than the range itself, {declaration.range_text}", right)
    return Uncertainty(deviation, is_share and deviation > 0.0)


def _find_scale(raw: Any, text: str, name: str, right: str) -> Unit:
    """Unit that a text names; a temperature with a zero of its own is none for a difference."""
    try:
        scale = unit(name)
    except InvalidValue as wrong:
        meant = respelt(text)
        raise InvalidValue(f"{quoted(raw)}: {wrong.wrong}", f'write "{meant}"' if meant != text else right) from None
    if scale.offset:
        raise InvalidValue(f"{quoted(raw)}: a difference of temperatures is in K", right)
    return scale


def _right_forms(declaration: Quantity, value: float) -> list[str]:
    """Right forms in TOML: a share, unless it is of a temperature, and a number with its unit."""
    scale = unit(declaration.unit)
    usual = abs(value) if math.isfinite(value) and value else next(filter(math.isfinite, declaration.ends[::-1]), 1.0)
    number = f"{TYPICAL_SHARE * usual / float(scale.factor):.2g} {declaration.unit}".strip()
    forms = ['"1 %"', f'"{number}"' if declaration.unit else number]
    return forms[1:] if scale.dimension == KELVIN else forms


def format_uncertainty(uncertainty: Uncertainty, declaration: Quantity) -> str:
    """Write a standard deviation of a declared number as `read_uncertainty` reads it."""
    if not uncertainty.deviation:
        return EXACT
    name = "%" if uncertainty.is_share else declaration.unit
    return f"{unit(name)._replace(offset=Fraction(0)).shortest(uncertainty.deviation)} {name}".strip()


def flatten(table: Mapping[str, Any], section: str = "") -> Iterator[tuple[str, Any]]:
    """Flatten tables in tables, which TOML makes of keys whose dots stand without quotes, to keys with dots and values.

    `section` is set before the keys.

    >>> list(flatten({"valve": {"stroke": "1 %"}, "sensor.lift.gain": "0.2 %"}))
    [('valve.stroke', '1 %'), ('sensor.lift.gain', '0.2 %')]
    """
    for key, raw in table.items():
        if isinstance(raw, Mapping) and raw:
            yield from flatten(raw, f"{section}{key}.")
        else:
            yield f"{section}{key}", raw
