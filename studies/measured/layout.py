"""Layouts: where header and numbers of a file stand, and what separates them, as a dialect says or as is guessed."""

import csv
import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from apesim.quantities import InvalidValue, quoted, unit
from apesim.quantities.files import split_header
from apesim.studies.measured.cells import ANY_NUMBER, is_clock, is_missing, is_word, split_stated
from apesim.studies.measured.conversion import split_kind
from apesim.studies.measured.dialect import SEPARATORS, Dialect, Marks
from apesim.studies.measured.text_blocks import HEAD_BYTES, blocks_of_lines, guess_encoding, read_head

GUESSED_ROWS = 200
"""Rows of numbers from which separator and marks are guessed."""
MAX_PREAMBLE = 500
"""Lines among which a header is looked for, to say where it may be."""
MAX_HEADER = 300
"""Characters of a header in which a name and a unit are told apart; in a longer one the patterns would take minutes."""
MIN_COLUMNS = 2
"""Columns of numbers that a table has: what it stands over, and one sensor."""
MIN_SHARE = 0.5
"""Share of rows that have to show a separator; the others are faults, each with its line."""
GUESSES = ("\t", ";", ",", " ")
"""Separators that are tried. A comma and a blank stand in numbers and headers, too, and come last."""


CountTail = Callable[[Sequence[str]], int]
"""Type of what counts the last columns of a header that a row may lack."""


class Layout(NamedTuple):
    """Places of header and numbers in a file, and what separates them."""

    encoding: str
    """Encoding of its text."""
    separator: str
    """Character between cells; " ": any run of blanks and tabs."""
    headers: tuple[str, ...]
    """Header of each column, with the unit that a second line gives; "" where there is none."""
    names: tuple[str, ...]
    """Header of each column as it stands in its line."""
    skip_rows: int
    """Lines above the header, or above the numbers where there is none."""
    first_line: int
    """Lines above those that may be rows of numbers."""
    decimal: str
    """Decimal mark where none is said."""
    is_plain: bool
    """Whether it is the layout of the files that apesim writes: header in line 1, commas, decimal points."""
    guessed: Mapping[str, str]
    """What was guessed and differs from the files that apesim writes, by key of ``[read]``."""
    has_units: bool = False
    """Whether the line under the header holds units."""
    ignored: re.Pattern[bytes] | None = None
    """Pattern of the lines below the header that are passed over; None: there are none."""
    optional: int = 0
    """Last columns that nobody asks for: a row may end before them."""
    clocks: frozenset[int] = frozenset()
    """Places of columns of clock times, from 0."""
    missing: frozenset[str] = frozenset()
    """Texts that are stated to be no number, in small letters."""
    missing_numbers: frozenset[float] = frozenset()
    """Numbers that are stated to be none."""


BRACKETS = r"\(((?:[^()]|\([^()]*\))*)\)"
"""Brackets, which may hold one more pair: (bar(g))."""


def split_line(line: str, separator: str) -> list[str]:
    """Split a line of numbers into its cells, without blanks around them; separator " ": any run of blanks and tabs.

    Raises InvalidValue where a quotation in it has no end.

    >>> split_line('0,5;"1,25"; -', ";"), split_line(" 0.5   1.25 ", " ")
    (['0,5', '1,25', '-'], ['0.5', '1.25'])
    """
    if '"' in line:
        quiet = " ".join(line.split()) if separator == " " else line
        try:
            reader = csv.reader([quiet], delimiter=separator, strict=True, skipinitialspace=True)
            return [cell.strip() for cell in next(reader)]
        except csv.Error:
            raise InvalidValue("has a quotation without an end", "write each cell in no or in two quotes") from None
    return line.split() if separator == " " else [cell.strip() for cell in line.split(separator)]


def is_unit(text: str | None) -> bool:
    """Tell whether a text is a unit, with ``abs`` or ``gauge`` behind it or without."""
    try:
        return text is not None and bool(unit(split_kind(text)[0]))
    except InvalidValue:
        return False


def split_name(text: str) -> tuple[str, str | None]:
    """Split a laboratory's header into name and unit: the unit in brackets, behind a slash or behind "in".

    The unit is None where what stands there is no unit.

    >>> [split_name(text) for text in ("Zeit (s)", "Weg / mm", "p in bar", "lift [mm]", "Ch1 (raw)")]
    [('Zeit', 's'), ('Weg', 'mm'), ('p', 'bar'), ('lift', 'mm'), ('Ch1 (raw)', None)]
    """
    name, named = split_header(text)
    if named is not None or len(text) > MAX_HEADER:
        return name, named
    forms = [rf"(.*?)\s*{BRACKETS}", r"(.*?)\s*/\s*(.*)", r"(.*?)\s+in\s+(.*)"]
    if re.search(r"\(\s*[gG]\s*\)\s*$", text):  # in bar (g) it is no gram
        forms.append(forms.pop(0))
    for form in forms:
        parts = re.fullmatch(form, text.strip())
        if parts and parts[1] and parts[2].strip() and is_unit(parts[2].strip()):
            return parts[1], parts[2].strip()
    return text.strip(), None


def find_layout(path: Path, dialect: Dialect, names: Sequence[str]) -> Layout:
    r"""Find header and numbers in a file, from what `dialect` says of it and our `names` of columns.

    Raises InvalidValue where the file cannot be read, or is no such table; the right form names the key of ``[read]``
    that would help.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "p040.csv").write_text("time [ms];lift [mm]\n0,0;0,01\n0,5;0,02\n")
    ...     layout = find_layout(Path(folder, "p040.csv"), Dialect(), ("time", "lift"))
    >>> layout.headers, layout.separator, layout.decimal, layout.guessed
    (('time [ms]', 'lift [mm]'), ';', ',', {'separator': 'semicolon', 'decimal': ','})
    """
    data, is_whole = read_head(path)
    encoding = dialect.encoding or guess_encoding(data, is_whole=is_whole)
    lines = _first_lines(path, encoding, dialect.skip_rows + MAX_PREAMBLE)

    # The lines that may be header and rows. Lines are ignored below the header alone: it may begin with such a text.
    above = [number for number, line in enumerate(lines) if number >= dialect.skip_rows and line.strip()]
    ignored = ignored_pattern(dialect.ignore_lines)
    if ignored:
        heads, others = above[: dialect.header], above[dialect.header :]
        above = [*heads, *(number for number in others if not ignored.match(lines[number].encode()))]
    if not above:
        where = f" after {dialect.skip_rows} rows" if dialect.skip_rows else ""
        raise InvalidValue(f"there is nothing{where}", "give a file with rows of numbers")
    first = above[0]
    header = lines[first] if dialect.header else None
    rows = [lines[number] for number in above[dialect.header :]][: GUESSED_ROWS + 1]

    # The separator, as stated or as the first rows show it. Marks of thousands belong to numbers, and rows may lack
    # last columns: without both, the right separator would seem to make no table.
    thousands = {marks.thousands or "" for marks in (dialect.marks, *dialect.marks_by_column.values())}
    marks_of_thousands = "".join(sorted(thousands))
    count_tail = partial(_count_tail, names=names, dialect=dialect)
    separator = dialect.separator or _guess_separator(header, rows, marks_of_thousands, count_tail)
    if dialect.is_stated and dialect.separator and (header is not None or dialect.interval is None):
        _refuse_separator(dialect.separator, header, rows, marks_of_thousands, count_tail)
    if separator is None:
        separator = ","  # what apesim writes: a cell that is no number is a fault of the cell
        if not dialect.header or not _is_header(split_header_line(header or "", separator), names, dialect):
            raise _no_table(lines, first, dialect, "".join(thousands))
    cells = [
        _split_numbered(lines[number], separator, number) for number in above[dialect.header :][: GUESSED_ROWS + 1]
    ]
    headers = [""] * len(cells[0]) if header is None else without_tail(split_header_line(header, separator))
    # between quotes a separator is a mark of a number; without quotes nobody can tell
    is_quoted = any(separator in cell for row in cells for cell in row)
    for marks in () if is_quoted else (dialect.marks, *dialect.marks_by_column.values()):
        if separator in marks:
            right = 'save it with another separator, and write it, e.g. separator = "semicolon", in [read]'
            raise InvalidValue(f"{quoted(separator)} is the separator and a mark in numbers: which is which?", right)
    optional = count_tail(headers) if dialect.header else 0
    cells = [fit_cells(row, len(headers), optional) for row in cells]
    if dialect.header and not _is_header(headers, names, dialect):
        raise _no_table(lines, first, dialect, "".join(thousands))

    # Where the numbers begin: a line of units between them and the header belongs to the header.
    first_line = first + 1 if dialect.header else dialect.skip_rows
    units = cells[0] if header is not None and cells and _is_unit_row(cells[0], len(headers)) else None
    names_alone = tuple(headers)
    if units:
        headers = [_with_unit(name, text) for name, text in zip(headers, units, strict=True)]
        first_line, cells = above[1] + 1, cells[1:]

    # The decimal mark, by the cells. Without a header, commas may be separators or decimal marks.
    decimal = _guess_decimal(cells, separator, dialect)
    if dialect.separator is None and header is None and separator == "," and not is_quoted:
        _refuse_two_readings(cells)
    return Layout(
        encoding,
        separator,
        tuple(headers),
        names_alone,
        first if dialect.header else dialect.skip_rows,
        first_line,
        decimal,
        not dialect.is_stated and separator == "," and first == 0 and units is None and decimal != ",",
        _name_guesses(dialect, separator, decimal, encoding),
        units is not None,
        ignored,
        optional,
        _find_clocks(cells, len(headers)),
        *split_stated(dialect.missing),
    )


def _find_clocks(rows: Sequence[Sequence[str]], number: int) -> frozenset[int]:
    """Places of the columns whose first cells are clock times, or missing."""
    columns = list(zip(*(row for row in rows if len(row) == number), strict=True))
    return frozenset(
        at
        for at, column in enumerate(columns)
        if any(map(is_clock, column)) and all(is_clock(cell) or is_missing(cell) for cell in column)
    )


def _count_tail(headers: Sequence[str], *, names: Sequence[str], dialect: Dialect) -> int:
    """Number of the last columns that have no name of ours, such as a comment."""
    theirs = set(dialect.columns.values())
    for number, header in enumerate(reversed(headers)):
        known = {header, split_header(header)[0], split_name(header)[0]}
        if known & {*names, *theirs} or len(headers) - number in theirs:
            return number
    return 0


def ignored_pattern(texts: Sequence[str]) -> re.Pattern[bytes] | None:
    """Make the pattern of lines that begin with one of several texts, in quotes or not; None where there is no text.

    >>> pattern = ignored_pattern(["End of data", "#"])
    >>> [bool(pattern.match(line)) for line in (b"# 24 rows", b'"End of data";;', b"1;2")]
    [True, True, False]
    """
    if not texts:
        return None
    either = "|".join(re.escape(text) for text in texts)
    return re.compile(rf"^[ \t\"]*(?:{either})[^\n]*".encode(), re.MULTILINE)


def _split_numbered(line: str, separator: str, number: int) -> list[str]:
    """Cells of a line; what is wrong with it names the line."""
    try:
        return split_line(line, separator)
    except InvalidValue as wrong:
        raise InvalidValue(f"line {number + 1} {wrong.wrong}", wrong.right) from None


def _first_lines(path: Path, encoding: str, number: int) -> list[str]:
    """First lines of a file."""
    lines: list[str] = []
    for block in islice(blocks_of_lines(path, encoding, HEAD_BYTES), 1 + number):
        try:
            lines += block.decode().split("\n")[:-1]
        except UnicodeDecodeError as error:
            raise refuse_encoding(len(lines) + block[: error.start].count(b"\n") + 1) from None
        if len(lines) >= number:
            break
    return lines


def refuse_encoding(line: int) -> InvalidValue:
    """Make the error of a line, given by its number, that is no UTF-8."""
    right = 'save it as UTF-8, or write its encoding = "latin-1" in [read]'
    return InvalidValue(f"is no text in line {line}", right)


def split_header_line(line: str, separator: str) -> list[str]:
    """Split a header into the names of its columns.

    Where the separator is a blank, brackets belong to the name before them.

    >>> split_header_line("time [ms] pressure_a [kPa abs]", " ")
    ['time [ms]', 'pressure_a [kPa abs]']
    """
    if separator != " " or '"' in line:
        cells = split_line(line, separator)
    else:
        found = re.finditer(rf"[^\s\[(]+(?:\s*(?:\[[^\]]*\]|{BRACKETS}))?|[\[(][^\s]*", line)
        cells = [each[0] for each in found]
    return [" ".join(cell.split()) for cell in cells]


def _is_header(cells: Sequence[str], names: Sequence[str], dialect: Dialect) -> bool:
    """Whether cells are a header: with a name that is known, a unit, or what the dialect names."""
    theirs = set(dialect.columns.values())
    if any(isinstance(each, int) for each in theirs) and not any(ANY_NUMBER.fullmatch(cell) for cell in cells):
        return True
    for cell in cells:
        name, named = split_name(cell)
        if name in names or is_unit(named) or cell in theirs or name in theirs:
            return True
    return False


def _is_numeric(cell: str, thousands: str) -> bool:
    """Whether a cell is a number with any marks."""
    for mark in thousands:
        cell = cell.replace(mark, "")
    return bool(ANY_NUMBER.fullmatch(cell))


def _guess_separator(
    header: str | None, rows: Sequence[str], thousands: str, count_tail: CountTail | None = None
) -> str | None:
    """Separator that makes columns of numbers of all rows, else of most of them; None: there is none."""
    for counted in (None, count_tail) if count_tail else (None,):  # rows as long as the header go first
        shares = {separator: _share_of_rows(header, rows, thousands, separator, counted) for separator in GUESSES}
        best = max(GUESSES, key=lambda separator: shares[separator])  # the first of equals
        if shares[best] > MIN_SHARE:
            return best
    return None


def _refuse_separator(
    separator: str, header: str | None, rows: Sequence[str], thousands: str, count_tail: CountTail
) -> None:
    """Refuse a separator that makes no table where another one does; raises `InvalidValue`."""
    if _share_of_rows(header, rows, thousands, separator, count_tail) > 0.0:
        return
    better = _guess_separator(header, rows, thousands, count_tail)
    if better not in (None, separator):
        names = {mark: name for name, mark in SEPARATORS.items()}
        wrong = f'separator = "{names[separator]}" makes no columns of numbers'
        raise InvalidValue(wrong, f'write separator = "{names[better]}" in [read], or leave it out')


def _share_of_rows(
    header: str | None, rows: Sequence[str], thousands: str, separator: str, count_tail: CountTail | None = None
) -> float:
    """Share of rows of which a separator makes as many cells as columns, two of them at least of numbers."""
    try:
        cells = [split_line(row, separator) for row in rows]
        headers = cells[0] if header is None else without_tail(split_header_line(header, separator))
    except (InvalidValue, IndexError):
        return 0.0
    number, tail = len(headers), count_tail(headers) if count_tail and header is not None else 0
    cells = [fit_cells(row, number, tail) for row in cells]
    if header is not None and not any(_is_numeric(cell, thousands) for row in cells[:1] for cell in row):
        cells = cells[1:]  # it may hold units
    fitting = [
        row
        for row in cells
        if len(row) == number and all(is_word(cell) or _is_numeric(cell, thousands) for cell in row)
    ]
    columns = list(zip(*fitting, strict=True))
    has_numbers = [any(_is_numeric(cell, thousands) or is_clock(cell) for cell in column) for column in columns]
    return len(fitting) / max(len(cells), 1) if sum(has_numbers) >= MIN_COLUMNS else 0.0


def without_tail(cells: list[str]) -> list[str]:
    """Take off the empty cell that a separator at the end of a header makes."""
    return cells[:-1] if len(cells) > 1 and not cells[-1] else cells


def fit_cells(cells: list[str], number: int, optional: int = 0) -> list[str]:
    """Take off the empty cell that a separator at the end of a row makes, and add those that a row may end before.

    `number` is that of the columns, `optional` how many of the last of them a row may lack.

    >>> fit_cells(["0", "1", ""], 2), fit_cells(["0", "1", ""], 3), fit_cells(["0", "1"], 3, optional=1)
    (['0', '1'], ['0', '1', ''], ['0', '1', ''])
    """
    if optional and number - optional <= len(cells) < number:
        return [*cells, *[""] * (number - len(cells))]
    return cells[:-1] if len(cells) == number + 1 and not cells[-1] else cells


def _is_unit_row(cells: Sequence[str], number: int) -> bool:
    """Whether a row has units and no number: in brackets, or bare."""
    if len(cells) != number or any(ANY_NUMBER.fullmatch(cell) for cell in cells):
        return False
    bare = [cell for cell in cells if cell and not re.fullmatch(r"\(.*\)|\[.*\]", cell)]
    some = [cell for cell in cells if cell and is_unit(_unbracket(cell)) and _unbracket(cell)]
    return bool(some) and all(is_unit(cell) and not is_missing(cell) for cell in bare)


def _unbracket(text: str) -> str:
    """Text without the brackets around it."""
    found = re.fullmatch(r"\s*[(\[](.*)[)\]]\s*", text)
    return (found[1] if found else text).strip()


def _with_unit(header: str, text: str) -> str:
    """Header with the unit of the line below."""
    text = _unbracket(text)
    return f"{header} [{text}]" if text and split_name(header)[1] is None else header


def _guess_decimal(rows: Sequence[Sequence[str]], separator: str, dialect: Dialect) -> str:
    """Decimal mark of the columns that have none said."""
    decimal, thousands = dialect.marks
    if decimal is not None:
        return decimal
    numbers = [cell for row in rows for cell in row if ANY_NUMBER.fullmatch(cell)]
    points, commas = (sum(mark in cell for cell in numbers) for mark in ".,")
    if separator == "," and not commas:  # else they stand between quotes
        return "." if thousands != "." else ""
    if thousands in (".", ","):
        return {".": ",", ",": "."}[thousands]
    if points and commas and not dialect.marks_by_column:
        right = 'write decimal = "," and thousands = "." in [read], or the other way round'
        raise InvalidValue("the numbers have both points and commas", right)
    return "," if commas and not points else "."


def _refuse_two_readings(rows: Sequence[Sequence[str]]) -> None:
    """Refuse whole numbers between commas that may be decimals: 0,5,1,25."""
    cells = [cell for row in rows for cell in row]
    if rows and len(rows[0]) % 2 == 0 and len(rows[0]) >= 4 and not any("." in cell for cell in cells):
        wrong = "the commas may be separators or decimal marks"
        raise InvalidValue(wrong, 'write separator = "comma" in [read], or save it with another separator')


def _no_table(lines: Sequence[str], first: int, dialect: Dialect, thousands: str) -> InvalidValue:
    """Error of a file without a header where one has to be; no line of it is shown, as the file may be any other."""
    if not dialect.header:
        right = 'write separator = "tab", or skip_rows if rows of text stand above, in [read]'
        return InvalidValue(f"line {first + 1} is no row of numbers that a separator is seen in", right)
    wrong = f"line {first + 1} is no header with names and units"
    for number in range(first, min(len(lines), first + MAX_PREAMBLE) - 2):
        rows = [line for line in lines[number + 1 : number + 5] if line.strip()]
        if _is_above_numbers(lines[number], rows, thousands):
            key = f"skip_rows = {number}, and " * (number > first)
            return InvalidValue(wrong, f'write {key}columns = {{ time = "their header", … }} in [read]')
        if number == first and _guess_separator(None, [lines[first], *rows], thousands):
            right = "write header = false and columns = { time = 1, lift = 2 } in [read]"
            right += f", with skip_rows = {first + 1} if line {first + 1} is a header of numbers"
            return InvalidValue(wrong, right)
    return InvalidValue(wrong)


def _is_above_numbers(line: str, rows: Sequence[str], thousands: str) -> bool:
    """Whether a line of words stands right above rows of numbers, or above a line of units and them."""
    if starts_numeric(line) or not line.strip() or not rows:
        return False
    separator = _guess_separator(line, rows, thousands, _count_any_tail)
    if not separator:
        return False
    units = split_line(rows[0], separator)
    below = rows[1:] if _is_unit_row(units, len(units)) else rows
    return bool(below) and starts_numeric(below[0].lstrip('\t ,;"'))


def _count_any_tail(headers: Sequence[str]) -> int:
    """One: the last column of a header that may be any may be one of comments."""
    return int(len(headers) > MIN_COLUMNS)


def starts_numeric(line: str) -> bool:
    """Tell whether a line begins with a number, be it after blanks."""
    return bool(re.match(r"\s*[+-]?[0-9.,]", line))


def _name_guesses(dialect: Dialect, separator: str, decimal: str, encoding: str) -> dict[str, str]:
    """What was guessed and differs from the files that apesim writes, by key of ``[read]``."""
    guessed = {}
    if dialect.separator is None and (dialect.is_stated or separator != ","):
        guessed["separator"] = next(name for name, mark in SEPARATORS.items() if mark == separator)
    if dialect.marks.decimal is None and (separator != "," or decimal == ","):
        guessed["decimal"] = decimal
    if dialect.encoding is None and not encoding.startswith("utf-8"):
        guessed["encoding"] = encoding
    return guessed


def resolve_marks(said: Marks, layout: Layout) -> Marks:
    """Take what is not said of the marks of a column from the layout; no mark is None then.

    >>> layout = Layout("utf-8", ";", ("time [ms]",), ("time [ms]",), 0, 1, ",", False, {})
    >>> resolve_marks(Marks(), layout), resolve_marks(Marks(None, ","), layout)
    (Marks(decimal=',', thousands=''), Marks(decimal='.', thousands=','))
    """
    decimal, thousands = said
    if decimal is None:
        decimal = layout.decimal
        if decimal == thousands:
            decimal = {".": ",", ",": "."}[decimal] if layout.separator != "," else ""
    return Marks(decimal, thousands or "")
