"""Commands that compute the valve over pressure and temperature of its control air."""

from apesim.quantities import Quantity, parse, parse_range
from apesim.studies.commands.archived import computed, summary
from apesim.studies.commands.given import TIME, supplies_of
from apesim.studies.commands.limit_summary import summary_json, summary_lines
from apesim.studies.commands.machine import load_machine
from apesim.studies.commands.tables import number, table_of
from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.limit.points import lowest_run, own_run
from apesim.valve.bench import run_bench

DUTY = Quantity("", 0.01, 0.99, "command line", typical="0.5")
TIMES = ("opening_delay_s", "opening_stroke_time_s", "closing_delay_s", "closing_stroke_time_s")
MAP_HEADER = (
    *("open t_d\n[ms]", "open t_f\n[ms]", "close t_d\n[ms]", "close t_f\n[ms]"),
    *("open v_e\n[m/s]", "close v_e\n[m/s]"),
)
LIMIT_HEADER = ("duty", "limit [Hz]", "[r/min]", "lap to lap [ms]", "window [deg]", "")
SPEEDS = ("opening_seating_speed_m_s", "closing_seating_speed_m_s")


def map_command(console, machine_file, settings, pressure, temperature, pulse, out, overwrite, figures):
    """A map of the valve; see `apesim valve map --help`.

    Returns
    -------
    int
        Exit code.
    """
    from apesim.studies.figures.valve import map_figures
    from apesim.studies.valve_map import faults_of_map, map_valve

    machine = load_machine(machine_file, settings)
    grid = supplies_of(machine, pressure, temperature)
    pulse = parse(pulse, TIME, where="--pulse", file=COMMAND_LINE)

    def compute(**options):
        return map_valve(machine, *grid, pulse, **options)

    def draw(archive, folder):
        return map_figures(archive, machine.ambient.pressure, folder) if figures else []

    archive, told = computed(console, "map", (run_bench, machine, pulse), compute, out, overwrite, draw)
    v = {name: variable.values for name, variable in archive.variables.items()}
    columns = [1e3 * v[name] for name in TIMES] + [v[name] for name in SPEEDS]
    rows = [[number(value, ".4f") for value in row] for row in zip(*columns, strict=True)]
    faults = faults_of_map(archive)
    table = _table("The valve over pressure and temperature", machine, v, MAP_HEADER, rows)
    console.result({"runs": len(rows), "faults": faults} | told, table, summary(told, f"{len(rows)} runs"))
    for fault in faults:
        console.message(f"warning: {fault}")
    return INCOMPLETE if faults else DONE


def limit_command(console, machine_file, settings, pressure, temperature, duty, out, jobs, overwrite, figures):
    """Working limits of the valve; see `apesim valve limit --help`.

    Returns
    -------
    int
        Exit code.
    """
    from apesim.studies.figures.valve import limit_figures
    from apesim.studies.limit.valve_limit import CRITERION, faults_of_limits, is_complete, limit_map

    machine = load_machine(machine_file, settings)
    grid = supplies_of(machine, pressure, temperature)
    duties = parse_range(duty, DUTY, where="--duty", file=COMMAND_LINE)

    def compute(**options):
        return limit_map(machine, *grid, duties, jobs=jobs, **options)

    def draw(archive, folder):
        return limit_figures(archive, machine.ambient.pressure, folder) if figures else []

    archive, told = computed(console, "limit", (is_complete, machine, 10.0, duties[0]), compute, out, overwrite, draw)
    v = {name: variable.values for name, variable in archive.variables.items()}
    keys = {
        "supply_pressure_Pa": "supply_pressure",
        "supply_temperature_K": "supply_temperature",
        **{name: name for name in ("duty", "limit_hz", "limit_rpm", "lap_to_lap_s", "window_deg", "rule_window_deg")},
    }
    points = [{key: v[name][run] for key, name in keys.items()} for run in range(len(v["run"]))]
    faults = faults_of_limits(archive)
    stated = summary_json(v, "duty")
    data = stated | {"criterion": CRITERION, "points": points, "faults": faults}
    own, lowest = own_run(v), lowest_run(v)
    marks = {lowest: "lowest"} | {own: "own" if own != lowest else "own, lowest"}
    rows = [(*_limit_row(point), marks.get(run, "")) for run, point in enumerate(points)]
    table = _table("Highest working rate", machine, v, LIMIT_HEADER, rows)
    places = {
        name: _place(points[run], machine.ambient.pressure)
        for name, run in (("own", own), ("lowest", lowest))
        if run is not None
    }
    lines = summary_lines(stated, CRITERION, places)
    console.result(data | told, table, *lines, summary(told, f"{len(rows)} limits"))
    for fault in faults:
        console.message(f"warning: {fault}")
    return INCOMPLETE if faults else DONE


def _limit_row(point):
    return (
        f"{point['duty']:.3g}",
        number(point["limit_hz"], ".2f"),
        number(point["limit_rpm"], ".0f"),
        number(1e3 * point["lap_to_lap_s"], ".2f"),
        number(point["window_deg"], ".0f"),
    )


def _place(point, ambient_pressure):
    pressure = f"{(point['supply_pressure_Pa'] - ambient_pressure) / 1e6:.3g} MPa gauge"
    return f"{pressure}, {point['supply_temperature_K']:g} K and duty of {point['duty']:.3g}"


def _table(title, machine, v, header, rows):
    """A table whose first columns are pressure and temperature."""
    supplies = zip(v["supply_pressure"] - machine.ambient.pressure, v["supply_temperature"], strict=True)
    rows = [(f"{p / 1e6:.3g}", f"{t:g}", *row) for (p, t), row in zip(supplies, rows, strict=True)]
    return table_of(title, ("MPa gauge", "K", *header), rows, left=())
