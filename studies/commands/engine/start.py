"""Command `apesim engine start`."""

from typing import Annotated

import typer

from apesim.studies.commands.options import Common, FigureFolder, Traces, as_options
from apesim.studies.terminal.console import DONE

SHOWN = (
    ("first motion", "first_motion", 1e3, "ms"),
    ("time", "time", 1.0, "s"),
    ("turns", "turns", 1.0, ""),
    ("engine air", "engine_air", 1e3, "g"),
    ("control air", "control_air", 1e3, "g"),
    ("lowest speed", "lowest_speed_rpm", 1.0, "r/min"),
    ("highest speed", "highest_speed_rpm", 1.0, "r/min"),
)


def start_engine(
    common: Common,
    angle: Annotated[
        str, typer.Option(metavar="A", help='Angle of the shaft at rest; "all": from which angles it starts.')
    ] = "30 deg",
    until: Annotated[
        str | None, typer.Option(metavar="N", help='Speed at which time and air are read, e.g. "900 rpm".')
    ] = None,
    cranking_release: Annotated[
        str | None, typer.Option(metavar="A", help="Release while cranking, until each cylinder passes its 180 deg.")
    ] = None,
    csv: Traces = None,
    figures: FigureFolder = None,
) -> int:
    """Does the engine start from rest, how fast, with how much air; or from which angles of its crank."""
    from apesim.archive import find_target
    from apesim.studies.execution.output import write_traces
    from apesim.studies.terminal.tables import number, table_of
    from apesim.studies.transient import start as starting
    from apesim.studies.transient.transient import trace_table

    console, machine = common.console, common.load_machine()
    if csv:
        find_target(csv)
    with as_options("start_engine", cranking_release="--cranking-release"):
        start = console.run(
            "start", starting.start_engine, machine, angle=angle, until=until, cranking_release=cranking_release
        )
    if csv and start.march:
        write_traces(csv, *trace_table(start.march.run))

    if figures:
        from apesim.studies.transient.figures import draw_start

        draw_start(start, figures)

    # One start in numbers, or the angles of all.
    if start.march:
        rows = [(name, number(start[key] * factor), unit) for name, key, factor, unit in SHOWN]
        title = f"start from {start.conditions['angle']}: {'it starts' if start['starts'] else 'it does not start'}"
        lines = [table_of(title, ("", "value", "unit"), rows)]
    else:
        rows = [(f"{low:.2f}", f"{high:.2f}", f"{high - low:.2f}") for low, high in start.intervals_deg]
        title = f"it starts from {start['starting_share']:.1%} of all angles"
        lines = [table_of(title, ("from [deg]", "to [deg]", "width [deg]"), rows)]
    console.result(start.to_dict(), *lines)
    for warning in start.warnings:
        console.message(f"warning: {warning}")
    return DONE
