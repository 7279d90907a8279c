"""Tables on the terminal."""

from collections.abc import Iterable, Sequence
from math import isnan
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rich.table import Table


def number(value: float, form: str = ".5g") -> str:
    """A number as text; "-" where there is none."""
    return "-" if isnan(value) else f"{value:{form}}"


def table_of(title: str, header: Iterable[str], rows: Iterable, left: Sequence[int] = (0,)) -> "Table":
    """A table whose columns stand to the right, but for some.

    Parameters
    ----------
    title : str
    header : sequence of str
    rows : sequence of sequence of str
    left : sequence of int
        Columns that stand to the left.

    Returns
    -------
    rich.table.Table
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
    """A table whose first columns are pressure and temperature of the supply.

    Parameters
    ----------
    title : str
    ambient_pressure : float
        [Pa abs]
    columns : dict of array
        Those of an archive, ``supply_pressure`` [Pa abs] and ``supply_temperature`` [K] among them.
    header : sequence of str
    rows : iterable of sequence of str
        What stands behind them, one for each run.

    Returns
    -------
    rich.table.Table
    """
    supplies = zip(columns["supply_pressure"] - ambient_pressure, columns["supply_temperature"], strict=True)
    rows = [(f"{p / 1e6:.3g}", f"{t:g}", *row) for (p, t), row in zip(supplies, rows, strict=True)]
    return table_of(title, ("MPa gauge", "K", *header), rows, left=())
