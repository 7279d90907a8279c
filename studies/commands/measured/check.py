"""Command `apesim measured check`."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from apesim.studies.commands.options import Common, MeasuredFolder, Overwrite
from apesim.studies.terminal.console import BAD_INPUT, DONE

if TYPE_CHECKING:
    from apesim.studies.measured import Measured
    from apesim.studies.measured.plausibility import Finding

HEADER = ("", "file", "channel", "seen", "likely reason", "right")


def check_measured_folder(
    common: Common,
    folder: MeasuredFolder,
    out: Annotated[
        Path | None, typer.Option(metavar="OUT", help="Draw all runs over the model, into this folder.")
    ] = None,
    overwrite: Overwrite = False,
) -> int:
    """Judge whether measured data can be what measured.toml says, and draw them over the model.

    A fault cannot be physics of a rig anywhere near the machine: gap explain and valve fit refuse such data. A warning
    may be real. A hint is information. What measured.toml lacks is named with its right form, and an unknown key with
    those that are known.
    """
    from apesim.studies.execution.output import make_folder
    from apesim.studies.execution.own_thread import call_in_thread
    from apesim.studies.measured import read_measured
    from apesim.studies.measured.check import check_measured
    from apesim.studies.measured.plausibility import group_findings
    from apesim.studies.terminal.tables import table_of

    console, machine = common.console, common.load_machine()
    measured = read_measured(folder, machine.ambient.pressure)
    console.notes(measured.hints)
    if out is not None:
        make_folder(out, overwrite)
    with console.stages("plausibility") as progress:
        check = call_in_thread(check_measured, machine, measured, progress=progress).result()
    drawn = check.write(out, overwrite=True) if out is not None else []
    rows = [_row(finding, more) for finding, more in group_findings(check.findings)]
    shown = [table_of("", HEADER, rows, left=range(len(HEADER)))] if rows else []
    lines = list(_show_tables(measured))
    lines += [f"figures in {out}/"] if drawn else []
    data = check.to_dict() | {"figures": [str(path) for path in drawn]}
    console.result(data, *shown, *lines, check.summary)
    return BAD_INPUT if check.faults else DONE


def _show_tables(measured: "Measured") -> Iterator[str]:
    """How files were read of whose form something was guessed, as ``measured.toml`` may say it."""
    files: dict[str, list[str]] = {}
    for file, table in measured.read.items():
        if table.guessed:
            files.setdefault(str(table), []).append(file)
    for text, (first, *more) in files.items():
        yield f"{first}{f' and {len(more)} more' if more else ''}, as measured.toml may say it:"
        yield from text.splitlines()


def _row(finding: "Finding", more: int) -> tuple[str, ...]:
    """Cells of a finding that stands for some more of other files, or of other runs of measured.toml."""
    from apesim.studies.measured.sensors import FILE

    behind = f" and {more} more" if more else ""
    of_run = finding.file == FILE
    return (
        str(finding.kind),
        finding.file + ("" if of_run else behind),
        finding.channel + (behind if of_run else ""),
        finding.seen,
        finding.reason,
        finding.right,
    )
