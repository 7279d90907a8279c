"""Summary of a map of limits for console and JSON: the machine's own limit, the lowest, and the design rule."""

from math import isnan

import numpy as np

from apesim.studies.limit.design_rule import FORMULA, PAPER_RPM
from apesim.studies.limit.points import Point, lowest_run, own_run

OVER_ALL = "over all pressures and temperatures"


def summary_json(v, window):
    """Summarise a map of limits for JSON.

    Parameters
    ----------
    v : dict of array
        Columns of the map.
    window : str
        Name of the column that tells points of equal air apart.

    Returns
    -------
    dict
    """
    own, lowest = own_run(v), lowest_run(v)

    def place(run):
        return {
            "supply_pressure_Pa": v["supply_pressure"][run],
            "supply_temperature_K": v["supply_temperature"][run],
            window: v[window][run],
        }

    return {
        "limit_rpm": v["limit_rpm"][own],
        "limit_hz": v["limit_hz"][own],
        "limit_at": place(own),
        "min_limit_rpm": None if lowest is None else v["limit_rpm"][lowest],
        "min_limit_hz": None if lowest is None else v["limit_hz"][lowest],
        "min_limit_at": None if lowest is None else place(lowest),
        "design_rule": rule_json(v),
        "paper": paper_json(v),
    }


def rule_json(v):
    """The design rule of a map: the time it needs, its spread over the grid's air, and what it was fitted to."""
    times = v["rule_lap_to_lap_s"]
    fitted = v["rule_fitted"] == 1
    windows, misfits = windows_of(v)[fitted], np.abs(v["rule_limit_rpm"][fitted] / v["limit_rpm"][fitted] - 1.0)
    # One window alone is met in any case.
    free = len(misfits) > len(np.unique(times[fitted]))
    known = not np.isnan(times).all()
    return {
        "formula": FORMULA,
        "lap_to_lap_s": times[own_run(v)],
        "lap_to_lap_s_range": [np.nanmin(times), np.nanmax(times)] if known else None,
        "fitted_windows_deg": [windows.min(), windows.max()] if known else None,
        "largest_misfit": misfits.max() if free else None,
    }


def paper_json(v):
    """The paper's speeds judged point by point, and the window that its 30 Hz need by the design rule."""
    of_grid = v["point"] != Point.OWN
    needed = v["rule_window_deg"]
    known = not np.isnan(needed).all()
    return {
        "speeds_rpm": PAPER_RPM,
        "grid_points": int(of_grid.sum()),
        "reached_at_grid_points": {
            name: int((v["limit_rpm"][of_grid] >= speed).sum()) for name, speed in PAPER_RPM.items()
        },
        "reached_at_own_point": {name: bool(v["limit_rpm"][own_run(v)] >= speed) for name, speed in PAPER_RPM.items()},
        "window_for_30_hz_deg": needed[own_run(v)],
        "window_for_30_hz_deg_range": [np.nanmin(needed), np.nanmax(needed)] if known else None,
    }


def windows_of(v):
    """Window between opening and closing of each point [deg]: the intended one, or what the valve alone serves."""
    return v["duration_deg"] if "duration_deg" in v else v["window_deg"]


def summary_lines(told, criterion, places):
    """What is told of a map of limits as text.

    Parameters
    ----------
    told : dict
        See `summary_json`.
    criterion : str
    places : dict of str to str
        Where the machine's own and the lowest limit stand, by ``own`` and ``lowest``.

    Returns
    -------
    list of str
    """
    lines = [f"limit: {speed_text(told['limit_rpm'], told['limit_hz'])} at the machine's own {places['own']}"]
    if told["min_limit_rpm"] is not None:
        lowest = speed_text(told["min_limit_rpm"], told["min_limit_hz"])
        lines.append(f"lowest of the grid: {lowest} at {places['lowest']}")
    lines.append(f"criterion: {criterion}")
    return [*lines, *rule_lines(told["design_rule"]), *paper_lines(told)]


def speed_text(rpm, hertz):
    """A limit as text."""
    return "none" if isnan(rpm) else f"{rpm:.0f} r/min ({hertz:.1f} Hz)"


def rule_lines(rule):
    """The design rule as text."""
    if rule["lap_to_lap_s_range"] is None:
        return ["design rule: none, as no limit for a window of up to 150 deg is one of full lift"]
    low, high = (f"{1e3 * time:.2f}" for time in rule["lap_to_lap_s_range"])
    first, last = (f"{window:.0f}" for window in rule["fitted_windows_deg"])
    own = "" if isnan(rule["lap_to_lap_s"]) else f" t = {1e3 * rule['lap_to_lap_s']:.2f} ms at the machine's own air,"
    misfit = "" if rule["largest_misfit"] is None else f", off by up to {100.0 * rule['largest_misfit']:.2g} %"
    return [
        f"design rule: {rule['formula']}; from lap to lap the valve needs{own} {low} to {high} ms {OVER_ALL}",
        f"it is fitted to windows of {first} to {last} deg{misfit}; much longer ones are bounded by the time that the "
        "valve needs closed",
    ]


def paper_lines(told):
    """The judgement on the paper's speeds as text."""
    paper = told["paper"]
    lines = [
        f"the paper's {PAPER_RPM[name]:g} r/min ({name}): reached at {count} of {paper['grid_points']} points of the "
        f"grid, {'and' if paper['reached_at_own_point'][name] else 'not'} at the machine's own"
        for name, count in paper["reached_at_grid_points"].items()
    ]
    if paper["window_for_30_hz_deg_range"]:
        low, high = (f"{window:.0f}" for window in paper["window_for_30_hz_deg_range"])
        needed = paper["window_for_30_hz_deg"]
        own = "" if isnan(needed) else f" {needed:.0f} deg at the machine's own air,"
        longest = told["design_rule"]["fitted_windows_deg"][1]
        beyond = f" (beyond {longest:.0f} deg extrapolated)" if float(high) > longest + 0.5 else ""
        lines.append(f"30 Hz need a window of{own} {low} to {high} deg {OVER_ALL}{beyond}")
    return lines
