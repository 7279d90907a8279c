"""The commands of the valve alone."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.options import (
    Common,
    Figures,
    Jobs,
    Out,
    Overwrite,
    Pressures,
    Pulse,
    Temperatures,
    Traces,
    command,
)

valve = typer.Typer(no_args_is_help=True, help="The electro-pneumatic valve alone, on its test bench.")


@command(valve, "run")
def valve_run(
    common: Common,
    supply: Annotated[str | None, typer.Option(metavar="P", help='Control pressure, e.g. "0.49 MPa gauge".')] = None,
    temperature: Annotated[str | None, typer.Option(metavar="T", help='Of the supply, e.g. "287 K".')] = None,
    pulse: Pulse = "50 ms",
    until: Annotated[
        str | None, typer.Option(metavar="TIME", help="End of the run; twice the pulse if left out.")
    ] = None,
    repeat: Annotated[
        str | None, typer.Option(metavar="RATE", help='Repeat the pulse to the periodic state, e.g. "30 Hz".')
    ] = None,
    csv: Traces = None,
):
    """One bench run: delay time, full stroke time, seating speed, fluctuation, control air."""
    from apesim.studies.commands.valve import bench_run

    return bench_run(*common, supply, temperature, pulse, until, repeat, csv)


@command(valve, "map")
def valve_map(
    common: Common,
    pressure: Pressures = "0.1:1.9:0.2 MPa gauge",
    temperature: Temperatures = "250:322:8 K",
    pulse: Pulse = "50 ms",
    out: Out = Path("valve_map.h5"),
    overwrite: Overwrite = False,
    figures: Figures = True,
):
    """Delay time, stroke time, seating speed, fluctuation over pressure and temperature."""
    from apesim.studies.commands.valve_grid import map_command

    return map_command(*common, pressure, temperature, pulse, out, overwrite, figures)


@command(valve, "limit")
def valve_limit(
    common: Common,
    pressure: Pressures = "0.1:1.9:0.2 MPa gauge",
    temperature: Temperatures = "250 K, 287 K, 322 K",
    duty: Annotated[str, typer.Option(metavar="RANGE", help="Share of the period energised.")] = "0.3, 0.5",
    out: Out = Path("valve_limit.h5"),
    jobs: Jobs = None,
    overwrite: Overwrite = False,
    figures: Figures = True,
):
    """The highest rate at which every stroke is complete, in periodic operation.

    For the machine's own control air and commands, whose duty is their share of a turn, and over a grid.
    """
    from apesim.studies.commands.valve_grid import limit_command

    return limit_command(*common, pressure, temperature, duty, out, jobs, overwrite, figures)


@command(valve, "soft-landing")
def valve_soft_landing(
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
):
    """Pulse patterns that lower the seating speed: a braking re-switch in each stroke.

    A brake switches both solenoids at once or one of them alone, whichever lands the piston more softly. Edges are
    counted from the command edge of their stroke. Brakes are given for the spacing the solenoids can do, and
    for any spacing; the softest, and the sturdiest at 5 % more and less pressure and 10 K more and less. Exit code 3
    where no brake within the spacing lowers the seating speed at that cost.
    """
    from apesim.studies.commands.soft_landing import soft_landing_command

    return soft_landing_command(
        *common, pressure, temperature, cost, spacing, solenoids, pulse, out, overwrite, figures
    )


@command(valve, "discharge")
def valve_discharge(
    common: Common,
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Discharge tests: CSV of time and pressure.")],
    volume: Annotated[str, typer.Option(metavar="V", help='Of the vessel, e.g. "50 cm^3".')],
    temperature: Annotated[
        str | None, typer.Option(metavar="T", help="Of the air at the start; ambient if left out.")
    ] = None,
    out: Annotated[Path, typer.Option(metavar="F.csv", help="Curve to write.")] = Path("curve.csv"),
    overwrite: Overwrite = False,
    figures: Figures = True,
):
    """Effective area of a solenoid valve from discharge tests (Eq. 10), with its uncertainty."""
    from apesim.studies.commands.discharge import discharge_command

    return discharge_command(*common, files, volume, temperature, out, overwrite, figures)


@command(valve, "fit")
def valve_fit(
    common: Common,
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Measured data: a folder with a measured.toml.")],
    free: Annotated[
        list[str],
        typer.Option(metavar="KEY[=LOW:HIGH]", help="Key of the machine to identify, with bounds. Repeatable."),
    ],
    method: Annotated[
        str, typer.Option(metavar="NAME", help="least-squares, or ga: the paper's genetic algorithm.")
    ] = "least-squares",
):
    """Identify parameters from measured lift (Eq. 11), with their uncertainty.

    Runs of the role "fit" are fitted. Those of the role "gate" are not: one that contradicts the fitted model beyond
    noise refuses it (exit code 3; the parameters are told all the same). Those of the role "check" are only reported.
    """
    from apesim.studies.commands.fit import fit_command

    return fit_command(*common, folder, free, method)
