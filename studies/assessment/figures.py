"""Figures of an assessment: what each cause costs over speed, and where the exergy goes."""

from functools import partial
from os import PathLike
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from apesim.archive import Archive
from apesim.studies.assessment.causes import CAUSES, ENTERS, EXERGY, ORDERS
from apesim.studies.drawing.conditions import conditions_of
from apesim.studies.drawing.files import write_figures
from apesim.studies.drawing.panels import add_figure_legend, draw_zero, label_axes, open_row
from apesim.studies.drawing.style import BLUE, MARKERS, RED, Look

COLOURS = {"lateness": BLUE, "finite_speed": "#e0a030", "fluctuation": "#7a4e9c", "control_air": RED}
"""Colour of each cause."""
NAMES = {
    "lateness": "lateness",
    "finite_speed": "finite speed",
    "fluctuation": "of it fluctuation",
    "control_air": "control air",
}
"""Name of each cause in legends."""
CORNERS = {
    "ideal": "ideal: on time, at once",
    "late_at_once": "late, at once",
    "on_time_real_lift": "on time, real lift",
    "real": "real: late, real lift, control air",
}
"""Valves whose exergy is drawn, and the titles of their panels."""
EXERGY_COLOURS = {
    "indicated_work": ("indicated work", "#3a7d44", ""),
    "exhaust": ("exhaust", "#9aa5b1", "..."),
    "groove": ("groove", "#e0a030", "///"),
    "feed": ("feed", BLUE, "xxx"),
    "valve_drive": ("valve drive", RED, "\\\\\\"),
    "other": ("mixing and other", "#7a4e9c", "|||"),
}
"""Name, colour and stripes of where exergy goes."""
MAX_OVER_MEDIAN = 4.0
"""Values beyond this many times the median of the sums are cut off: a single point near stalling would else press all
others on the zero line."""
SPEED = ("speed", "r/min")
"""Name and unit of the x axis of all panels."""
MARKS = "dots: mean of both orders; bars: from lateness first (end with a tick) to finite speed first"
"""What dots and bars of losses mean."""
LEGEND_SIZE = 9.5
"""Size of the letters of the legends, which are few and wide [pt]."""


def assessment_figures(archive: Archive, folder: str | PathLike[str]) -> list[Path]:
    """Write all figures of an assessment as PNG and PDF into a folder, made if it does not exist.

    `archive` is as `apesim.studies.assessment.grid.assess_speeds` gives it.
    """
    figures = {"losses": partial(_plot_losses, archive), "exergy": partial(_plot_exergy, archive)}
    timing = f"{archive.provenance['timing']} timing"
    return write_figures(figures, folder, conditions_of(archive.machine, more=timing))


def _plot_losses(archive: Archive) -> Figure:
    """Plot torque lost and air added by each cause over speed: mean of both orders, and the span between them."""
    figure, (left, right) = open_row(2, (10.4, 4.6), sharex=True)
    label_axes(left, y=("brake torque lost", "N m"))
    label_axes(right, y=("air over brake work added", "kg/kWh"))
    draw_losses(left, archive, "brake_torque_lost_Nm", title="Torque lost against the ideal valve; below zero: gained")
    draw_losses(right, archive, "specific_air_added_kg_per_kWh", title="Air added to that of the ideal valve")
    handles = left.get_legend_handles_labels()[0]
    add_figure_legend(figure, handles, title=MARKS, fontsize=LEGEND_SIZE, title_fontsize=9)
    return figure


def draw_losses(axis: Axes, archive: Archive, name: str, title: str = "") -> Axes:
    """Draw a loss by each cause over speed: the mean as a line, both orders as the ends of a bar, and the sum.

    `name` is "brake_torque_lost_Nm" or "specific_air_added_kg_per_kWh"; what is not shown is said behind the `title`.
    """
    v = archive.variables
    speed, parts = v["speed_rpm"].values, v[name].values
    first, other, mean = (parts[:, number] for number in range(len(ORDERS)))
    step = 0.12 * np.diff(np.sort(speed)).min() if len(speed) > 1 else 0.01 * speed[0]
    draw_zero(axis, colour="0.2", width=0.9)
    for number, cause in enumerate(CAUSES):
        x = speed + step * (number - 1.5)
        look: Look = {"color": COLOURS[cause], "lw": 1.2, "ls": "--" if cause == "fluctuation" else "-"}
        axis.plot(x, mean[:, number], marker=MARKERS[number], ms=4, label=NAMES[cause], **look)
        axis.vlines(x, first[:, number], other[:, number], color=COLOURS[cause], lw=1.6, alpha=0.6)
        axis.plot(x, first[:, number], "_", color=COLOURS[cause], ms=6)
    total = _total_of(mean)
    axis.plot(speed, total, "D", color="white", mec="black", ms=4.5, label="sum")
    label_axes(axis, x=SPEED)
    if len(speed) == 1:
        axis.set_xticks(speed)
    label_axes(axis, title="\n".join([title] * bool(title) + _cut_off(axis, total, parts)))
    return axis


def _total_of(mean: np.ndarray) -> np.ndarray:
    """Sum over the causes but fluctuation, which is a part of finite speed."""
    parts = (mean[:, number] for number, cause in enumerate(CAUSES) if cause != "fluctuation")
    return sum(parts, np.zeros(len(mean)))


def _cut_off(axis: Axes, total: np.ndarray, parts: np.ndarray) -> list[str]:
    """Cut off what is far beyond most, and say so in a line; say, too, where sums are undefined."""
    notes = []
    if np.isnan(total).any():
        notes.append("no sum where air over work is undefined")
    known = total[~np.isnan(total)]
    highest = MAX_OVER_MEDIAN * np.median(np.abs(known)) if len(known) else np.inf
    if np.nanmax(np.abs(parts), initial=0.0) > highest:
        axis.set_ylim(1.1 * max(np.nanmin(parts), -0.25 * highest), highest)
        notes.append("cut off")
    return [f"({'; '.join(notes)})"] if notes else []


def _plot_exergy(archive: Archive) -> Figure:
    """Plot where the exergy of a cycle goes, over speed, with each valve between the ideal and the real one."""
    figure, panels = open_row(len(CORNERS), (12.4, 4.2), sharex=True, sharey=True)
    for axis, (valve, title) in zip(panels, CORNERS.items(), strict=True):
        _draw_exergy(axis, archive, valve)
        label_axes(axis, x=SPEED, title=title)
    label_axes(panels[0], y=("exergy in a cycle", "J"))
    add_figure_legend(figure, panels[0].get_legend_handles_labels()[0], fontsize=LEGEND_SIZE)
    return figure


def _draw_exergy(axis: Axes, archive: Archive, valve: str) -> Axes:
    """Draw where exergy goes with a valve over speed as bars, what is negative below zero; dots: what comes in."""
    v = archive.variables
    place = v["valve"].values.tolist().index(valve)
    speed = v["speed_rpm"].values
    terms = {name: np.nan_to_num(v[f"exergy_{name}_J"].values[:, place]) for name in EXERGY}
    width = 0.8 * np.diff(np.sort(speed)).min() if len(speed) > 1 else 0.05 * speed[0]
    top, bottom = np.zeros(len(speed)), np.zeros(len(speed))
    for name, (label, colour, stripes) in EXERGY_COLOURS.items():
        start = np.where(terms[name] >= 0.0, top, bottom)
        axis.bar(speed, terms[name], width, bottom=start, fc=colour, ec="white", lw=0, hatch=stripes, label=label)
        top, bottom = top + np.maximum(terms[name], 0.0), bottom + np.minimum(terms[name], 0.0)
    axis.plot(speed, sum(terms[name] for name in ENTERS), "D", color="white", mec="black", ms=3.5, label="brought in")
    draw_zero(axis, colour="0.2", width=0.9)
    axis.grid(False, axis="x")
    if len(speed) == 1:
        axis.set_xticks(speed)
    return axis
