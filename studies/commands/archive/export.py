"""Command `apesim archive export`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import ArchivePath, Common
from apesim.studies.terminal.console import DONE


def export_archive(
    common: Common, path: ArchivePath, out: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder to make.")]
) -> int:
    """Write an archive as CSV, TOML and JSON files."""
    from apesim.studies.archives import joining
    from apesim.studies.commands.archive.machine_differences import refuse_other_machine

    refused = refuse_other_machine(common, [path])
    if refused is not None:
        return refused
    files = joining.export_archive(path, out)
    common.console.result({"files": [str(file) for file in files]}, f"{out}: {len(files)} files")
    return DONE
