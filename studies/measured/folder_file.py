"""The file ``measured.toml`` of a folder: its text, its tables ``[read]``, and the instant that is t = 0 by them."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from apesim.quantities import Fault, InputError, InvalidValue, quoted
from apesim.quantities.files import path_below, text_of
from apesim.quantities.toml_text import parse_toml
from apesim.studies.measured.dialect import COMMAND, FIRST_ROW, READ, Dialect


def load_folder_file(path: Path) -> dict[str, Any]:
    """Load the file of a folder; raises InputError where it cannot be read, or is no TOML."""
    try:
        text = text_of(path_below(path.parent, path.name))
    except InvalidValue as wrong:
        right = wrong.right or f"give a folder with {path.name} and the CSV files that it names"
        raise InputError([Fault(str(path), "", wrong.wrong, right)]) from None
    return parse_toml(str(path), text, 'pulse = "50 ms"')


def take_read_table(file: str, section: str, data: Mapping[str, Any], all_faults: list[Fault]) -> dict[str, Any]:
    """Take the table ``[read]`` of a folder or a run; empty where there is none.

    `section` is the table's name in the file, `data` the contents of the folder's file, or of a run; `all_faults` gets
    a fault where it is no table.
    """
    table = data.get(READ, {})
    if isinstance(table, dict):
        return table
    all_faults.append(
        Fault(file, section, f"{quoted(table)} is no table", f"write [{'' if section == READ else 'run.'}{READ}]")
    )
    return {}


def find_unknown_start(file: str, axis: str, dialect: Dialect, *, is_counted: bool) -> Iterator[Fault]:
    """Find whether rows are counted, and nothing says where the command is.

    `axis` is the column over which the traces of the record stand; `is_counted`: its values are counted from the first
    row, as those of clock times are.

    >>> [fault.key for fault in find_unknown_start("p040.csv", "time", Dialect(interval=1e-3), is_counted=False)]
    ['time']
    """
    right = f'write in [read] start = "{FIRST_ROW}", or its time after the first row, e.g. start = "12.5 ms"'
    is_scaled = axis in dialect.scales and dialect.scales[axis].unit
    is_counted = is_counted or dialect.interval is not None
    if is_counted and dialect.start in (None, COMMAND):
        yield Fault(file, axis, "is counted from the first row, and the command may be at any", right)
    elif is_scaled and not is_counted and dialect.start is None:
        right = f'write in [read] start = "{COMMAND}" if it is at 0, start = "{FIRST_ROW}", or its time, e.g. "12.5 ms"'
        yield Fault(file, axis, "is made of other numbers by its scale, and the command may be at any of them", right)


def shift_to_start(times: np.ndarray, dialect: Dialect) -> np.ndarray:
    """Shift times (n,) [s] so that the command stands at 0, when the solenoids were energised.

    >>> shift_to_start(np.array([1.0, 2.0]), Dialect(start="first row")).tolist()
    [0.0, 1.0]
    """
    if dialect.start is None or isinstance(dialect.start, str):
        return times - times[0] if dialect.start == FIRST_ROW else times
    return times - dialect.start
