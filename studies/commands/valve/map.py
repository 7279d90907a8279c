"""Command `apesim valve map`."""

from pathlib import Path

from apesim.studies.console import COMMAND_LINE, DONE, INCOMPLETE
from apesim.studies.options import Common, Figures, Out, Overwrite, Pressures, Pulse, Temperatures

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
) -> int:
    """Delay time, stroke time, seating speed, fluctuation over pressure and temperature."""
    from apesim.quantities import parse
    from apesim.studies.figures.valve import map_figures
    from apesim.studies.operating_conditions import TIME, parse_supplies
    from apesim.studies.output import compute_archive, written_text
    from apesim.studies.tables import number, table_over_supplies
    from apesim.studies.valve_map import faults_of_map, map_valve
    from apesim.valve.bench import run_bench

    machine = common.load_machine()
    grid = parse_supplies(machine, pressure=pressure, temperature=temperature)
    pulse = parse(pulse, TIME, where="--pulse", file=COMMAND_LINE)

    def compute(**options):
        return map_valve(machine, *grid, pulse, **options)

    def draw(archive, folder):
        return map_figures(archive, machine.ambient.pressure, folder) if figures else []

    archive, written = compute_archive(
        common.console,
        task="map",
        first_march=(run_bench, machine, pulse),
        compute=compute,
        out=out,
        overwrite=overwrite,
        draw=draw,
    )
    v = {name: variable.values for name, variable in archive.variables.items()}
    values = [1e3 * v[name] for name in TIMES] + [v[name] for name in SPEEDS]
    rows = [[number(value, ".4f") for value in row] for row in zip(*values, strict=True)]
    faults = faults_of_map(archive)
    title = "The valve over pressure and temperature"
    table = table_over_supplies(title, machine.ambient.pressure, columns=v, header=HEADER, rows=rows)
    data = {"runs": len(rows), "faults": faults} | written
    common.console.result(data, table, written_text(written, f"{len(rows)} runs"))
    for fault in faults:
        common.console.message(f"warning: {fault}")
    return INCOMPLETE if faults else DONE
