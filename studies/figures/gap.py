"""Figures of the missing-effect workflow."""

from itertools import groupby

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Patch

from apesim.studies.figures.style import STYLE, save, svg
from apesim.studies.gap.decide.operating_points import label_of
from apesim.studies.gap.report.comparison import by_run, shown_of, size_of, worst
from apesim.studies.gap.report.effect_rows import NORMAL_95
from apesim.studies.gap.report.residual_map import residual_map
from apesim.studies.gap.search.phases import PHASES, phases
from apesim.studies.measured import CHECK, ENGINE, FIT, GATE

MEASURED, BEFORE, AFTER = "0.55", "#c1440e", "#2a6f97"
SHADES = {
    "dead time": "#e8e8e8",
    "opening flight": "#dcebf7",
    "impact": "#f9d9c8",
    "dwell": "#ffffff",
    "closing flight": "#e3f1dd",
    "charging": "#dcebf7",
    "expansion": "#ffffff",
    "exhaust": "#f3ead7",
}
WORDS = {CHECK: "never used", GATE: "used to judge", FIT: "fitted"}
MARKS = {CHECK: " *", GATE: " †", FIT: ""}
TICKS = (0, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000)
MEAN = 9
"""Samples of a running mean."""
SCALE = 4.0, 12.0
"""Least and largest end of a map's colours."""
WIDTH = 7.6


def draw_gap(compared, rows, added, ambient_pressure, folder, latent=()):
    """Draw all figures, and write them as PNG and PDF.

    Parameters
    ----------
    compared : list of apesim.studies.gap.report.comparison.Compared
    rows : list of apesim.studies.gap.report.html.Tried
        Candidates with what was expected of them and what came.
    added : str
        What was added to the model, in words.
    ambient_pressure : float
        [Pa abs]
    folder : path
        Is there.
    latent : sequence of apesim.studies.gap.tables.latent.Branch
        What a table says, where one was added.

    Returns
    -------
    dict of str
        SVG by name.
    """
    figures = {
        "gap": lambda: sizes(compared, added, ambient_pressure),
        "maps": lambda: maps(residual_map(compared), added, ambient_pressure),
    }
    if latent:
        figures["latent"] = lambda: quantities(latent)
    if rows:  # all of the library may be left out
        figures["candidates"] = lambda: candidates(rows)
    chosen = worst(compared, 3)
    if chosen:  # of an engine there may be means alone
        figures["overlays"] = lambda: overlays(chosen, added, ambient_pressure)
    found = {}
    with plt.rc_context(STYLE):
        for name, make in figures.items():
            figure = make()
            found[name] = svg(figure)
            save(figure, folder, name)
    return found


def sizes(compared, added, ambient_pressure):
    """The gap of each run before and after, over the noise."""
    runs = by_run(compared)
    figure, axis = plt.subplots(figsize=(WIDTH, 0.9 + 0.36 * len(runs)), layout="constrained")
    both = compared[0].left_after is not None
    place, labels, roles = 0.0, [], []
    for number, own in enumerate(runs):
        role = own[0].role
        place += 0.6 * bool(number and role != runs[number - 1][0].role)
        bars = [(size_of(one.left_before for one in own), BEFORE)]
        if both:
            bars.append((size_of(one.left_after for one in own), AFTER))
        for k, (size, colour) in enumerate(bars):
            height = 0.8 / len(bars)
            at = place - 0.4 + (k + 0.5) * height
            axis.barh(at, size, height=height, color=colour, alpha=1.0 if role == CHECK else 0.55)
            where = {"xytext": (3, 0), "textcoords": "offset points", "va": "center", "fontsize": 8, "zorder": 4}
            axis.annotate(f"{size:.2f}", (size, at), **where, bbox={"fc": "white", "ec": "none", "pad": 0.6})
        labels.append(f"{label_of(own[0].block.run, ambient_pressure)} ({WORDS[role]})")
        roles.append(place)
        place += 1.0
    axis.axvline(1.0, color="0.2", lw=1.0, ls="--")
    axis.set_yticks(roles, labels)
    axis.set_ylim(place - 0.4, -0.6)
    axis.grid(axis="y", visible=False)
    axis.set(xlabel="root mean square of what is left, over the noise")
    axis.margins(x=0.08)
    handles = [Patch(color=BEFORE, label="calibrated model"), Patch(color=AFTER, label=added)]
    handles = handles[: 1 + both]
    handles.append(plt.Line2D([], [], color="0.2", lw=1.0, ls="--", label="noise alone"))
    figure.legend(handles=handles, loc="outside upper right", ncols=3, fontsize=8.5)
    return figure


def quantities(latent):
    """What a table says, over what it was made to depend on."""
    figure, axes = plt.subplots(1, len(latent), figsize=(WIDTH, 2.9), layout="constrained", squeeze=False)
    for axis, branch in zip(axes[0], latent, strict=True):
        axis.axhline(0.0, color="0.2", lw=0.8)
        if len(branch.places) > 1:
            axis.plot(*branch.curve(), color=AFTER, lw=1.4)
        bars = {"fmt": "o", "color": AFTER, "ms": 4, "elinewidth": 1.0, "capsize": 2}
        axis.errorbar(branch.places, branch.values, NORMAL_95 * branch.deviations, **bars)
        axis.set(xlabel=branch.over, ylabel=branch.quantity.replace("^2", "²"))
        if branch.is_round:
            axis.set_xticks(range(0, 361, 90))
    return figure


def overlays(chosen, added, ambient_pressure):
    """The traces that the calibrated machine misses by most, with what it leaves of them."""
    size = (WIDTH, 0.8 + 2.8 * len(chosen))
    figure, axes = plt.subplots(
        2 * len(chosen), 1, figsize=size, layout="constrained", height_ratios=(2.4, 1) * len(chosen)
    )
    shades: dict = {}
    for above, below, one in zip(axes[::2], axes[1::2], chosen, strict=True):
        run, shown = one.block.run, shown_of(one.block)
        over = np.degrees(run.angles) if run.bench == ENGINE else one.block.times * 1e3
        shades |= _shade(above, over, one)
        above.plot(over, shown.of(one.block.values), ".", color=MEASURED, ms=3, label="measured")
        above.plot(over, shown.of(one.before), color=BEFORE, lw=1.2, label="calibrated model")
        below.axhspan(-2.0, 2.0, color="0.93", lw=0, zorder=0)
        _left(below, over, (one.before - one.block.values) / one.noise, BEFORE)
        if one.after is not None:
            above.plot(over, shown.of(one.after), color=AFTER, lw=1.2, ls="--", label=added)
            _left(below, over, (one.after - one.block.values) / one.noise, AFTER)
        above.set(ylabel=f"{shown.name} [{shown.unit}]")
        above.set_title(f"{label_of(run, ambient_pressure)}, {WORDS[one.role]}", loc="left")
        above.tick_params(labelbottom=False)
        below.set(ylabel="left [noise]")
        below.set_xlabel("crank angle [deg]" if run.bench == ENGINE else "time after the command [ms]")
        for axis in (above, below):
            axis.set_xlim(over[0], over[-1])
    figure.align_ylabels()
    handles, _ = axes[0].get_legend_handles_labels()
    handles += [Patch(facecolor=colour, edgecolor="0.7", lw=0.5, label=name) for name, colour in shades.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=8.5)
    return figure


def _left(axis, over, left, colour):
    """What is left: its samples pale, their running mean strong."""
    axis.plot(over, left, color=colour, lw=0.6, alpha=0.35)
    if len(left) > MEAN:
        mean = np.convolve(left, np.full(MEAN, 1.0 / MEAN), "valid")
        axis.plot(over[MEAN // 2 : MEAN // 2 + len(mean)], mean, color=colour, lw=1.3)


def _shade(axis, over, one):
    """Shade the phases of a run; the shades that were used."""
    of, used = phases(one.block, one.marks), {}
    for phase, samples in groupby(range(len(of)), key=of.__getitem__):
        inside = list(samples)
        name = PHASES[phase]
        end = over[min(inside[-1] + 1, len(over) - 1)]
        axis.axvspan(over[inside[0]], end, color=SHADES[name], zorder=0, lw=0)
        if SHADES[name] != "#ffffff":
            used[name] = SHADES[name]
    return used


def maps(found, added, ambient_pressure):
    """What is left of every signal over the stroke or cycle, before and after, on one scale.

    Parameters
    ----------
    found : apesim.studies.gap.report.residual_map.ResidualMap
    added : str
        What was added to the model, in words.
    ambient_pressure : float
        [Pa abs]
    """
    pictures = [picture for picture in (found.before, found.after) if picture is not None]
    limit = float(np.clip(np.nanquantile(np.abs(found.before), 0.98), *SCALE))
    size = (WIDTH, 1.6 + 0.21 * len(found.rows))
    figure, axes = plt.subplots(1, len(pictures), figsize=size, layout="constrained", sharey=True, squeeze=False)
    titles = ("calibrated model", added)
    for axis, picture, title in zip(axes[0], pictures, titles, strict=False):
        image = axis.imshow(picture, aspect="auto", cmap="RdBu_r", vmin=-limit, vmax=limit, interpolation="none")
        axis.set_facecolor("0.75")
        axis.set_title(title, loc="left")
        axis.grid(visible=False)
        _name_columns(axis, found.sections)
        for row in range(1, len(found.rows)):
            if found.rows[row].block.sensor != found.rows[row - 1].block.sensor:
                axis.axhline(row - 0.5, color="0.2", lw=0.8)
    labels = [
        f"{shown_of(one.block).name}, {label_of(one.block.run, ambient_pressure)}{MARKS[one.role]}"
        for one in found.rows
    ]
    axes[0, 0].set_yticks(range(len(labels)), labels, fontsize=7)
    bar = figure.colorbar(image, ax=axes, location="bottom", extend="both", shrink=0.5, aspect=40)
    bar.set_label("model less measured, over what noise leaves of a cell's mean", fontsize=8.5)
    return figure


def _name_columns(axis, sections):
    """Name the sections under their columns; a cycle has its angles there."""
    if len(sections) == 1:
        ((_, columns),) = sections
        axis.set_xticks(np.linspace(0.0, columns, 5) - 0.5, [f"{angle}°" for angle in range(0, 361, 90)])
        axis.set_xlabel("crank angle")
        return
    ends = np.cumsum([0, *(columns for _, columns in sections)]) - 0.5
    for end in ends[1:-1]:
        axis.axvline(end, color="0.2", lw=0.6, ls=":")
    middles = 0.5 * (ends[1:] + ends[:-1])
    axis.set_xticks(
        middles, [name for name, _ in sections], rotation=35, ha="right", rotation_mode="anchor", fontsize=7
    )
    axis.tick_params(axis="x", length=0)


def candidates(rows):
    """What each candidate promised and what fitting it gave, the gap's own deviations."""
    figure, axis = plt.subplots(figsize=(WIDTH, 0.9 + 0.3 * len(rows)), layout="constrained")
    for place, row in enumerate(rows):
        if row.realised is not None:
            axis.plot([row.expected, row.realised], [place, place], color="0.7", lw=1.2, zorder=1)
            axis.plot(row.realised, place, "o", color=AFTER, ms=6)
        axis.plot(row.expected, place, "o", mfc="none", mec=BEFORE, mew=1.4, ms=6)
    axis.axvline(5.0, color="0.2", lw=1.0, ls="--")
    end = 1.15 * max(6.0, *(value for row in rows for value in (row.expected, row.realised or 0.0)))
    axis.set_xscale("symlog", linthresh=10.0, linscale=1.5)
    axis.set_xlim(-0.3, end)
    axis.set_xticks([tick for tick in TICKS if tick < end], [f"{tick:g}" for tick in TICKS if tick < end])
    axis.set_xticks([], minor=True)
    axis.set_yticks(range(len(rows)), [row.name.replace("_", " ") for row in rows])
    axis.set_ylim(len(rows) - 0.4, -0.6)
    axis.set(xlabel="part of the gap that it explains [deviations]")
    handles = [
        plt.Line2D([], [], ls="", marker="o", mfc="none", mec=BEFORE, mew=1.4, label="expected, by its score"),
        plt.Line2D([], [], ls="", marker="o", color=AFTER, label="realised, fitted through the simulator"),
        plt.Line2D([], [], color="0.2", lw=1.0, ls="--", label="5 deviations"),
    ]
    figure.legend(handles=handles, loc="outside upper right", ncols=3, fontsize=8.5)
    return figure
