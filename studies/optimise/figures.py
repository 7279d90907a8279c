"""Figures of the best commands over speed."""

from collections.abc import Mapping
from functools import partial
from os import PathLike
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from apesim.archive import Archive
from apesim.studies.drawing.conditions import conditions_of
from apesim.studies.drawing.files import write_figures
from apesim.studies.drawing.panels import (
    MAX_SPECIFIC_AIR,
    add_figure_legend,
    add_legend_entry,
    columns_of,
    draw_zero,
    gauge_in_mpa,
    label_axes,
    open_one,
    open_row,
)
from apesim.studies.drawing.style import BLUE, RED, looks_of

LOOKS = {
    "fixed": ("0.45", "x", "fixed"),
    "most_torque": (RED, "o", "for most torque"),
    "least_air": (BLUE, "s", "for least specific air"),
}
"""Colour, marker and name of the commands: the machine's own, and those for each goal."""
ANGLES = {
    "energise": ("energise_deg", BLUE, "o--"),
    "opens": ("valve_open_deg", BLUE, "o-"),
    "release": ("release_deg", RED, "s--"),
    "closes": ("valve_close_deg", RED, "s-"),
}
"""Column, colour, marker and style of each angle."""
SPEED = ("speed", "r/min")
"""Name and unit of the x axis of most panels."""


def optimise_figures(archive: Archive, ambient_pressure: float, folder: str | PathLike[str]) -> list[Path]:
    """Write all figures of the best commands as PNG and PDF into a folder, made if it does not exist.

    `archive` is as `apesim.studies.optimise.table.archive_of` gives it; gauge pressures stand above `ambient_pressure`
    [Pa abs].
    """
    figures = {
        "optimum_angles": partial(_plot_angles, archive),
        "optimum_torque_and_air": partial(_plot_torque_and_air, archive),
    }
    if "point" in archive.variables:
        figures["pareto_fronts"] = partial(_plot_fronts, archive)
    if any(name.endswith("_bound_supply_pressure") for name in archive.variables):
        figures["optimum_pressure"] = partial(_plot_pressures, archive, ambient_pressure)
    free = ("supply.pressure",) if "optimum_pressure" in figures else ()
    return write_figures(figures, folder, conditions_of(archive.machine, free))


def _kinds(v: Mapping[str, np.ndarray]) -> list[str]:
    """The machine's own commands, and those for each goal that was looked for."""
    return [kind for kind in LOOKS if f"{kind}_energise_deg" in v]


def _plot_angles(archive: Archive) -> Figure:
    """Plot commands over speed, and when the valve really opens and closes by them."""
    kinds = _kinds(columns_of(archive))
    figure, panels = open_row(len(kinds), (3.1 * len(kinds) + 1.2, 4.1), sharey=True)
    for axis, kind in zip(panels, kinds, strict=True):
        _draw_angles(axis, archive, kind)
    label_axes(panels[0], y=("crank angle after TDC", "deg"))
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside right center")
    return figure


def _draw_angles(axis: Axes, archive: Archive, kind: str) -> Axes:
    """Draw commands of a kind over speed, and between which angles the valve is open by them."""
    v = columns_of(archive)
    open_, close = v[f"{kind}_valve_open_deg"], v[f"{kind}_valve_close_deg"]
    axis.fill_between(v["speed_rpm"], open_, close, color="0.94", lw=0)
    for label, (name, colour, style) in ANGLES.items():
        axis.plot(v["speed_rpm"], v[f"{kind}_{name}"], style, color=colour, ms=3, label=label)
    draw_zero(axis)
    label_axes(axis, x=SPEED, title=LOOKS[kind][2])
    return axis


def _plot_torque_and_air(archive: Archive) -> Figure:
    """Plot brake torque and specific air over speed, at their best and with the machine's own commands."""
    figure, (left, right) = open_row(2)
    draw_over_speed(left, archive, "brake_torque_Nm")
    draw_over_speed(right, archive, "specific_air_kg_per_kWh")
    draw_zero(left)
    label_axes(left, y=("brake torque", "N m"), title="Torque")
    label_axes(right, y=("specific air", "kg/kWh"), title="All air, control air counted, over brake work")
    right.set_ylim(0.0, MAX_SPECIFIC_AIR)
    add_figure_legend(figure, left.get_legend_handles_labels()[0])
    return figure


def draw_over_speed(axis: Axes, archive: Archive, column: str) -> Axes:
    """Draw a result of each kind of commands over speed; `column` names it, e.g. "brake_torque_Nm"."""
    v = columns_of(archive)
    for kind in _kinds(v):
        colour, marker, label = LOOKS[kind]
        axis.plot(v["speed_rpm"], v[f"{kind}_{column}"], color=colour, marker=marker, ms=4, label=label)
    label_axes(axis, x=SPEED)
    return axis


def _plot_fronts(archive: Archive) -> Figure:
    """Plot the Pareto fronts, with the legend beside them."""
    figure, axis = open_one((7.6, 4.6))
    _draw_fronts(axis, archive)
    figure.legend(loc="outside right upper", title="speed [r/min]")
    return figure


def _draw_fronts(axis: Axes, archive: Archive) -> Axes:
    """Draw the Pareto front of torque and specific air at each speed, beside the machine's own commands."""
    v = columns_of(archive)
    for run, (speed, look) in enumerate(zip(v["speed_rpm"], looks_of(len(v["speed_rpm"])), strict=True)):
        x, y = v["front_brake_torque_Nm"][run], v["front_specific_air_kg_per_kWh"][run]
        axis.plot(x, y, ms=3, label=f"{speed:g}", **look)
        own = v["fixed_brake_torque_Nm"][run], v["fixed_specific_air_kg_per_kWh"][run]
        axis.plot(*own, color=look["color"], marker="x", ms=7, mew=1.6, lw=0, zorder=3)
    add_legend_entry(axis, "fixed", color="0.3", marker="x", ms=7, mew=1.6, lw=0)
    title = "Pareto fronts of torque and all air over brake work"
    label_axes(axis, x=("brake torque", "N m"), y=("specific air", "kg/kWh"), title=title)
    axis.set_xlim(left=0.0)
    axis.set_ylim(top=min(axis.get_ylim()[1], MAX_SPECIFIC_AIR))
    return axis


def _plot_pressures(archive: Archive, ambient_pressure: float) -> Figure:
    """Plot the best supply pressure over speed, with the legend beside it."""
    figure, axis = open_one((6.6, 3.6))
    _draw_pressures(axis, archive, ambient_pressure)
    figure.legend(loc="outside right center")
    return figure


def _draw_pressures(axis: Axes, archive: Archive, ambient_pressure: float) -> Axes:
    """Draw the best supply pressure over speed."""
    v = columns_of(archive)
    for size, kind in zip((6, 9, 4), LOOKS, strict=True):  # goals often share the pressure: let both be seen
        if kind in _kinds(v):
            colour, marker, label = LOOKS[kind]
            gauge = gauge_in_mpa(v[f"{kind}_supply_pressure"], ambient_pressure)
            axis.plot(v["speed_rpm"], gauge, color=colour, marker=marker, ms=size, lw=0.4 * size, label=label)
    label_axes(axis, x=SPEED, y=("supply pressure", "MPa gauge"))
    axis.set_ylim(0.0, 1.1 * axis.get_ylim()[1])
    return axis
