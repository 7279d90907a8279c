"""Command `apesim engine optimise`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import Common, Figures, Jobs, Out, Overwrite, Report, Speeds, as_options
from apesim.studies.run.default_grids import OPTIMUM_SPEEDS
from apesim.studies.terminal.console import DONE, INCOMPLETE


def optimise_commands(
    common: Common,
    goal: Annotated[
        str, typer.Option("--for", metavar="GOAL", help="torque: the most; air: the least specific air; or both.")
    ] = "both",
    speed: Speeds = OPTIMUM_SPEEDS,
    free: Annotated[
        str | None,
        typer.Option(metavar="KEY=LOW:HIGH", help='Also "supply.pressure=0.5 MPa gauge:1.5 MPa gauge".'),
    ] = None,
    out: Out = Path("optimise.h5"),
    jobs: Jobs = None,
    overwrite: Overwrite = False,
    figures: Figures = True,
    report: Report = None,
) -> int:
    """Command angles for most torque, least specific air, or the best of both.

    In the coupled periodic state. For both, the Pareto front stands beside the two optima: commands than which no
    others give more torque with no more air. Exit code 3 where no commands give brake work.
    """
    import sys

    from apesim.archive import command_line
    from apesim.studies.execution.output import written_json, written_text
    from apesim.studies.optimise import optimisation
    from apesim.studies.optimise.summary import end_lines, optimum_table
    from apesim.studies.report.writing import prepare_page

    console, machine = common.console, common.load_machine()
    write_page = prepare_page(report, overwrite=overwrite)

    # The search, at each speed. Faults in its arguments are named as options, of which one has another name here.
    named = as_options("optimise_commands", goal="--for")
    with named, console.progress("optimise") as show_progress:
        result = optimisation.optimise_commands(
            machine,
            goal=goal,
            speed=speed,
            free=free,
            jobs=jobs,
            out=out,
            overwrite=overwrite,
            progress=show_progress,
            call=command_line(["apesim", *sys.argv[1:]]),
        )

    # What is shown: where all lies, the optima, and which of them lie at an end of the range that was searched.
    drawn = result.draw(out.with_suffix(".figures")) if figures else []
    written = written_json(out, drawn, result["wall_time"]) | write_page(out)
    counts = f"{result['runs']} speeds, {result['all_sketches']} sketches, {result['all_full_runs']} runs,"
    table = optimum_table(result.optima, result.ambient_pressure)
    console.result(result.to_dict() | written, table, *end_lines(result.optima), written_text(written, counts))

    # A speed without brake work leaves the others valid; the exit code tells of it.
    for fault in result.failed:
        console.message(f"warning: {fault}")
    return INCOMPLETE if result.failed else DONE
