"""Command `apesim valve limit`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.commands.options import (
    Common,
    Figures,
    Jobs,
    Out,
    Overwrite,
    Pressures,
    Report,
    Temperatures,
    as_options,
)
from apesim.studies.terminal.console import DONE, INCOMPLETE

HEADER = ("duty", "limit [Hz]", "[r/min]", "lap to lap [ms]", "window [deg]", "")


def find_valve_limits(
    common: Common,
    pressure: Pressures = "0.1:1.9:0.2 MPa gauge",
    temperature: Temperatures = "250 K, 287 K, 322 K",
    duty: Annotated[str, typer.Option(metavar="RANGE", help="Share of the period energised.")] = "0.3, 0.5",
    out: Out = Path("valve_limit.h5"),
    jobs: Jobs = None,
    overwrite: Overwrite = False,
    figures: Figures = True,
    report: Report = None,
) -> int:
    """The highest rate at which every stroke is complete, in periodic operation.

    For the machine's own control air and commands, whose duty is their share of a turn, and over a grid.

    Examples
    --------
    >>> from typer.testing import CliRunner
    >>> from apesim.studies.commands.cli import app
    >>> print(CliRunner().invoke(app, ["valve", "limit", "--duty", "1.5"]).exception)
    command line: --duty: '1.5' is out of range; allowed: 0.01 to 0.99
    """
    import sys

    from apesim.archive import command_line
    from apesim.archive.columns import values_of
    from apesim.studies.execution.output import written_json, written_text
    from apesim.studies.limit import valve_limit
    from apesim.studies.limit.points import lowest_run, own_run
    from apesim.studies.limit.summary import summary_lines
    from apesim.studies.report.writing import prepare_page
    from apesim.studies.terminal.tables import table_over_supplies

    console, machine = common.console, common.load_machine()
    write_page = prepare_page(report, overwrite=overwrite)

    # The map, in the archive. Faults in its arguments are named as options of the command line.
    with as_options("find_valve_limit"), console.progress("limit") as show_progress:
        result = valve_limit.find_valve_limit(
            machine,
            pressure=pressure,
            temperature=temperature,
            duty=duty,
            out=out,
            jobs=jobs,
            overwrite=overwrite,
            progress=show_progress,
            call=command_line(["apesim", *sys.argv[1:]]),
        )
    drawn = []
    if figures:
        from apesim.studies.limit.valve_figures import limit_figures  # half a second, for those who draw

        drawn = limit_figures(result.archive, machine.ambient.pressure, out.with_suffix(".figures"))
    written = written_json(out, drawn, result["wall_time"]) | write_page(out)
    v = values_of(result.archive)
    data = result.to_dict()
    points = data["points"]

    # The table marks the two points that the lines below it are about.
    own_point, lowest_point = own_run(v), lowest_run(v)
    marks = {lowest_point: "lowest"} | {own_point: "own" if own_point != lowest_point else "own, lowest"}
    rows = [(*_row(point), marks.get(run, "")) for run, point in enumerate(points)]
    table = table_over_supplies("Highest working rate", machine.ambient.pressure, columns=v, header=HEADER, rows=rows)

    # There is no lowest limit where a point of the grid has none.
    conditions = {
        name: _conditions(points[run], machine.ambient.pressure)
        for name, run in (("own", own_point), ("lowest", lowest_point))
        if run is not None
    }
    lines = summary_lines(data, result.criterion, conditions)
    console.result(data | written, table, *lines, written_text(written, f"{len(rows)} limits"))

    # A point without a limit leaves the others valid; the exit code says that the map has gaps.
    for fault in result.failed:
        console.message(f"warning: {fault}")
    return INCOMPLETE if result.failed else DONE


def _row(point: dict) -> tuple[str, ...]:
    """Cells of a limit behind its pressure and temperature."""
    from apesim.studies.terminal.tables import number

    return (
        f"{point['duty']:.3g}",
        number(point["limit_hz"], ".2f"),
        number(point["limit_rpm"], ".0f"),
        number(1e3 * point["lap_to_lap_s"], ".2f"),
        number(point["window_deg"], ".0f"),
    )


def _conditions(point: dict, ambient_pressure: float) -> str:
    """Conditions at which a limit holds, in words."""
    pressure = f"{(point['supply_pressure_Pa'] - ambient_pressure) / 1e6:.3g} MPa gauge"
    return f"{pressure}, {point['supply_temperature_K']:g} K and duty of {point['duty']:.3g}"
