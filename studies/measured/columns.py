"""Columns of measured CSV files, in SI: the name and unit of each stand in its header, e.g. ``lift [mm]``."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from apesim.quantities import Fault, InvalidValue, quoted, unit
from apesim.quantities.files import csv_columns
from apesim.quantities.units import NUMBER

TIME = "time"
"""Column over which the traces of a valve stand."""
NOT_MEASURED = "nan"
"""What stands in the cells of a column that was not measured."""
KINDS = (ABSOLUTE, GAUGE) = ("abs", "gauge")
"""Words behind the unit of a pressure."""


def read_columns(
    path: Path, declared: Mapping[str, str], due: Sequence[str], ambient_pressure: float, right: str
) -> tuple[dict[str, np.ndarray], list[str], list[Fault]]:
    r"""Read the declared columns of a CSV; others are ignored.

    Parameters
    ----------
    path : path
        CSV whose first line has names with units.
    declared : mapping of str to str
        The unit of each column by name, in any of its dimension; that of a pressure ends in `` abs``, and the file
        says whether it is abs or gauge.
    due : sequence of str
        Names that must be there; the first of them has to rise. Of others, one of nan alone is as if it were not there.
    ambient_pressure : float
        Pressure that gauge pressures stand above [Pa abs].
    right : str
        What is said to be right where the file is no CSV at all, or its first line no header; that line is not shown
        then, as the file may be any other.

    Returns
    -------
    columns : dict of str to (n,) float array
        Values in SI and absolute, by name; what is wrong is missing.
    names : list of str
        Names of all columns in the file.
    faults : list of Fault
        Faults, empty where there are none.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "p040.csv")
    ...     _ = path.write_text("time [ms],pressure [kPa gauge]\n0,400\n1,390\n")
    ...     declared = {"time": "ms", "pressure": "kPa abs"}
    ...     columns, _, faults = read_columns(path, declared, ("time", "pressure"), 100e3, "give a CSV")
    >>> columns["pressure"].tolist(), faults
    ([500000.0, 490000.0], [])
    """
    file = str(path)
    faults: list[Fault] = []
    columns: dict[str, np.ndarray] = {}
    try:
        texts = csv_columns(path)
    except InvalidValue as wrong:
        return {}, [], [Fault(file, "", wrong.wrong, wrong.right or right)]
    if not any(name in declared or _is_unit(text) for name, text in texts):
        return {}, [], [Fault(file, "", "line 1 is no header with names and units", right)]
    names = [name for name, _ in texts]
    for name, expected in declared.items():
        matching = [item for item in texts.items() if item[0][0] == name]
        form = f'write "{name} [{expected}]" in the header'
        if name in due and not matching:
            faults.append(Fault(file, name, "there is no such column", form))
        if len(matching) > 1:
            faults.append(Fault(file, name, "stands in several columns", "keep one of them"))
        elif matching and (name in due or any(cell.strip() != NOT_MEASURED for cell in matching[0][1])):
            (_, header_unit), cells = matching[0]
            try:
                columns[name] = _values(name, header_unit, cells, expected, ambient_pressure, form)
            except InvalidValue as wrong:
                faults.append(Fault(file, name, wrong.wrong, wrong.right))
    stuck = np.flatnonzero(np.diff(columns.get(due[0], ())) <= 0.0)
    if len(stuck) and not faults:
        faults.append(Fault(file, due[0], f"does not rise in row {stuck[0] + 2}", "sort the rows, one of equals"))
    return columns, names, faults


def _is_unit(text: str | None) -> bool:
    """Whether a text of a header, or None, is a unit."""
    try:
        return text is not None and bool(unit(re.sub(rf" ({'|'.join(KINDS)})$", "", text)))
    except InvalidValue:
        return False


def _values(
    name: str, given: str | None, cells: Sequence[str], expected: str, ambient_pressure: float, right: str
) -> np.ndarray:
    """The SI values of a column; raises `InvalidValue`."""
    if given is None:
        raise InvalidValue("has no unit", right)
    body, kind = given, ABSOLUTE
    if expected.endswith(ABSOLUTE):
        body, _, kind = given.rpartition(" ")
        if kind not in KINDS:
            raise InvalidValue(f"{quoted(given)} says neither gauge nor abs", f"{right}, or gauge")
    try:
        scale = unit(body)
    except InvalidValue as wrong:
        raise InvalidValue(wrong.wrong, right) from None
    if scale.dimension != unit(expected.removesuffix(f" {ABSOLUTE}")).dimension:
        raise InvalidValue(f"{quoted(given)} is no unit of {name}", right)
    for row, cell in enumerate(cells, 1):
        if not re.fullmatch(NUMBER, cell.strip()):
            raise InvalidValue(f"{quoted(cell)} in row {row} is no finite number", "give a number in every cell")
    offset = float(scale.offset) + (ambient_pressure if kind == GAUGE else 0.0)
    values = np.array([float(cell) for cell in cells]) * float(scale.factor) + offset
    if not np.all(np.isfinite(values)):
        raise InvalidValue(
            f"row {int(np.argmin(np.isfinite(values))) + 1} is too large, not finite", "give finite numbers"
        )
    return values
