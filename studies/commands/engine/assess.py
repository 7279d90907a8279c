"""Command `apesim engine assess`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import Common, Figures, Out, Overwrite, Report, Speeds, as_options
from apesim.studies.run.default_grids import SPEEDS
from apesim.studies.terminal.console import DONE, INCOMPLETE


def assess_valve(
    common: Common,
    speed: Speeds = SPEEDS,
    timing: Annotated[
        str,
        typer.Option(metavar="NAME", help="fixed: the machine's commands; corrected: those that meet its targets."),
    ] = "fixed",
    out: Out = Path("assessment.h5"),
    overwrite: Overwrite = False,
    figures: Figures = True,
    report: Report = None,
) -> int:
    """What the valve's lateness, finite speed, fluctuation and control air cost in torque and air.

    What lateness and finite speed cost depends on which of them comes first: both orders, and their mean.
    """
    import sys

    from apesim.archive import command_line
    from apesim.studies.assessment import comparison
    from apesim.studies.assessment.summary import EXPLAINED, tables_of
    from apesim.studies.execution.output import written_json, written_text
    from apesim.studies.report.writing import prepare_page

    console, machine = common.console, common.load_machine()
    write_page = prepare_page(report, overwrite=overwrite)
    with as_options("assess_valve"), console.progress("assessment") as show_progress:
        result = comparison.assess_valve(
            machine,
            speed=speed,
            timing=timing,
            out=out,
            overwrite=overwrite,
            progress=show_progress,
            call=command_line(["apesim", *sys.argv[1:]]),
        )
    drawn = result.draw(out.with_suffix(".figures")) if figures else []
    written = written_json(out, drawn, result["wall_time"]) | write_page(out)
    lines = written_text(written, f"{result['runs']} points")
    console.result(result.to_dict() | written, *tables_of(result.archive), EXPLAINED, lines)
    for line in (*result.failed, *result.warnings):
        console.message(f"warning: {line}")
    return INCOMPLETE if result.failed else DONE
