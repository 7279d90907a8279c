"""Curves: two columns of numbers, from a CSV or a table."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np

from apesim.quantities.declarations import Declaration
from apesim.quantities.files import csv_columns, path_below, split_header
from apesim.quantities.input_errors import InvalidValue, quoted
from apesim.quantities.units import MAX_TEXT, NUMBER, unit

NO_CURVE = np.empty((0, 2))
"""A curve that is not given."""

MAX_POINTS = 100_000
"""Largest number of points of a curve, a range or a list; far more than a kernel's table needs."""


@dataclass(frozen=True)
class Curve(Declaration):
    """Two columns of numbers; inside an array in SI, shape (n, 2), n >= 2, the first column rising.

    In a file it is the path of a CSV, which lies in the folder of that file or below, or a table of two lists; both
    name the columns with units. A CSV may hold more columns. A path on the command line may lead anywhere. Columns are
    declared by name and display unit, e.g. ``("time [ms]", "opening [-]")``; `source` says where such a curve comes
    from.
    """

    columns: tuple[str, str]
    source: str

    @property
    def range_text(self) -> str:
        """The form of the file."""
        return f'a CSV with the header "{",".join(self.columns)}"'

    @property
    def strong(self) -> str:
        """A right form in TOML."""
        return '"curve.csv"'

    def read(
        self, raw: Any, ambient_pressure: float | None = None, folder: str | PathLike[str] | None = None
    ) -> np.ndarray:
        """Return the curve (n, 2) in SI that a user wrote as a table of two lists, or named by a CSV's path.

        "" gives `NO_CURVE`. A text is a path from `folder`, that of the file which names the curve, and stays in it;
        without a folder, and for a Path, it may lead anywhere. The ambient pressure is unused. Raises InvalidValue
        where the file cannot be read, a column is missing or has a wrong unit, a value is no finite number, or the
        first column does not rise.
        """
        lists = ", ".join(f'"{header}" = [...]' for header in self.columns)
        right = f"give the path of {self.range_text}, or a table {{ {lists} }}"
        if raw == "":
            return NO_CURVE
        try:
            if isinstance(raw, str | PathLike):
                path = Path(raw) if folder is None or isinstance(raw, Path) else path_below(folder, fspath(raw))
                return self._array(csv_columns(path), f"{quoted(str(raw))}: ")
            if not isinstance(raw, dict) or not all(isinstance(column, list) for column in raw.values()):
                raise InvalidValue(f"{quoted(raw)} is no curve")
            columns = {split_header(header): column for header, column in raw.items()}
            if len(columns) != 2:
                raise InvalidValue(f"the table has {len(columns)} columns, not 2")
            return self._array(columns, "")
        except InvalidValue as wrong:
            raise InvalidValue(wrong.wrong, wrong.right or right) from None

    def _array(self, columns: Mapping[tuple[str, str | None], Sequence[Any]], file: str) -> np.ndarray:
        given = [self._column(columns, file, *split_header(header)) for header in self.columns]
        x, y = given
        if len(x) != len(y) or not 2 <= len(x) <= MAX_POINTS:
            raise InvalidValue(f"{file}columns of {len(x)} and {len(y)} numbers", f"give 2 to {MAX_POINTS} of both")
        if np.any(stuck := np.diff(x) <= 0):
            row = int(np.argmax(stuck)) + 2
            raise InvalidValue(f"{file}{self.columns[0]} does not rise in row {row}", "sort the rows, one of equals")
        return np.ascontiguousarray(np.transpose(given))

    def _column(
        self, columns: Mapping[tuple[str, str | None], Sequence[Any]], file: str, name: str, display_unit: str | None
    ) -> list[float]:
        found = [header for header in columns if header[0] == name]
        if len(found) != 1:
            raise InvalidValue(f"{file}{len(found) or 'no'} columns {quoted(name)}")
        if found[0][1] is None:
            raise InvalidValue(f"{file}column {quoted(name)} has no unit")
        given = unit(found[0][1])
        if given.dimension != unit(display_unit).dimension:
            raise InvalidValue(f"{file}{quoted(found[0][1])} is no unit of {quoted(name)}")
        values = []
        for row, raw in enumerate(columns[found[0]], 1):
            text = raw.strip() if isinstance(raw, str) else quoted(raw)
            value = given.si(text) if len(text) <= MAX_TEXT and re.fullmatch(NUMBER, text) else math.inf
            if math.isinf(value):
                raise InvalidValue(f"{file}{quoted(raw)} in row {row} is no finite number", "give numbers")
            values.append(value)
        return values

    def check(self, value: Any) -> None:
        """Refuse an array, made in Python, that no file could have given; (0, 2) is no curve and taken.

        Raises InvalidValue where the shape or type is wrong, a number is not finite, or the first column does not rise.
        """
        array = np.asarray(value)
        if array.shape == NO_CURVE.shape and array.dtype == NO_CURVE.dtype:
            return
        if array.shape[1:] != (2,) or len(array) == 1 or len(array) > MAX_POINTS or array.dtype.kind not in "if":
            raise InvalidValue(
                f"an array of shape {array.shape} is no curve", f"give 2 to {MAX_POINTS} rows of two floats"
            )
        if not np.all(np.isfinite(array)) or np.any(np.diff(array[:, 0]) <= 0.0):
            raise InvalidValue("is not finite, or its first column does not rise", "give finite floats in SI, sorted")

    def _converted(self, value: Any) -> np.ndarray:
        """Convert a checked array to floats that lie as the kernels are compiled for, see `Declaration.convert`."""
        lies_right = type(value) is np.ndarray and value.dtype == float and value.flags.carray
        return value if lies_right else np.array(value, dtype=float, order="C")

    def render(self, value: np.ndarray, ambient_pressure: float | None = None) -> dict[str, list[float]] | str:
        """Return the table in SI units, numbers by header, that reads back as a curve (n, 2); "" for no curve.

        The ambient pressure is unused.
        """
        if not len(value):
            return ""
        names = [split_header(header) for header in self.columns]
        return {f"{n} [{unit(u).si_text}]": value[:, i].tolist() for i, (n, u) in enumerate(names)}
