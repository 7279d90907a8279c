"""Figure of the highest speeds at which the valve meets its targets."""

from collections.abc import Mapping
from functools import partial
from os import PathLike
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from apesim.archive import Archive
from apesim.engine.angles import DEGREE, RPM
from apesim.studies.archives.pressure_axes import find_pressure_axis
from apesim.studies.drawing.conditions import conditions_of, supply_keys_of
from apesim.studies.drawing.files import write_figures
from apesim.studies.drawing.panels import columns_of, label_axes, open_row
from apesim.studies.drawing.style import RED, Look
from apesim.studies.limit.design_rule import DesignRule
from apesim.studies.limit.lines import OWN_POINT, draw_over_pressure, draw_own_point
from apesim.studies.limit.points import Point, own_run


def engine_limit_figures(archive: Archive, ambient_pressure: float, folder: str | PathLike[str]) -> list[Path]:
    """Write the figure of a map of limits as PNG and PDF into a folder, made if it does not exist.

    `archive` holds limits over pressure, temperature and duration, see `apesim.studies.limit.engine_limit`; gauge
    pressures stand above `ambient_pressure` [Pa abs].
    """
    figures = {"engine_limit": partial(_plot_limits, archive, ambient_pressure)}
    return write_figures(figures, folder, conditions_of(archive.machine, supply_keys_of(archive)))


def _plot_limits(archive: Archive, ambient_pressure: float) -> Figure:
    """Plot the limit over pressure, and over the window with the design rule."""
    figure, (left, right) = open_row(2, (12.4, 4.6), sharey=True)
    draw_limits(left, archive, ambient_pressure)
    left.set_title("Targets met within 0.5°, strokes complete, every cycle the same")
    left.set_ylim(bottom=0.0)
    _draw_rule(right, columns_of(archive))
    figure.legend(loc="outside right upper", title="opening to closing, air")
    return figure


def draw_limits(axis: Axes, archive: Archive, ambient_pressure: float) -> Axes:
    """Draw the highest speed over pressure, for each duration and temperature, and the machine's own.

    Gauge pressures stand above `ambient_pressure` [Pa abs].
    """
    v, pressure_axis = columns_of(archive), find_pressure_axis(archive)
    v["supply_pressure"] = v[pressure_axis]
    of_grid = {name: values[v["point"] != Point.OWN] for name, values in v.items()}
    common: Look = {"ambient_pressure": ambient_pressure}
    draw_over_pressure(axis, of_grid, "limit_rpm", parameter="duration_deg", label="{:g}°", **common)
    draw_own_point(axis, v, "limit_rpm", more=f"{v['duration_deg'][own_run(v)]:.4g}°", **common)
    label_axes(axis, x=(pressure_axis.replace("_", " "), "MPa gauge"), y=("highest speed", "r/min"))
    return axis


def _draw_rule(axis: Axes, v: Mapping[str, np.ndarray]) -> Axes:
    """Draw limits over the window, and the design rule of each supply, where there is one."""
    label_axes(axis, x=("window: target opening to target closing", "deg"))
    axis.plot(v["duration_deg"], v["limit_rpm"], "o", ms=3, color="0.55")
    own = own_run(v)
    axis.plot(v["duration_deg"][own], v["limit_rpm"][own], **OWN_POINT)
    times = np.unique(v["rule_lap_to_lap_s"][~np.isnan(v["rule_lap_to_lap_s"])])
    if not len(times):
        return axis
    windows = np.linspace(0.0, 1.08 * np.nanmax(v["duration_deg"]), 2)
    for time in times:
        axis.plot(windows, DesignRule(time).limit(windows * DEGREE) / RPM, color="0.8", lw=0.8, zorder=1)
    title = "Design rule: limit = (window + 1°)/(6 t)"
    time = v["rule_lap_to_lap_s"][own]
    if not np.isnan(time):
        axis.plot(windows, DesignRule(time).limit(windows * DEGREE) / RPM, color=RED, lw=1.2)
        title += f"\nt = {1e3 * time:.2f} ms (red, its own air)"
    label_axes(axis, title=f"{title}\nt = {1e3 * times[0]:.2f} to {1e3 * times[-1]:.2f} ms (grey, all air)")
    axis.set_xlim(0.0, windows[-1])
    return axis
