"""Tables on the terminal, and traces as CSV."""

import csv
import io
from math import isnan
from pathlib import Path

from apesim.kernel import when_compiling

COMPILING = "compiling the model for this processor: once, some fifteen seconds"


def warm_up(console, march, *arguments, **options):
    """Run a march once, so that what is timed after it is compiled; tell where that takes long.

    Parameters
    ----------
    console : apesim.studies.console.Console
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
    from rich.text import Text

    table = Table(title=Text(title) if title else None, box=box.SIMPLE_HEAD, title_justify="left")
    for number, name in enumerate(header):
        table.add_column(name, justify="left" if number in left else "right", overflow="fold")
    for row in rows:
        table.add_row(*row)
    return table


def write_traces(path, header, rows):
    """Write traces as CSV, floats without loss; the file is complete or absent.

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
    from apesim.archive import ArchiveError, replace_file

    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows.tolist())
    path, content = Path(path), text.getvalue().encode()
    try:
        if path.exists() and (path.is_symlink() or not path.is_file()):  # /dev/stdout, a pipe: no name to take over
            path.write_bytes(content)
        else:
            replace_file(path, content)
    except OSError as error:
        raise ArchiveError(path, f"cannot be written: {error.strerror}", "choose another file") from None
