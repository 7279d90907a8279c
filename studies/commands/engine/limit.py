"""Command `apesim engine limit`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import (
    Common,
    ControlPressures,
    Figures,
    Jobs,
    Out,
    Overwrite,
    Report,
    SupplyPressures,
    SupplyTemperatures,
    as_options,
)
from apesim.studies.run.default_grids import DURATIONS
from apesim.studies.terminal.console import DONE, INCOMPLETE

HEADER = (
    *("K", "window [deg]", "limit [r/min]", "[Hz]", "lap to lap [ms]", "then fails"),
    *("works again [r/min]", "30 Hz need [deg]", ""),
)


def find_engine_limit(
    common: Common,
    pressure: SupplyPressures = None,
    control_pressure: ControlPressures = None,
    temperature: SupplyTemperatures = None,
    duration: Annotated[
        str, typer.Option(metavar="R", help="From the target opening to the target closing.")
    ] = DURATIONS,
    out: Out = Path("engine_limit.h5"),
    jobs: Jobs = None,
    overwrite: Overwrite = False,
    figures: Figures = True,
    report: Report = None,
) -> int:
    """The highest speed at which the valve opens and closes at its targets, with complete strokes.

    For the machine's own supply and targets, and over a grid; with the time from lap to lap that decides it.
    """
    import sys

    from apesim.archive import command_line
    from apesim.archive.columns import values_of
    from apesim.studies.archives.pressure_axes import find_pressure_axis
    from apesim.studies.execution.output import written_json, written_text
    from apesim.studies.limit import engine_limit_map
    from apesim.studies.limit.points import lowest_run, own_run
    from apesim.studies.limit.summary import summary_lines
    from apesim.studies.report.writing import prepare_page
    from apesim.studies.terminal.tables import table_of

    console, machine = common.console, common.load_machine()
    write_page = prepare_page(report, overwrite=overwrite)

    # The map, in the archive. Faults in its arguments are named as options of the command line.
    with as_options("find_engine_limit"), console.progress("limit") as show_progress:
        result = engine_limit_map.find_engine_limit(
            machine,
            pressure=pressure,
            control_pressure=control_pressure,
            temperature=temperature,
            duration=duration,
            jobs=jobs,
            out=out,
            overwrite=overwrite,
            progress=show_progress,
            call=command_line(["apesim", *sys.argv[1:]]),
        )

    # Figures, and where all lies: the archive is written by now, and has its digest.
    drawn = result.draw(out.with_suffix(".figures")) if figures else []
    written = written_json(out, drawn, result["wall_time"]) | write_page(out)
    data, columns, ambient = result.to_dict(), values_of(result.archive), result.ambient_pressure

    # The table marks the two points that the lines below it are about.
    own_point, lowest_point, points = own_run(columns), lowest_run(columns), data["points"]
    marks = {lowest_point: "lowest"} | {own_point: "own" if own_point != lowest_point else "own, lowest"}
    axis = find_pressure_axis(result.archive)
    header = f"{axis.removesuffix('_pressure')} [MPa gauge]", *HEADER
    rows = [(*_row(point, ambient, axis), marks.get(run, "")) for run, point in enumerate(points)]

    # There is no lowest limit where a point of the grid has none.
    conditions = {
        name: _conditions(points[run], ambient, axis)
        for name, run in (("own", own_point), ("lowest", lowest_point))
        if run is not None
    }
    table = table_of("Highest speed at which the targets are met", header, rows, left=(6, 9))
    lines = summary_lines(data, data["criterion"], conditions)
    console.result(data | written, table, *lines, written_text(written, f"{len(rows)} limits"))

    # A point without a limit leaves the others valid; the exit code says that the map has gaps.
    for fault in result.failed:
        console.message(f"warning: {fault}")
    return INCOMPLETE if result.failed else DONE


def _row(point: dict, ambient_pressure: float, pressure_axis: str) -> tuple[str, ...]:
    """Cells of a limit."""
    from apesim.studies.terminal.tables import number

    return (
        f"{(point[pressure_axis] - ambient_pressure) / 1e6:.3g}",
        f"{point['supply_temperature']:g}",
        f"{point['duration_deg']:g}",
        number(point["limit_rpm"], ".0f"),
        number(point["limit_hz"], ".1f"),
        number(1e3 * point["lap_to_lap_s"], ".2f"),
        point["fails"].replace("_", " "),
        number(point["works_again_rpm"], ".0f"),
        number(point["rule_window_deg"], ".0f"),
    )


def _conditions(point: dict, ambient_pressure: float, pressure_axis: str) -> str:
    """Conditions at which a limit holds, in words."""
    pressure, temperature, duration, *_ = _row(point, ambient_pressure, pressure_axis)
    control = f"{(point['control_pressure'] - ambient_pressure) / 1e6:.3g}"
    air = "" if control == pressure else f" (control air {control} MPa gauge)"
    return f"{pressure} MPa gauge{air}, {temperature} K and window of {duration} deg"
