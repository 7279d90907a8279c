"""Command `apesim valve soft-landing`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.options import Common, Figures, Out, Overwrite, Pressures

ANY = "any"


def find_soft_landings(
    common: Common,
    pressure: Pressures = "0.4:1.6:0.6 MPa gauge",
    temperature: Annotated[str, typer.Option(metavar="T", help="Of the control air.")] = "287 K",
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
    overwrite: Overwrite = False,
    figures: Figures = True,
) -> int:
    """Pulse patterns that lower the seating speed: a braking re-switch in each stroke.

    A brake switches both solenoids at once or one of them alone, whichever lands the piston more softly. Edges are
    counted from the command edge of their stroke. Brakes are given for the spacing the solenoids can do, and
    for any spacing; the softest, and the sturdiest at 5 % more and less pressure and 10 K more and less. Exit code 3
    where no brake within the spacing lowers the seating speed at that cost.
    """
    from apesim.quantities import Choice, parse, parse_range
    from apesim.studies.figures.soft_landing import soft_landing_figures
    from apesim.studies.operating_conditions import PRESSURE, SHORT_TIME, TEMPERATURE, TIME
    from apesim.studies.output import compute_archive, written_text
    from apesim.studies.soft_landing.landing import SOLENOIDS
    from apesim.studies.soft_landing.results import archive_of
    from apesim.studies.soft_landing.strokes import SPACING, faults_of, soft_landings
    from apesim.studies.soft_landing.summary import landing_tables, stroke_json
    from apesim.valve.bench import run_bench

    machine = common.load_machine()
    pressures = parse_range(pressure, PRESSURE, machine.ambient.pressure, where="--pressure", file=COMMAND_LINE)
    temperature = parse(temperature, TEMPERATURE, where="--temperature", file=COMMAND_LINE)
    max_added = parse(cost, SHORT_TIME, where="--cost", file=COMMAND_LINE)
    apart = parse(spacing, SHORT_TIME, where="--spacing", file=COMMAND_LINE) if spacing else SPACING
    choice = Choice((*SOLENOIDS, ANY), "command line")
    solenoids = choice.options[parse(solenoids, choice, where="--solenoids", file=COMMAND_LINE)]
    pulse = parse(pulse, TIME, where="--pulse", file=COMMAND_LINE)
    ways = SOLENOIDS if solenoids == ANY else (solenoids,)
    results = []

    def compute(command, report):
        results.extend(soft_landings(machine, pressures, temperature, pulse, apart, max_added, report, ways))
        return archive_of(machine, results, apart, max_added, command, ways)

    def draw(archive, folder):
        return soft_landing_figures(archive, machine.ambient.pressure, folder) if figures else []

    _, written = compute_archive(
        common.console,
        task="soft landing",
        first_march=(run_bench, machine, pulse),
        compute=compute,
        out=out,
        overwrite=overwrite,
        draw=draw,
    )
    faults = faults_of(results, apart, max_added, ways)
    data = {
        "spacing_ms": 1e3 * apart,
        "cost_ms": 1e3 * max_added,
        "solenoids": solenoids,
        "reachable": not faults,
        "points": [stroke_json(result, apart, max_added) for result in results],
        "faults": faults,
    }
    tables = landing_tables(results, apart, max_added)
    common.console.result(data | written, *tables, written_text(written, f"{len(results)} strokes"))
    for fault in faults:
        common.console.message(f"warning: {fault}")
    return INCOMPLETE if faults else DONE
