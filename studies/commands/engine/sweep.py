"""Command `apesim engine sweep`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import Common, Figures, Jobs, Out, Overwrite, Report, Speeds, as_options
from apesim.studies.terminal.console import DONE, INCOMPLETE


def sweep_engine(
    common: Common,
    speed: Speeds = "300:2400:100 rpm",
    varied: Annotated[
        list[str] | None,
        typer.Option(
            "--vary",
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
    traces: Annotated[bool, typer.Option(help="Keep the traces over crank angle, some 63 kB for each run.")] = True,
    out: Out = Path("sweep.h5"),
    jobs: Jobs = None,
    dask: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Compute on a cluster: its scheduler, e.g. tcp://HOST:8786.")
    ] = None,
    shard: Annotated[str | None, typer.Option(metavar="i/N", help="Only every N-th point from the i-th.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with an interrupted sweep.")] = False,
    overwrite: Overwrite = False,
    figures: Figures = True,
    report: Report = None,
) -> int:
    """The main job: speeds, intakes, timings and any keys into an archive, figures and a table.

    Examples
    --------
    >>> from typer.testing import CliRunner
    >>> from apesim.studies.commands.cli import app
    >>> print(CliRunner().invoke(app, ["engine", "sweep", "--shard", "5/4"]).exception)
    command line: --shard: '5/4' is no share of the work; write e.g. 1/4
    """
    import sys

    from apesim.archive import command_line
    from apesim.studies.execution.output import written_json, written_text
    from apesim.studies.report.writing import prepare_page
    from apesim.studies.sweep import study, vary
    from apesim.studies.sweep.table import sweep_table
    from apesim.terminal import visible

    console, machine = common.console, common.load_machine()
    write_page = prepare_page(report, overwrite=overwrite)

    # Machines that vary are read anew from file and settings, with each key given as one more setting.
    variation = vary(varied, common.machine_file, common.settings or ()) if varied else None

    # An interrupt keeps the shards that are written; the way to go on has to be told here, where it is heard.
    try:
        with as_options("sweep"), console.progress("sweep") as show_progress:
            result = study.sweep(
                machine,
                speed,
                intake=intake,
                timing=timing,
                vary=variation,
                traces=traces,
                out=out,
                jobs=jobs,
                dask=dask,
                shard=shard,
                resume=resume,
                overwrite=overwrite,
                progress=show_progress,
                call=command_line(["apesim", *sys.argv[1:]]),
            )
    except KeyboardInterrupt:
        console.message("interrupted; what is done is kept, go on with the same command and --resume")
        raise
    drawn = []
    if figures:
        from apesim.studies.sweep.figures import sweep_figures  # half a second, for those who draw

        drawn = sweep_figures(result.archive, out.with_suffix(".figures"))

    # The data for scripts: where the archive lies, and what is in it; the time last.
    data = written_json(out, drawn, result["wall_time"]) | write_page(out)
    wall_time = data.pop("wall_time_s")
    data |= result.to_dict() | {"wall_time_s": wall_time}

    # A sweep that is resumed by the name of its archive alone may be another than the user thinks: the call that made
    # it is told.
    runs = f"{data['runs']} runs"
    count = f"finished already, its {runs} checked" if result.was_finished else runs
    if result.made_by:
        count = f"{count}, made by `{visible(result.made_by)}`,"
    console.result(data, sweep_table(result.archive), written_text(data, count))

    # Faults of an archive that was finished before are told again, but to resume it has done all that was asked.
    for line in (*result.failed, *result.warnings):
        console.message(f"warning: {line}")
    return INCOMPLETE if result.failed and not result.was_finished else DONE
