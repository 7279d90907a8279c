"""Summary of a map of limits for console and JSON: the machine's own limit, the lowest, and the design rule."""

from collections.abc import Mapping
from math import isnan
from typing import Any

import numpy as np

from apesim.studies.limit.design_rule import FORMULA, PAPER_RPM
from apesim.studies.limit.points import Point, lowest_run, own_run

OVER_ALL = "over all pressures and temperatures"


def summary_json(v: Mapping[str, np.ndarray], window: str) -> dict[str, Any]:
    """Summarise a map of limits for JSON.

    It holds the limit at the machine's own point and the lowest of the grid, each with its place, the design rule and
    the paper's speeds; the lowest is None where a point of the grid has no limit. `v` holds the map's columns (n,) by
    name; `window` is the one that distinguishes points of equal air: "duration_deg" of the engine, "duty" of the valve.

    >>> from apesim.studies.limit.design_rule import rule_columns
    >>> windows, limits, by_full_lift = np.radians([60.0, 75.0]), np.array([188.0, 233.0]), np.array([True, True])
    >>> rule = rule_columns(["air", "air"], windows, limits, by_full_lift)
    >>> v = {name: variable.values for name, variable in rule.items()} | {
    ...     "point": np.array([Point.GRID, Point.GRID_AND_OWN]),
    ...     "supply_pressure": np.array([1.1e6, 1.1e6]),
    ...     "supply_temperature": np.array([287.0, 287.0]),
    ...     "duration_deg": np.array([60.0, 75.0]),
    ...     "limit_rpm": np.array([1795.0, 2225.0]),
    ...     "limit_hz": np.array([29.9, 37.1]),
    ... }
    >>> summary = summary_json(v, "duration_deg")
    >>> float(summary["limit_rpm"]), float(summary["min_limit_rpm"])
    (2225.0, 1795.0)
    >>> round(1e3 * float(summary["design_rule"]["lap_to_lap_s"]), 2)
    5.68
    >>> summary["paper"]["reached_at_own_point"]
    {'30 Hz, one event a revolution': True, 'as printed': True}
    """
    own, lowest = own_run(v), lowest_run(v)

    def place(run: int) -> dict[str, Any]:
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
        "design_rule": _rule_json(v),
        "paper": _paper_json(v),
    }


def _rule_json(v: Mapping[str, np.ndarray]) -> dict[str, Any]:
    """Summarise the design rule: the time it needs, its spread over the grid's air, and the points it is fitted to."""
    times = v["rule_lap_to_lap_s"]
    fitted = v["rule_fitted"] == 1
    windows, misfits = _windows_of(v)[fitted], np.abs(v["rule_limit_rpm"][fitted] / v["limit_rpm"][fitted] - 1.0)
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


def _paper_json(v: Mapping[str, np.ndarray]) -> dict[str, Any]:
    """Judge the paper's speeds point by point, and find the window that its 30 Hz need by the design rule."""
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


def _windows_of(v: Mapping[str, np.ndarray]) -> np.ndarray:
    """Window from opening to closing at each point [deg]: the intended one, or the one that the valve alone serves."""
    return v["duration_deg"] if "duration_deg" in v else v["window_deg"]


def summary_lines(summary: Mapping[str, Any], criterion: str, conditions: Mapping[str, str]) -> list[str]:
    r"""Write the summary of a map of limits, see `summary_json`, in words.

    The lines are on both limits, the criterion, the design rule and the paper's speeds. `criterion` says what a speed
    or rate has to meet; `conditions` are those of the machine's own limit, by "own", and of the lowest, by "lowest".
    """
    lines = [
        f"limit: {_speed_text(summary['limit_rpm'], summary['limit_hz'])} at the machine's own {conditions['own']}"
    ]
    if summary["min_limit_rpm"] is not None:
        lowest = _speed_text(summary["min_limit_rpm"], summary["min_limit_hz"])
        lines.append(f"lowest of the grid: {lowest} at {conditions['lowest']}")
    lines.append(f"criterion: {criterion}")
    return [*lines, *_rule_lines(summary["design_rule"]), *_paper_lines(summary)]


def _speed_text(rpm: float, hertz: float) -> str:
    """Write a limit in words: its speed and its rate."""
    return "none" if isnan(rpm) else f"{rpm:.0f} r/min ({hertz:.1f} Hz)"


def _rule_lines(rule: Mapping[str, Any]) -> list[str]:
    """Write the design rule in words."""
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


def _paper_lines(summary: Mapping[str, Any]) -> list[str]:
    """Write in words where the paper's speeds are reached, and which window its 30 Hz need."""
    paper = summary["paper"]
    lines = [
        f"the paper's {PAPER_RPM[name]:g} r/min ({name}): reached at {count} of {paper['grid_points']} points of the "
        f"grid, {'and' if paper['reached_at_own_point'][name] else 'not'} at the machine's own"
        for name, count in paper["reached_at_grid_points"].items()
    ]
    if paper["window_for_30_hz_deg_range"]:
        low, high = (f"{window:.0f}" for window in paper["window_for_30_hz_deg_range"])
        needed = paper["window_for_30_hz_deg"]
        own = "" if isnan(needed) else f" {needed:.0f} deg at the machine's own air,"
        longest = summary["design_rule"]["fitted_windows_deg"][1]
        beyond = f" (beyond {longest:.0f} deg extrapolated)" if float(high) > longest + 0.5 else ""
        lines.append(f"30 Hz need a window of{own} {low} to {high} deg {OVER_ALL}{beyond}")
    return lines
