"""Figures of soft landing: fronts, what spacing it takes, traces, robustness."""

import matplotlib.pyplot as plt
import numpy as np

from apesim.studies.figures.conditions import conditions_of
from apesim.studies.figures.style import draw

STROKES = {"opening": "C0", "closing": "C1"}
BRAKES = {"softest": ("#d55e00", "-"), "sturdy": ("#0072b2", "--")}
"""Colour and style of each kind of brake: colour-blind eyes tell vermilion from blue (Okabe and Ito)."""
MAX_CURVES = 3
"""Pressures that are shown, at most."""


def soft_landing_figures(archive, ambient_pressure, folder):
    """All figures of a study of soft landing.

    Parameters
    ----------
    archive : Archive
        See `apesim.studies.soft_landing.results.archive_of`.
    ambient_pressure : float
        Gauge pressures stand above it [Pa abs].
    folder : path
        Made if it does not exist.

    Returns
    -------
    list of Path
    """
    v = {name: variable.values for name, variable in archive.variables.items()}
    pressure = (v["supply_pressure"] - ambient_pressure) / 1e6
    shown = np.unique(np.linspace(0, len(pressure) - 1, MAX_CURVES).round().astype(int))
    titles = [(int(run), f"{pressure[run]:.3g} MPa gauge") for run in shown]
    spacing, cost, dwell = (1e3 * float(archive.provenance[name]) for name in ("spacing_s", "cost_s", "dwell_s"))
    figures = {
        "fronts": lambda: fronts(v, titles, spacing, cost),
        "spacing": lambda: over_spacing(v, titles, spacing, cost),
        "robustness": lambda: robustness(v, titles),
    }
    for stroke in STROKES:
        figures[f"traces_{stroke}"] = lambda stroke=stroke: traces(v, titles, stroke, dwell)
    return draw(figures, folder, conditions_of(archive.machine, ("supply.pressure", "supply.control_pressure")))


def best(v, stroke, run, kind):
    """Prefix of a kind of brake that was found, within the spacing rather than of any; None if none was."""
    prefixes = (f"{stroke}_{limit}_spacing_{kind}" for limit in ("within", "any"))
    return next((prefix for prefix in prefixes if not np.isnan(v[f"{prefix}_speed"][run])), None)


def panels(titles, rows, height, **shared):
    """A figure with a column for each pressure, and its axes."""
    size = (max(8.0, 1.0 + 3.1 * len(titles)), height)
    figure, axes = plt.subplots(rows, len(titles), figsize=size, layout="constrained", squeeze=False, **shared)
    for axis, (_, title) in zip(axes[0], titles, strict=True):
        axis.set_title(title)
    return figure, axes


def fronts(v, titles, spacing, cost):
    """Seating speed against added time, for any spacing of the edges and for that of the solenoids.

    Parameters
    ----------
    v : dict of str to array
        Of the archive.
    titles : list of (int, str)
        Runs to show.
    spacing, cost : float
        [ms]

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = panels(titles, 1, 3.6, sharey=True)
    added = 1e3 * v["added_time"]
    for axis, (run, _) in zip(axes[0], titles, strict=True):
        last = cost
        for stroke, colour in STROKES.items():
            unbraked = v[f"{stroke}_seating_speed"][run]
            axis.plot(0.0, unbraked, "o", color=colour, ms=5, clip_on=False, zorder=3)
            axis.axhline(v[f"{stroke}_lowest_speed"][run], color=colour, lw=0.8, ls=":")
            for limit, width in (("any", 1.4), ("within", 3.0)):
                front = v[f"{stroke}_{limit}_spacing_front_speed"][run]
                label = f"{stroke}, edges " + ("as close as it takes" if limit == "any" else f"{spacing:.3g} ms apart")
                if np.isnan(front).all():
                    continue
                axis.plot(added, front, color=colour, lw=width, drawstyle="steps-post", label=label)
                changes = np.flatnonzero(np.diff(front) < 0.0)
                last = max(last, added[changes[-1] + 1] if len(changes) else 0.0)
        if all(np.isnan(v[f"{stroke}_within_spacing_front_speed"][run]).all() for stroke in STROKES):
            told = f"edges {spacing:.3g} ms apart:\nno brake lowers it"
            axis.text(0.93, 0.68, told, transform=axis.transAxes, ha="right", bbox={"fc": "white", "ec": "none"})
        axis.axvline(cost, color="0.4", lw=0.9, ls="--")
        axis.set(xlabel="time added to the stroke [ms]", xlim=(0.0, 1.15 * last))
    highest = max(np.nanmax(v[f"{stroke}_seating_speed"], initial=0.1) for stroke in STROKES)
    axes[0, 0].set(ylabel="seating speed [m/s]", ylim=(0.0, 1.05 * highest))
    drawn = [axis.get_legend_handles_labels() for axis in axes[0]]
    handles = {label: handle for pair in drawn for handle, label in zip(*pair, strict=True)}
    handles["unbraked"] = plt.Line2D([], [], color="0.3", marker="o", ls="", ms=5)
    handles["lowest speed before contact, unbraked"] = plt.Line2D([], [], color="0.3", lw=0.8, ls=":")
    handles["time allowed"] = plt.Line2D([], [], color="0.4", lw=0.9, ls="--")
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3, fontsize=8)
    return figure


def over_spacing(v, titles, spacing, cost):
    """Softest landing at the allowed cost over the time between edges that the solenoids need; see `fronts`."""
    figure, axis = plt.subplots(figsize=(7.4, 3.8), layout="constrained")
    colours = plt.get_cmap("viridis")(np.linspace(0.0, 0.85, len(titles)))
    for (run, title), colour in zip(titles, colours, strict=True):
        for stroke, style in zip(STROKES, ("-", "--"), strict=True):
            share = v[f"{stroke}_speed_over_spacing"][run] / v[f"{stroke}_seating_speed"][run]
            axis.plot(1e3 * v["spacing"], share, color=colour, ls=style, marker="o", ms=3, label=f"{title}, {stroke}")
    axis.axvline(spacing, color="0.3", lw=0.9, ls=":", label=f"the solenoids' {spacing:.3g} ms")
    axis.set(xlabel="shortest time between two edges [ms]", ylabel="seating speed over unbraked [-]")
    axis.set(ylim=(0.0, 1.05), xlim=(0.0, None), title=f"Softest landing for {cost:.3g} ms")
    figure.legend(fontsize=8.5, loc="outside right center")
    return figure


def traces(v, titles, stroke, dwell):
    """Commands of both solenoids, lift and speed of a stroke, without a brake and with the softest one.

    Parameters
    ----------
    v, titles
        See `fronts`.
    stroke : str
    dwell : float
        [ms]

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = panels(titles, 4, 7.0, sharex=True, sharey="row", height_ratios=(0.8, 0.8, 1.6, 1.6))
    command, sign = (0.0, 1.0) if stroke == "opening" else (dwell, -1.0)
    time = 1e3 * v["time"] - command
    last = 0.0
    for column, (run, _) in enumerate(titles):
        prefix = best(v, stroke, run, "softest")
        edges = [1e3 * v[f"{prefix}_{edge}"][run] for edge in ("brake", "release")] if prefix else []
        last = max(last, 1.2e3 * v[f"{stroke}_contact"][run], *edges)
        for name, colour, width in (("unbraked", "0.55", 1.2), ("braked", "C3", 1.6)):
            if name == "braked" and not edges:
                continue
            for row, solenoid in enumerate("ab"):
                if name == "braked":
                    own = edges if v[f"{prefix}_solenoids"][run] in (0, row + 1) else []
                    levels = np.resize((0.0, 1.0) if stroke == "opening" else (1.0, 0.0), 2 + len(own))
                    steps = [-1.0, 0.0, *own, 1e3]
                    axes[row, column].step(steps, [*levels, levels[-1]], where="post", color=colour, lw=1.0)
                axes[row, column].plot(time, v[f"{name}_energised_{solenoid}"][run], color=colour, lw=width, ls="--")
            axes[2, column].plot(time, 1e3 * v[f"{name}_lift"][run], color=colour, lw=width)
            axes[3, column].plot(time, sign * v[f"{name}_velocity"][run], color=colour, lw=width)
        axes[3, column].set_xlabel(f"time after the command [ms], {stroke}")
    axes[0, 0].set_xlim(-0.5, last)
    peak = max(np.nanmax(sign * v["unbraked_velocity"]), 0.1)
    axes[3, 0].set_ylim(-0.15 * peak, 1.1 * peak)
    for axis, label in zip(
        axes[:, 0], ("solenoid A", "solenoid B", "lift [mm]", "speed to the stop [m/s]"), strict=True
    ):
        axis.set_ylabel(label)
    line = plt.Line2D
    handles = (
        line([], [], color="0.55", lw=1.2),
        line([], [], color="C3"),
        line([], [], color="C3", lw=1.0),
        line([], [], color="C3", ls="--"),
    )
    names = ("unbraked", "softest brake", "command", "energised fraction")
    figure.legend(handles, names, loc="outside lower center", ncols=4, fontsize=8.5)
    return figure


def robustness(v, titles):
    """Seating speed under other pressures and temperatures; hollow where the piston falls off its stop again."""
    figure, axes = panels(titles, 2, 5.6, sharex=True, sharey=True)
    factors, offsets = v["pressure_factor"], v["temperature_offset"]
    markers = ("v", "o", "^")
    for row, stroke in zip(axes, STROKES, strict=True):
        for axis, (run, _) in zip(row, titles, strict=True):
            axis.axhline(v[f"{stroke}_seating_speed"][run], color="0.55", lw=1.0)
            for kind, (colour, style) in BRAKES.items():
                prefix = best(v, stroke, run, kind)
                if not prefix:
                    continue
                for number, marker in zip(range(len(offsets)), markers, strict=True):
                    speed = v[f"{prefix}_speed_at"][run][:, number]
                    stays = v[f"{prefix}_stays_at"][run][:, number] == 1
                    axis.plot(100.0 * (factors - 1.0), speed, color=colour, lw=0.9, ls=style)
                    for chosen, face in ((stays, colour), (~stays, "white")):
                        points = {"marker": marker, "ls": "", "ms": 5, "mec": colour, "mfc": face}
                        axis.plot(100.0 * (factors - 1.0)[chosen], speed[chosen], **points)
        row[0].set_ylabel(f"seating speed, {stroke} [m/s]")
    for axis in axes[-1]:
        axis.set_xlabel("gauge pressure off by [%]")
    axes[0, 0].set(ylim=(0.0, None), xticks=np.round(100.0 * (factors - 1.0)))
    line = plt.Line2D
    handles = {"unbraked": line([], [], color="0.55", lw=1.0)}
    handles |= {kind: line([], [], color=colour, ls=style) for kind, (colour, style) in BRAKES.items()}
    for offset, marker in zip(offsets, markers, strict=True):
        handles[f"{offset:+g} K"] = line([], [], color="0.3", marker=marker, ls="", ms=5)
    handles["falls off its stop"] = line([], [], color="0.3", marker="o", mfc="white", ls="", ms=5)
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=len(handles), fontsize=8.5)
    return figure
