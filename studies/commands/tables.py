"""Tables on the terminal, and traces as CSV."""

import csv
from math import isnan

from apesim.archive import ArchiveError
from apesim.kernel import when_compiling

COMPILING = "compiling the model for this processor: once, about 20 s"


def warm_up(console, march, *arguments, **options):
    """Run a march once, so that what is timed after it is compiled; tell where that takes long.

    Parameters
    ----------
    console : studies.console.Console
    march : function
    """
    with when_compiling(lambda: console.message(COMPILING)):
        console.run("first march", march, *arguments, **options)


def number(value, form=".5g"):
    """A number as text; "-" where there is none."""
    return "-" if isnan(value) else f"{value:{form}}"


def table_of(title, header, rows, left=(0,)):
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

    table = Table(title=title or None, box=box.SIMPLE_HEAD, title_justify="left")
    for number, name in enumerate(header):
        table.add_column(name, justify="left" if number in left else "right")
    for row in rows:
        table.add_row(*row)
    return table


def write_traces(path, header, rows):
    """Write traces as CSV, floats without loss.

    Parameters
    ----------
    path : path
    header : sequence of str
        ``name [unit]``
    rows : (n, m) float array

    Raises
    ------
    ArchiveError
        The file cannot be written.
    """
    try:
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(header)
            writer.writerows(rows.tolist())
    except OSError as error:
        raise ArchiveError(path, f"cannot be written: {error.strerror}", "choose another file") from None
