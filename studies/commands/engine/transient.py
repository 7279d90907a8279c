"""Command `apesim engine transient`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import Common, FigureFolder, Overwrite, Report, Traces, as_options
from apesim.studies.terminal.console import DONE, INCOMPLETE

SHOWN = (
    ("time", "duration", 1.0, "s"),
    ("turns", "turns", 1.0, ""),
    ("work of the gas", "gas_work", 1.0, "J"),
    ("brake work", "brake_work", 1.0, "J"),
    ("work of the load", "load_work", 1.0, "J"),
    ("engine air", "engine_air", 1e3, "g"),
    ("control air", "control_air", 1e3, "g"),
    ("brake work per gram of air", "specific_work_J_per_g", 1.0, "J/g"),
    ("lowest speed", "lowest_speed_rpm", 1.0, "r/min"),
    ("highest speed", "highest_speed_rpm", 1.0, "r/min"),
)
MOST_ROWS = 24
"""Revolutions in the table; of more, as many are shown, evenly spread."""
HEADER = "start [s]", "speed [r/min]", "gas [N m]", "brake [N m]", "air [g]", "opens [deg]", "closes [deg]"


def run_transient(
    common: Common,
    duration: Annotated[str | None, typer.Option(metavar="T", help='Time to march, e.g. "3 s".')] = None,
    angle: Annotated[str | None, typer.Option(metavar="A", help="Angle of the shaft at the start, at rest.")] = None,
    from_speed: Annotated[
        str | None, typer.Option("--from", metavar="N", help="Speed at whose periodic state the shaft is let free.")
    ] = None,
    speed: Annotated[
        str | None, typer.Option(metavar="COURSE", help='Imposed speed: "0 s: 300 rpm, 1.5 s: 1800 rpm".')
    ] = None,
    load: Annotated[
        str | None, typer.Option(metavar="COURSE", help='Constant part of the load from instants on: "5 s: 10 N m".')
    ] = None,
    supply: Annotated[
        str | None, typer.Option(metavar="COURSE", help='Supply from instants on: "2 s: 0.8 MPa gauge".')
    ] = None,
    timing: Annotated[
        str,
        typer.Option(metavar="T", help="fixed, feedback, or a CSV of commands over speed of engine timing."),
    ] = "fixed",
    min_pulse: Annotated[str | None, typer.Option(metavar="TIME", help="Shortest pulse that is commanded.")] = None,
    sample: Annotated[str | None, typer.Option(metavar="TIME", help="Time between two rows of the traces.")] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="F.h5", help="Archive to write; what is done of a long march survives a kill."),
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with a march that was interrupted.")] = False,
    overwrite: Overwrite = False,
    csv: Traces = None,
    figures: FigureFolder = None,
    report: Report = None,
) -> int:
    """The engine over time: a free shaft from rest or from a speed, or an imposed speed."""
    import sys

    from apesim.archive import command_line, find_target
    from apesim.results import NotConverged
    from apesim.studies.execution.output import digest_line, write_traces, written_json
    from apesim.studies.report.writing import prepare_page
    from apesim.studies.terminal.tables import number, table_of
    from apesim.studies.transient import transient
    from apesim.studies.transient.march_archive import trace_table

    console, machine = common.console, common.load_machine()
    write_page = prepare_page(report, overwrite=overwrite)
    if csv:
        find_target(csv)
    try:
        with as_options("run_transient", from_speed="--from"), console.progress("transient") as show_progress:
            run = transient.run_transient(
                machine,
                duration=duration,
                angle=angle,
                from_speed=from_speed,
                speed=speed,
                load=load,
                supply=supply,
                timing=timing,
                min_pulse=min_pulse,
                sample=sample,
                progress=show_progress,
                out=out,
                resume=resume,
                overwrite=overwrite,
                call=command_line(["apesim", *sys.argv[1:]]),
            )
    except NotConverged as error:
        run = error.result
    except KeyboardInterrupt:
        if out:
            console.message("interrupted; a checkpoint is kept where there is one: same command and --resume")
        raise
    if csv:
        write_traces(csv, *trace_table(run))
    drawn = []
    if figures:
        from apesim.studies.transient.figures import draw_transient

        drawn = draw_transient(run, figures)

    # Totals, then revolutions; with several cylinders the angles are those of the first.
    data, seconds = run.to_dict(), run["wall_time"]
    rows = [(name, number(run[key] * factor), unit) for name, key, factor, unit in SHOWN]
    lines = data["revolutions"][:: max(1, -(-len(data["revolutions"]) // MOST_ROWS))]
    turns = [
        (
            f"{row['start_s']:.3f}",
            f"{row['mean_speed_rpm']:.1f}",
            f"{row['gas_torque_Nm']:.2f}",
            f"{row['brake_torque_Nm']:.2f}",
            f"{row['engine_air_kg'] * 1e3:.3f}",
            number(row["cylinders"][0]["valve_open_deg"]),
            number(row["cylinders"][0]["valve_close_deg"]),
        )
        for row in lines
    ]
    closes = ", ".join(f"{name} {value:.1e}" for name, value in data["closure"].items())
    took = "finished already" if run.was_finished else f"{1e3 * seconds:.0f} ms"
    texts = [f"closure: {closes}; {run['steps']} steps, {took}"]
    written = {"wall_time_s": seconds}
    if out:
        written = written_json(out, drawn, seconds)
        texts.append(f"{out}\n{digest_line(written['content_sha256'])}")
    console.result(
        data | written | write_page(out or run),
        table_of("over the whole time", ("", "value", "unit"), rows),
        table_of(f"{len(lines)} of {len(data['revolutions'])} revolutions", HEADER, turns),
        *texts,
    )
    for warning in (*run.failed, *run.warnings):
        console.message(f"warning: {warning}")
    return INCOMPLETE if run.failed else DONE
