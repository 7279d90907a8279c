"""Columns: what studies put into archives, a value for each run, and how a run is named by its coordinates."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from apesim.archive.records import Archive, Variable, codes_of

__all__ = ["NO_YES", "column", "meanings_of", "run_axis", "run_text", "values_of"]

NO_YES = "0 no, 1 yes"
"""Meanings of a flag."""
FORMATS = {"Pa abs": (1e6, "MPa abs"), "K": (1.0, "K"), "r/min": (1.0, "r/min"), "deg": (1.0, "deg"), "s": (1e-3, "ms")}
"""Units in which a coordinate is told in words, and what they are in the archive's."""


def run_axis(count: int, description: str = "number of the run") -> Variable:
    """Return the axis of runs that are numbered from 0.

    Parameters
    ----------
    count : int
        Number of runs.
    description : str
        What the axis is, in one line.

    Returns
    -------
    Variable
        Run numbers, int64, over the axis "run".

    Examples
    --------
    >>> run_axis(3).values.tolist()
    [0, 1, 2]
    """
    return Variable(("run",), np.arange(count), "1", description)


def column(
    values: ArrayLike | Iterable[float],
    unit: str,
    description: str,
    meanings: str = "",
    *,
    coordinate: bool = False,
) -> Variable:
    """Return the values of a quantity, one for each run, as a variable of an archive.

    Parameters
    ----------
    values : sequence
        One value for each run. Numbers keep their type; codes and flags become int8, the flags "0 no, 1 yes".
    unit : str
        Unit, such as "Pa abs"; "1" without any.
    description : str
        What the quantity is, in one line.
    meanings : str
        What codes mean, such as "0 epv, 1 cam"; "" for other values.
    coordinate : bool
        Whether the values say where in a grid the runs lie, and are no results.

    Returns
    -------
    Variable
        Variable over the axis "run".

    Examples
    --------
    >>> column([True, False], "1", "whether the motion turns back").meanings
    '0 no, 1 yes'
    """
    array = np.asarray(values)
    if array.dtype == bool:
        meanings = meanings or NO_YES
    return Variable(
        ("run",), array.astype(np.int8) if meanings else array, unit, description, meanings, coordinate=coordinate
    )


def meanings_of(names: Iterable[str]) -> str:
    """Return the text that says what the codes 0, 1... mean.

    Parameters
    ----------
    names : iterable of str
        Words in the order of their codes, none with a comma.

    Returns
    -------
    str
        Text as `Variable` takes it.

    Examples
    --------
    >>> meanings_of(["epv", "cam"])
    '0 epv, 1 cam'
    """
    return ", ".join(f"{code} {name}" for code, name in enumerate(names))


def values_of(archive: Archive) -> dict[str, np.ndarray]:
    """Return the values of the variables of an archive, by their names.

    Parameters
    ----------
    archive : Archive
        Results of runs.

    Returns
    -------
    dict of str to ndarray
        Values of each variable, in its unit; not copied.

    Examples
    --------
    >>> from apesim.archive import Archive
    >>> from apesim.archive.columns import column, run_axis
    >>> speed = column([600.0, 900.0], "r/min", "speed of the crank", coordinate=True)
    >>> torque = column([3.0, 2.5], "N m", "brake torque")
    >>> archive = Archive("bore = 1", {}, {"run": run_axis(2), "speed": speed, "torque": torque})
    >>> values_of(archive)["torque"].tolist()
    [3.0, 2.5]
    """
    return {name: variable.values for name, variable in archive.variables.items()}


def run_text(archive: Archive, place: int) -> str:
    """Return a run in words: its number and its coordinates.

    Parameters
    ----------
    archive : Archive
        Results of runs.
    place : int
        Index of the run along the axis of runs.

    Returns
    -------
    str
        E.g. "run 3 (0.5 MPa abs, 287 K, duty 0.5)".

    Examples
    --------
    >>> from apesim.archive import Archive
    >>> from apesim.archive.columns import column, run_axis
    >>> speed = column([600.0, 900.0], "r/min", "speed of the crank", coordinate=True)
    >>> torque = column([3.0, 2.5], "N m", "brake torque")
    >>> archive = Archive("bore = 1", {}, {"run": run_axis(2), "speed": speed, "torque": torque})
    >>> run_text(archive, 1)
    'run 1 (900 r/min)'
    """
    told = []
    for name, variable in archive.variables.items():
        if variable.coordinate and variable.dims == ("run",):
            value = variable.values[place]
            if variable.unit in FORMATS:
                size, unit = FORMATS[variable.unit]
                told.append(f"{value / size:g} {unit}")
            else:
                told.append(f"{name} {codes_of(variable.meanings)[int(value)] if variable.meanings else value}")
    return f"run {archive.runs[place]} ({', '.join(told)})"
