"""The command line of apesim."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from studies.console import Console, main_of

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    help="Simulate air-powered engines whose intake is opened by an electro-pneumatic valve.",
)
valve_app = typer.Typer(no_args_is_help=True, help="The electro-pneumatic valve alone, on its test bench.")
engine_app = typer.Typer(no_args_is_help=True, help="The engine that breathes through it.")
archive_app = typer.Typer(no_args_is_help=True, help="Archives of results.")
app.add_typer(valve_app, name="valve")
app.add_typer(engine_app, name="engine")
app.add_typer(archive_app, name="archive")

MachineFile = Annotated[
    Path | None, typer.Option("--machine", metavar="FILE", help="Machine file (TOML); the embedded one if left out.")
]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help='A key of the machine, e.g. engine.bore="90 mm". Repeatable.'),
]
Json = Annotated[bool, typer.Option("--json", help="One JSON object on standard output, nothing else.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="No progress and no messages on standard error.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace an archive that is there.")]
Figures = Annotated[bool, typer.Option(help="Draw the figures, into F.figures.")]
ArchivePath = Annotated[Path, typer.Argument(metavar="F.h5", help="Archive.")]


@app.command()
def machine(
    check: Annotated[Path | None, typer.Option("--check", metavar="FILE", help="Check a machine file.")] = None,
    machine_file: MachineFile = None,
    settings: Settings = None,
    json: Json = False,
    quiet: Quiet = False,
):
    """Print the machine, every key commented; or check a machine file."""
    from studies.commands.machine import check_machine, print_machine

    console = Console(json, quiet)
    if check:
        check_machine(console, check, settings)
    else:
        print_machine(console, machine_file, settings)


@app.command()
def paper(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder to make.")],
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Write into a folder that is not empty.")] = False,
    machine_file: MachineFile = None,
    settings: Settings = None,
    json: Json = False,
    quiet: Quiet = False,
):
    """Repeat the paper, doi 10.1631/jzus.A0820373: its figures and a table of its claims."""
    from studies.commands.paper import paper_command

    raise typer.Exit(paper_command(Console(json, quiet), machine_file, settings, out, overwrite))


@valve_app.command("run")
def valve_run(
    supply: Annotated[str | None, typer.Option(metavar="P", help='Control pressure, e.g. "0.49 MPa gauge".')] = None,
    temperature: Annotated[str | None, typer.Option(metavar="T", help='Of the supply, e.g. "287 K".')] = None,
    pulse: Annotated[str, typer.Option(metavar="TIME", help="For which the solenoids are energised.")] = "50 ms",
    until: Annotated[
        str | None, typer.Option(metavar="TIME", help="End of the run; twice the pulse if left out.")
    ] = None,
    repeat: Annotated[
        str | None, typer.Option(metavar="RATE", help='Repeat the pulse to the periodic state, e.g. "30 Hz".')
    ] = None,
    csv: Annotated[Path | None, typer.Option(metavar="F", help="Write the traces as CSV.")] = None,
    machine_file: MachineFile = None,
    settings: Settings = None,
    json: Json = False,
    quiet: Quiet = False,
):
    """One bench run: delay time, full stroke time, seating speed, fluctuation, control air."""
    from studies.commands.valve import bench_run

    raise typer.Exit(
        bench_run(Console(json, quiet), machine_file, settings, supply, temperature, pulse, until, repeat, csv)
    )


@valve_app.command("map")
def valve_map(
    pressure: Annotated[
        str, typer.Option(metavar="RANGE", help="Control pressures, start:stop:step or list.")
    ] = "0.1:1.9:0.2 MPa gauge",
    temperature: Annotated[str, typer.Option(metavar="RANGE", help="Of the control air.")] = "250:322:8 K",
    pulse: Annotated[str, typer.Option(metavar="TIME", help="For which the solenoids are energised.")] = "50 ms",
    out: Annotated[Path, typer.Option(metavar="F.h5", help="Archive to write.")] = Path("valve_map.h5"),
    overwrite: Overwrite = False,
    figures: Figures = True,
    machine_file: MachineFile = None,
    settings: Settings = None,
    json: Json = False,
    quiet: Quiet = False,
):
    """Delay time, stroke time, seating speed, fluctuation over pressure and temperature."""
    from studies.commands.valve import map_command

    console = Console(json, quiet)
    raise typer.Exit(
        map_command(console, machine_file, settings, pressure, temperature, pulse, out, overwrite, figures)
    )


@valve_app.command("limit")
def valve_limit(
    pressure: Annotated[
        str, typer.Option(metavar="RANGE", help="Control pressures, start:stop:step or list.")
    ] = "0.1:1.9:0.2 MPa gauge",
    temperature: Annotated[str, typer.Option(metavar="RANGE", help="Of the control air.")] = "250 K, 287 K, 322 K",
    duty: Annotated[str, typer.Option(metavar="RANGE", help="Share of the period energised.")] = "0.3, 0.5",
    out: Annotated[Path, typer.Option(metavar="F.h5", help="Archive to write.")] = Path("valve_limit.h5"),
    overwrite: Overwrite = False,
    figures: Figures = True,
    machine_file: MachineFile = None,
    settings: Settings = None,
    json: Json = False,
    quiet: Quiet = False,
):
    """The highest rate at which every stroke is complete, in periodic operation."""
    from studies.commands.valve import limit_command

    console = Console(json, quiet)
    raise typer.Exit(
        limit_command(console, machine_file, settings, pressure, temperature, duty, out, overwrite, figures)
    )


@valve_app.command("discharge")
def valve_discharge(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Discharge tests: CSV of time and pressure.")],
    volume: Annotated[str, typer.Option(metavar="V", help='Of the vessel, e.g. "50 cm^3".')],
    temperature: Annotated[
        str | None, typer.Option(metavar="T", help="Of the air at the start; ambient if left out.")
    ] = None,
    out: Annotated[Path, typer.Option(metavar="F.csv", help="Curve to write.")] = Path("curve.csv"),
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace a curve that is there.")] = False,
    machine_file: MachineFile = None,
    settings: Settings = None,
    json: Json = False,
    quiet: Quiet = False,
):
    """Effective area of a solenoid valve from discharge tests (Eq. 10), with its uncertainty."""
    from studies.commands.discharge import discharge_command

    console = Console(json, quiet)
    raise typer.Exit(
        discharge_command(console, machine_file, settings, files, volume, temperature, out, overwrite) or 0
    )


@valve_app.command("fit")
def valve_fit(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Measured data: a folder with a measured.toml.")],
    free: Annotated[
        list[str],
        typer.Option(metavar="KEY[=LOW:HIGH]", help="Key of the machine to identify, with bounds. Repeatable."),
    ],
    method: Annotated[
        str, typer.Option(metavar="NAME", help="least-squares, or ga: the paper's genetic algorithm.")
    ] = "least-squares",
    machine_file: MachineFile = None,
    settings: Settings = None,
    json: Json = False,
    quiet: Quiet = False,
):
    """Identify parameters from measured lift (Eq. 11), with their uncertainty."""
    from studies.commands.fit import fit_command

    raise typer.Exit(fit_command(Console(json, quiet), machine_file, settings, folder, free, method))


@engine_app.command("run")
def engine_run(
    speed: Annotated[str, typer.Option(metavar="N", help='E.g. "1000 rpm".')],
    csv: Annotated[Path | None, typer.Option(metavar="F", help="Write the crank-angle traces as CSV.")] = None,
    machine_file: MachineFile = None,
    settings: Settings = None,
    json: Json = False,
    quiet: Quiet = False,
):
    """One operating point at its periodic steady state."""
    from studies.commands.engine import engine_point

    raise typer.Exit(engine_point(Console(json, quiet), machine_file, settings, speed, csv))


@engine_app.command("sweep")
def engine_sweep(
    speed: Annotated[str, typer.Option(metavar="R", help="Range start:stop:step, or list.")] = "300:2400:100 rpm",
    intake: Annotated[str, typer.Option(metavar="LIST", help="Of epv, cam, ideal.")] = "epv,cam,ideal",
    out: Annotated[Path, typer.Option(metavar="F.h5", help="Archive to write.")] = Path("sweep.h5"),
    jobs: Annotated[int | None, typer.Option(metavar="N", min=1, help="Processes.")] = None,
    shard: Annotated[str | None, typer.Option(metavar="i/N", help="Only every N-th point from the i-th.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with an interrupted sweep.")] = False,
    overwrite: Overwrite = False,
    figures: Figures = True,
    machine_file: MachineFile = None,
    settings: Settings = None,
    json: Json = False,
    quiet: Quiet = False,
):
    """The main job: speeds and intakes into an archive, figures and a table."""
    from studies.commands.engine import sweep_command

    console = Console(json, quiet)
    raise typer.Exit(
        sweep_command(console, machine_file, settings, speed, intake, out, jobs, shard, resume, overwrite, figures)
    )


@archive_app.command()
def info(path: ArchivePath, json: Json = False, quiet: Quiet = False):
    """What an archive holds and where it comes from."""
    from studies.commands.archive import show_info

    show_info(Console(json, quiet), path)


@archive_app.command()
def verify(path: ArchivePath, json: Json = False, quiet: Quiet = False):
    """Check every checksum, unit and axis; exit code 3 if anything is wrong."""
    from studies.commands.archive import show_faults

    raise typer.Exit(show_faults(Console(json, quiet), path))


@archive_app.command()
def diff(
    path: ArchivePath,
    other: Annotated[Path, typer.Argument(metavar="G.h5", help="Archive to compare with.")],
    rtol: Annotated[float, typer.Option(min=0.0, help="Relative difference that counts as none.")] = 0.0,
    atol: Annotated[float, typer.Option(min=0.0, help="Absolute difference that counts as none, in SI.")] = 0.0,
    json: Json = False,
    quiet: Quiet = False,
):
    """Compare two archives; exit code 3 if they differ."""
    from studies.commands.archive import show_differences

    raise typer.Exit(show_differences(Console(json, quiet), path, other, rtol, atol))


@archive_app.command()
def export(
    path: ArchivePath,
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder to make.")],
    json: Json = False,
    quiet: Quiet = False,
):
    """Write an archive as CSV, TOML and JSON files."""
    from studies.commands.archive import export_archive

    export_archive(Console(json, quiet), path, out)


@archive_app.command()
def merge(
    paths: Annotated[list[Path], typer.Argument(metavar="F.h5...", help="Archives of the parts of one sweep.")],
    out: Annotated[Path, typer.Option(metavar="F.h5", help="Archive to write.")],
    overwrite: Overwrite = False,
    json: Json = False,
    quiet: Quiet = False,
):
    """Join the archives of `--shard` jobs."""
    from studies.commands.archive import merge_archives

    raise typer.Exit(merge_archives(Console(json, quiet), paths, out, overwrite))


def main():
    """Entry point of the command `apesim`."""
    sys.exit(main_of(app))
