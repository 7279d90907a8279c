"""Archives whose runs are the points of a grid: named axes instead of run numbers.

Such an archive names its axes in the provenance entry "axes": JSON, the texts of the values of each axis by its name,
the last axis running fastest. Each name is that of a variable over the runs, which holds the values as numbers.
"""

from __future__ import annotations

import json
import math
import os
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from apesim.archive.conventions import CONVENTIONS, own_attributes
from apesim.archive.file import Archive, ArchiveError, read
from apesim.archive.records import Variable, codes_of
from apesim.results import needed

if TYPE_CHECKING:
    import xarray

__all__ = ["axes_of", "grid_dataset", "places_of", "read_grid", "words_of"]


def axes_of(archive: Archive) -> dict[str, list[str]]:
    """Return the axes of a grid whose points are the runs of an archive: texts of the values by name.

    Raises ValueError where the archive names none, or those that it names do not fit its runs.
    """
    axes = json.loads(archive.provenance.get("axes", "{}"))
    if not isinstance(axes, dict) or not axes:
        raise ValueError("its runs are no grid, it names no axes")
    for name, texts in axes.items():
        if not isinstance(texts, list) or not all(isinstance(text, str) for text in texts):
            raise ValueError(f"the axis {name} is no list of texts")
        if name not in archive.variables or archive.variables[name].dims != ("run",):
            raise ValueError(f"no variable over the runs for the axis {name}")
    if len(archive.runs) and archive.runs[-1] >= math.prod(map(len, axes.values())):
        raise ValueError("more runs than its axes have points")
    return axes


def places_of(archive: Archive) -> tuple[np.ndarray, ...]:
    """Return the place of each run along each axis of the grid, a (runs,) int array for each axis.

    Raises ValueError where the runs are no grid, see `axes_of`.
    """
    return np.unravel_index(archive.runs, [len(texts) for texts in axes_of(archive).values()])


def read_grid(path: str | os.PathLike[str]) -> xarray.Dataset:
    """Return an archive with named axes, as xarray knows them; codes along an axis are words.

    Axes come first as they were varied, then those of the traces. Points that are missing are NaN (whole numbers then
    become floats), and a value whose points are all missing is left out. Raises ArchiveError where the archive cannot
    be read or its runs are no grid, ImportError without xarray.
    """
    needed("xarray")
    try:
        return grid_dataset(read(path))
    except ValueError as error:
        raise ArchiveError(path, str(error), "open it run by run: xarray.open_dataset") from None


def grid_dataset(archive: Archive) -> xarray.Dataset:
    """Return the runs of an archive over its named axes, see `read_grid`.

    Raises ValueError where they are no grid (see `axes_of`), ImportError without xarray.
    """
    xarray = needed("xarray")
    names, places = list(axes_of(archive)), places_of(archive)

    # Axes have only the values that occur: one whose points are all missing would be nothing but NaN.
    coordinates: dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, Any]]] = {}
    corner = []
    for name, place in zip(names, places, strict=True):
        _, first, corners = np.unique(place, return_index=True, return_inverse=True)
        corner.append(corners)
        variable = archive.variables[name]
        values = words_of(variable)[first]
        coordinates[name] = ((name,), values, _attributes(variable, values))

    # The results over the grid. Where points are missing, whole numbers become floats: integers have no NaN.
    shape = tuple(len(values) for _, values, _ in coordinates.values())
    whole = len(archive.runs) == math.prod(shape)
    results = {}
    for name, variable in archive.variables.items():
        if variable.dims[0] != "run":
            coordinates[name] = (variable.dims, variable.values, _attributes(variable, variable.values))
        elif name not in names:
            values = variable.values
            if not whole and values.dtype.kind == "i":
                values = values.astype(float)
            missing = np.nan if values.dtype.kind == "f" else values.dtype.type()
            grid = np.full(shape + values.shape[1:], missing, dtype=values.dtype)
            grid[tuple(corner)] = values
            results[name] = ((*names, *variable.dims[1:]), grid, _attributes(variable, values))
    about = {"Conventions": CONVENTIONS, "machine": archive.machine, **archive.provenance}
    return xarray.Dataset(results, coordinates, about)


def words_of(variable: Variable) -> np.ndarray:
    """Return the values of a variable, in its shape; codes as the words that they stand for."""
    if not variable.meanings:
        return variable.values
    words = codes_of(variable.meanings)
    return np.array([words[code] for code in variable.values.ravel().tolist()]).reshape(variable.values.shape)


def _attributes(variable: Variable, values: np.ndarray) -> dict[str, Any]:
    """Attributes of the CF conventions; codes that became words have no flags."""
    if values.dtype.kind == "U":
        return dict(own_attributes(replace(variable, meanings="")))
    attributes: dict[str, Any] = dict(own_attributes(variable))
    if "flag_values" in attributes:
        attributes["flag_values"] = np.array(attributes["flag_values"], values.dtype)
    return attributes
