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
    """Return the axis of runs, which are numbered from 0 as int64."""
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

    Numbers keep their type; codes and flags become int8, the flags with the meanings "0 no, 1 yes". `meanings` says
    what codes mean, such as "0 epv, 1 cam"; `coordinate` marks values that say where in a grid the runs lie and are no
    results.
    """
    array = np.asarray(values)
    if array.dtype == bool:
        meanings = meanings or NO_YES
    return Variable(
        ("run",), array.astype(np.int8) if meanings else array, unit, description, meanings, coordinate=coordinate
    )


def meanings_of(names: Iterable[str]) -> str:
    """Return the text that says what the codes 0, 1... mean, from words in their order, none with a comma."""
    return ", ".join(f"{code} {name}" for code, name in enumerate(names))


def values_of(archive: Archive) -> dict[str, np.ndarray]:
    """Return the values of the variables of an archive, by their names; each in its unit, not copied."""
    return {name: variable.values for name, variable in archive.variables.items()}


def run_text(archive: Archive, place: int) -> str:
    """Return a run in words, e.g. "run 3 (0.5 MPa abs, 287 K, duty 0.5)".

    `place` is its index along the axis of runs.
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
