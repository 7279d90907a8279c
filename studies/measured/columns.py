"""Columns of measured files, in SI: the name and unit of each stand in its header, e.g. ``lift [mm]``, or are given."""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from apesim.quantities import Fault, InvalidValue, quoted, unit
from apesim.quantities.files import split_header
from apesim.studies.measured.conversion import SIGNALS, convert, is_measure, split_kind, suggest_unit
from apesim.studies.measured.dialect import ANGLE, SEPARATORS, TIME, Dialect, Marks, ReadTable
from apesim.studies.measured.layout import Layout, find_layout, is_unit, resolve_marks, split_name
from apesim.studies.measured.row_order import find_coarse_angle, find_disorder, unwrap_angle
from apesim.studies.measured.table import (
    CellError,
    LineError,
    Numbers,
    is_ambiguous,
    name_ignored_line,
    name_remedy,
    read_numbers,
)


class Columns(NamedTuple):
    """Columns of a file, and what is to be said of them."""

    values: dict[str, np.ndarray]
    """(n,) float arrays in SI and absolute, by our name; NaN where a cell has no number. What is wrong is missing."""
    names: list[str]
    """Names of all columns of the file that are not passed over, ours where they have one."""
    faults: list[Fault]
    """Faults, empty where there are none."""
    hints: list[str]
    """What was guessed, and what was left out, in words."""
    over_range: Mapping[str, np.ndarray] = {}
    """(n,) bool arrays by our name: rows whose cell says that the number is over range; only of columns with such."""
    is_counted: bool = False
    """Whether the times are counted from the first row, as the file has clock times."""
    table: ReadTable | None = None
    """Table ``[read]`` that says all of how the file was read, and reads the same numbers; None where it was not."""


class _Place(NamedTuple):
    """Place of a column in a file."""

    name: str
    """Our name, or that of the file."""
    at: int
    """Number of the column, from 0."""
    unit: str | None
    """Unit; None: there is none."""
    unit_of_header: str | None
    """Unit that the header says; None: none."""


def read_columns(
    path: Path,
    declared: Mapping[str, str],
    due: Sequence[str],
    ambient_pressure: float,
    *,
    right: str,
    dialect: Dialect,
) -> Columns:
    r"""Read the declared columns of a file; others are ignored.

    `declared` has the unit of each column by name, in any of its dimension; that of a pressure ends in `` abs``, and
    the file says whether it is abs or gauge, which stands above `ambient_pressure` [Pa abs]. Names in `due` must be
    there: the first has to rise, and a row without a number in it is left out. Of others, one without any number is as
    if it were not there. `right` is what is said to be right where the file is no table at all, or its first line no
    header; that line is not shown then, as the file may be any other.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "p040.csv")
    ...     _ = path.write_text("time [ms],pressure [kPa gauge]\n0,400\n1,390\n")
    ...     declared = {"time": "ms", "pressure": "kPa abs"}
    ...     columns = read_columns(path, declared, ("time", "pressure"), 100e3, right="give a CSV", dialect=Dialect())
    >>> columns.values["pressure"].tolist(), columns.faults
    ([500000.0, 490000.0], [])
    >>> print(columns.table)
    [read]
    separator = "comma"
    decimal = "."
    encoding = "utf-8"
    thousands = ""
    skip_rows = 0
    header = true
    columns.time = "time [ms]"
    columns.pressure = "pressure [kPa gauge]"
    unit.time = "ms"
    unit.pressure = "kPa gauge"
    """
    file = str(path)

    # Header, columns and cells. Where the file is no table, there is nothing to say of single columns.
    try:
        layout = find_layout(path, dialect, tuple(declared))
        places, faults = _places_of(file, layout, dialect, declared)
        read, marks, wrong_cells = _numbers_of(path, layout, dialect, places, declared)
    except InvalidValue as wrong:
        remedy = name_ignored_line(wrong.cell) if isinstance(wrong, LineError) else ""
        return Columns({}, [], [Fault(file, "", wrong.wrong, remedy or wrong.right or right)], [])
    names, numbers = [place.name for place in places], read.values
    hints = []
    if layout.guessed:
        keys = ", ".join(f'{key} = "{value}"' for key, value in layout.guessed.items())
        hints.append(f"{path.name}: read with {keys}")
    if layout.has_units:
        hints.append(f"{path.name}: the line under the header is taken for its units")
    over_range: dict[str, np.ndarray] = {}
    is_counted = False
    columns: dict[str, np.ndarray] = {}
    axis, axis_numbers, axis_unit = due[0], np.empty(0), ""
    rows_below = len(next(iter(numbers.values()), ()))

    # Each column by itself, so that a fault of one hides none of the others; first, whether it is there, and once.
    for name, expected in declared.items():
        matching = [place for place in places if place.name == name]
        scale, offset = dialect.scales.get(name), dialect.offsets.get(name)
        form = _name_unit(name, matching[0].unit if matching else None, expected, dialect)
        try:
            if len(matching) > 1:
                right = f"keep one of them, or write ignore = [{matching[-1].at + 1}] in [read]"
                raise InvalidValue("stands in several columns", right)
            if name == TIME and dialect.interval is not None:
                if matching:
                    right = f'take the key out, or write ignore = ["{layout.headers[matching[0].at]}"] in [read]'
                    raise InvalidValue("stands in the file beside a sample interval or rate: which is it?", right)
                columns[TIME] = dialect.interval * np.arange(rows_below)
                continue
            if not matching:
                if name in due and name not in dialect.columns:
                    raise InvalidValue("there is no such column", _name_absent(name, expected))
                continue
            if name in wrong_cells:
                raise wrong_cells[name]
            [(_, at, named, said)] = matching
            values = numbers.pop(at)
            is_empty = np.isnan(values)
            if name not in due and is_empty.all():
                if len(read.over_range[at]):
                    raise InvalidValue("is over range in every row that has a value", "leave the column out")
                continue
            if name == TIME and at in layout.clocks:
                is_counted = True
                columns[name] = _count_clock(values, named, dialect)
                hints.append(f"{path.name}: {name}: clock times are read as seconds since the first row")
                axis_numbers, axis_unit = columns[name], "s"
                continue

            # To SI, by unit, scale and offset; then whether a mark of its decimals may be one of thousands.
            if named is None:
                raise InvalidValue("has no unit", form)
            if not scale:
                form = _suggest_scale(name, named, expected) or form
                _refuse_two_units(name, named, said, expected)
            in_si = convert(name, named, values, expected, ambient_pressure, right=form, scale=scale, offset=offset)
            if dialect.marks_of(name) == Marks() and is_ambiguous(path, layout, at, values, marks[at].decimal or ""):
                raise _refuse_ambiguity(name, layout)
            columns[name] = in_si
            if len(read.over_range[at]):
                over_range[name] = np.isin(np.arange(len(values)), read.over_range[at])
            if name == axis:
                axis_numbers, axis_unit = values, split_kind(named)[0]
        except InvalidValue as wrong:
            faults.append(Fault(file, name, wrong.wrong, wrong.right))

    # The rows, where all columns are right. Those without a place on the axis go before the order is judged.
    if faults or axis not in columns:
        return Columns(columns, names, faults, hints)
    if lines := read.ignored_lines:
        some = f"line {lines[0]} is" if len(lines) == 1 else f"{len(lines)} lines, the first is line {lines[0]}, are"
        hints.append(f"{path.name}: {some} passed over")
    columns, rows, more = _placed_rows(path.name, columns, axis, over_range)
    over_range = {name: flags[rows] for name, flags in over_range.items()}
    # an angle that wraps goes on; nothing else that does not rise has one meaning
    if axis == ANGLE:
        columns[axis], wrapped = unwrap_angle(columns[axis], rows + 1)
        more = [*more, f"{path.name}: {axis} {wrapped}"] if wrapped else more
    others = {name: values for name, values in columns.items() if name != axis}
    shown = axis_numbers[rows] if len(axis_numbers) else columns[axis]
    coarse = find_coarse_angle(columns[axis]) if axis == ANGLE else None
    if disorder := coarse or find_disorder(columns[axis], rows + 1, others, shown, axis_unit):
        faults.append(Fault(file, axis, disorder.wrong, disorder.right))
    elif not len(rows) and dialect.interval is None:
        faults.append(Fault(file, axis, "has no number", "give a number in each row"))
    known = [place for place in places if place.name in declared]
    return Columns(columns, names, faults, [*hints, *more], over_range, is_counted, _state(layout, dialect, known))


def _state(layout: Layout, dialect: Dialect, places: Sequence[_Place]) -> ReadTable:
    """Table ``[read]`` that states a dialect with what was guessed of it, so that nothing is left to guess."""
    stated = dialect.table
    columns: dict[str, str | int] = dict(stated.get("columns", {}))
    units, marks = dict(stated.get("unit", {})), {}
    for name, at, named, _ in places:
        header = layout.names[at]
        columns.setdefault(name, header if header and _matching(layout.headers, header) == [at] else at + 1)
        if named is not None and at not in layout.clocks:
            units.setdefault(name, named)
    whole = Marks(layout.decimal, dialect.marks.thousands or "")
    for name in dict.fromkeys([*columns, *dialect.marks_by_column]):
        if (own := resolve_marks(dialect.marks_of(name), layout)) != whole:
            marks[name] = own._asdict()
    guessed = {
        "separator": next(name for name, mark in SEPARATORS.items() if mark == layout.separator),
        "decimal": layout.decimal,
        "encoding": layout.encoding,
        "thousands": whole.thousands,
        "skip_rows": layout.skip_rows,
        "header": dialect.header,
        "columns": columns,
        "unit": units,
        "column": marks,
    }
    table = {**guessed, **stated, **guessed}  # what is guessed stands first
    return ReadTable({key: value for key, value in table.items() if value != {}}, layout.guessed)


def _count_clock(seconds: np.ndarray, named: str | None, dialect: Dialect) -> np.ndarray:
    """Times since the first row of a column of clock times [s]."""
    if named and is_unit(named) and unit(named) != unit("s"):
        raise InvalidValue(f"holds clock times, and its unit is {quoted(named)}: which is it?", "take out the unit")
    if TIME in dialect.scales or TIME in dialect.offsets:
        right = "take scale.time and offset.time out of [read]"
        raise InvalidValue("holds clock times, which are neither scaled nor shifted", right)
    known = seconds[~np.isnan(seconds)]
    return seconds - known[0] if len(known) else seconds


def _name_unit(name: str, given: str | None, expected: str, dialect: Dialect) -> str:
    """Right form for the unit of a column."""
    if scale := dialect.scales.get(name):
        return f'write unit.{name} = "{suggest_unit(given, expected, scale)}" in [read], the unit before the scale'
    meant = suggest_unit(given, expected)
    return f'write "{name} [{meant}]" in the header or unit.{name} = "{meant}" in [read]'


def _places_of(
    file: str, layout: Layout, dialect: Dialect, declared: Mapping[str, str]
) -> tuple[list[_Place], list[Fault]]:
    """Columns of a file that are not passed over, and faults of those that it lacks."""
    headers = layout.headers
    places: list[_Place] = []
    faults: list[Fault] = []
    taken: set[int] = set()

    # Columns that [read] names are taken first, whatever their header says.
    for name, theirs in dialect.columns.items():
        matching = _matching(headers, theirs)
        if len(matching) == 1:
            taken.add(matching[0])
            named = split_name(headers[matching[0]])[1]
            places.append(_Place(name, matching[0], dialect.units.get(name, named), named))
            continue
        what = f"column {theirs}" if isinstance(theirs, int) else f"column {quoted(theirs)}"
        if matching:
            right = f"write its number, e.g. columns.{name} = {matching[0] + 1}"
            faults.append(Fault(file, name, f"{what} stands there {len(matching)} times", right))
        else:
            known = ", ".join(f"{header!r}" for header in headers if header) or f"columns 1 to {len(headers)}"
            faults.append(Fault(file, name, f"there is no {what}", f"the file has {known}"))

    # The others by their headers, which a file may lack. What nobody passes over may be one of ours.
    if not dialect.header:
        return places, faults
    passed = {at for theirs in dialect.ignore for at in _matching(headers, theirs)}
    for at, header in enumerate(headers):
        if at not in taken and at not in passed:
            # Our own form of a header goes first, then a laboratory's, then ours with brackets that hold no unit.
            name, named = split_header(header)
            if name not in declared and split_name(header)[0] in declared:
                name, named = split_name(header)
            if name not in declared and not dialect.ignore_others:
                name, named = _split_unknown_unit(header, declared) or (name, named)
            if dialect.ignore_others and name not in declared:
                continue
            chosen = dialect.columns.get(name)
            if isinstance(chosen, int) and chosen <= len(headers) and headers[chosen - 1] == header:
                continue  # the column is told from those of the same header by its number
            places.append(_Place(name, at, dialect.units.get(name, named), named))
    return places, faults


def _split_unknown_unit(header: str, declared: Mapping[str, str]) -> tuple[str, str] | None:
    """Name of ours and what stands behind it in brackets, which is no unit; None for any other header."""
    found = re.fullmatch(r"(.*?)\s*\((.*)\)", header)
    return (found[1], found[2].strip()) if found and found[1] in declared and found[2].strip() else None


def _name_absent(name: str, expected: str) -> str:
    """Right form for a column that is not there."""
    form = f'write "{name} [{expected}]" in the header, or in [read] columns.{name} = "the header that it has"'
    return form + ', or sample_interval = "0.02 ms" if the file has no times' * (name == TIME)


def _suggest_scale(name: str, named: str, expected: str) -> str:
    """What would be right, too, where the unit is one of what a sensor gives before it is scaled."""
    name_of_unit = split_kind(named)[0]
    if not is_unit(named) and is_measure(named):
        return f'write scale.{name} = "{named}" and unit.{name} = "-" in [read] if a count of 1 is as much'
    if not is_unit(named) or all(unit(name_of_unit).dimension != unit(signal).dimension for signal in SIGNALS):
        return ""
    due, kind = split_kind(expected)
    per = f"/{named}" if named not in ("", "-") else ""
    form = f'write in [read] what the sheet of the sensor says, e.g. scale.{name} = "2 {due}{per}" and '
    form += f'offset.{name} = "-1 {due}{" gauge" * bool(kind)}"'
    return f'{form}, or "{name} [{expected}]" in the header if the unit is wrong'


def _refuse_two_units(name: str, named: str, said: str | None, expected: str) -> None:
    """Refuse a unit that is said where the header has one of another kind; raises `InvalidValue`."""
    units = [unit(split_kind(text)[0]) for text in (named, said) if text and is_unit(text)]
    if len(units) == 2 and units[1].dimension and units[0].dimension != units[1].dimension:
        due, _ = split_kind(expected)
        theirs = split_kind(said or "")[0]
        right = f'write scale.{name} = "2 {due}/{theirs}" and offset.{name} in place of unit.{name}'
        right += f", or scale.{name} = 1 beside it if the header is wrong"
        raise InvalidValue(f"the header says {quoted(said)}, unit.{name} says {quoted(named)}", right)


def _matching(headers: Sequence[str], theirs: str | int) -> list[int]:
    """Places of a column by its number, from 1, its header, or the name in its header."""
    if isinstance(theirs, int):
        return [theirs - 1] if theirs <= len(headers) else []
    return [at for at, header in enumerate(headers) if header == theirs] or [
        at for at, header in enumerate(headers) if split_name(header)[0] == theirs or split_header(header)[0] == theirs
    ]


def _numbers_of(
    path: Path, layout: Layout, dialect: Dialect, places: Sequence[_Place], declared: Mapping[str, str]
) -> tuple[Numbers, dict[int, Marks], dict[str, InvalidValue]]:
    """Numbers of the declared columns and their marks by place, and the errors of columns with a cell that is none."""
    wanted = {
        place.at: (place.name, resolve_marks(dialect.marks_of(place.name), layout))
        for place in places
        if place.name in declared
    }
    wrong: dict[str, InvalidValue] = {}
    while wanted:
        marks = {at: marks for at, (_, marks) in wanted.items()}
        clocks = [at for at, (name, _) in wanted.items() if name == TIME and at in layout.clocks]
        try:
            return read_numbers(path, layout, marks, clocks), marks, wrong
        except CellError as error:
            name, said = wanted.pop(error.at)
            remedy = name_remedy(error.cell, said, name)
            if not remedy and error.at == 0 and (ignored := name_ignored_line(error.cell)):
                remedy = f"{error.right}, or {ignored}"
            elif not remedy and error.at:
                word = json.dumps(error.cell, ensure_ascii=False)
                remedy = f"{error.right}, or write missing = [{word}] in [read] if it stands for a missing one"
            wrong[name] = InvalidValue(error.wrong, remedy or error.right)
    return Numbers({}, {}, []), {}, wrong


def _refuse_ambiguity(name: str, layout: Layout) -> InvalidValue:
    """Error of a column whose points may be decimals or thousands."""
    mark = layout.decimal
    separator = next(name for name, character in SEPARATORS.items() if character == layout.separator)
    wrong = f"three digits stand behind each {quoted(mark)}: is 1{mark}234 a decimal number, or more than a thousand?"
    right = f'write decimal = "{mark}" in [read.column.{name}], or thousands = "{mark}" and decimal = ""'
    return InvalidValue(wrong, right + f', with separator = "{separator}"' * (not layout.is_plain and separator == ","))


def _placed_rows(
    file: str, columns: Mapping[str, np.ndarray], axis: str, over_range: Mapping[str, np.ndarray]
) -> tuple[dict[str, np.ndarray], np.ndarray, list[str]]:
    """Columns without the rows that stand nowhere on the axis, numbers of the rows, and what is said of empty cells."""
    is_placed = ~np.isnan(columns[axis])
    rows = np.flatnonzero(is_placed)
    hints = []
    if len(rows) < len(is_placed):
        number = len(is_placed) - len(rows)
        hints.append(f"{file}: {number} row{'s' * (number > 1)} without {axis} left out")
        columns = {name: values[is_placed] for name, values in columns.items()}
    over = {name: int(flags[is_placed].sum()) for name, flags in over_range.items()}
    return dict(columns), rows, [*hints, *_empty_cells(file, columns, over)]


def _empty_cells(file: str, columns: Mapping[str, np.ndarray], over_range: Mapping[str, int]) -> Iterator[str]:
    """What is said of cells without a number."""
    for name, values in columns.items():
        if number := int(np.isnan(values).sum()):
            cells = f"{number} of {len(values)} cells have no number"
            if many := over_range.get(name):
                cells += f", {many} of them as it is over range"
            yield f"{file}: {name}: {cells}; the other cells of their rows are used"
