"""The command line of apesim."""

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from studies.console import INTERRUPTED, main_of
from studies.options import (
    ArchivePath,
    Common,
    Figures,
    Jobs,
    Out,
    Overwrite,
    Pressures,
    Pulse,
    Speeds,
    SupplyPressures,
    SupplyTemperatures,
    Temperatures,
    Traces,
    command,
)

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    help="Simulate air-powered engines whose intake is opened by an electro-pneumatic valve.",
)
valve = typer.Typer(no_args_is_help=True, help="The electro-pneumatic valve alone, on its test bench.")
engine = typer.Typer(no_args_is_help=True, help="The engine that breathes through it.")
archive = typer.Typer(
    no_args_is_help=True,
    help="Archives of results. With --machine or --set, commands also say whether they were made with it.",
)
app.add_typer(valve, name="valve")
app.add_typer(engine, name="engine")
app.add_typer(archive, name="archive")

# What a command does is imported where it is called: --help answers at once.


def show_version(asked: bool):
    """Print the version and end, where it was asked for."""
    if asked:
        from importlib.metadata import version

        print(f"apesim {version('apesim')}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=show_version, is_eager=True, help="Print the version.")
    ] = False,
):
    """Options of apesim itself."""


@command(app)
def machine(
    common: Common,
    check: Annotated[Path | None, typer.Option("--check", metavar="FILE", help="Check a machine file.")] = None,
):
    """Print the machine, every key commented; or check a machine file."""
    from studies.commands.machine import machine_command

    return machine_command(*common, check)


@command(app)
def paper(
    common: Common,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder to make.")],
    overwrite: Overwrite = False,
):
    """Repeat the paper, doi 10.1631/jzus.A0820373: its figures and a table of its claims."""
    from studies.commands.paper import paper_command

    return paper_command(*common, out, overwrite)


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
    from studies.commands.valve import bench_run

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
    from studies.commands.valve_grid import map_command

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
    """The highest rate at which every stroke is complete, in periodic operation."""
    from studies.commands.valve_grid import limit_command

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
    pulse: Annotated[str, typer.Option(metavar="TIME", help="From each command edge to the next.")] = "50 ms",
    out: Out = Path("soft_landing.h5"),
    overwrite: Overwrite = False,
    figures: Figures = True,
):
    """Pulse patterns that lower the seating speed: a braking re-switch in each stroke.

    Edges are counted from the command edge of their stroke. Brakes are given for the spacing the solenoids can do, and
    for any spacing; the softest, and the sturdiest at 5 % more and less pressure and 10 K more and less. Exit code 3
    where no brake within the spacing lowers the seating speed at that cost.
    """
    from studies.commands.soft_landing import soft_landing_command

    return soft_landing_command(*common, pressure, temperature, cost, spacing, pulse, out, overwrite, figures)


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
    from studies.commands.discharge import discharge_command

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
    from studies.commands.fit import fit_command

    return fit_command(*common, folder, free, method)


@command(engine, "run")
def engine_run(
    common: Common, speed: Annotated[str, typer.Option(metavar="N", help='E.g. "1000 rpm".')], csv: Traces = None
):
    """One operating point at its periodic steady state."""
    from studies.commands.engine import engine_point

    return engine_point(*common, speed, csv)


@command(engine, "sweep")
def engine_sweep(
    common: Common,
    speed: Speeds = "300:2400:100 rpm",
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=RANGE",
            help='Also over a key of the machine, e.g. supply.pressure="0.6:1.4:0.2 MPa gauge". Repeatable.',
        ),
    ] = None,
    timing: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="Command angles of the epv: fixed (the machine's), corrected (so that it meets its targets), or both.",
        ),
    ] = "both",
    intake: Annotated[str, typer.Option(metavar="LIST", help="Of epv, cam, ideal.")] = "epv,cam,ideal",
    out: Out = Path("sweep.h5"),
    jobs: Jobs = None,
    dask: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Compute on a cluster: its scheduler, e.g. tcp://HOST:8786.")
    ] = None,
    shard: Annotated[str | None, typer.Option(metavar="i/N", help="Only every N-th point from the i-th.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with an interrupted sweep.")] = False,
    overwrite: Overwrite = False,
    figures: Figures = True,
):
    """The main job: speeds, intakes, timings and any keys into an archive, figures and a table."""
    from studies.commands.sweep import sweep_command

    return sweep_command(*common, speed, vary, timing, intake, out, jobs, dask, shard, resume, overwrite, figures)


@command(engine, "timing")
def engine_timing(
    common: Common,
    target: Annotated[
        str | None,
        typer.Option(metavar="ANGLES", help='Opening and closing, e.g. "-5 deg, 70 deg"; the machine\'s if left out.'),
    ] = None,
    speed: Speeds = "300:2400:300 rpm",
    pressure: SupplyPressures = "0.6:1.4:0.4 MPa gauge",
    temperature: SupplyTemperatures = "250 K, 287 K, 322 K",
    out: Annotated[
        Path, typer.Option(metavar="F.h5", help="Archive to write; CSV, JSON and C header stand beside it.")
    ] = Path("timing.h5"),
    jobs: Jobs = None,
    overwrite: Overwrite = False,
    figures: Figures = True,
):
    """Command angles that make the valve really open and close at its targets."""
    from studies.commands.timing import timing_command

    return timing_command(*common, target, speed, pressure, temperature, out, jobs, overwrite, figures)


@command(engine, "limit")
def engine_limit(
    common: Common,
    pressure: SupplyPressures = "0.6:1.4:0.4 MPa gauge",
    temperature: SupplyTemperatures = "250 K, 287 K, 322 K",
    duration: Annotated[
        str, typer.Option(metavar="R", help="From the target opening to the target closing.")
    ] = "60 deg, 75 deg, 120 deg",
    out: Out = Path("engine_limit.h5"),
    jobs: Jobs = None,
    overwrite: Overwrite = False,
    figures: Figures = True,
):
    """The highest speed at which the valve opens and closes at its targets, with complete strokes."""
    from studies.commands.engine_limit import engine_limit_command

    return engine_limit_command(*common, pressure, temperature, duration, out, jobs, overwrite, figures)


@command(engine, "assess")
def engine_assess(
    common: Common,
    speed: Speeds = "300:2400:100 rpm",
    timing: Annotated[
        str,
        typer.Option(metavar="NAME", help="fixed: the machine's commands; corrected: those that meet its targets."),
    ] = "fixed",
    out: Out = Path("assessment.h5"),
    overwrite: Overwrite = False,
    figures: Figures = True,
):
    """What the valve's delay, finite speed, fluctuation and control air cost in torque and air."""
    from studies.commands.assessment import assess_command

    return assess_command(*common, speed, timing, out, overwrite, figures)


@command(engine, "optimise")
def engine_optimise(
    common: Common,
    goal: Annotated[
        str, typer.Option("--for", metavar="GOAL", help="torque: the most; air: the least specific air; or both.")
    ] = "both",
    speed: Speeds = "600:1800:300 rpm",
    free: Annotated[
        str | None,
        typer.Option(metavar="KEY=LOW:HIGH", help='Also "supply.pressure=0.5 MPa gauge:1.5 MPa gauge".'),
    ] = None,
    out: Out = Path("optimise.h5"),
    jobs: Jobs = None,
    overwrite: Overwrite = False,
    figures: Figures = True,
):
    """Command angles for most torque, least specific air, or the best of both.

    In the coupled periodic state. For both, the Pareto front stands beside the two optima: commands than which no
    others give more torque with no more air. Exit code 3 where no commands give brake work.
    """
    from studies.commands.optimise import optimise_command

    return optimise_command(*common, goal, speed, free, out, jobs, overwrite, figures)


@command(archive)
def info(common: Common, path: ArchivePath):
    """What an archive holds and where it comes from."""
    from studies.commands.archive import show_info

    return show_info(*common, path)


@command(archive)
def verify(common: Common, path: ArchivePath):
    """Check every checksum, unit and axis; exit code 3 if anything is wrong."""
    from studies.commands.archive import show_faults

    return show_faults(*common, path)


@command(archive)
def diff(
    common: Common,
    path: ArchivePath,
    other: Annotated[Path, typer.Argument(metavar="G.h5", help="Archive to compare with.")],
    rtol: Annotated[float, typer.Option(min=0.0, help="Relative difference that counts as none.")] = 0.0,
    atol: Annotated[float, typer.Option(min=0.0, help="Absolute difference that counts as none, in SI.")] = 0.0,
):
    """Compare two archives; exit code 3 if they differ."""
    from studies.commands.archive import show_differences

    return show_differences(*common, path, other, rtol, atol)


@command(archive)
def export(
    common: Common, path: ArchivePath, out: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder to make.")]
):
    """Write an archive as CSV, TOML and JSON files."""
    from studies.commands.archive import export_archive

    return export_archive(*common, path, out)


@command(archive)
def merge(
    common: Common,
    paths: Annotated[list[Path], typer.Argument(metavar="F.h5...", help="Archives of the parts of one sweep.")],
    out: Annotated[Path, typer.Option(metavar="F.h5", help="Archive to write.")],
    overwrite: Overwrite = False,
):
    """Join the archives of `--shard` jobs."""
    from studies.commands.archive import merge_archives

    return merge_archives(*common, paths, out, overwrite)


def main():
    """Entry point of the command `apesim`."""
    # Matrices are small here: several threads only wait for one another.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    code = main_of(app)
    if code == INTERRUPTED:
        os._exit(code)  # what is at work in another thread need not come to its end
    sys.exit(code)
