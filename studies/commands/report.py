"""Command `apesim report`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import ArchivePath, Common, Overwrite, as_options
from apesim.studies.terminal.console import DONE


def write_report(
    common: Common,
    path: ArchivePath,
    out: Annotated[
        Path | None, typer.Option(metavar="F.html", help="Page to write; beside the archive if left out.")
    ] = None,
    measured: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Measured data of the engine: torque and air over the curves of a sweep."),
    ] = None,
    overwrite: Overwrite = False,
) -> int:
    """Write a page of an archive: one HTML file that stands alone, for any browser, with curves that answer."""
    from apesim.studies.commands.archive.machine_differences import refuse_other_machine
    from apesim.studies.report import writing

    refused = refuse_other_machine(common, [path])
    if refused is not None:
        return refused
    with as_options("write_report"):
        page = writing.write_report(path, out, measured=measured, overwrite=overwrite)
    size = page.stat().st_size
    common.console.result({"file": str(page), "bytes": size}, f"{page}: {size / 1000:.0f} kB, opens in any browser")
    return DONE
