"""Command `apesim engine limit`."""

import sys
import time

import numpy as np

from apesim.archive import command_line
from apesim.kernel import is_cold
from apesim.quantities import Quantity, parse_range
from engine.breathing import DEGREE
from studies.commands.tables import COMPILING, table_of
from studies.commands.timing import machine_with_targets, supplies_of
from studies.console import COMMAND_LINE, DONE, INCOMPLETE
from studies.output import publish, refuse_to_replace

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
    pressures, temperatures = supplies_of(machine, pressure, temperature)
    durations = parse_range(duration, DURATION, where="--duration", file=COMMAND_LINE)
    if not overwrite:
        refuse_to_replace(out)
    if is_cold():
        console.message(COMPILING)
    judged(machine, LOWEST)  # compiles, or loads what is compiled
    start = time.perf_counter()
    with console.progress("limit") as report:
        command = command_line(["apesim", *sys.argv[1:]])
        archive = map_engine_limit(machine, pressures, temperatures, durations, jobs, command, report)
    wall = time.perf_counter() - start
    publish(archive, out, overwrite)
    drawn = engine_limit_figures(archive, machine.ambient.pressure, out.with_suffix(".figures")) if figures else []
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
        "archive": str(out),
        "figures": [str(path) for path in drawn],
        "wall_time_s": wall,
    }
    rows = [_row(point, machine.ambient.pressure) for point in points]
    claims = list(PAPER_RPM.values())
    header = ("MPa gauge", "K", "duration [deg]", "limit [r/min]", "[Hz]", "open for [ms]", "then fails", "works again")
    reached = ", ".join(f"{claim:g} r/min at {np.sum(found >= claim)} of {len(points)} points" for claim in claims)
    where = f"{out}: {len(rows)} limits in {wall:.1f} s" + (f"; figure in {drawn[0].parent}/" if drawn else "")
    table = table_of("Highest speed at which the targets are met", header, rows, left=(6,))
    console.result(data, table, f"criterion: {CRITERION}", f"the paper's limits are reached: {reached}", where)
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
        "-" if np.isnan(point["works_again_rpm"]) else f"{point['works_again_rpm']:.0f}",
    )
