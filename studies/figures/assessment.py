"""Figures of an assessment: what each cause costs over speed."""

import matplotlib.pyplot as plt
import numpy as np

from studies.assessment.chain import CAUSES
from studies.figures.style import draw

COLOURS = {"delay": "#2a6f97", "finite_speed": "#e0a030", "fluctuation": "#7a4e9c", "control_air": "#c1440e"}
NAMES = {
    "delay": "delay",
    "finite_speed": "finite speed",
    "fluctuation": "fluctuation",
    "control_air": "control air",
}
CUT = 4.0
"""Bars longer than this many medians are cut."""


def assessment_figures(archive, folder):
    """All figures of an assessment.

    Parameters
    ----------
    archive : Archive
        See `studies.assessment.grid.assess_speeds`.
    folder : path
        Made if it does not exist.

    Returns
    -------
    list of Path
    """
    return draw({"losses": lambda: losses(archive)}, folder)


def losses(archive):
    """Torque lost and air added by each cause, stacked over speed.

    Parameters
    ----------
    archive : Archive

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.4, 4.2), layout="constrained")
    left.set(ylabel="brake torque lost [N m]", title="Torque lost against the ideal valve; below zero: gained")
    right.set(ylabel="air over brake work added [kg/kWh]", title="Air added to that of the ideal valve")
    stack(left, archive, "brake_torque_lost_Nm")
    stack(right, archive, "specific_air_added_kg_per_kWh")
    handles = dict(zip(*reversed(right.get_legend_handles_labels()), strict=True))
    order = [name for name in (*NAMES.values(), "sum", "undefined") if name in handles]
    figure.legend([handles[name] for name in order], order, loc="outside lower center", ncols=len(order))
    return figure


def stack(axis, archive, name):
    """Bars of a loss over speed, gains below the zero line; a mark for the sum, a cross where it is undefined."""
    v = archive.variables
    speed, parts = v["speed_rpm"].values, v[name].values
    width = 0.7 * np.diff(np.sort(speed)).min() if len(speed) > 1 else 0.05 * speed[0]
    defined = ~np.isnan(parts).any(axis=1)
    up, down = np.zeros(len(speed)), np.zeros(len(speed))
    for number, cause in enumerate(CAUSES):
        part = np.where(defined, parts[:, number], 0.0)
        axis.bar(speed, part, width, bottom=np.where(part >= 0.0, up, down), color=COLOURS[cause], label=NAMES[cause])
        up, down = up + np.maximum(part, 0.0), down + np.minimum(part, 0.0)
    total = up + down
    axis.axhline(0.0, color="0.2", lw=0.9)
    axis.plot(speed[defined], total[defined], "D", color="white", mec="black", ms=4.5, label="sum")
    if not defined.all():
        axis.plot(speed[~defined], 0.0 * speed[~defined], "x", color="0.4", ms=5, label="undefined")
    axis.use_sticky_edges = False  # so that marks on top are whole
    axis.set_xlabel("speed [r/min]")
    axis.grid(False, axis="x")
    if defined.any():
        cut(axis, *(values[defined] for values in (speed, up, down, total)))


def cut(axis, speed, up, down, total):
    """Cut bars that are far longer than most, and write the sum into each."""
    most = CUT * np.median(up - down)
    long = np.maximum(up, -down) > most
    if not long.any():
        return
    top, bottom = up[~long].max(), down[~long].min()
    axis.set_title(f"{axis.get_title()}; bars that are cut bear their sum")
    axis.set_ylim(min(1.4 * bottom, -0.15 * top), 1.4 * top)
    for x, sum_of in zip(speed[long], total[long], strict=True):
        axis.text(x, 1.38 * top, f"sum {sum_of:.0f}", rotation=90, ha="center", va="top", fontsize=8, color="0.1")
