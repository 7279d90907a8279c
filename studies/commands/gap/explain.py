"""Command `apesim gap explain`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.options import Common, Jobs, MeasuredFolder, Overwrite, Without


def explain_gap(
    common: Common,
    folder: MeasuredFolder,
    out: Annotated[Path, typer.Option(metavar="OUT", help="Folder for verdict.json, machine.toml and report.html.")],
    without: Without = None,
    tolerance: Annotated[
        float | None, typer.Option(metavar="SIZE", min=0.0, help="A gap below this share of the noise is none; 0.15.")
    ] = None,
    jobs: Jobs = None,
    overwrite: Overwrite = False,
) -> int:
    """Find where measurements and model disagree, name the effect that is missing, add it, show the gap shrink."""
    from apesim.studies.commands.gap_explain import explain_command

    return explain_command(
        common,
        folder=folder,
        out=out,
        without=without or (),
        tolerance=tolerance,
        jobs=jobs,
        overwrite=overwrite,
    )
