"""Tables: the numbers of a file of any length, column by column."""

import io
import json
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from apesim.quantities import InvalidValue, quoted
from apesim.studies.measured.cells import (
    LIKE_OVER_RANGE,
    SCPI_MISSING,
    SCPI_OVER_RANGE,
    Clock,
    is_missing,
    is_over_range,
)
from apesim.studies.measured.dialect import NUMBER_BEGINS, Marks
from apesim.studies.measured.layout import Layout, fit_cells, refuse_encoding, split_line, starts_numeric
from apesim.studies.measured.text_blocks import blocks_of_lines

MAX_ROWS = 50_000_000
"""Largest number of rows that are read: five times a long record of an oscilloscope."""
PLAIN_BYTES = b"0123456789+-.eEnNaA \t\n"
"""Bytes of numbers with a decimal point, and of nan, which NumPy reads at once."""
EXPONENT = r"(?:[eE][+-]?[0-9]{1,3})?"
"""The end of a number."""
SEGMENT = "Channels"
"""First word of the header that LabVIEW writes above a further segment, see the specification of its .lvm files."""
MAX_BEGINNING = 30
"""Characters of a line that are named to know it again."""
MAX_OFF_THOUSANDTH = 1e-6
"""Distance from a whole number of thousandths, below which a number has three decimals at most."""
MIN_JUMP = 0.5
"""Step between two rows over the largest number, from which a record jumps."""
MAX_SMOOTHER = 0.1
"""Largest step of a record over its largest number where points are thousands, over that where they are decimals, below
which they are thousands: a mark of thousands taken for a decimal one divides single rows by a thousand."""


def number_pattern(marks: Marks) -> re.Pattern[str]:
    """Make the pattern of a number with given marks, of which none is None.

    >>> pattern = number_pattern(Marks(",", "."))
    >>> [bool(pattern.fullmatch(cell)) for cell in ("1.234,5", "1234,5", "1,5e-3", "12.34", "1.5")]
    [True, True, True, False, False]
    """
    decimal, thousands = map(re.escape, (marks.decimal or "", marks.thousands or ""))
    whole = rf"(?:[0-9]{{1,3}}(?:{thousands}[0-9]{{3}})+|[0-9]+)" if thousands else "[0-9]+"
    body = rf"(?:{whole}(?:{decimal}[0-9]*)?|{decimal}[0-9]+)" if decimal else whole
    return re.compile(rf"[+-]?{body}{EXPONENT}")


class Numbers(NamedTuple):
    """Numbers of columns, by the place of the column."""

    values: dict[int, np.ndarray]
    """(n,) float arrays, NaN where a cell has no number."""
    over_range: dict[int, np.ndarray]
    """(m,) int arrays: rows, from 0, whose cell says that the number is over range."""
    ignored_lines: list[int]
    """Numbers of the lines that were passed over, from 1."""


def read_numbers(path: Path, layout: Layout, wanted: Mapping[int, Marks], clocks: Collection[int] = ()) -> Numbers:
    r"""Read columns of a file; a cell without a number is NaN.

    `wanted` has the marks of each column by its place, from 0, none of them None; `clocks` are the places of columns
    that hold clock times, which are read in seconds. Raises InvalidValue where a line is no row of the table, or a cell
    no number; its right form names the key of ``[read]`` that would help.
    """
    parts: dict[int, list[np.ndarray]] = {at: [np.empty(0)] for at in wanted}
    words: dict[int, list[int]] = {at: [] for at in wanted}
    readers = {at: Clock() for at in clocks}
    rows, ignored = 0, list[int]()
    for line, block in _data_blocks(path, layout, ignored):
        numbers = _read_at_once(block, layout, wanted)
        if numbers is None:
            numbers, over = _read_cell_by_cell(block, line, layout, wanted, readers)
            for at, places in over.items():
                words[at] += [rows + place for place in places]
        for at, values in numbers.items():
            parts[at].append(values)
        rows += len(next(iter(numbers.values()), ()))
        if rows > MAX_ROWS:
            raise InvalidValue(f"has more than {MAX_ROWS // 10**6} million rows", "cut it into several records")
    columns = {at: np.concatenate(parts.pop(at)) for at in wanted}
    over_range = {at: _take_out(columns[at], words[at], layout.missing_numbers) for at in wanted}
    return Numbers(columns, over_range, ignored)


def _take_out(values: np.ndarray, words: Sequence[int], missing: Collection[float]) -> np.ndarray:
    """Put NaN for the numbers that stand for none; returns the rows that are over range, by words or by a number."""
    is_over = np.abs(values) == SCPI_OVER_RANGE
    is_none = is_over | (values == SCPI_MISSING)
    for number in missing:
        is_none |= values == number
    if is_none.any():
        values[is_none] = np.nan
    return np.union1d(np.flatnonzero(is_over), np.array(words, dtype=int))


def _data_blocks(path: Path, layout: Layout, passed: list[int] | None = None) -> Iterator[tuple[int, bytes]]:
    """Blocks of the file below its header, each with the number of lines above it.

    Ignored lines are empty in them; `passed` gets their numbers, from 1.
    """
    line, due = 0, layout.first_line
    for block in blocks_of_lines(path, layout.encoding):
        number = block.count(b"\n")
        while due and number:
            end = block.index(b"\n") + 1
            block, due, number, line = block[end:], due - 1, number - 1, line + 1
        if block and layout.ignored:
            if passed is not None:
                matches = layout.ignored.finditer(block)
                passed += (line + 1 + block[: match.start()].count(b"\n") for match in matches)
            block = layout.ignored.sub(b"", block)
        if block:
            yield line, block
        line += number


def _read_at_once(block: bytes, layout: Layout, wanted: Mapping[int, Marks]) -> dict[int, np.ndarray] | None:
    """Columns of a block of plain numbers; None where not all of it is plain."""
    decimals = {marks.decimal for marks in wanted.values()}
    if len(decimals) != 1 or any(marks.thousands for marks in wanted.values()):
        return None
    [decimal] = decimals
    if decimal == layout.separator:
        return None
    separator = layout.separator.encode()
    if decimal == ",":
        if b"." in block:
            return None
        block = block.replace(b",", b".")
    elif decimal == "" and b"." in block:
        return None
    if block.translate(None, PLAIN_BYTES + separator) or (separator != b"\t" and separator != b" " and b"\t" in block):
        return None
    number = len(layout.headers)
    try:
        if not block.strip():
            return {at: np.empty(0) for at in wanted}
        delimiter = None if layout.separator == " " else layout.separator
        numbers = np.loadtxt(io.BytesIO(block), delimiter=delimiter, comments=None, ndmin=2)
    except ValueError:
        return None
    is_whole = number - layout.optional <= numbers.shape[1] <= number
    return {at: numbers[:, at].copy() for at in wanted} if is_whole else None


def _read_cell_by_cell(
    block: bytes, line: int, layout: Layout, wanted: Mapping[int, Marks], clocks: Mapping[int, Clock]
) -> tuple[dict[int, np.ndarray], dict[int, list[int]]]:
    """Columns of a block in any dialect, and the rows of cells over range; so many lines stand above it."""
    over: dict[int, list[int]] = {at: [] for at in wanted}
    patterns = {at: number_pattern(marks) for at, marks in wanted.items()}
    values: dict[int, list[float]] = {at: [] for at in wanted}
    for number, cells in _rows_of(block, line, layout):
        for at, (decimal, thousands) in wanted.items():
            cell = cells[at]
            if at in clocks and not is_missing(cell):
                try:
                    values[at].append(clocks[at].read(cell))
                except InvalidValue as wrong:
                    raise InvalidValue(f"line {number}: {wrong.wrong}", wrong.right) from None
            elif patterns[at].fullmatch(cell):
                if thousands:
                    cell = cell.replace(thousands, "")
                values[at].append(float(cell.replace(",", ".") if decimal == "," else cell))
            elif is_missing(cell) or is_over_range(cell) or cell.lower() in layout.missing:
                if is_over_range(cell) or (cell.lower() in layout.missing and LIKE_OVER_RANGE.search(cell)):
                    over[at].append(len(values[at]))
                values[at].append(np.nan)
            else:
                raise LineError(number, cells[0]) if _has_words_alone(cells) else CellError(at, cell, number)
    return {at: np.array(column, dtype=float) for at, column in values.items()}, over


def _rows_of(block: bytes, line: int, layout: Layout) -> Iterator[tuple[int, list[str]]]:
    """Numbers of the lines, from 1, and cells of the rows of a block; so many lines stand above it."""
    try:
        lines = block.decode().split("\n")[:-1]
    except UnicodeDecodeError as error:
        raise refuse_encoding(line + block[: error.start].count(b"\n") + 1) from None
    number = len(layout.headers)
    for at, text in enumerate(lines, line + 1):
        if not text.strip():
            continue
        try:
            cells = fit_cells(split_line(text, layout.separator), number, layout.optional)
        except InvalidValue as error:
            raise InvalidValue(f"line {at} {error.wrong}", error.right) from None
        if cells[0] == SEGMENT:
            right = "save each segment in a file of its own"
            raise InvalidValue(f"line {at} begins another segment of LabVIEW", right)
        if len(cells) != number:
            if _has_words_alone(cells):
                raise LineError(at, cells[0])
            above = "header" if any(layout.headers) else "first row"
            wrong = f"line {at} has {len(cells)} cell{'s' * (len(cells) != 1)}, the {above} {number}"
            right = "make all rows as long, or write the separator and skip_rows in [read]"
            raise InvalidValue(wrong, right)
        yield at, cells


def _has_words_alone(cells: Sequence[str]) -> bool:
    """Whether cells are those of a footer, a header or a remark: the first is a word, and none is a number."""
    return not is_missing(cells[0]) and not any(map(starts_numeric, cells))


class LineError(InvalidValue):
    """Error of a line below the header that has words and no number: the line's number and first cell."""

    def __init__(self, line: int, cell: str) -> None:
        super().__init__(f"line {line} is no row of numbers, it begins with {quoted(cell)}", "take the line out")
        self.cell = cell


class CellError(InvalidValue):
    """Error of a cell that holds no number, in a row of numbers.

    `at` is the place of the column, from 0, `cell` what stands there, `line` the number of its line.
    """

    def __init__(self, at: int, cell: str, line: int) -> None:
        super().__init__(f"{quoted(cell)} in line {line} is no finite number", "give a number in every cell")
        self.at, self.cell = at, cell


def is_ambiguous(path: Path, layout: Layout, at: int, values: np.ndarray, decimal: str) -> bool:
    r"""Tell whether the decimal marks of a column may be marks of thousands, as nothing in it shows which.

    1.234 may be both. A number below 1, one of four digits without a mark, or one with other than three decimals shows
    that the mark is decimal. In the layout of the files that apesim writes, where the mark is known to be a point, it
    only tells whether the record jumps as long as points are decimal. `at` is the place of the column, from 0, `values`
    its numbers (n,), read with the mark `decimal`.

    >>> import tempfile
    >>> from apesim.studies.measured.dialect import Dialect
    >>> from apesim.studies.measured.layout import find_layout
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "p040.csv")
    ...     _ = path.write_text("time [us];lift [mm]\n999.000;0.5\n1.000;0.6\n")
    ...     layout = find_layout(path, Dialect(), ("time", "lift"))
    ...     [is_ambiguous(path, layout, at, np.array(values), ".") for at, values in enumerate([[999, 1], [0.5, 0.6]])]
    [True, False]
    """
    if not decimal or not _may_be_thousands(values) or (layout.is_plain and _largest_step(values) < MIN_JUMP):
        return False
    undecided = re.compile(rf"[+-]?[1-9][0-9]{{0,2}}{re.escape(decimal)}[0-9]{{3}}")
    neutral = re.compile(rf"[+-]?(?:[0-9]{{1,3}}|0{re.escape(decimal)}000)")
    is_marked: list[bool] = []
    for line, block in _data_blocks(path, layout):
        for _, cells in _rows_of(block, line, layout):
            cell = cells[at]
            if not (is_missing(cell) or is_over_range(cell) or undecided.fullmatch(cell) or neutral.fullmatch(cell)):
                return False
            is_marked.append(bool(undecided.fullmatch(cell)))
    marked = np.array(is_marked)
    if not layout.is_plain or not marked.any():
        return bool(marked.any())
    return _largest_step(np.where(marked, 1e3 * values, values)) < MAX_SMOOTHER * _largest_step(values)


def _may_be_thousands(values: np.ndarray) -> bool:
    """Whether all numbers are such as a mark of thousands, taken for a decimal one, makes."""
    sizes = np.abs(values[np.isfinite(values)])
    sizes = sizes[sizes > 0.0]
    thousandths = 1e3 * sizes
    is_one = (
        (sizes >= 1.0) & (sizes < 1e3) & (np.abs(thousandths - np.rint(thousandths)) < MAX_OFF_THOUSANDTH * thousandths)
    )
    return bool(len(sizes) and np.all(is_one))


def _largest_step(values: np.ndarray) -> float:
    """Largest step between neighbours over the largest number."""
    values = values[np.isfinite(values)]
    return (
        float(np.max(np.abs(np.diff(values))) / np.max(np.abs(values))) if len(values) > 1 and np.any(values) else 0.0
    )


def name_ignored_line(cell: str) -> str:
    """Name the key of ``[read]`` that passes over lines that begin with a cell; "" where rows of numbers may, too."""
    text = cell.split('"')[0][:MAX_BEGINNING].strip()
    if NUMBER_BEGINS.fullmatch(text) or starts_numeric(text):
        return ""
    return f"write ignore_lines = [{json.dumps(text, ensure_ascii=False)}] in [read] to pass over such lines"


def name_remedy(cell: str, marks: Marks, name: str) -> str:
    """Name the key of ``[read]`` that would make a number of a cell; "" where no key would help.

    `marks` are those that the cell was read with, `name` is our name of its column.

    >>> name_remedy("1,5", Marks(".", ""), "lift")
    'write decimal = "," in [read]'
    >>> name_remedy("1.002.000", Marks(".", ""), "time")
    'write thousands = "." and decimal = "" in [read.column.time]'
    """
    for decimal in (".", ","):
        if decimal != marks.decimal and number_pattern(Marks(decimal, "")).fullmatch(cell):
            return f'write decimal = "{decimal}" in [read]'
    for thousands, decimal in ((".", ""), (",", ""), ("'", "."), (" ", "."), (" ", ","), (".", ","), (",", ".")):
        if number_pattern(Marks(decimal, thousands)).fullmatch(cell):
            return f'write thousands = "{thousands}" and decimal = "{decimal}" in [read.column.{name}]'
    return ""
