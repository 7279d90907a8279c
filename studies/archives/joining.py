"""Joining the archives of one sweep's parts, and writing archives as text files."""

from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path

from apesim.archive import read
from apesim.archive.completeness import gaps_in_words, missing_runs, runs_planned
from apesim.archive.inspection import export
from apesim.archive.merge import merge
from apesim.studies.archives.archive_result import ArchiveResult, result_of
from apesim.studies.execution.calls import public
from apesim.studies.execution.output import publish


@public
def merge_archives(
    paths: Sequence[str | PathLike[str]], out: str | PathLike[str], *, overwrite: bool = False
) -> ArchiveResult:
    """Join the archives of the parts of one sweep, see ``shard`` of `apesim.sweep`.

    Parameters
    ----------
    paths : sequence of path
        Archives of the parts; runs that occur twice must agree bit for bit.
    out : path
        Archive to write.
    overwrite : bool
        Replace one that is there.

    Returns
    -------
    ArchiveResult
        All runs; a warning names those of the whole sweep that are missing still.

    Raises
    ------
    ArchiveError
        A part cannot be read, the parts do not belong together, or `out` exists.

    Examples
    --------
    >>> import tempfile
    >>> import apesim
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     parts = [f"{folder}/{number}.h5" for number in (1, 2)]
    ...     for shard, part in zip(["1/2", "2/2"], parts):
    ...         _ = apesim.sweep(apesim.Machine(), speed=["900 rpm", "1200 rpm"], intake="ideal", shard=shard, out=part)
    ...     whole = apesim.merge_archives(parts, f"{folder}/whole.h5")
    >>> whole.traces["speed_rpm"].values.round().tolist()
    [900.0, 1200.0]
    """
    archive = merge([read(path) for path in paths], list(paths))
    publish(archive, out, overwrite)
    result, planned = result_of(archive), runs_planned(archive)
    gaps = missing_runs(archive, planned)
    if not gaps:
        return result
    warning = f"missing runs: {gaps_in_words(gaps)} (of {planned} planned, counted from 0)"
    return replace(result, warnings=(*result.warnings, warning))


@public
def export_archive(path: str | PathLike[str], out: str | PathLike[str]) -> list[Path]:
    """Write an archive as CSV, TOML and JSON files; floats read back to the same bits.

    Parameters
    ----------
    path : path
        File of the archive.
    out : path
        Folder to make.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    ArchiveError
        The archive cannot be read, or the folder cannot be made.

    Examples
    --------
    >>> import tempfile
    >>> import apesim
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = f"{folder}/map.h5"
    ...     found = apesim.map_valve(apesim.Machine(), pressure="0.8 MPa gauge", temperature="287 K", out=path)
    ...     names = [file.name for file in apesim.export_archive(path, f"{folder}/text")]
    >>> names[:4]
    ['machine.toml', 'provenance.json', 'variables.csv', 'runs.csv']
    """
    return export(path, out)
