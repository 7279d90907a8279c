"""Command `apesim archive export`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.console import DONE
from apesim.studies.options import ArchivePath, Common


def export_archive(
    common: Common, path: ArchivePath, out: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder to make.")]
) -> int:
    """Write an archive as CSV, TOML and JSON files.

    Parameters
    ----------
    common : Common
        Console and machine of the command line.
    path : path
        Archive.
    out : path
        Folder to make.

    Returns
    -------
    int
        Exit code: 0 done, 3 where the archive was made with another machine than the one of the command line.

    Raises
    ------
    ArchiveError
        The archive cannot be read, or the folder not be made.

    Examples
    --------
    >>> import os, tempfile
    >>> from typer.testing import CliRunner
    >>> from apesim.archive import Archive, write
    >>> from apesim.archive.columns import column, run_axis
    >>> from apesim.studies.cli import app
    >>> variables = {"run": run_axis(1), "torque": column([20.0], "N m", "brake torque")}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = write(Archive("bore = 1", {}, variables), f"{folder}/a.h5")
    ...     _ = CliRunner().invoke(app, ["archive", "export", f"{folder}/a.h5", "--out", f"{folder}/a"])
    ...     sorted(os.listdir(f"{folder}/a"))
    ['machine.toml', 'provenance.json', 'runs.csv', 'traces', 'variables.csv']
    """
    from apesim.studies.archives import joining
    from apesim.studies.commands.archive.machine_differences import refuse_other_machine

    refused = refuse_other_machine(common, [path])
    if refused is not None:
        return refused
    files = joining.export_archive(path, out)
    common.console.result({"files": [str(file) for file in files]}, f"{out}: {len(files)} files")
    return DONE
