"""Results of studies that leave an archive: whatever was run, its variables are at hand by name."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import nan
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from apesim.archive import Archive
from apesim.archive.grid import words_of
from apesim.results import Result, Scalar, Trace, name_of

if TYPE_CHECKING:
    import pandas
    import xarray


@dataclass(frozen=True, eq=False, repr=False)
class ArchiveResult(Result):
    """What an archive holds; its variables are the traces, over the runs.

    Attributes
    ----------
    archive : Archive
    failed : tuple of str
        One line for each point that failed, is out of reach or did not converge.
    """

    title: ClassVar[str] = "results of an archive"

    archive: Archive = field(kw_only=True)
    failed: tuple[str, ...] = field(default=(), kw_only=True)

    @classmethod
    def of(cls, archive: Archive, wall_time: float = nan, **more: Any) -> Self:
        """The result of an archive.

        Parameters
        ----------
        archive : Archive
        wall_time : float
            Computing time [s].
        **more
            Further attributes.
        """
        failed = tuple(
            more.pop("failed", None) or cls._faults_of(archive)
        )  # a sweep knows of points without a run, too
        scalars = {
            "runs": Scalar(len(archive.runs), "1", "runs"),
            "failed_runs": Scalar(len(failed), "1", "points that failed, are out of reach or did not converge"),
            **cls._summary_of(archive),
        }
        if not np.isnan(wall_time):
            scalars["wall_time"] = Scalar(wall_time, "s", "computing time")
        return cls(
            scalars,
            variables_of(archive),
            cls._conditions_of(archive),
            tuple(cls._warnings_of(archive)),
            f"{len(failed)} failed: {failed[0]}" if failed else "",
            not failed,
            archive.machine,
            archive=archive,
            failed=failed,
            **more,
        )

    @classmethod
    def _holds(cls, archive: Archive) -> bool:
        """Whether an archive is one of this kind."""
        return True

    @classmethod
    def _faults_of(cls, archive: Archive) -> Iterable[str]:
        """One line for each run that has no good result."""
        return ()

    @classmethod
    def _warnings_of(cls, archive: Archive) -> Iterable[str]:
        """One line for each thing that a reader should know."""
        return ()

    @classmethod
    def _summary_of(cls, archive: Archive) -> Mapping[str, Scalar]:
        """Numbers over all runs."""
        return {}

    @classmethod
    def _conditions_of(cls, archive: Archive) -> Mapping[str, str]:
        """What was run."""
        return {"by": archive.provenance["command"]} if archive.provenance.get("command") else {}

    @property
    def dataset(self) -> "xarray.Dataset":
        """All variables as xarray knows them; see `to_xarray`."""
        return self.to_xarray()

    def to_pandas(self) -> "pandas.DataFrame":
        """Make a table with a row for each run; codes are the words that they stand for.

        Variables with further axes, such as traces over the crank angle, are left out: `to_xarray` holds them.

        Returns
        -------
        pandas.DataFrame
            ``attrs["units"]`` and ``attrs["long_names"]`` are mappings by column.

        Raises
        ------
        ImportError
            pandas is not installed.
        """
        frame = super().to_pandas()
        for name, variable in self.archive.variables.items():
            if variable.meanings and name_of(name, variable.unit) in frame:
                frame[name_of(name, variable.unit)] = words_of(variable)
        return frame

    def write(self, path: str | PathLike[str], *, overwrite: bool = False) -> Path:
        """Write the archive.

        Parameters
        ----------
        path : path
        overwrite : bool
            Replace one that is there.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ArchiveError
            It exists, or cannot be written.
        """
        from apesim.studies.output import publish

        publish(self.archive, path, overwrite=overwrite)
        return Path(path)


def variables_of(archive: Archive) -> dict[str, Trace]:
    """Variables of an archive by their names in Python, see `apesim.results`."""
    names = {name: name_of(name, variable.unit) for name, variable in archive.variables.items()}
    traces = {}
    for name, variable in archive.variables.items():
        values = variable.values.view()
        values.flags.writeable = False
        dims = tuple(names[dim] for dim in variable.dims)
        traces[names[name]] = Trace(dims, values, variable.unit, variable.description)
    return traces


def read_archive(path: str | PathLike[str]) -> ArchiveResult:
    """Read an archive back as the result that was written.

    Parameters
    ----------
    path : path
        The archive, from whomever: its checksums and digests are verified.

    Returns
    -------
    ArchiveResult
        A `Sweep`, `ValveMap` or `ValveLimit` where it is one.

    Raises
    ------
    ArchiveError
        The file is missing, damaged, unsafe, too large, no archive or of a newer format.

    Examples
    --------
    >>> import tempfile
    >>> import apesim
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = f"{folder}/map.h5"
    ...     found = apesim.map_valve(apesim.Machine(), pressure="0.8 MPa gauge", temperature="287 K", out=path)
    ...     again = apesim.read_archive(path)
    >>> type(again).__name__, again.conditions == found.conditions
    ('ValveMap', True)
    """
    from apesim.archive import read
    from apesim.studies.limit.valve_limit import ValveLimit
    from apesim.studies.sweep.study import Sweep
    from apesim.studies.valve_map import ValveMap

    archive = read(path)
    kind = next(kind for kind in (Sweep, ValveMap, ValveLimit, ArchiveResult) if kind._holds(archive))
    return kind.of(archive)
