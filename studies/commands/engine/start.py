"""Command `apesim engine start`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from apesim.studies.commands.options import Common, FigureFolder, Jobs, Overwrite, Report, Traces, as_options
from apesim.studies.terminal.console import DONE, INCOMPLETE

if TYPE_CHECKING:
    from rich.table import Table

    from apesim.studies.transient.start import StartRun
    from apesim.studies.transient.start_map import StartMap

SHOWN = (
    ("first motion", "first_motion", 1e3, "ms"),
    ("time", "time", 1.0, "s"),
    ("turns", "turns", 1.0, ""),
    ("engine air", "engine_air", 1e3, "g"),
    ("control air", "control_air", 1e3, "g"),
    ("lowest speed", "lowest_speed_rpm", 1.0, "r/min"),
    ("highest speed", "highest_speed_rpm", 1.0, "r/min"),
)
OVER_KEYS = (
    ("time [s]", "time_s", 1.0, ".4f"),
    ("turns", "turns", 1.0, ".3f"),
    ("engine air [g]", "engine_air_kg", 1e3, ".3f"),
    ("control air [g]", "control_air_kg", 1e3, ".3f"),
)
MAX_ROWS_SHOWN = 500
"""Rows that are shown of a table: nobody reads more."""


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
    varied: Annotated[
        list[str] | None,
        typer.Option(
            "--vary", metavar="KEY=RANGE", help="Over a key of the machine, e.g. engine.cylinders=1:6:1. Repeatable."
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="F.h5", help="Archive to write.")] = None,
    jobs: Jobs = None,
    overwrite: Overwrite = False,
    csv: Traces = None,
    figures: FigureFolder = None,
    report: Report = None,
) -> int:
    """Does the engine start from rest, how fast, with how much air; or from which angles of its crank."""
    import sys

    from apesim.archive import command_line, find_target
    from apesim.quantities import Fault, InputError
    from apesim.studies.execution.output import digest_line, write_traces, written_json
    from apesim.studies.report.writing import prepare_page
    from apesim.studies.sweep import vary
    from apesim.studies.terminal.console import COMMAND_LINE
    from apesim.studies.transient import start as starting
    from apesim.studies.transient.march_archive import trace_table

    console, machine = common.console, common.load_machine()
    write_page = prepare_page(report, overwrite=overwrite)
    if csv and (varied or angle == "all"):
        wrong = "has no traces to write with --vary, or of all angles"
        raise InputError([Fault(COMMAND_LINE, "--csv", wrong, "leave it out, or start one machine from one angle")])
    if csv:
        find_target(csv)

    # Machines that vary are read anew from file and settings, with each key given as one more setting.
    settings = common.settings or ()
    variation = vary(varied, common.machine_file, settings, has_intakes=False) if varied else None
    with as_options("start_engine", cranking_release="--cranking-release"), console.progress("start") as show_progress:
        start = starting.start_engine(
            machine,
            angle=angle,
            until=until,
            cranking_release=cranking_release,
            vary=variation,
            out=out,
            jobs=jobs,
            overwrite=overwrite,
            progress=show_progress,
            call=command_line(["apesim", *sys.argv[1:]]),
        )
    if csv:
        write_traces(csv, *trace_table(start))

    drawn = []
    if figures:
        from apesim.studies.transient.figures import draw_start

        drawn = start.draw(figures) if isinstance(start, starting.StartMap) else draw_start(start, figures)
    table = _map_table(start) if isinstance(start, starting.StartMap) else _table(start)
    data, lines = start.to_dict() | {"wall_time_s": start["wall_time"]} | write_page(out or start), []
    if out:
        written = written_json(out, drawn, start["wall_time"])
        data |= written
        lines.append(f"{out}\n{digest_line(written['content_sha256'])}")
    console.result(data, table, *lines)
    for warning in (*start.failed, *start.warnings):
        console.message(f"warning: {warning}")
    return INCOMPLETE if start.failed else DONE


def _table(start: "StartRun") -> "Table":
    """One start in numbers, or the angles of all."""
    from apesim.studies.terminal.tables import number, table_of

    if start.is_of_all_angles:
        rows = [(f"{low:.2f}", f"{high:.2f}", f"{high - low:.2f}") for low, high in start.intervals_deg]
        title = f"it starts from {start['starting_share']:.1%} of all angles"
        return table_of(title, ("from [deg]", "to [deg]", "width [deg]"), rows)
    rows = [(name, number(start[key] * factor), unit) for name, key, factor, unit in SHOWN]
    title = f"start from {start.conditions['angle']}: {'it starts' if start['starts'] else 'it does not start'}"
    return table_of(title, ("", "value", "unit"), rows)


def _map_table(starts: "StartMap") -> "Table":
    """A row for each machine that was started: how it did from one angle, or its intervals of angles."""
    from apesim.archive.grid import places_of
    from apesim.studies.sweep.table import head_and_cells
    from apesim.studies.terminal.tables import number, table_of

    data = starts.to_dict()
    points = data["points"][:MAX_ROWS_SHOWN]
    heads, cells = [], []
    for (name, texts), places in zip(data["axes"].items(), places_of(starts.archive), strict=True):
        head, shown = head_and_cells(name, texts)
        heads.append(head)
        cells.append([shown[place] for place in places[: len(points)]])
    title = "Starts from rest" if starts.is_of_all_angles else f"Starts from rest, from {starts.conditions['angle']}"
    if len(points) < len(data["points"]):
        title += f"; {len(points)} of {len(data['points'])} rows, all of which are in the archive"
    rows: list[tuple[str, ...]]
    if starts.is_of_all_angles:
        header, left = [*heads, "of all angles", "from-to [deg]"], len(heads) + 1
        told = [", ".join(f"{low:.2f}-{high:.2f}" for low, high in point["intervals_deg"]) for point in points]
        rows = [(f"{point['starting_share']:.1%}", text) for point, text in zip(points, told, strict=True)]
    else:
        header, left = [*heads, "starts", *(head for head, *_ in OVER_KEYS)], len(heads)
        rows = [
            (
                "yes" if point["starts"] else "no",
                *(number(point[key] * factor, form) for _, key, factor, form in OVER_KEYS),
            )
            for point in points
        ]
    varied = zip(*cells, strict=True)
    return table_of(title, header, [(*keys, *row) for keys, row in zip(varied, rows, strict=True)], left=(left,))
