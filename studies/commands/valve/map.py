"""Command `apesim valve map`."""

from pathlib import Path

from apesim.studies.commands.options import (
    Common,
    Figures,
    Out,
    Overwrite,
    Pressures,
    Pulse,
    Report,
    Temperatures,
    as_options,
)
from apesim.studies.terminal.console import DONE, INCOMPLETE

TIMES = ("opening_delay_s", "opening_stroke_time_s", "closing_delay_s", "closing_stroke_time_s")
SPEEDS = ("opening_seating_speed_m_s", "closing_seating_speed_m_s")
HEADER = (
    *("open t_d\n[ms]", "open t_f\n[ms]", "close t_d\n[ms]", "close t_f\n[ms]"),
    *("open v_e\n[m/s]", "close v_e\n[m/s]"),
)


def map_valve_strokes(
    common: Common,
    pressure: Pressures = "0.1:1.9:0.2 MPa gauge",
    temperature: Temperatures = "250:322:8 K",
    pulse: Pulse = "50 ms",
    out: Out = Path("valve_map.h5"),
    overwrite: Overwrite = False,
    figures: Figures = True,
    report: Report = None,
) -> int:
    """Delay time, stroke time, seating speed, fluctuation over pressure and temperature.

    Examples
    --------
    >>> from typer.testing import CliRunner
    >>> from apesim.studies.commands.cli import app
    >>> print(CliRunner().invoke(app, ["valve", "map", "--pressure", "0.4 MPa"]).exception)
    command line: --pressure: '0.4 MPa' says neither gauge nor abs; write "0.4 MPa gauge" or "0.4 MPa abs"
    """
    import sys

    from apesim.archive import command_line
    from apesim.archive.columns import values_of
    from apesim.studies.execution.output import written_json, written_text
    from apesim.studies.limit import valve_map
    from apesim.studies.report.writing import prepare_page
    from apesim.studies.terminal.tables import number, table_over_supplies

    console, machine = common.console, common.load_machine()
    write_page = prepare_page(report, overwrite=overwrite)

    # The map, in the archive. Faults in its arguments are named as options of the command line.
    with as_options("map_valve"), console.progress("map") as show_progress:
        result = valve_map.map_valve(
            machine,
            pressure=pressure,
            temperature=temperature,
            pulse=pulse,
            out=out,
            overwrite=overwrite,
            progress=show_progress,
            call=command_line(["apesim", *sys.argv[1:]]),
        )
    drawn = []
    if figures:
        from apesim.studies.limit.valve_figures import map_figures  # half a second, for those who draw

        drawn = map_figures(result.archive, machine.ambient.pressure, out.with_suffix(".figures"))
    written = written_json(out, drawn, result["wall_time"]) | write_page(out)

    # The table has times in milliseconds, as the header says; the archive has them in SI units.
    v = values_of(result.archive)
    values = [1e3 * v[name] for name in TIMES] + [v[name] for name in SPEEDS]
    rows = [[number(value, ".4f") for value in row] for row in zip(*values, strict=True)]
    title = "The valve over pressure and temperature"
    table = table_over_supplies(title, machine.ambient.pressure, columns=v, header=HEADER, rows=rows)
    console.result(result.to_dict() | written, table, written_text(written, f"{len(rows)} runs"))

    # A stroke that is not completed leaves the others valid; the exit code says that the map has gaps.
    for fault in result.failed:
        console.message(f"warning: {fault}")
    return INCOMPLETE if result.failed else DONE
