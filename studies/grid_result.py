"""Results of studies over a full grid of operating points."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.grid import words_of
from apesim.results import Result, Trace, name_of
from apesim.studies.archive_result import ArchiveResult

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False, repr=False)
class GridResult(ArchiveResult):
    """Result of a study over a full grid of operating points.

    Attributes
    ----------
    ambient_pressure : float
        What gauge pressures stand above [Pa abs].
    """

    axes: ClassVar[tuple[str, ...]] = ()
    """Variables over the runs that span the grid, the last one running fastest."""

    ambient_pressure: float = field(kw_only=True)

    @classmethod
    def conditions_of(cls, archive: Archive) -> Mapping[str, str]:
        """Each axis with its ends."""
        return {name.removesuffix("_rpm").removesuffix("_deg"): _span(archive.variables[name]) for name in cls.axes}

    def runs_of_grid(self) -> np.ndarray:
        """Runs that are points of the grid."""
        return np.arange(len(self.archive.runs))

    def to_xarray(self) -> "xarray.Dataset":
        """All results over the axes of the grid; each variable has the attributes ``units`` and ``long_name``.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        ImportError
            xarray is not installed.
        """
        traces = traces_over(self.archive, self.axes, self.runs_of_grid())
        scalars = {name: scalar for name, scalar in self.scalars.items() if name not in traces}
        over_grid = Result(scalars, traces, self.conditions, self.warnings, machine=self.machine)
        return over_grid.to_xarray().assign_attrs(title=self.title)

    @abstractmethod
    def draw(self, folder: str | PathLike[str]) -> list[Path]:
        """Draw all figures into a folder, as PNG and PDF; returns their paths."""

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """The result under the keys of the command's JSON; NaN where JSON says null."""


def _span(variable: Variable) -> str:
    """Values of an axis in words: one of them, or both ends and how many there are."""
    factor, unit = (1e-6, "MPa abs") if variable.unit == "Pa abs" else (1.0, variable.unit)
    points = [f"{factor * value:.5g}" for value in np.unique(variable.values)]
    return f"{points[0]} {unit}" if len(points) == 1 else f"{points[0]} to {points[-1]} {unit} ({len(points)})"


def traces_over(archive: Archive, axes: Sequence[str], runs: np.ndarray) -> dict[str, Trace]:
    """Variables of an archive over named axes instead of runs; codes as the words that they stand for.

    Parameters
    ----------
    archive : Archive
    axes : sequence of str
        Variables over the runs, which span a full grid, the last one running fastest.
    runs : (n,) int array
        Runs that are points of the grid.

    Returns
    -------
    dict of str to Trace
    """
    variables = archive.variables
    points = {}
    for name in axes:
        values = variables[name].values[runs]
        points[name] = values[np.sort(np.unique(values, return_index=True)[1])]
    shape = tuple(len(values) for values in points.values())
    names = {name: name_of(name, variable.unit) for name, variable in variables.items()}
    traces = {}
    for name, variable in variables.items():
        if name == "run":
            continue
        values, dims = words_of(variable), variable.dims
        if name in axes:
            values, dims = points[name], (name,)
        elif dims[0] == "run":
            values, dims = values[runs].reshape(*shape, *values.shape[1:]), (*axes, *dims[1:])
        traces[names[name]] = Trace(tuple(names[dim] for dim in dims), values, variable.unit, variable.description)
    return traces
