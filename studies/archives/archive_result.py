"""Results of studies that leave an archive: whatever was run, its variables are at hand by name."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from importlib import import_module
from math import nan
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from apesim.archive import Archive
from apesim.archive.grid import words_of
from apesim.quantities import InputError
from apesim.results import Result, Scalar, Trace, name_of
from apesim.studies.archives.result_kinds import KINDS, kind_of
from apesim.studies.execution.calls import public

if TYPE_CHECKING:
    import pandas
    import xarray


@dataclass(frozen=True, eq=False, repr=False)
class ArchiveResult(Result):
    """What an archive holds; its variables are the traces, over the runs.

    Attributes
    ----------
    archive : Archive
        Archive with all variables.
    failed : tuple of str
        One line for each point that failed, is out of reach or did not converge.
    """

    title: ClassVar[str] = "results of an archive"

    archive: Archive = field(kw_only=True)
    failed: tuple[str, ...] = field(default=(), kw_only=True)

    @classmethod
    def of(cls, archive: Archive, wall_time: float = nan, **more: Any) -> Self:
        """Make the result of an archive.

        Parameters
        ----------
        archive : Archive
            Archive of a study.
        wall_time : float
            Computing time [s]; NaN: not known.
        **more
            Further attributes of the result; `failed` replaces the lines on the runs of the archive.

        Returns
        -------
        ArchiveResult
            Result of this class; its variables are the traces.

        Examples
        --------
        >>> from apesim.archive.columns import column, run_axis
        >>> archive = Archive("", {}, {"run": run_axis(2), "torque_Nm": column([30.0, 29.0], "N m", "mean torque")})
        >>> result = ArchiveResult.of(archive)
        >>> result["runs"], result.traces["torque"]
        (2, <Trace [N m] over 2 run, 29 to 30>)
        """
        failed = tuple(
            more.pop("failed", None) or cls._faults_of(archive)
        )  # a sweep knows of points without a run, too
        scalars = dict(cls._scalars_of(archive, failed))
        if not np.isnan(wall_time):
            scalars["wall_time"] = Scalar(wall_time, "s", "computing time")
        return cls(
            scalars,
            cls._traces_of(archive),
            cls._conditions_of(archive),
            tuple(cls._warnings_of(archive)),
            f"{len(failed)} failed: {failed[0]}" if failed else "",
            not failed,
            partial(getattr, archive, "machine"),
            archive=archive,
            failed=failed,
            **more,
        )

    @classmethod
    def _scalars_of(cls, archive: Archive, failed: Sequence[str]) -> Mapping[str, Scalar]:
        """Find the numbers of the result, beside the computing time."""
        return {
            "runs": Scalar(len(archive.runs), "1", "runs"),
            "failed_runs": Scalar(len(failed), "1", "points that failed, are out of reach or did not converge"),
            **cls._summary_of(archive),
        }

    @classmethod
    def _traces_of(cls, archive: Archive) -> Mapping[str, Trace]:
        """Lay out the variables of the archive as traces."""
        return variables_of(archive)

    @classmethod
    def _recorded(cls, archive: Archive) -> dict[str, Any]:
        """Find the further attributes of the result in the archive."""
        return {}

    @classmethod
    def _faults_of(cls, archive: Archive) -> Iterable[str]:
        """Write one line for each run that has no good result."""
        return ()

    @classmethod
    def _warnings_of(cls, archive: Archive) -> Iterable[str]:
        """Write one line for each thing that a reader should know."""
        return ()

    @classmethod
    def _summary_of(cls, archive: Archive) -> Mapping[str, Scalar]:
        """Find numbers over all runs."""
        return {}

    @classmethod
    def _conditions_of(cls, archive: Archive) -> Mapping[str, str]:
        """Write what was run, by name."""
        return {"by": archive.provenance["command"]} if archive.provenance.get("command") else {}

    @property
    def dataset(self) -> "xarray.Dataset":
        """All variables as xarray knows them; see `to_xarray`."""
        return self.to_xarray()

    def to_dict(self) -> dict[str, Any]:
        """Convert to a dictionary with the keys of the command's JSON.

        Returns
        -------
        dict
            Plain numbers, texts, lists and dictionaries; NaN where JSON says null.

        Examples
        --------
        >>> from apesim.archive.columns import run_axis
        >>> ArchiveResult.of(Archive("", {}, {"run": run_axis(2)})).to_dict()
        {'runs': 2, 'faults': []}
        """
        return {"runs": self["runs"], "faults": list(self.failed)}

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

        Examples
        --------
        >>> from apesim.archive.columns import column, run_axis
        >>> outcomes = column([0, 1], "1", "how it ended", "0 done, 1 failed")
        >>> archive = Archive("", {}, {"run": run_axis(2), "outcome": outcomes})
        >>> ArchiveResult.of(archive).to_pandas()["outcome"].tolist()
        ['done', 'failed']
        """
        frame = super().to_pandas()
        for name, variable in self.archive.variables.items():
            if variable.meanings and variable.dims == ("run",) and name_of(name, variable.unit) in frame:
                frame[name_of(name, variable.unit)] = words_of(variable)
        return frame

    def write(self, path: str | PathLike[str], *, overwrite: bool = False) -> Path:
        """Write the archive.

        Parameters
        ----------
        path : path
            File to write.
        overwrite : bool
            Replace one that is there.

        Returns
        -------
        Path
            Path of the file.

        Raises
        ------
        ArchiveError
            The file exists, or cannot be written.

        Examples
        --------
        >>> import tempfile
        >>> import apesim
        >>> delays = apesim.map_valve(apesim.Machine(), pressure="0.8 MPa gauge", temperature="287 K")
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = delays.write(f"{folder}/map.h5")
        ...     path.name, path.stat().st_size > 0
        ('map.h5', True)
        """
        from apesim.studies.execution.output import publish

        publish(self.archive, path, overwrite=overwrite)
        return Path(path)


def variables_of(archive: Archive) -> dict[str, Trace]:
    """Lay out the variables of an archive as traces, by their names in Python, see `apesim.results`.

    Parameters
    ----------
    archive : Archive
        Archive of a study.

    Returns
    -------
    dict of str to Trace
        Variables without units in their names; their values are read only.

    Examples
    --------
    >>> from apesim.archive.columns import column, run_axis
    >>> delays = column([5.9e-3, 5.5e-3], "s", "delay time")
    >>> archive = Archive("", {}, {"run": run_axis(2), "delay_s": delays})
    >>> variables_of(archive)["delay"]
    <Trace [s] over 2 run, 0.0055 to 0.0059>
    """
    names = {name: name_of(name, variable.unit) for name, variable in archive.variables.items()}
    traces = {}
    for name, variable in archive.variables.items():
        values = variable.values.view()
        values.flags.writeable = False
        dims = tuple(names[dim] for dim in variable.dims)
        traces[names[name]] = Trace(dims, values, variable.unit, variable.description)
    return traces


@public
def read_archive(path: str | PathLike[str]) -> ArchiveResult:
    """Read an archive back as the result that was written.

    Parameters
    ----------
    path : path
        Archive to read, from whomever: its checksums and digests are verified.

    Returns
    -------
    ArchiveResult
        Result of the class that was written, such as `Sweep`, with all that it can; a bare one, whose warning says why,
        where it cannot be read as that.

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

    return result_of(read(path))


def result_of(archive: Archive) -> ArchiveResult:
    """Make the result that an archive was written from.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    ArchiveResult
        Result of its kind, see `KINDS`; a bare one where it has none, or cannot be read as that.

    Examples
    --------
    >>> from apesim.archive.columns import column, run_axis
    >>> torque = column([3.0, 2.5], "N m", "brake torque")
    >>> result_of(Archive("", {}, {"run": run_axis(2), "torque": torque})).traces["torque"]
    <Trace [N m] over 2 run, 2.5 to 3>
    """
    kind = kind_of(archive.variables, archive.provenance)
    if kind not in KINDS:
        return _bare(archive, f"a kind that this version of apesim does not know: {kind!r}" if kind else "")
    module, name = KINDS[kind].split(":")
    result_class: type[ArchiveResult] = getattr(import_module(module), name)
    try:
        return result_class.of(archive, **result_class._recorded(archive))
    except (KeyError, ValueError, IndexError, TypeError, InputError) as error:  # whoever wrote it
        why = str(error) if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
        told = f"not read as what it seems to be, {result_class.title}, as something is missing or odd in it: {why}"
        return _bare(archive, told)


def _bare(archive: Archive, warning: str) -> ArchiveResult:
    """Make a result that knows no more than the variables, and warns why."""
    plain = ArchiveResult.of(archive)
    return replace(plain, warnings=(*plain.warnings, warning)) if warning else plain
