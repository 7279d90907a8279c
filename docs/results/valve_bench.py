"""The valve on its bench at 287 K: both strokes over the control pressure, and a pulse that is repeated."""

import apesim
from docs.results import Number, Table
from docs.results._terminal import run

PRESSURES = (0.2, 0.49, 1.0, 1.5, 1.9)


def compute():
    """Delay time, full stroke time, seating speed, fluctuation and control air."""
    machine = apesim.Machine()
    rows = []
    for pressure in PRESSURES:
        bench = apesim.run_valve(machine, supply=f"{pressure} MPa gauge")
        rows.append([f"{pressure:g}", *_measures(bench)])
    measures = ["delay time [ms]", "full stroke time [ms]", "seating speed [m/s]", "fluctuation [–]"]
    columns = ["control pressure [MPa gauge]", *measures]
    return {
        "opening": Table([*columns, "control air of a pulse [g]"], [[*row[:5], row[9]] for row in rows]),
        "closing": Table(columns, [[row[0], *row[5:9]] for row in rows]),
        "repeated": run("valve", "run", "--pulse", "25 ms", "--repeat", "20 Hz"),
    }


def _measures(bench):
    numbers = []
    for stroke in ("opening", "closing"):
        numbers += [
            Number(1e3 * bench[f"{stroke}_delay"], "ms", error=0.005),
            Number(1e3 * bench[f"{stroke}_stroke_time"], "ms", error=0.005),
            Number(bench[f"{stroke}_seating_speed"], "m/s", error=0.005),
            Number(bench[f"{stroke}_fluctuation"], "", error=0.0005),
        ]
    return [*numbers, Number(1e3 * bench["control_air"], "g", error=0.0005)]
