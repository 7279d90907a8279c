"""Tables of runs: their coordinates and some of their numbers."""

from collections.abc import Iterable

import numpy as np

from apesim.archive import Archive
from apesim.studies.report.figures.labels import find_shown_unit, format_number, shorten_name
from apesim.studies.report.grid import words_over_runs
from apesim.studies.report.sections import Table

MAX_ROWS = 120
"""Runs up to which all are in the table of a page; more are for a program to read."""
MAX_COLUMNS = 12
"""Columns of a table: more would fit no page."""


def list_runs(archive: Archive, names: Iterable[str]) -> Table | None:
    """Make a table of runs with some variables; None where there are too many runs."""
    names = [name for name in names if name in archive.variables and archive.variables[name].dims == ("run",)]
    if not names or len(archive.runs) > MAX_ROWS:
        return None
    names = [name for name in names if _has_cells(archive, name)]
    columns = [_write_column(archive, name) for name in names[:MAX_COLUMNS]]
    if len(archive.runs) == 1:
        return Table("", ("", "value"), [(head, cells[0]) for head, cells in columns])
    heads, cells = zip(*columns, strict=True)
    return Table("", heads, list(zip(*cells, strict=True)))


def _has_cells(archive: Archive, name: str) -> bool:
    """Whether a variable has a word or a number."""
    variable = archive.variables[name]
    return bool(variable.meanings) or variable.kind == "text" or bool(np.isfinite(variable.values.astype(float)).any())


def _write_column(archive: Archive, name: str) -> tuple[str, list[str]]:
    """Head and cells of a column."""
    variable = archive.variables[name]
    if variable.meanings or variable.kind == "text":
        return shorten_name(name), words_over_runs(archive, name)
    factor, unit = find_shown_unit(variable.unit, variable.values)
    head = shorten_name(name) + (f" [{unit}]" if unit else "")
    return head, [format_number(float(value)) for value in np.asarray(variable.values, dtype=float) * factor]
