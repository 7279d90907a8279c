"""The commands of the engine."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.options import (
    Common,
    Figures,
    Jobs,
    Out,
    Overwrite,
    Speeds,
    SupplyPressures,
    SupplyTemperatures,
    Traces,
    command,
)

engine = typer.Typer(no_args_is_help=True, help="The engine that breathes through it.")


@command(engine, "run")
def engine_run(
    common: Common, speed: Annotated[str, typer.Option(metavar="N", help='E.g. "1000 rpm".')], csv: Traces = None
):
    """One operating point at its periodic steady state."""
    from apesim.studies.commands.engine import engine_point

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
    from apesim.studies.commands.sweep import sweep_command

    return sweep_command(*common, speed, vary, timing, intake, out, jobs, dask, shard, resume, overwrite, figures)


@command(engine, "timing")
def engine_timing(
    common: Common,
    target: Annotated[
        str | None,
        typer.Option(metavar="ANGLES", help='Opening and closing, e.g. "-5 deg, 70 deg"; the machine\'s if left out.'),
    ] = None,
    speed: Speeds = "300:2400:150 rpm",
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
    from apesim.studies.commands.timing import timing_command

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
    """The highest speed at which the valve opens and closes at its targets, with complete strokes.

    For the machine's own supply and targets, and over a grid; with the time from lap to lap that decides it.
    """
    from apesim.studies.commands.engine_limit import engine_limit_command

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
    """What the valve's lateness, finite speed, fluctuation and control air cost in torque and air.

    What lateness and finite speed cost depends on which of them comes first: both orders, and their mean.
    """
    from apesim.studies.commands.assessment import assess_command

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
    from apesim.studies.commands.optimise import optimise_command

    return optimise_command(*common, goal, speed, free, out, jobs, overwrite, figures)
