"""Command `apesim engine limit`."""

import numpy as np

from apesim.quantities import Quantity, parse_range
from engine.breathing import DEGREE
from studies.commands.archived import computed, summary
from studies.commands.given import supplies_of
from studies.commands.tables import number, table_of
from studies.commands.timing import machine_with_targets
from studies.console import COMMAND_LINE, DONE, INCOMPLETE

DURATION = Quantity("deg", 0.1, 359, "command line")


def engine_limit_command(
    console, machine_file, settings, pressure, temperature, duration, out, jobs, overwrite, figures
):
    """Limits of the engine's intake; see `apesim engine limit --help`.

    Returns
    -------
    int
        Exit code.
    """
    from studies.engine_limit import CRITERION, LOWEST, PAPER_RPM, RPM, Failure, judged, map_engine_limit
    from studies.figures.engine_limit import engine_limit_figures

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
    found = v["limit_rpm"][~np.isnan(v["limit_rpm"])]
    missing = len(points) - len(found)
    data = {
        "limit_rpm": None if missing else found.min(),
        "limit_hz": None if missing else found.min() / 60.0,
        "criterion": CRITERION,
        "open_target_deg": machine.command.open_target / DEGREE,
        "paper_rpm": PAPER_RPM,
        "points": points,
    }
    rows = [_row(point, machine.ambient.pressure) for point in points]
    claims = list(PAPER_RPM.values())
    header = ("MPa gauge", "K", "duration [deg]", "limit [r/min]", "[Hz]", "open for [ms]", "then fails", "works again")
    reached = ", ".join(f"{claim:g} r/min at {np.sum(found >= claim)} of {len(points)} points" for claim in claims)
    table = table_of("Highest speed at which the targets are met", header, rows, left=(6,))
    where = f"the paper's limits are reached: {reached}", summary(told, f"{len(rows)} limits")
    console.result(data | told, table, f"criterion: {CRITERION}", *where)
    if missing:
        lowest = f"{LOWEST / RPM:g} r/min"
        console.message(f"warning: at {missing} points the criterion is not even met at {lowest}")
    return INCOMPLETE if missing else DONE


def _row(point, ambient_pressure):
    return (
        f"{(point['supply_pressure'] - ambient_pressure) / 1e6:.3g}",
        f"{point['supply_temperature']:g}",
        f"{point['duration_deg']:g}",
        f"{point['limit_rpm']:.0f}",
        f"{point['limit_hz']:.1f}",
        f"{1e3 * point['open_time_s']:.2f}",
        point["fails"].replace("_", " "),
        number(point["works_again_rpm"], ".0f"),
    )
