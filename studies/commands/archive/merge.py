"""Command `apesim archive merge`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import Common, Overwrite
from apesim.studies.terminal.console import DONE, INCOMPLETE


def merge_archives(
    common: Common,
    paths: Annotated[list[Path], typer.Argument(metavar="F.h5...", help="Archives of the parts of one sweep.")],
    out: Annotated[Path, typer.Option(metavar="F.h5", help="Archive to write.")],
    overwrite: Overwrite = False,
) -> int:
    """Join the archives of `--shard` jobs."""
    from apesim.archive import read_digest
    from apesim.archive.completeness import missing_runs, runs_planned
    from apesim.studies.archives import joining
    from apesim.studies.commands.archive.machine_differences import refuse_other_machine
    from apesim.studies.execution.output import digest_line

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
