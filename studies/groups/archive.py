"""The commands of archives."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.options import (
    ArchivePath,
    Common,
    Overwrite,
    command,
)

archive = typer.Typer(
    no_args_is_help=True,
    help="Archives of results. With --machine or --set, commands also say whether they were made with it.",
)


@command(archive)
def info(common: Common, path: ArchivePath):
    """What an archive holds and where it comes from."""
    from apesim.studies.commands.archive import show_info

    return show_info(*common, path)


@command(archive)
def verify(common: Common, path: ArchivePath):
    """Check every checksum, unit and axis; exit code 3 if anything is wrong."""
    from apesim.studies.commands.archive import show_faults

    return show_faults(*common, path)


@command(archive)
def diff(
    common: Common,
    path: ArchivePath,
    other: Annotated[Path, typer.Argument(metavar="G.h5", help="Archive to compare with.")],
    rtol: Annotated[float, typer.Option(min=0.0, help="Relative difference that counts as none.")] = 0.0,
    atol: Annotated[float, typer.Option(min=0.0, help="Absolute difference that counts as none, in SI.")] = 0.0,
    show_all: Annotated[bool, typer.Option("--all", help="Show every difference, not only the first 20.")] = False,
):
    """Compare two archives, sweeps by the coordinates of their runs; exit code 3 if they differ."""
    from apesim.studies.commands.archive import show_differences

    return show_differences(*common, path, other, rtol, atol, show_all)


@command(archive)
def export(
    common: Common, path: ArchivePath, out: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder to make.")]
):
    """Write an archive as CSV, TOML and JSON files."""
    from apesim.studies.commands.archive import export_archive

    return export_archive(*common, path, out)


@command(archive)
def merge(
    common: Common,
    paths: Annotated[list[Path], typer.Argument(metavar="F.h5...", help="Archives of the parts of one sweep.")],
    out: Annotated[Path, typer.Option(metavar="F.h5", help="Archive to write.")],
    overwrite: Overwrite = False,
):
    """Join the archives of `--shard` jobs."""
    from apesim.studies.commands.archive import merge_archives

    return merge_archives(*common, paths, out, overwrite)
