"""The table of a sweep that the console shows: torque and air of each operating point."""

from collections.abc import Sequence

from rich.table import Table

from apesim.archive import Archive
from apesim.archive.grid import axes_of, places_of
from apesim.studies.sweep.plan import in_one_unit
from apesim.studies.sweep.results import has_incomplete_stroke
from apesim.studies.terminal.tables import INCOMPLETE_MARK, number, table_of

MAX_ROWS_SHOWN = 500
"""Rows that are shown: nobody reads more, and to lay out 30 000 takes 80 MB."""
COLUMNS = {"brake_torque_Nm": ("N m", ".2f"), "specific_air_kg_per_kWh": ("kg/kWh", ".1f")}


def sweep_table(archive: Archive) -> Table:
    """Lay out the table that the console shows of a sweep, with a row for each varied combination and speed.

    For every actuation it has the brake torque [N m] and the consumption of all air over brake work [kg/kWh]; runs
    whose valve does not open fully and close fully are marked, and missing points are a dash. Only the first
    `MAX_ROWS_SHOWN` rows are shown, and how many there are.
    """
    (_, actuations), *axes = axes_of(archive).items()
    incomplete = has_incomplete_stroke(archive)
    blank = " " * int(incomplete.any())

    # Runs by their places along the axes: a point that is missing has none.
    points = list(zip(*(places.tolist() for places in places_of(archive)), strict=True))
    runs = {point: run for run, point in enumerate(points)}
    shown = sorted({at for at, *_ in points})

    def cell(column: str, point: tuple[int, ...], form: str) -> str:
        if point not in runs:
            return f"-{blank}"
        mark = INCOMPLETE_MARK if incomplete[runs[point]] else blank
        return number(archive.variables[column].values[runs[point]], form) + mark

    # A row for each combination of the other axes; the actuations stand side by side.
    heads, columns = zip(*(head_and_cells(name, texts) for name, texts in axes), strict=True)
    rows = []
    combinations = sorted({tuple(where) for _, *where in points})
    for where in combinations[:MAX_ROWS_SHOWN]:
        row = [columns[axis][at] for axis, at in enumerate(where)]
        row += [cell(column, (at, *where), form) for column, (_, form) in COLUMNS.items() for at in shown]
        rows.append(row)

    # Heads in the order of the cells above: one result of all actuations, then the next.
    header = list(heads)
    header += [f"{actuations[at]}\n[{unit}]" for unit, _ in COLUMNS.values() for at in shown]

    # The title says what the mark means, and how many rows are left out: nothing else would.
    title = "Brake torque, and all air over brake work"
    if incomplete.any():
        title += f" ({INCOMPLETE_MARK} incomplete stroke of the valve)"
    if len(rows) < len(combinations):
        title += f"; {len(rows)} of {len(combinations)} rows, all of which are in the archive"
    return table_of(title, header, rows, left=range(len(axes) - 1))


def head_and_cells(name: str, texts: Sequence[str]) -> tuple[str, Sequence[str]]:
    r"""Write the head and the cells of a column of values; a unit that all share stands in the head only.

    The head is the name of the axis in words, the unit in a second line.

    >>> head_and_cells("supply_pressure", ["0.6 MPa", "1 MPa"])
    ('supply pressure\n[MPa]', ['0.6', '1'])
    """
    cells, unit = in_one_unit(texts)
    name = name.removesuffix("_rpm").replace("_", " ")  # breaks at spaces only
    return f"{name}\n[{unit}]" if unit else name, cells
