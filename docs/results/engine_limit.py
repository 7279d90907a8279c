"""The highest speed at which the valve opens and closes at its targets with complete strokes, and the design rule."""

import numpy as np

import apesim
from apesim.archive.columns import values_of
from apesim.engine.angles import DEGREE
from apesim.studies.limit.engine_limit import RESOLUTION, engine_limit, lasting
from apesim.studies.limit.summary import summary_json
from docs.results import Number, Table
from docs.results._figures import keep
from tests.truth.simulator.periodic import opening_and_closing
from tests.truth.simulator.reading import engine_of

LONG = True
RPM = 6.0 * DEGREE
FOUND_TO = RESOLUTION / RPM
"""How closely a limit is looked for [r/min]."""
WINDOWS = (40.0, 60.0, 75.0, 90.0, 120.0, 140.0, 160.0, 200.0, 240.0, 320.0)


def compute():
    """Limits of the default grid and over the window; the valve alone; and the independent simulator at the limit."""
    machine = apesim.Machine()
    limits = apesim.find_engine_limit(machine)
    keep(limits.draw, engine_limit="engine_limit")
    data = limits.to_dict()
    rule, paper = data["design_rule"], data["paper"]
    shortest, longest = rule["lap_to_lap_s_range"]
    reached = paper["reached_at_grid_points"]
    windows = paper["window_for_30_hz_deg_range"]
    lowest = data["min_limit_at"]
    values = {
        "limit": Number(data["limit_rpm"], "r/min", error=FOUND_TO),
        "time": Number(1e3 * rule["lap_to_lap_s"], "ms", error=0.005),
        "shortest_time": Number(1e3 * shortest, "ms", error=0.05),
        "longest_time": Number(1e3 * longest, "ms", error=0.05),
        "misfit": Number(1e2 * rule["largest_misfit"], "%", error=0.005),
        "lowest": Number(data["min_limit_rpm"], "r/min", error=FOUND_TO),
        "lowest.pressure": Number((lowest["supply_pressure_Pa"] - machine.ambient.pressure) / 1e6, "MPa", error=0.05),
        "lowest.temperature": Number(lowest["supply_temperature_K"], "K"),
        "lowest.window": Number(lowest["duration_deg"], "°", error=0.5),
        "points": Number(paper["grid_points"]),
        "reach_30_hz": Number(reached["30 Hz, one event a revolution"]),
        "reach_2000": Number(reached["as printed"]),
        "window_30_hz": Number(paper["window_for_30_hz_deg"], "°", error=0.5),
        "window_30_hz.least": Number(min(windows), "°", error=0.5),
        "window_30_hz.most": Number(max(windows), "°", error=0.5),
        "windows": _windows(machine, rule["lap_to_lap_s"]),
    }
    return values | _truth(machine) | _bench(machine)


def _windows(machine, time):
    rows = []
    for window in WINDOWS:
        found = engine_limit(lasting(machine, window * DEGREE))
        limit, rule = found.limit / RPM, (window + 1.0) / (6.0 * time)
        time_needed, share = 1e3 * (window + 1.0) / (6.0 * limit), FOUND_TO / limit
        needed = Number(time_needed, "ms", error=time_needed * share)
        off = Number(1e2 * (limit / rule - 1.0), "%", error=1e2 * share)
        rows.append(
            [
                f"{window:g}",
                Number(limit, "r/min", error=FOUND_TO),
                needed,
                off,
                found.fails.name.lower().replace("_", " "),
            ]
        )
    heads = ["window [°]", "limit [r/min]", "(window + 1°)/(6 limit) [ms]", "limit against the rule [%]", "fails first"]
    return Table(heads, rows)


def _truth(machine):
    found = engine_limit(machine)
    command = found.timing.machine.command
    truth = np.degrees(opening_and_closing(engine_of(machine), found.limit, command.energise, command.release))
    return {
        "truth.opens": Number(truth[0], "°", error=0.00005),
        "truth.closes": Number(truth[1], "°", error=0.00005),
    }


def _bench(machine):
    grid = {"pressure": "1 MPa gauge", "temperature": "287 K", "duty": [0.3, 0.5]}
    data = summary_json(values_of(apesim.find_valve_limit(machine, **grid).archive), "duty")
    return {
        "bench.time": Number(1e3 * data["design_rule"]["lap_to_lap_s"], "ms", error=0.005),
        "bench.limit": Number(data["limit_hz"], "Hz", error=0.05),
        "bench.duty": Number(1e2 * data["limit_at"]["duty"], "%", error=0.05),
    }
