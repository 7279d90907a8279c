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
from apesim.studies.archives.archive_result import ArchiveResult
from apesim.studies.archives.machines import read_recorded_machine

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
    """Variables over the runs that span the grid, the last one running fastest, unless `_axes_of` finds others."""

    ambient_pressure: float = field(kw_only=True)

    @classmethod
    def _axes_of(cls, archive: Archive) -> tuple[str, ...]:
        """Name the variables over the runs that span the grid of an archive."""
        return cls.axes

    @classmethod
    def _recorded(cls, archive: Archive) -> dict[str, Any]:
        """Find the ambient pressure in the text of the machine."""
        return {"ambient_pressure": read_recorded_machine(archive.machine).ambient.pressure}

    @classmethod
    def _conditions_of(cls, archive: Archive) -> Mapping[str, str]:
        """Write each axis in words, by its name: its value, or both ends and how many values there are."""
        axes = cls._axes_of(archive)
        return {name.removesuffix("_rpm").removesuffix("_deg"): _span(archive.variables[name]) for name in axes}

    def _runs_of_grid(self) -> np.ndarray:
        """Find the runs that are points of the grid."""
        return np.arange(len(self.archive.runs))

    def to_xarray(self) -> "xarray.Dataset":
        """Lay all results out over the axes of the grid, as an xarray dataset.

        Returns
        -------
        xarray.Dataset
            Each variable has the attributes ``units`` and ``long_name``.

        Raises
        ------
        ImportError
            xarray is not installed.

        Examples
        --------
        >>> import apesim
        >>> valves = apesim.assess_valve(apesim.Machine(), speed="900 rpm")
        >>> dataset = valves.to_xarray()
        >>> dict(dataset["brake_torque"].sizes)
        {'speed_rpm': 1, 'valve': 7}
        """
        traces = traces_over(self.archive, self._axes_of(self.archive), self._runs_of_grid())
        scalars = {name: scalar for name, scalar in self.scalars.items() if name not in traces}
        over_grid = Result(scalars, traces, self.conditions, self.warnings, machine=self.machine)
        return over_grid.to_xarray().assign_attrs(title=self.title)

    def draw(self, folder: str | PathLike[str]) -> list[Path]:
        """Draw all figures into a folder, each as PNG and PDF.

        Parameters
        ----------
        folder : path
            Folder to write to; it is made where it is missing.

        Returns
        -------
        list of Path
            Files that were written.

        Examples
        --------
        >>> import tempfile
        >>> from apesim.engine.machine import Machine
        >>> from apesim.studies.limit.engine_limit import EngineLimit, Failure, limit_columns
        >>> from apesim.studies.limit.engine_limit_map import EngineLimitMap
        >>> from apesim.studies.limit.points import Point
        >>> limit = EngineLimit(230.0, Failure.FULL_LIFT, np.nan, None, 102)
        >>> columns = limit_columns([(1.1e6, 287.0, 1.3, 1.1e6)], [Point.GRID_AND_OWN], [limit])
        >>> archive = Archive(Machine().to_toml(), {}, columns)
        >>> limits = EngineLimitMap.of(archive, ambient_pressure=101325.0, open_target_deg=-5.0)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     [path.name for path in limits.draw(folder)]
        ['engine_limit.png', 'engine_limit.pdf']
        """
        return self._draw(folder)

    @abstractmethod
    def _draw(self, folder: str | PathLike[str]) -> list[Path]:
        """Draw all figures into a folder; `draw` is what users call."""


def _span(variable: Variable) -> str:
    """Write the values of an axis in words: one of them, or both ends and how many there are."""
    factor, unit = (1e-6, "MPa abs") if variable.unit == "Pa abs" else (1.0, variable.unit)
    points = [f"{factor * value:.5g}" for value in np.unique(variable.values)]
    return f"{points[0]} {unit}" if len(points) == 1 else f"{points[0]} to {points[-1]} {unit} ({len(points)})"


def traces_over(archive: Archive, axes: Sequence[str], runs: np.ndarray) -> dict[str, Trace]:
    """Lay variables of an archive out over named axes instead of runs.

    Parameters
    ----------
    archive : Archive
        Archive whose runs span a full grid.
    axes : sequence of str
        Variables over the runs that span the grid, the last one running fastest.
    runs : (n,) int array
        Runs that are points of the grid.

    Returns
    -------
    dict of str to Trace
        Variables by their names in Python, the axes among them; codes are the words that they stand for.

    Examples
    --------
    >>> from apesim.archive.columns import column, run_axis
    >>> speeds = column([600.0, 900.0], "r/min", "speed of the crankshaft", coordinate=True)
    >>> torques = column([30.0, 29.0], "N m", "mean torque")
    >>> archive = Archive("", {}, {"run": run_axis(2), "speed_rpm": speeds, "torque_Nm": torques})
    >>> traces_over(archive, ["speed_rpm"], np.arange(2))["torque"]
    <Trace [N m] over 2 speed_rpm, 29 to 30>
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
