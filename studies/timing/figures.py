"""Figures of corrected commands over speed, pressure and temperature."""

from collections.abc import Callable
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from apesim.engine.angles import DEGREE, TURN
from apesim.studies.drawing.conditions import conditions_of, supply_keys_of
from apesim.studies.drawing.files import write_figures
from apesim.studies.drawing.panels import (
    MAX_SPECIFIC_AIR,
    add_figure_legend,
    add_legend_entry,
    draw_zero,
    gauge_in_mpa,
    label_axes,
    open_row,
)
from apesim.studies.drawing.style import Look, looks_of
from apesim.studies.timing.grid import TimingMap

SPEED = ("speed", "r/min")
"""Name and unit of the x axis of most panels."""
DASHED: Look = {"lw": 1.0, "ls": "--", "ms": 3.5, "mfc": "white"}
"""Look of what corrected commands are compared with; its markers are hollow."""
BY_BENCH = "by the delay on the bench"
"""What the dashed lines of an advance are."""


def timing_figures(timing_map: TimingMap, ambient_pressure: float, folder: str | PathLike[str]) -> list[Path]:
    """Write all figures of a map of corrected commands, each as PNG and PDF, into a folder that is made if need be.

    Gauge pressures stand above `ambient_pressure` [Pa abs].
    """
    plots: dict[str, Callable] = {"advance": _plot_advances, "won_back": _plot_won_back, "shortcut": _plot_shortcut}
    if timing_map.laws["advance"]:
        plots["temperature_law"] = _plot_temperature_law
    figures = {name: partial(plot, timing_map, ambient_pressure) for name, plot in plots.items()}
    return write_figures(figures, folder, conditions_of(timing_map.archive.machine, supply_keys_of(timing_map.archive)))


def _columns(timing_map: TimingMap) -> dict[str, np.ndarray]:
    """Results on the axes (speed, pressure, temperature)."""
    return {
        name: variable.values.reshape(timing_map.axes.shape)
        for name, variable in timing_map.archive.variables.items()
        if name != "run"
    }


def _pressures(axes: Any, ambient_pressure: float) -> list[tuple[int, Look, str]]:
    """Number, look and label of each pressure."""
    looks = looks_of(len(axes.pressures))
    labels = [f"{gauge_in_mpa(pressure, ambient_pressure):.3g} MPa gauge" for pressure in axes.pressures]
    return list(zip(range(len(labels)), looks, labels, strict=True))


def _middle(axes: Any) -> tuple[int, str]:
    """Number of the temperature in the middle, and its text."""
    number = len(axes.temperatures) // 2
    return number, f"{axes.temperatures[number]:g} K"


def _plot_advances(timing_map: TimingMap, ambient_pressure: float) -> Figure:
    """Plot the advance of energising and release over speed; thin, what the delays of the bench would give."""
    figure, panels = open_row(2, sharey=True)
    for axis, edge in zip(panels, ("energise", "release"), strict=True):
        draw_advance(axis, timing_map, ambient_pressure, edge=edge)
    add_legend_entry(panels[0], BY_BENCH, **DASHED)
    label_axes(panels[0], y=("target less command angle", "deg"))
    panels[0].set_ylim(bottom=0.0)
    add_figure_legend(figure, panels[0].get_legend_handles_labels()[0])
    return figure


def draw_advance(axis: Axes, timing_map: TimingMap, ambient_pressure: float, *, edge: str) -> Axes:
    """Draw the advance of one command edge over speed, a colour for each pressure, at the temperature in the middle.

    `edge` is "energise" or "release"; pressures are shown as gauge, above `ambient_pressure` [Pa abs].

    >>> from apesim.archive import Archive
    >>> from apesim.archive.columns import column
    >>> from apesim.engine.machine import Machine
    >>> from apesim.studies.drawing.panels import open_one
    >>> from apesim.studies.timing.table import Axes as Points
    >>> values = {"speed_rpm": [600.0, 900.0], "advance_deg": [30.0, 45.0], "shortcut_energise_deg": [-33.0, -48.0]}
    >>> archive = Archive("", {}, {name: column(numbers, "1", name) for name, numbers in values.items()})
    >>> points = Points(np.array([62.8, 94.2]), np.array([1.1e6]), np.array([287.0]))
    >>> nothing: Any = None
    >>> timing_map = TimingMap(archive, Machine().command, points, nothing, nothing, {}, nothing)
    >>> _, axis = open_one()
    >>> axis = draw_advance(axis, timing_map, 0.1e6, edge="energise")
    >>> axis.lines[0].get_label(), axis.lines[0].get_ydata().tolist()
    ('1 MPa gauge', [30.0, 45.0])
    """
    axes, v = timing_map.axes, _columns(timing_map)
    k, temperature = _middle(axes)
    speed, command = v["speed_rpm"][:, 0, k], timing_map.command
    advance, target = {
        "energise": ("advance_deg", command.open_target),
        "release": ("release_advance_deg", command.close_target),
    }[edge]
    for j, look, label in _pressures(axes, ambient_pressure):
        by_bench = target / DEGREE - v[f"shortcut_{edge}_deg"][:, j, k]
        axis.plot(speed, v[advance][:, j, k], ms=3, label=label, **look)
        axis.plot(speed, by_bench, **look, **DASHED)
    label_axes(axis, x=SPEED, title=f"{edge}, {temperature}")
    return axis


def _plot_won_back(timing_map: TimingMap, ambient_pressure: float) -> Figure:
    """Plot brake torque and specific air over speed, corrected and with the machine's own commands."""
    _, temperature = _middle(timing_map.axes)
    figure, (left, right) = open_row(2)
    _draw_won_back(left, timing_map, ambient_pressure, column="brake_torque_Nm")
    _draw_won_back(right, timing_map, ambient_pressure, column="specific_air_kg_per_kWh")
    draw_zero(left)
    add_legend_entry(left, "fixed", **DASHED)
    label_axes(left, y=("brake torque", "N m"), title=f"Torque, {temperature}")
    label_axes(right, y=("specific air", "kg/kWh"), title="All air, control air counted, over brake work")
    right.set_ylim(0.0, MAX_SPECIFIC_AIR)
    add_figure_legend(figure, left.get_legend_handles_labels()[0])
    return figure


def _draw_won_back(axis: Axes, timing_map: TimingMap, ambient_pressure: float, *, column: str) -> Axes:
    """Draw a result over speed with corrected commands, and dashed with the machine's own."""
    axes, v = timing_map.axes, _columns(timing_map)
    k, _ = _middle(axes)
    speed = v["speed_rpm"][:, 0, k]
    for j, look, label in _pressures(axes, ambient_pressure):
        axis.plot(speed, v[column][:, j, k], ms=3, label=label, **look)
        axis.plot(speed, v[f"fixed_{column}"][:, j, k], **look, **DASHED)
    label_axes(axis, x=SPEED)
    return axis


def _plot_shortcut(timing_map: TimingMap, ambient_pressure: float) -> Figure:
    """Plot the error of opening and closing if commands stand the delay of the bench before their targets."""
    axes, v = timing_map.axes, _columns(timing_map)
    k, temperature = _middle(axes)
    figure, panels = open_row(2)
    speed = v["speed_rpm"][:, 0, k]
    for axis, name in zip(panels, ("open", "close"), strict=True):
        for j, look, label in _pressures(axes, ambient_pressure):
            axis.plot(speed, v[f"shortcut_{name}_error_deg"][:, j, k], ms=3, label=label, **look)
        draw_zero(axis)
        axis.set_xlim(speed[0] - 50.0, speed[-1] + 50.0)
        title = f"{name.removesuffix('e')}ing, {temperature}"
        label_axes(axis, x=SPEED, y=("true less target angle", "deg"), title=title)
    title = "a line ends where the shortcut does not open the valve"
    add_figure_legend(figure, panels[1].get_legend_handles_labels()[0], title=title)
    return figure


def _plot_temperature_law(timing_map: TimingMap, ambient_pressure: float) -> Figure:
    """Plot the advance as a time over the temperature, with straight lines, at the speed in the middle."""
    axes, v = timing_map.axes, _columns(timing_map)
    i = len(axes.speeds) // 2
    figure, panels = open_row(2)
    ends = axes.temperatures[[0, -1]]
    for axis, name, title in zip(panels, ("advance", "release_advance"), ("energise", "release"), strict=True):
        for j, look, label in _pressures(axes, ambient_pressure):
            times = v[f"{name}_deg"][i, j] * DEGREE / axes.speeds[i] * 1e3
            axis.plot(axes.temperatures, times, ms=4, lw=0, label=label, **look)
            for law in timing_map.laws[name]:
                if law.speed == axes.speeds[i] and law.pressure == axes.pressures[j]:
                    axis.plot(ends, 1e3 * (law.at_reference + law.slope * (ends - 287.0)), color=look["color"], lw=1)
        at_speed = f"{axes.speeds[i] / TURN * 60.0:.5g} r/min"
        temperature = ("temperature of the control air", "K")
        label_axes(axis, x=temperature, y=("advance as a time", "ms"), title=f"{title}, {at_speed}")
    add_figure_legend(figure, panels[0].get_legend_handles_labels()[0])
    return figure
