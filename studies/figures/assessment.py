"""Figures of an assessment: what each cause costs over speed, and where the exergy goes."""

import matplotlib.pyplot as plt
import numpy as np

from apesim.studies.assessment.causes import CAUSES, ENTERS, EXERGY, ORDERS
from apesim.studies.figures.conditions import conditions_of
from apesim.studies.figures.style import draw

COLOURS = {"lateness": "#2a6f97", "finite_speed": "#e0a030", "fluctuation": "#7a4e9c", "control_air": "#c1440e"}
NAMES = {
    "lateness": "lateness",
    "finite_speed": "finite speed",
    "fluctuation": "of it fluctuation",
    "control_air": "control air",
}
CORNERS = {
    "ideal": "ideal: on time, at once",
    "late_at_once": "late, at once",
    "on_time_real_lift": "on time, real lift",
    "real": "real: late, real lift, control air",
}
"""Valves whose exergy is drawn."""
EXERGY_COLOURS = {
    "indicated_work": ("indicated work", "#3a7d44"),
    "exhaust": ("exhaust", "#9aa5b1"),
    "groove": ("groove", "#e0a030"),
    "feed": ("feed", "#2a6f97"),
    "valve_drive": ("valve drive", "#c1440e"),
    "other": ("mixing and other", "#7a4e9c"),
}
CUT = 4.0
"""Values beyond this many times the median of the sums are cut off."""


def assessment_figures(archive, folder):
    """All figures of an assessment.

    Parameters
    ----------
    archive : Archive
        See `apesim.studies.assessment.grid.assess_speeds`.
    folder : path
        Made if it does not exist.

    Returns
    -------
    list of Path
    """
    figures = {"losses": lambda: losses(archive), "exergy": lambda: ledgers(archive)}
    return draw(figures, folder, conditions_of(archive.machine))


def losses(archive):
    """Torque lost and air added by each cause over speed: mean of both orders, and the span between them.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.4, 4.6), layout="constrained", sharex=True)
    left.set(ylabel="brake torque lost [N m]", title="Torque lost against the ideal valve; below zero: gained")
    right.set(ylabel="air over brake work added [kg/kWh]", title="Air added to that of the ideal valve")
    spans(left, archive, "brake_torque_lost_Nm")
    spans(right, archive, "specific_air_added_kg_per_kWh")
    handles, labels = left.get_legend_handles_labels()
    title = "dots: mean of both orders; bars: from lateness first (end with a tick) to finite speed first"
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), title=title, title_fontsize=9)
    return figure


def spans(axis, archive, name):
    """A loss by each cause over speed: the mean as a line, both orders as the ends of a bar, and the sum of all."""
    v = archive.variables
    speed, parts = v["speed_rpm"].values, v[name].values
    first, other, mean = (parts[:, number] for number in range(len(ORDERS)))
    apart = 0.12 * np.diff(np.sort(speed)).min() if len(speed) > 1 else 0.01 * speed[0]
    axis.axhline(0.0, color="0.2", lw=0.9)
    for number, cause in enumerate(CAUSES):
        x = speed + apart * (number - 1.5)
        look = {"color": COLOURS[cause], "lw": 1.2, "ls": "--" if cause == "fluctuation" else "-"}
        axis.plot(x, mean[:, number], marker="o", ms=3, label=NAMES[cause], **look)
        axis.vlines(x, first[:, number], other[:, number], color=COLOURS[cause], lw=1.6, alpha=0.6)
        axis.plot(x, first[:, number], "_", color=COLOURS[cause], ms=6)
    total = total_of(mean)
    axis.plot(speed, total, "D", color="white", mec="black", ms=4.5, label="sum")
    axis.set_xlabel("speed [r/min]")
    if len(speed) == 1:
        axis.set_xticks(speed)
    cut(axis, total, parts)


def total_of(mean):
    """Sum over the causes but fluctuation, which is a part of finite speed."""
    return sum(mean[:, number] for number, cause in enumerate(CAUSES) if cause != "fluctuation")


def cut(axis, total, parts):
    """Cut off what is far beyond most, and say so; say, too, where sums are undefined."""
    notes = []
    if np.isnan(total).any():
        notes.append("no sum where air over work is undefined")
    known = total[~np.isnan(total)]
    highest = CUT * np.median(np.abs(known)) if len(known) else np.inf
    if np.nanmax(np.abs(parts), initial=0.0) > highest:
        axis.set_ylim(1.1 * max(np.nanmin(parts), -0.25 * highest), highest)
        notes.append("cut off")
    if notes:
        axis.set_title(f"{axis.get_title()}\n({'; '.join(notes)})")


def ledgers(archive):
    """Draw where the exergy of a cycle goes, over speed, with each valve between the ideal and the real one.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = plt.subplots(1, len(CORNERS), figsize=(12.4, 4.2), layout="constrained", sharex=True, sharey=True)
    for axis, (valve, title) in zip(axes, CORNERS.items(), strict=True):
        axis.set(title=title, xlabel="speed [r/min]")
        stack(axis, archive, valve)
    axes[0].set_ylabel("exergy in a cycle [J]")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def stack(axis, archive, valve):
    """Bars of where exergy goes with a valve over speed, what is negative below the zero line; dots: what comes in."""
    v = archive.variables
    at = v["valve"].values.tolist().index(valve)
    speed = v["speed_rpm"].values
    terms = {name: np.nan_to_num(v[f"exergy_{name}_J"].values[:, at]) for name in EXERGY}
    width = 0.8 * np.diff(np.sort(speed)).min() if len(speed) > 1 else 0.05 * speed[0]
    up, down = np.zeros(len(speed)), np.zeros(len(speed))
    for name, (label, colour) in EXERGY_COLOURS.items():
        axis.bar(speed, terms[name], width, bottom=np.where(terms[name] >= 0.0, up, down), color=colour, label=label)
        up, down = up + np.maximum(terms[name], 0.0), down + np.minimum(terms[name], 0.0)
    axis.plot(speed, sum(terms[name] for name in ENTERS), "D", color="white", mec="black", ms=3.5, label="brought in")
    axis.axhline(0.0, color="0.2", lw=0.9)
    axis.grid(False, axis="x")
    if len(speed) == 1:
        axis.set_xticks(speed)
