"""Tables on the terminal."""

from collections.abc import Iterable, Sequence
from math import isnan
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rich.table import Table

INCOMPLETE_MARK = "*"
"""What stands behind a number of a run whose valve does not make full strokes."""


def number(value: float, form: str = ".5g") -> str:
    """A number as text; "-" where there is none.

    Parameters
    ----------
    value : float
        The number; NaN: there is none.
    form : str
        Format of Python's numbers.

    Returns
    -------
    str
        Text for a cell.

    Examples
    --------
    >>> number(0.0123456), number(4.0, ".2f"), number(float("nan"))
    ('0.012346', '4.00', '-')
    """
    return "-" if isnan(value) else f"{value:{form}}"


def table_of(title: str, header: Iterable[str], rows: Iterable, left: Sequence[int] = (0,)) -> "Table":
    """Make a table whose columns stand to the right, but for some.

    Parameters
    ----------
    title : str
        Title; "" for none.
    header : iterable of str
        Names of the columns.
    rows : iterable of sequence of str
        Cells.
    left : sequence of int
        Columns that stand to the left.

    Returns
    -------
    rich.table.Table
        Table for `apesim.studies.terminal.console.Console.result`.

    Examples
    --------
    >>> table = table_of("Limits", ("air", "limit [r/min]"), [("0.6 MPa gauge", "1500")])
    >>> table.row_count, [column.justify for column in table.columns]
    (1, ['left', 'right'])
    """
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(title) if title else None, box=box.SIMPLE_HEAD, title_justify="left")
    for number, name in enumerate(header):
        table.add_column(name, justify="left" if number in left else "right", overflow="fold")
    for row in rows:
        table.add_row(*row)
    return table


def table_over_supplies(
    title: str, ambient_pressure: float, columns: dict[str, np.ndarray], header: Sequence[str], rows: Iterable
) -> "Table":
    """Make a table whose first columns are pressure and temperature of the supply.

    Parameters
    ----------
    title : str
        Title; "" for none.
    ambient_pressure : float
        Pressure that gauge pressures stand above [Pa abs].
    columns : dict of (n,) array
        Columns of an archive, ``supply_pressure`` [Pa abs] and ``supply_temperature`` [K] among them.
    header : sequence of str
        Names of the columns behind those two.
    rows : iterable of sequence of str
        Cells behind those two, one row for each run.

    Returns
    -------
    rich.table.Table
        Table for `apesim.studies.terminal.console.Console.result`.

    Examples
    --------
    >>> supplies = {"supply_pressure": np.array([0.6e6]), "supply_temperature": np.array([287.0])}
    >>> table = table_over_supplies("Limits", 0.1e6, columns=supplies, header=("[r/min]",), rows=[("1500",)])
    >>> [next(iter(column.cells)) for column in table.columns]
    ['0.5', '287', '1500']
    """
    supplies = zip(columns["supply_pressure"] - ambient_pressure, columns["supply_temperature"], strict=True)
    rows = [(f"{p / 1e6:.3g}", f"{t:g}", *row) for (p, t), row in zip(supplies, rows, strict=True)]
    return table_of(title, ("MPa gauge", "K", *header), rows, left=())
