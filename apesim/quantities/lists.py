"""Lists: several numbers of one quantity in one key."""

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from apesim.quantities.declarations import DECIMAL_COMMA, Declaration, Quantity
from apesim.quantities.input_errors import InputError, InvalidValue, quoted
from apesim.quantities.ranges import parse_range
from apesim.quantities.units import unit

NO_LIST = np.empty(0)
"""A list that is not given."""


def as_parts(error: InputError) -> InvalidValue:
    """Return the faults of single numbers as one `InvalidValue` of the list that they stand in."""
    parts = tuple(("", InvalidValue(fault.wrong, fault.right)) for fault in error.faults)
    return InvalidValue(parts[0][1].wrong, parts[0][1].right, parts)


@dataclass(frozen=True)
class QuantityList(Declaration):
    """Several numbers of one quantity; inside an array in SI, shape (n,), empty where none is given.

    In a file it is a text with one unit for all, "0, 120, 240 deg", a range "0:240:120 deg", or a list of texts.
    `quantity` is what each number may be, `max_count` how many there are at most, `source` where such a list comes
    from, and `text` what holds if it is not given.
    """

    quantity: Quantity
    max_count: int
    source: str
    text: str | None = None

    @property
    def range_text(self) -> str:
        """The form of the list, and the range of each number."""
        return f"a list of 1 to {self.max_count}, each {self.quantity.range_text}"

    @property
    def strong(self) -> str:
        """A right form in TOML."""
        return self.quantity.strong

    def read(self, raw: Any, ambient_pressure: float | None = None, folder: Any = None) -> np.ndarray:
        """Return the numbers (n,) in SI of what a user wrote; "" gives `NO_LIST`. The folder is unused.

        Raises InvalidValue whose ``parts`` have every number that is refused.

        >>> angles = QuantityList(Quantity("deg", 0, 360, "chosen"), 8, "chosen")
        >>> np.degrees(angles.read("0, 120, 240 deg")).round(9).tolist()
        [0.0, 120.0, 240.0]
        """
        if isinstance(raw, str) and not raw.strip():
            return NO_LIST
        if not isinstance(raw, str | list | tuple):
            raise InvalidValue(f"{quoted(raw)} is no list", self.example(NO_LIST))
        try:
            values = parse_range(raw, self.quantity, ambient_pressure)
        except InputError as error:
            raise self._without_decimal_comma(raw, ambient_pressure) or as_parts(error) from None
        self._refuse_long(len(values))
        return np.array(values)

    def _without_decimal_comma(self, raw: Any, ambient_pressure: float | None) -> InvalidValue | None:
        """The `InvalidValue` of a text that is a right list with a space behind each comma; else None."""
        meant = re.sub(DECIMAL_COMMA, ", ", raw) if isinstance(raw, str) else raw
        if meant == raw:
            return None
        try:
            parse_range(meant, self.quantity, ambient_pressure)
        except InputError:
            return None
        return InvalidValue(f"{quoted(raw)} has a comma between digits, which may be a decimal one", f'write "{meant}"')

    def _refuse_long(self, count: int) -> None:
        if count > self.max_count:
            raise InvalidValue(f"{count} numbers are too many", f"give at most {self.max_count}")

    def check(self, value: Any) -> None:
        """Refuse an array, made in Python, that no text could have given; an empty one is no list and taken.

        Raises InvalidValue where the shape or type is wrong, or a number is out of range.
        """
        array = np.asarray(value)
        if array.ndim != 1 or array.dtype.kind not in "if":
            raise InvalidValue(f"an array of shape {array.shape} is no list of numbers", "give a list of floats in SI")
        self._refuse_long(len(array))
        for number in array.tolist():
            self.quantity.check(number)

    def _converted(self, value: Any) -> np.ndarray:
        """Convert a checked list to floats that lie as kernels need them, see `Declaration.convert`."""
        lies_right = type(value) is np.ndarray and value.dtype == float and value.flags.carray
        return value if lies_right else np.array(value, dtype=float, order="C")

    def render(self, value: np.ndarray, ambient_pressure: float | None = None) -> str:
        """Return the shortest text that reads back as an array (n,); "" for an empty one.

        The ambient pressure is unused.
        """
        scale = unit(self.quantity.unit)
        numbers = ", ".join(scale.shortest(number) for number in np.asarray(value).tolist())
        return f"{numbers} {self.quantity.unit}".strip() if numbers else ""

    def example(self, value: Any, ambient_pressure: float | None = None) -> str:
        """Return a right form for a message, a list of two; the arguments are unused."""
        scale = unit(self.quantity.unit)
        low, high = (end / scale.si("1") for end in self.quantity.ends)
        return f'write e.g. "{low:g}, {0.5 * (low + high):g} {self.quantity.unit}"'
