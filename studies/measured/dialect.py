"""Dialects: how a laboratory's file writes its table, as the table ``[read]`` of ``measured.toml`` says it.

Whatever is not said is None here, and guessed from the file by `apesim.studies.measured.layout`.
"""

import difflib
import json
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any, NamedTuple

from apesim.quantities import Fault, InvalidValue, Quantity, quoted
from apesim.quantities.input_errors import name_unknown
from apesim.studies.measured.conversion import Measure, read_measure

READ = "read"
"""Table of a folder or a run that says how its files are written."""
SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t", "space": " "}
"""Characters between cells by their names; "space" is any run of blanks and tabs."""
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1", "cp1252")
"""Encodings of a file."""
DECIMALS = (".", ",", "")
"""Decimal marks; "": whole numbers alone."""
TIME = "time"
"""Column over which the traces of a valve stand."""
ANGLE = "crank_angle"
"""Column over which the traces of an engine stand."""
THOUSANDS = ("", ".", ",", "'", " ")
"""Marks between groups of three digits; "": none."""
COMMAND, FIRST_ROW = STARTS = ("command", "first row")
"""Words for the instant of a file that t = 0 stands at, beside a time."""
START = Quantity("ms", -1e9, 1e9, "measured.toml", typical="12.5 ms")
"""Declaration of a time of the file that t = 0 stands at."""
SAMPLINGS = {
    "sample_interval": Quantity("ms", 1e-6, 1e4, "measured.toml", typical="0.02 ms"),
    "sample_rate": Quantity("Hz", 0.1, 1e9, "measured.toml", typical="50 kHz"),
}
"""Declarations of the keys that say how fast the rows of a file without times follow one another."""
MAX_SKIPPED = 1_000_000
"""Largest number of rows that are passed over: far above any instrument's preamble."""
SKIP_ROWS: tuple[Callable[[Any], bool], str, str] = (
    lambda value: type(value) is int and 0 <= value <= MAX_SKIPPED,
    "is no number of rows",
    f"write a whole number from 0 to {MAX_SKIPPED}",
)
"""What a number of skipped rows is, and what is said of another."""
MAX_COLUMN = 10_000
"""Largest number of a column: far above any instrument's number of channels."""
TABLES = ("columns", "unit", "scale", "offset", "column")
"""Keys that are tables: a run's entries are put over the folder's one by one."""
KEYS = (
    "separator",
    "decimal",
    "encoding",
    "skip_rows",
    "ignore_lines",
    "columns",
    "unit",
    "scale",
    "offset",
    "ignore",
    "ignore_others",
    "header",
    "thousands",
    "missing",
    "column",
    *SAMPLINGS,
    "start",
)
"""Keys of ``[read]``."""
NUMBER_BEGINS = re.compile(r"\s*[+-]?[0-9.,']*(?:[eE][+-]?[0-9]*)?")
"""Text that a row of numbers may begin with."""


class Marks(NamedTuple):
    """Marks in the numbers of a column."""

    decimal: str | None = None
    """Decimal mark; "": whole numbers; None: not said."""
    thousands: str | None = None
    """Mark between groups of three digits; "": there is none; None: not said."""


class ReadTable(dict[str, Any]):
    """Table ``[read]`` of a file, with what is guessed of it; it prints as ``measured.toml`` has it."""

    def __init__(self, entries: Mapping[str, Any], guessed: Mapping[str, str]) -> None:
        super().__init__(entries)
        self.guessed = dict(guessed)
        """What of it was guessed, and differs from the files that apesim writes."""

    def __str__(self) -> str:
        return "\n".join([f"[{READ}]", *_print_entries(self)])


def _print_entries(table: Mapping[str, Any], within: str = "") -> Iterator[str]:
    """Lines of TOML of a table, those of a table in it with dotted keys."""
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _print_entries(value, f"{within}{key}.")
        else:  # a text of JSON is one of TOML, but for one control character
            yield f"{within}{key} = {json.dumps(value, ensure_ascii=False)}".replace("\x7f", "\\u007f")


class Dialect(NamedTuple):
    """Way in which a file writes its table."""

    table: Mapping[str, Any] = {}
    """Table ``[read]`` that states it; empty: there is none."""
    separator: str | None = None
    """Character between cells; None: guessed."""
    encoding: str | None = None
    """Encoding of the text; None: guessed."""
    skip_rows: int = 0
    """Rows above the header, or above the numbers where there is none."""
    ignore_lines: tuple[str, ...] = ()
    """Beginnings of lines below the header that are passed over."""
    header: bool = True
    """Whether a header stands above the numbers."""
    columns: Mapping[str, str | int] = {}
    """Header or number, counted from 1, of a column in the file, by our name."""
    units: Mapping[str, str] = {}
    """Units by our name."""
    scales: Mapping[str, Measure] = {}
    """What the numbers of a column are multiplied with, by our name."""
    offsets: Mapping[str, Measure] = {}
    """What is added then, by our name."""
    ignore: tuple[str | int, ...] = ()
    """Headers or numbers of columns that are passed over."""
    ignore_others: bool = False
    """Whether all other columns are passed over."""
    marks: Marks = Marks()
    """Marks in the numbers of the file."""
    marks_by_column: Mapping[str, Marks] = {}
    """Marks in the numbers of a column that has its own, by our name."""
    interval: float | None = None
    """Time from row to row of a file without times [s]; None: the file has them."""
    missing: tuple[str, ...] = ()
    """Cells without a number, beside those that are known."""
    start: float | str | None = None
    """Time of the file at which t = 0 stands [s], or one of `STARTS`; None: not said, `COMMAND`."""

    @property
    def is_stated(self) -> bool:
        """Whether a ``[read]`` is there."""
        return bool(self.table)

    def marks_of(self, name: str) -> Marks:
        """Find the marks in the numbers of a column, by our name of it.

        Each is the column's own, or that of the file where the column has none.

        >>> dialect = Dialect(marks=Marks("."), marks_by_column={"time": Marks("", ".")})
        >>> dialect.marks_of("time"), dialect.marks_of("lift")
        (Marks(decimal='', thousands='.'), Marks(decimal='.', thousands=None))
        """
        own = self.marks_by_column.get(name, Marks())
        return Marks(*(mine if mine is not None else whole for mine, whole in zip(own, self.marks, strict=True)))


def merge_tables(folder: Mapping[str, Any], run: Mapping[str, Any]) -> dict[str, Any]:
    """Put the ``[read]`` of a run over that of its folder.

    A key of the run replaces the folder's, and a sample rate an interval; of tables in it, an entry of the run replaces
    the folder's.

    >>> merge_tables({"decimal": ",", "unit": {"time": "ms"}}, {"decimal": ".", "unit": {"lift": "mm"}})
    {'decimal': '.', 'unit': {'time': 'ms', 'lift': 'mm'}}
    """
    merged = dict(folder)
    for key, value in run.items():
        both = key in TABLES and isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = merge_tables(merged[key], value) if both else value
    for key in SAMPLINGS.keys() - run.keys() if SAMPLINGS.keys() & run.keys() else ():
        merged.pop(key, None)
    if isinstance(folder.get("column"), dict) and isinstance(run.get("column"), dict):
        for name in folder["column"].keys() & run["column"].keys():
            pair = folder["column"][name], run["column"][name]
            if all(isinstance(table, dict) for table in pair):
                merged["column"][name] = {**pair[0], **pair[1]}
    return merged


def find_unknown_keys(file: str, section: str, given: Collection[str], valid: Collection[str]) -> Iterator[Fault]:
    """Find the keys of a table that nobody knows; each fault names the nearest right one.

    `section` is the name of the table in the file, "": the top of the file.
    """

    def fault_of(key: str) -> Fault:
        near = difflib.get_close_matches(key, valid, n=1)
        right = f"did you mean {near[0]}?" if near else f"valid here: {', '.join(valid)}"
        return Fault(file, f"{section}.{key}".lstrip("."), "unknown key", right)

    yield from name_unknown([key for key in given if key not in valid], fault_of, file, section)


def read_dialect(
    file: str, section: str, table: Mapping[str, Any], names: Collection[str], *, is_timed: bool
) -> tuple[Dialect | None, list[Fault]]:
    """Read the dialect that a table ``[read]`` states; None: the table is wrong. Of an empty one all is guessed.

    `section` is the table's name in the file, `names` are those of the columns that are known here; `is_timed`: the
    traces stand over time, so that there is a ``start``.
    """
    if not table:
        return Dialect(), []
    reading = _Reading(file, section, table, names)
    faults = reading.faults
    faults += find_unknown_keys(file, section, table, KEYS)

    # Every key is read, whatever is wrong with others: a wrong one leaves a fault, and its default in the dialect.
    separator = reading.word("separator", tuple(SEPARATORS))
    marks = reading.marks()
    dialect = Dialect(
        table=table,
        separator=SEPARATORS[separator] if separator else None,
        encoding=reading.word("encoding", ENCODINGS),
        skip_rows=reading.take("skip_rows", 0, *SKIP_ROWS),
        ignore_lines=reading.ignored_lines(),
        header=reading.truth("header", default=True),
        columns=reading.columns(),
        units=reading.units(),
        scales=reading.measures("scale"),
        offsets=reading.measures("offset"),
        ignore=reading.ignored(),
        ignore_others=reading.truth("ignore_others", default=False),
        marks=marks,
        marks_by_column=reading.marks_by_column(),
        interval=reading.interval(is_timed=is_timed),
        missing=tuple(text.strip() for text in reading.texts("missing", 'write missing = ["OVER", "-9999"]')),
        start=reading.start(is_timed=is_timed),
    )

    # What keys say together is judged only where each is right: a default would be blamed in place of a wrong key.
    if not dialect.header and not faults:
        faults += _headless_faults(file, section, dialect)
    if not faults:
        faults += _contradictions(file, section, dialect)
    return None if faults else dialect, faults


class _Reading:
    """Values of one table, with the faults of those that are wrong."""

    def __init__(self, file: str, section: str, table: Mapping[str, Any], names: Collection[str]) -> None:
        self.file, self.section, self.table, self.names = file, section, table, names
        self.faults: list[Fault] = []

    def fault(self, key: str, wrong: str, right: str) -> None:
        """Add a fault of a key."""
        self.faults.append(Fault(self.file, f"{self.section}.{key}", wrong, right))

    def take(self, key: str, default: Any, is_right: Callable[[Any], bool], wrong: str, right: str) -> Any:
        """Take a value; its default where it is not given, or is wrong."""
        value = self.table.get(key, default)
        if is_right(value):
            return value
        self.fault(key, f"{quoted(value)} {wrong}", right)
        return default

    def word(self, key: str, words: tuple[str, ...]) -> str | None:
        """One of several words; None where it is not given."""
        *others, last = (f'"{word}"' for word in words)
        right = f"write {', '.join(others)} or {last}"
        value: str | None = self.take(
            key, None, lambda value: value is None or (isinstance(value, str) and value in words), "is no option", right
        )
        return value

    def truth(self, key: str, *, default: bool) -> bool:
        """A truth value."""
        right = f"write {key} = {str(not default).lower()}"
        return bool(self.take(key, default, lambda value: isinstance(value, bool), "is neither true nor false", right))

    def entries(self, key: str, right: str) -> dict[str, Any]:
        """Entries of a table whose keys are our names."""
        entries = self.take(key, {}, lambda value: isinstance(value, dict), "is no table", right)
        self.faults += find_unknown_keys(self.file, f"{self.section}.{key}", entries, self.names)
        return {name: entries[name] for name in entries if name in self.names}

    def columns(self) -> dict[str, str | int]:
        """Headers or numbers by our name."""
        right = 'write columns = { time = "Zeit (s)", lift = "Ch1" }, or numbers from 1'
        columns: dict[str, str | int] = {}
        for name, value in self.entries("columns", right).items():
            if _is_column(value):
                columns[name] = _without_blanks(value)
            else:
                self.fault(f"columns.{name}", f"{quoted(value)} is no header and no number of a column", right)
        if len(set(columns.values())) < len(columns):
            self.fault("columns", "one column of the file has two names", "name each column once")
        return columns

    def units(self) -> dict[str, str]:
        """Units by our name; whether they are units is seen with their column."""
        units = {}
        for name, value in self.entries("unit", 'write unit.lift = "mm"').items():
            if _is_text(value):
                units[name] = value.strip()
            else:
                self.fault(f"unit.{name}", f"{quoted(value)} is no unit", f'write unit.{name} = "mm"')
        return units

    def measures(self, key: str) -> dict[str, Measure]:
        """Numbers with units by our name; whether they are of the right dimension is seen with their column."""
        measures = {}
        examples = {"scale": ("2 mm/V", "2.5 bar/V"), "offset": ("-1 mm", "-1.25 bar gauge")}[key]
        for name, value in self.entries(key, f'write {key}.lift = "{examples[0]}"').items():
            right = f'write it like "{examples["pressure" in name]}"'
            try:
                measures[name] = read_measure(value)
                if key == "scale" and (measures[name].kind or not measures[name].number):
                    self.fault(f"{key}.{name}", f"{quoted(value)} is no factor", right)
            except InvalidValue as wrong:
                self.fault(f"{key}.{name}", wrong.wrong, right)
        return measures

    def ignored(self) -> tuple[str | int, ...]:
        """Headers or numbers of columns."""
        right = 'write ignore = ["Trigger"], or numbers from 1'
        value = self.take("ignore", [], lambda value: _is_list(value, _is_column), "is no list of columns", right)
        return tuple(map(_without_blanks, value))

    def texts(self, key: str, right: str) -> tuple[str, ...]:
        """Texts that are not blank."""
        return tuple(self.take(key, [], lambda value: _is_list(value, _is_text), "is no list of texts", right))

    def ignored_lines(self) -> tuple[str, ...]:
        """Beginnings of lines, none of which a row of numbers may have."""
        texts = self.texts("ignore_lines", 'write the texts that such lines begin with: ignore_lines = ["End of data"]')
        for text in filter(NUMBER_BEGINS.fullmatch, texts):
            right = "write more of the line, or take the line out of the file"
            self.fault("ignore_lines", f"a row of numbers may begin with {quoted(text)}, too", right)
        return tuple(text.strip() for text in texts)

    def marks(self) -> Marks:
        """Marks in numbers."""
        return Marks(self.word("decimal", DECIMALS), self.word("thousands", THOUSANDS))

    def marks_by_column(self) -> dict[str, Marks]:
        """Marks of columns that have their own."""
        marks = {}
        right = f'write [{self.section}.column.time] with thousands = "."'
        for name, table in self.entries("column", right).items():
            if isinstance(table, dict):
                column = _Reading(self.file, f"{self.section}.column.{name}", table, ())
                column.faults += find_unknown_keys(self.file, column.section, table, Marks._fields)
                marks[name] = column.marks()
                self.faults += column.faults
            else:
                self.fault(f"column.{name}", f"{quoted(table)} is no table", right)
        return marks

    def interval(self, *, is_timed: bool) -> float | None:
        """Time from row to row of a file without times; None where none of its keys is given."""
        keys = [key for key in SAMPLINGS if key in self.table]
        columns = self.table.get("columns")
        if not keys:
            return None
        if not is_timed:
            right = "give the crank angle of each row in a column"
            self.fault(keys[0], "an engine's traces stand over the crank angle", right)
        elif len(keys) == 2:
            self.fault("sample_rate", "stands beside sample_interval: which is it?", "keep one of the two")
        elif isinstance(columns, dict) and TIME in columns:
            self.fault(f"columns.{TIME}", f"stands beside {keys[0]}: which is the time?", "keep one of the two")
        else:
            [key] = keys
            try:
                value = SAMPLINGS[key].read(self.table[key])
                return 1.0 / value if key == "sample_rate" else value
            except InvalidValue as wrong:
                self.fault(key, wrong.wrong, wrong.right or f'write {key} = "{SAMPLINGS[key].typical}"')
        return None

    def start(self, *, is_timed: bool) -> float | str | None:
        """Instant of the file that t = 0 stands at."""
        value = self.table.get("start")
        if value is None or value == COMMAND or (value == FIRST_ROW and is_timed):
            return value
        if not is_timed:
            self.fault("start", "an engine's traces stand over the crank angle", f'leave it out, or "{COMMAND}"')
            return COMMAND
        try:
            return START.read(value)
        except InvalidValue as wrong:
            self.fault("start", wrong.wrong, f'write "{COMMAND}", "{FIRST_ROW}" or a time, e.g. "12.5 ms"')
            return COMMAND


def _is_text(value: Any) -> bool:
    """Whether a value is a text that is not blank."""
    return isinstance(value, str) and bool(value.strip())


def _is_column(value: Any) -> bool:
    """Whether a value is a header or a number of a column."""
    return _is_text(value) or (type(value) is int and 1 <= value <= MAX_COLUMN)


def _is_list(value: Any, is_right: Callable[[Any], bool]) -> bool:
    """Whether a value is a list of what is right."""
    return isinstance(value, list) and all(map(is_right, value))


def _without_blanks(column: str | int) -> str | int:
    """Number of a column, or its header with single blanks."""
    return " ".join(column.split()) if isinstance(column, str) else column


def _headless_faults(file: str, section: str, dialect: Dialect) -> Iterator[Fault]:
    """Faults of what a file without header cannot have."""
    right = "give its number, counted from 1"
    for name, theirs in dialect.columns.items():
        if isinstance(theirs, str):
            yield Fault(file, f"{section}.columns.{name}", f"{quoted(theirs)} in a file without header", right)
    if not dialect.columns:
        form = "write columns = { time = 1, lift = 2 }, with unit.time and unit.lift"
        yield Fault(file, f"{section}.columns", "is not given, and the file has no header", form)


def _contradictions(file: str, section: str, dialect: Dialect) -> Iterator[Fault]:
    """Faults of marks that mean two things."""
    for name in (None, *dialect.marks_by_column):
        decimal, thousands = dialect.marks_of(name) if name else dialect.marks
        at = f"{section}.column.{name}" if name else section
        if decimal and decimal == thousands:
            right = 'give two marks, or "" for the one that there is not'
            yield Fault(file, at, f"decimal and thousands are both {quoted(decimal)}", right)
