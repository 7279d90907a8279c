"""Command `apesim valve soft-landing`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import Common, Figures, Jobs, Out, Overwrite, Report, as_options
from apesim.studies.terminal.console import DONE, INCOMPLETE


def find_soft_landing(
    common: Common,
    pressure: Annotated[
        str | None,
        typer.Option(metavar="R", help="Control pressures; 0.4, 1 and 1.6 times the machine's own gauge pressure."),
    ] = None,
    temperature: Annotated[
        str | None, typer.Option(metavar="T", help="Of the control air; the machine's own if left out.")
    ] = None,
    cost: Annotated[str, typer.Option(metavar="TIME", help="Added to a stroke, command to contact, at most.")] = "1 ms",
    spacing: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="Between two edges of a solenoid, at least; 4.17 ms (120 Hz) if left out."),
    ] = None,
    solenoids: Annotated[
        str, typer.Option(metavar="both|a|b|any", help="Switched by a brake: both at once, A or B alone, the best.")
    ] = "any",
    pulse: Annotated[str, typer.Option(metavar="TIME", help="From each command edge to the next.")] = "50 ms",
    out: Out = Path("soft_landing.h5"),
    jobs: Jobs = None,
    overwrite: Overwrite = False,
    figures: Figures = True,
    report: Report = None,
) -> int:
    """Pulse patterns that lower the seating speed: a braking re-switch in each stroke.

    A brake switches both solenoids at once or one of them alone, whichever lands the piston more softly. Edges are
    counted from the command edge of their stroke. Brakes are given for the spacing the solenoids can do, and for any
    spacing; the softest, and the sturdiest at 5 % more and less pressure and 10 K more and less. Exit code 3 where no
    brake within the spacing lowers the seating speed at that cost.
    """
    import sys

    from apesim.archive import command_line
    from apesim.studies.execution.output import written_json, written_text
    from apesim.studies.report.writing import prepare_page
    from apesim.studies.soft_landing import study
    from apesim.studies.soft_landing.summary import landing_tables

    console, machine = common.console, common.load_machine()
    write_page = prepare_page(report, overwrite=overwrite)

    # The brakes of each stroke. Faults in the arguments are named as options of the command line.
    with as_options("find_soft_landing"), console.progress("soft landing") as show_progress:
        result = study.find_soft_landing(
            machine,
            pressure=pressure,
            temperature=temperature,
            cost=cost,
            spacing=spacing or None,
            solenoids=solenoids,
            pulse=pulse,
            out=out,
            jobs=jobs,
            overwrite=overwrite,
            progress=show_progress,
            call=command_line(["apesim", *sys.argv[1:]]),
        )

    # Where archive and figures lie, and the tables, in which spacing and cost bound the brakes.
    drawn = result.draw(out.with_suffix(".figures")) if figures else []
    written = written_json(out, drawn, result["wall_time"]) | write_page(out)
    tables = landing_tables(result.strokes, result.spacing, result.cost)
    console.result(result.to_dict() | written, *tables, written_text(written, f"{len(result.strokes)} strokes"))

    # A stroke that no brake softens leaves the others valid; the exit code tells of it.
    for fault in result.failed:
        console.message(f"warning: {fault}")
    return INCOMPLETE if result.failed else DONE
