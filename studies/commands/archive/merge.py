"""Command `apesim archive merge`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.console import DONE, INCOMPLETE
from apesim.studies.options import Common, Overwrite


def merge_archives(
    common: Common,
    paths: Annotated[list[Path], typer.Argument(metavar="F.h5...", help="Archives of the parts of one sweep.")],
    out: Annotated[Path, typer.Option(metavar="F.h5", help="Archive to write.")],
    overwrite: Overwrite = False,
) -> int:
    """Join the archives of `--shard` jobs.

    Parameters
    ----------
    common : Common
        Console and machine of the command line.
    paths : list of path
        Archives of the parts of one sweep.
    out : path
        Archive to write.
    overwrite : bool
        Replace one that is there.

    Returns
    -------
    int
        Exit code: 0 done, 3 where runs are missing still, or the parts were made with another machine.

    Raises
    ------
    ArchiveError
        A part cannot be read, the parts are not of one sweep, or the archive exists.

    Examples
    --------
    >>> from typer.testing import CliRunner
    >>> from apesim.studies.cli import app
    >>> print(CliRunner().invoke(app, ["archive", "merge", "part_1.h5", "part_2.h5", "--out", "sweep.h5"]).exception)
    part_1.h5: there is no such file; check the name
    """
    from apesim.archive import read_digest
    from apesim.archive.completeness import missing_runs, runs_planned
    from apesim.studies.archives import joining
    from apesim.studies.commands.archive.machine_differences import refuse_other_machine
    from apesim.studies.output import digest_line

    refused = refuse_other_machine(common, paths)
    if refused is not None:
        return refused
    merged, digest = joining.merge_archives(paths, out, overwrite=overwrite), read_digest(out)
    gaps = missing_runs(merged.archive, runs_planned(merged.archive))
    common.console.result(
        {"archive": str(out), "content_sha256": digest, "runs": merged["runs"], "missing_runs": gaps},
        f"{out}: {merged['runs']} runs",
        digest_line(digest),
    )
    for first, last in gaps:
        common.console.message(f"warning: runs {first} to {last} are missing")
    return INCOMPLETE if gaps else DONE
