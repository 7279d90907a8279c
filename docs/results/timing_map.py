"""Command angles over speed, pressure and temperature: laws of the advance, error of the table, and the shortcut."""

import numpy as np

import apesim
from apesim.studies.timing.open_loop import open_loop_delays
from docs.results import Number, Table
from docs.results._figures import keep

LONG = True
OWN = (1101325.0, 287.0)


def compute():
    """Map the commands every 150 r/min and every 300 r/min, and compare them with what the bench's delays give."""
    machine = apesim.Machine()
    timing = apesim.correct_timing(machine)
    data = timing.to_dict()
    coarse = apesim.correct_timing(machine, speed="300:2400:300 rpm").to_dict()["interpolation_error"]
    keep(timing.draw, advance="timing_advance", won_back="timing_won_back", shortcut="timing_shortcut")
    fine = data["interpolation_error"]
    values = {
        "fine.energise": Number(fine["advance_most_deg"], "°", error=0.005),
        "fine.release": Number(fine["release_advance_most_deg"], "°", error=0.005),
        "coarse.energise": Number(coarse["advance_most_deg"], "°", error=0.005),
        "coarse.release": Number(coarse["release_advance_most_deg"], "°", error=0.005),
    }
    own = [p for p in data["points"] if np.allclose([p["supply_pressure"], p["supply_temperature"]], OWN, rtol=1e-9)]
    return values | _laws(data["temperature_law"]) | _shortcut(machine, own) | {"commands": _commands(own)}


def _laws(laws):
    def at(edge, *, one_law):
        rows = [law for law in laws[edge] if abs(law["supply_pressure_Pa"] - OWN[0]) < 1.0]
        return [law for law in rows if (law["speed_rpm"] is None) == one_law]

    [opening] = at("advance", one_law=True)
    [closing] = at("release_advance", one_law=True)
    singles = at("release_advance", one_law=False)
    return {
        "opening.time": Number(opening["at_287_K_ms"], "ms", error=0.0005),
        "opening.fall": Number(-1e3 * opening["slope_ms_per_K"], "µs/K", error=0.005),
        "opening.error": Number(opening["error_most_ms"], "ms", error=0.005),
        "opening.angle_error": Number(opening["error_most_deg"], "°", error=0.005),
        "closing.angle_error": Number(closing["error_most_deg"], "°", error=0.5),
        "closing.single_angle_error": Number(max(law["error_most_deg"] for law in singles), "°", error=0.005),
    }


def _shortcut(machine, own):
    delays = open_loop_delays(machine)
    shut = [p["speed_rpm"] for p in own if p["shortcut_open_error_deg"] is None]
    rows = []
    for point in own:
        opened, closed = (point[f"shortcut_{edge}_error_deg"] for edge in ("open", "close"))
        if opened is None:
            rows.append([f"{point['speed_rpm']:g}", "does not open", ""])
        else:
            rows.append([f"{point['speed_rpm']:g}", *(Number(error, "°", error=0.05) for error in (opened, closed))])
    slow = [p for p in own if p["speed_rpm"] <= 600.0]
    worst = max(max(abs(p[f"shortcut_{edge}_error_deg"]) for edge in ("open", "close")) for p in slow)
    return {
        "bench.opening": Number(1e3 * delays.opening, "ms", error=0.005),
        "bench.closing": Number(1e3 * delays.closing, "ms", error=0.005),
        "shortcut.up_to_600": Number(worst, "°", error=0.05),
        "shortcut.does_not_open_from": Number(min(shut), "r/min"),
        "shortcut": Table(["speed [r/min]", "error of the opening [°]", "error of the closing [°]"], rows),
    }


def _commands(own):
    heads = ["speed [r/min]", "energise [°]", "release [°]", "brake torque [N·m]", "with fixed timing [N·m]"]
    heads += ["air over brake work [kg/kWh]", "with fixed timing [kg/kWh]"]
    rows = []
    for point in own[::2]:
        row = [f"{point['speed_rpm']:g}"]
        row += [Number(point[f"{edge}_deg"], "°", error=0.05) for edge in ("energise", "release")]
        row += [Number(point[f"{name}brake_torque_Nm"], "N·m", error=0.05) for name in ("", "fixed_")]
        airs = [point[f"{name}specific_air_kg_per_kWh"] for name in ("", "fixed_")]
        row += ["–" if air is None else Number(air, "kg/kWh", error=0.05) for air in airs]
        rows.append(row)
    return Table(heads, rows)
