"""Command `apesim engine limit`."""

from pathlib import Path
from typing import Annotated

import typer

from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.options import Common, Figures, Jobs, Out, Overwrite, SupplyPressures, SupplyTemperatures

HEADER = (
    *("MPa gauge", "K", "window [deg]", "limit [r/min]", "[Hz]", "lap to lap [ms]", "then fails"),
    *("works again [r/min]", "30 Hz need [deg]", ""),
)


def find_engine_limits(
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
) -> int:
    """The highest speed at which the valve opens and closes at its targets, with complete strokes.

    For the machine's own supply and targets, and over a grid; with the time from lap to lap that decides it.
    """
    import numpy as np

    from apesim.engine.angles import DEGREE
    from apesim.quantities import parse_range
    from apesim.studies.figures.engine_limit import engine_limit_figures
    from apesim.studies.limit.design_rule import RPM
    from apesim.studies.limit.engine_limit import CRITERION, LOWEST, Failure, judged, map_engine_limit
    from apesim.studies.limit.points import lowest_run, own_run
    from apesim.studies.limit.summary import summary_json, summary_lines
    from apesim.studies.operating_conditions import DURATION, parse_supplies
    from apesim.studies.output import compute_archive, written_text
    from apesim.studies.tables import table_of
    from apesim.studies.timing.targets import require_epv

    machine = common.load_machine()
    require_epv(machine)
    grid = parse_supplies(machine, pressure=pressure, temperature=temperature)
    durations = parse_range(duration, DURATION, where="--duration", file=COMMAND_LINE)

    def compute(**options):
        return map_engine_limit(machine, *grid, durations, jobs, **options)

    def draw(archive, folder):
        return engine_limit_figures(archive, machine.ambient.pressure, folder) if figures else []

    archive, written = compute_archive(
        common.console,
        task="limit",
        first_march=(judged, machine, LOWEST),
        compute=compute,
        out=out,
        overwrite=overwrite,
        draw=draw,
    )
    v = {name: variable.values for name, variable in archive.variables.items()}
    points = []
    for run in v["run"]:
        point = {name: values[run] for name, values in v.items() if name != "run"}
        failure = Failure(point["fails"])
        points.append(point | {"fails": failure.name.lower(), "remedy": failure.remedy})
    missing = int(np.isnan(v["limit_rpm"]).sum())
    stated = summary_json(v, "duration_deg")
    data = stated | {
        "criterion": CRITERION,
        "open_target_deg": machine.command.open_target / DEGREE,
        "points": points,
    }
    own, lowest = own_run(v), lowest_run(v)
    marks = {lowest: "lowest"} | {own: "own" if own != lowest else "own, lowest"}
    rows = [(*_row(point, machine.ambient.pressure), marks.get(run, "")) for run, point in enumerate(points)]
    places = {
        name: _place(points[run], machine.ambient.pressure)
        for name, run in (("own", own), ("lowest", lowest))
        if run is not None
    }
    table = table_of("Highest speed at which the targets are met", HEADER, rows, left=(6, 9))
    lines = summary_lines(stated, CRITERION, places)
    common.console.result(data | written, table, *lines, written_text(written, f"{len(rows)} limits"))
    if missing:
        lowest_speed = f"{LOWEST / RPM:g} r/min"
        common.console.message(f"warning: at {missing} points the criterion is not even met at {lowest_speed}")
    return INCOMPLETE if missing else DONE


def _row(point: dict, ambient_pressure: float) -> tuple[str, ...]:
    """Cells of a limit."""
    from apesim.studies.tables import number

    return (
        f"{(point['supply_pressure'] - ambient_pressure) / 1e6:.3g}",
        f"{point['supply_temperature']:g}",
        f"{point['duration_deg']:g}",
        number(point["limit_rpm"], ".0f"),
        number(point["limit_hz"], ".1f"),
        number(1e3 * point["lap_to_lap_s"], ".2f"),
        point["fails"].replace("_", " "),
        number(point["works_again_rpm"], ".0f"),
        number(point["rule_window_deg"], ".0f"),
    )


def _place(point: dict, ambient_pressure: float) -> str:
    """Conditions at which a limit holds, in words."""
    pressure, temperature, duration, *_ = _row(point, ambient_pressure)
    return f"{pressure} MPa gauge, {temperature} K and window of {duration} deg"
