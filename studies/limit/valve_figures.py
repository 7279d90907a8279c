"""Figures of the valve alone: maps over pressure and temperature, velocity traces, working limits."""

from collections.abc import Mapping
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from apesim.archive import Archive
from apesim.studies.drawing.conditions import CONTROL_AIR, VALVE_SECTIONS, conditions_of
from apesim.studies.drawing.files import write_figures
from apesim.studies.drawing.panels import (
    add_figure_legend,
    columns_of,
    gauge_in_mpa,
    label_axes,
    named,
    open_one,
    open_row,
)
from apesim.studies.drawing.spread import spread_out
from apesim.studies.drawing.style import Look, looks_of, spaced
from apesim.studies.limit.lines import draw_over_pressure, draw_own_point
from apesim.studies.limit.points import Point, own_run

MAPS = {
    "delay_time": ("delay_s", 1e3, "delay time", "ms"),
    "stroke_time": ("stroke_time_s", 1e3, "full stroke time", "ms"),
    "seating_speed": ("seating_speed_m_s", 1.0, "seating speed", "m/s"),
    "fluctuation": ("fluctuation", 1.0, "fluctuation of the speed", "-"),
}
"""Maps by the name of their file: the measure, the factor from SI, its name and its unit in the figure."""
STROKES = ("opening", "closing")
"""The strokes, a panel for each."""
SIZE = (9.2, 3.7)
"""Size of the figures with a panel for each stroke [inch]."""
ROUND = (1, 2, 5, 10)
"""Steps between levels, times a power of ten: readers interpolate between round numbers."""
MAX_LEVELS = 14
"""Steps between levels at most: of round steps the next larger one leaves some six."""
LEVEL = "%g"
"""How the number of a level is written."""
MIN_APART = 0.04, 0.1
"""Least distance of two labels of levels, in widths and heights of the panel: closer ones overlap."""


def map_figures(archive: Archive, ambient_pressure: float, folder: str | PathLike[str]) -> list[Path]:
    """Write all figures of a valve map, each as PNG and PDF, into a folder that is made if need be.

    The archive is one of `compute_map`; gauge pressures stand above `ambient_pressure` [Pa abs].
    """
    figures = {name: partial(plot_map, archive, ambient_pressure, name) for name in MAPS}
    figures["velocity"] = partial(plot_velocities, archive, ambient_pressure)
    more = [f"{1e3 * float(archive.provenance['pulse_s']):g} ms pulse"]
    for name, axis, unit in zip(
        ("pressure", "temperature"), grid_of(archive, ambient_pressure), ("MPa gauge", "K"), strict=True
    ):
        more += [f"control air {name} {axis[0]:.4g} {unit}"] * (len(axis) == 1)
    return write_figures(figures, folder, conditions_of(archive.machine, CONTROL_AIR, ", ".join(more), VALVE_SECTIONS))


def grid_of(archive: Archive, ambient_pressure: float) -> tuple[np.ndarray, np.ndarray]:
    """Axes of a map, ascending: pressures (n,) [MPa gauge] above `ambient_pressure` [Pa abs], temperatures (m,) [K]."""
    v = archive.variables
    pressures = np.unique(v["supply_pressure"].values)
    return gauge_in_mpa(pressures, ambient_pressure), np.unique(v["supply_temperature"].values)


def plot_map(archive: Archive, ambient_pressure: float, name: str) -> Figure:
    """Plot a measure over pressure and temperature, a panel for opening and one for closing.

    `name` is a key of `MAPS`, `ambient_pressure` in [Pa abs]. Contours are drawn, or lines where the grid has one
    pressure or one temperature only.
    """
    column, factor, label, unit = MAPS[name]
    pressures, temperatures = grid_of(archive, ambient_pressure)
    shape = (len(pressures), len(temperatures))
    values = {stroke: archive.variables[f"{stroke}_{column}"].values.reshape(shape).T * factor for stroke in STROKES}
    figure, panels = open_row(2, SIZE, sharey=True)
    if min(shape) < 2:
        _draw_lines(panels, values, pressures, temperatures)
        label_axes(panels[0], y=(label, unit))
        return figure
    low, high = (function([function(v) for v in values.values()]) for function in (np.nanmin, np.nanmax))
    levels = MaxNLocator(MAX_LEVELS, steps=ROUND).tick_values(low, high)
    for axis, (stroke, field) in zip(panels, values.items(), strict=True):
        filled = axis.contourf(pressures, temperatures, field, levels, cmap="viridis")
        lines = axis.contour(pressures, temperatures, field, levels, colors="white", linewidths=0.6)
        _label_levels(axis, lines)
        label_axes(axis, x=("control pressure", "MPa gauge"), title=stroke)
        axis.grid(False)
    label_axes(panels[0], y=("control air temperature", "K"))
    figure.colorbar(filled, ax=panels, label=named(label, unit), format=LEVEL)
    return figure


def _label_levels(axis: Axes, lines: ContourSet) -> None:
    """Label levels on their lines, but for those that the frame would cut off or that would overlap."""
    style: Look = {"fmt": LEVEL, "fontsize": 7.5}
    to_axes, places = axis.transData + axis.transAxes.inverted(), dict[str, tuple[float, float]]()
    for text in axis.clabel(lines, inline=False, **style):
        x, y = to_axes.transform(text.get_position())
        is_free = all(abs(x - u) > MIN_APART[0] or abs(y - v) > MIN_APART[1] for u, v in places.values())
        if is_free and 0.04 < x < 0.96 and 0.04 < y < 0.96:
            places[text.get_text()] = x, y
        text.remove()
    levels = np.asarray(lines.levels)
    for level in levels:
        if style["fmt"] % level in places:
            # Yellow and light green, the upper end of the colour map, would swallow white.
            is_light = level - levels[0] > 0.6 * np.ptp(levels)
            axis.clabel(lines, [level], colors="black" if is_light else "white", **style)


def _draw_lines(
    panels: np.ndarray, values: Mapping[str, np.ndarray], pressures: np.ndarray, temperatures: np.ndarray
) -> None:
    """Draw a map that has one pressure or one temperature only as a line over the other."""
    along_pressure = len(pressures) >= len(temperatures)
    x, name = (pressures, ("control pressure", "MPa gauge")) if along_pressure else (temperatures, ("temperature", "K"))
    for axis, (stroke, field) in zip(panels, values.items(), strict=True):
        axis.plot(x, field.ravel(), marker="o", ms=3)
        label_axes(axis, x=name, title=stroke)


def plot_velocities(archive: Archive, ambient_pressure: float, max_traces: int = 5) -> Figure:
    """Plot the velocity of the piston at several pressures, at the temperature in the middle (Fig. 9 of the paper).

    At most `max_traces` pressures are shown, as gauge above `ambient_pressure` [Pa abs].
    """
    v = archive.variables
    pressures, temperatures = grid_of(archive, ambient_pressure)
    middle = len(temperatures) // 2
    shown = spread_out(len(pressures), max_traces)
    time = v["time"].values * 1e3
    release = float(archive.provenance["pulse_s"]) * 1e3
    figure, panels = open_row(2, SIZE, sharey=True)
    last = 0.0
    for look, number in zip(looks_of(len(shown)), shown, strict=True):
        run = number * len(temperatures) + middle
        velocity = v["velocity"].values[run]

        # When the opening ends: after the release the piston moves because of the closing.
        moving = np.flatnonzero((np.abs(velocity) > 0.0) & (time < release))
        last = max(last, time[moving[-1]] if len(moving) else 0.0)

        # One trace holds both strokes: the closing counts from the release, and its speed towards the stop is positive.
        for axis, stroke, start, sign in zip(panels, STROKES, (0.0, release), (1.0, -1.0), strict=True):
            contact = sum(v[f"{stroke}_{name}"].values[run] for name in ("delay_s", "stroke_time_s")) * 1e3
            last = max(last, np.nan_to_num(contact))
            # The speed ends at contact, between two rows of the trace.
            row = np.searchsorted(time - start, contact)
            times = np.insert(time - start, row, [contact] * 2)
            speeds = np.insert(sign * velocity, row, [v[f"{stroke}_seating_speed_m_s"].values[run], 0.0])

            # Markers stand within the part of the trace that is shown, and at other rows for each pressure.
            first, end = np.searchsorted(times, (0.0, last))
            offset, step = spaced(max(int(end - first), 1), list(shown).index(number), len(shown))
            every: Look = {"markevery": (int(first) + offset, step), "ms": 3.5}
            axis.plot(times, speeds, lw=1.3, label=f"{pressures[number]:.3g}", **every, **look)

    # Limits come last, when the longest stroke is known.
    for axis, stroke in zip(panels, STROKES, strict=True):
        label_axes(axis, x=("time after the command", "ms"), title=f"{stroke}, {temperatures[middle]:g} K")
        axis.set_xlim(0.0, last + 2.0)
        axis.set_ylim(bottom=0.0)
    label_axes(panels[0], y=("speed of the piston", "m/s"))
    add_figure_legend(figure, panels[1].get_legend_handles_labels()[0], title="control pressure [MPa gauge]")
    return figure


def limit_figures(archive: Archive, ambient_pressure: float, folder: str | PathLike[str]) -> list[Path]:
    """Write the figure of a map of working limits as PNG and PDF into a folder that is made if need be.

    The archive holds limits over pressure, temperature and duty, see `valve_limit`; gauge pressures stand above
    `ambient_pressure` [Pa abs].
    """
    figures = {"working_limit": partial(_plot_limits, archive, ambient_pressure)}
    sections = (*VALVE_SECTIONS, "command")  # the window of its own point is that of the command
    return write_figures(figures, folder, conditions_of(archive.machine, CONTROL_AIR, sections=sections))


def _plot_limits(archive: Archive, ambient_pressure: float) -> Figure:
    """Plot the working limit over pressure, with the legend beside it; see `draw_limits`."""
    figure, axis = open_one((7.8, 4.2))
    draw_limits(axis, archive, ambient_pressure)
    figure.legend(loc="outside right upper")
    return figure


def _rpm_of(hz: Any) -> Any:
    """Speed at one event a revolution [r/min]."""
    return 60.0 * hz


def _hz_of(rpm: Any) -> Any:
    """Working rate at one event a revolution [Hz]."""
    return rpm / 60.0


def draw_limits(axis: Axes, archive: Archive, ambient_pressure: float) -> Axes:
    """Draw the working limit over pressure, a line for each temperature and duty; `ambient_pressure` in [Pa abs]."""
    v = columns_of(archive)
    of_grid = {name: values[v["point"] != Point.OWN] for name, values in v.items()}
    common: Look = {"ambient_pressure": ambient_pressure}
    draw_over_pressure(axis, of_grid, "limit_hz", parameter="duty", label="duty {:g}", **common)
    own = own_run(v)
    draw_own_point(axis, v, "limit_hz", more=f"duty {v['duty'][own]:.3g}", **common)
    title = "Every stroke complete"
    if not np.isnan(v["rule_lap_to_lap_s"][own]):
        title += f"; at its own point above the lap for {1e3 * v['rule_lap_to_lap_s'][own]:.2f} ms"
    label_axes(axis, x=("control pressure", "MPa gauge"), y=("highest working rate", "Hz"), title=title)
    axis.set_ylim(bottom=0.0)
    side = axis.secondary_yaxis("right", functions=(_rpm_of, _hz_of))
    side.set_ylabel(named("engine speed, one event a revolution", "r/min"))
    return axis
