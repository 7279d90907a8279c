"""Command `apesim engine limit`."""

import numpy as np

from apesim.engine.angles import DEGREE
from apesim.quantities import Quantity, parse_range
from apesim.studies.commands.archived import computed, summary
from apesim.studies.commands.given import supplies_of
from apesim.studies.commands.limit_summary import summary_json, summary_lines
from apesim.studies.commands.tables import number, table_of
from apesim.studies.commands.timing import machine_with_targets
from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.limit.design_rule import RPM
from apesim.studies.limit.points import lowest_run, own_run

HEADER = (
    *("MPa gauge", "K", "window [deg]", "limit [r/min]", "[Hz]", "lap to lap [ms]", "then fails"),
    *("works again [r/min]", "30 Hz need [deg]", ""),
)
DURATION = Quantity("deg", 0.1, 359, "command line", typical="75 deg")


def engine_limit_command(
    console, machine_file, settings, pressure, temperature, duration, out, jobs, overwrite, figures
):
    """Limits of the engine's intake; see `apesim engine limit --help`.

    Returns
    -------
    int
        Exit code.
    """
    from apesim.studies.figures.engine_limit import engine_limit_figures
    from apesim.studies.limit.engine_limit import CRITERION, LOWEST, Failure, judged, map_engine_limit

    machine = machine_with_targets(machine_file, settings, None)
    grid = supplies_of(machine, pressure, temperature)
    durations = parse_range(duration, DURATION, where="--duration", file=COMMAND_LINE)

    def compute(**options):
        return map_engine_limit(machine, *grid, durations, jobs, **options)

    def draw(archive, folder):
        return engine_limit_figures(archive, machine.ambient.pressure, folder) if figures else []

    archive, told = computed(console, "limit", (judged, machine, LOWEST), compute, out, overwrite, draw)
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
    console.result(data | told, table, *lines, summary(told, f"{len(rows)} limits"))
    if missing:
        lowest_speed = f"{LOWEST / RPM:g} r/min"
        console.message(f"warning: at {missing} points the criterion is not even met at {lowest_speed}")
    return INCOMPLETE if missing else DONE


def _row(point, ambient_pressure):
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


def _place(point, ambient_pressure):
    pressure, temperature, duration, *_ = _row(point, ambient_pressure)
    return f"{pressure} MPa gauge, {temperature} K and window of {duration} deg"
