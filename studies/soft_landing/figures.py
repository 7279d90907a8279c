"""Figures of soft landing: fronts, what spacing it takes, traces, robustness."""

from collections.abc import Mapping, Sequence
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from apesim.archive import Archive
from apesim.studies.drawing.conditions import CONTROL_AIR, VALVE_SECTIONS, conditions_of
from apesim.studies.drawing.files import write_figures
from apesim.studies.drawing.panels import (
    add_figure_legend,
    columns_of,
    gauge_in_mpa,
    label_axes,
    legend_handle,
    open_one,
    open_panels,
)
from apesim.studies.drawing.spread import spread_out
from apesim.studies.drawing.style import BLUE, RED, STYLES, Look, looks_of

STROKES = {"opening": BLUE, "closing": RED}
"""Colour of each stroke."""
STROKE_STYLES = {"opening": "-", "closing": "--"}
"""Style of each stroke's lines."""
LOWEST_STYLES = {"opening": ":", "closing": "-."}
"""Style of the lowest speed of each stroke without a brake."""
ALLOWED: Look = {"color": "0.4", "lw": 0.9, "ls": STYLES[4]}
"""Look of the line at the time that a stroke may take longer."""
UNBRAKED: Look = {"color": "0.4", "lw": 1.2, "ls": ":"}
"""Look of the seating speed without a brake."""
BRAKES = {"softest": (RED, "-"), "sturdy": (BLUE, "--")}
"""Colour and style of each kind of brake."""
TRACES: dict[str, Look] = {
    "unbraked": {"color": "0.45", "lw": 1.2, "ls": "--"},
    "braked": {"color": RED, "lw": 1.6},
    "command": {"color": "0.1", "lw": 1.0, "ls": ":"},
}
"""Looks of traces without a brake and with one, and of its command."""
ENERGISED = "solenoid {},\nenergised [-]"
"""Name of the fraction to which a solenoid is energised."""
MAX_CURVES = 3
"""Pressures that are shown at most: a column of panels for each."""
MARKERS = ("v", "o", "^")
"""Marker of each temperature: lower, the same, higher."""

Columns = Mapping[str, np.ndarray]
"""Columns of the archive by name, over its runs."""
Titles = Sequence[tuple[int, str]]
"""Runs to show, each with the title of its panel."""


def soft_landing_figures(archive: Archive, ambient_pressure: float, folder: str | PathLike[str]) -> list[Path]:
    """Write all figures of a study of soft landing as PNG and PDF into a folder, made if it does not exist.

    `archive` is as `apesim.studies.soft_landing.results.archive_of` gives it; gauge pressures stand above
    `ambient_pressure` [Pa abs].
    """
    v, titles, spacing, cost = shown_of(archive, ambient_pressure)
    dwell = 1e3 * float(archive.provenance["dwell_s"])
    figures = {
        "fronts": partial(_plot_fronts, v, titles, spacing, cost),
        "spacing": partial(_plot_over_spacing, v, titles, spacing, cost),
        "robustness": partial(_plot_robustness, v, titles),
    }
    figures |= {f"traces_{stroke}": partial(_plot_traces, v, titles, stroke, dwell) for stroke in STROKES}
    kelvins = "".join(f"control air {kelvin:g} K, " for kelvin in np.unique(v["supply_temperature"]))
    more = f"{kelvins}{dwell:g} ms pulse, solenoids that brake: {archive.provenance['solenoids'].replace(', ', ' or ')}"
    return write_figures(figures, folder, conditions_of(archive.machine, CONTROL_AIR, more, VALVE_SECTIONS))


def shown_of(archive: Archive, ambient_pressure: float) -> tuple[dict[str, np.ndarray], Titles, float, float]:
    """What the figures show of an archive, with the ambient pressure in [Pa abs].

    Gives columns over the runs, the runs to show, each with the title of its panel, the time that two edges of the
    command stand apart at least [ms], and the time that a stroke may take longer [ms].

    >>> from apesim.archive.columns import column
    >>> pressure = column([0.5e6, 0.9e6], "Pa abs", "control pressure")
    >>> archive = Archive("", {"spacing_s": "4.17e-3", "cost_s": "1e-3"}, {"supply_pressure": pressure})
    >>> _, titles, spacing, cost = shown_of(archive, 0.1e6)
    >>> titles, spacing, cost
    ([(0, '0.4 MPa gauge'), (1, '0.8 MPa gauge')], 4.17, 1.0)
    """
    v = columns_of(archive)
    pressure = gauge_in_mpa(v["supply_pressure"], ambient_pressure)
    titles = [(int(run), f"{pressure[run]:.3g} MPa gauge") for run in spread_out(len(pressure), MAX_CURVES)]
    spacing, cost = (1e3 * float(archive.provenance[name]) for name in ("spacing_s", "cost_s"))
    return v, titles, spacing, cost


def _prefix_of(v: Columns, stroke: str, run: int, kind: str) -> str | None:
    """Prefix of the columns of a kind of brake, one within the spacing rather than any; None if there is none."""
    prefixes = (f"{stroke}_{limit}_spacing_{kind}" for limit in ("within", "any"))
    return next((prefix for prefix in prefixes if not np.isnan(v[f"{prefix}_speed"][run])), None)


def _open(titles: Titles, rows: int, height: float, **options: Any) -> tuple[Figure, np.ndarray]:
    """Open a figure with a column of panels for each pressure."""
    size = (max(8.0, 1.0 + 3.1 * len(titles)), height)
    figure, axes = open_panels(rows, len(titles), size, **options)
    for axis, (_, title) in zip(axes[0], titles, strict=True):
        axis.set_title(title)
    return figure, axes


def _labelled(handles: Mapping[str, Any]) -> list[Any]:
    """Handles of a legend with their labels."""
    for label, handle in handles.items():
        handle.set_label(label)
    return list(handles.values())


def _plot_fronts(v: Columns, titles: Titles, spacing: float, cost: float) -> Figure:
    """Plot the seating speed against added time, for any spacing of the edges and for that of the solenoids."""
    figure, axes = _open(titles, 1, 3.6, sharey=True)
    added = 1e3 * v["added_time"]
    for axis, (run, _) in zip(axes[0], titles, strict=True):
        last = cost
        for stroke, colour in STROKES.items():
            unbraked = v[f"{stroke}_seating_speed"][run]
            axis.plot(0.0, unbraked, "o", color=colour, ms=5, clip_on=False, zorder=3)
            axis.axhline(v[f"{stroke}_lowest_speed"][run], color=colour, lw=0.8, ls=LOWEST_STYLES[stroke])

            # A thin line for edges at any spacing, a wide one for those that the solenoids can follow.
            for limit, width in (("any", 1.4), ("within", 3.0)):
                front = v[f"{stroke}_{limit}_spacing_front_speed"][run]
                label = f"{stroke}, edges " + ("at any spacing" if limit == "any" else f"{spacing:.3g} ms apart")
                if np.isnan(front).all():
                    continue
                look = {"color": colour, "ls": STROKE_STYLES[stroke], "lw": width}
                axis.plot(added, front, drawstyle="steps-post", label=label, **look)

                # The axis ends soon after the last gain: more time than that softens nothing.
                changes = np.flatnonzero(np.diff(front) < 0.0)
                last = max(last, added[changes[-1] + 1] if len(changes) else 0.0)

        # A reader would look for the wide lines: the note says that there are none.
        if all(np.isnan(v[f"{stroke}_within_spacing_front_speed"][run]).all() for stroke in STROKES):
            note = f"edges {spacing:.3g} ms apart:\nno brake lowers it"
            axis.text(0.93, 0.68, note, transform=axis.transAxes, ha="right", bbox={"fc": "white", "ec": "none"})
        axis.axvline(cost, **ALLOWED)
        label_axes(axis, x=("time added to the stroke", "ms"))
        axis.set_xlim(0.0, 1.15 * last)

    # The panels share the y axis, so that the first one sets it for all; 0.1 m/s where there is no speed to show.
    highest = max(np.nanmax(v[f"{stroke}_seating_speed"], initial=0.1) for stroke in STROKES)
    label_axes(axes[0, 0], y=("seating speed", "m/s"))
    axes[0, 0].set_ylim(0.0, 1.05 * highest)

    # A line that several panels have gets one entry; entries for what is drawn without a label follow.
    drawn = [axis.get_legend_handles_labels() for axis in axes[0]]
    handles = {label: handle for pair in drawn for handle, label in zip(*pair, strict=True)}
    handles["unbraked"] = legend_handle(color="0.3", marker="o", ls="", ms=5)
    for stroke, style in LOWEST_STYLES.items():
        name = f"{stroke}, unbraked: lowest speed before contact"
        handles[name] = legend_handle(color=STROKES[stroke], lw=0.8, ls=style)
    handles["time allowed"] = legend_handle(**ALLOWED)
    add_figure_legend(figure, _labelled(handles), fontsize=8)
    return figure


def _plot_over_spacing(v: Columns, titles: Titles, spacing: float, cost: float) -> Figure:
    """Plot the softest landing over the time between edges, with the legend beside it; see `draw_over_spacing`."""
    figure, axis = open_one()
    draw_over_spacing(axis, v, titles, spacing, cost)
    figure.legend(loc="outside right center")
    return figure


def draw_over_spacing(axis: Axes, v: Columns, titles: Titles, spacing: float, cost: float) -> Axes:
    """Draw the softest landing at the allowed cost over the time between edges that the solenoids need.

    `v` holds columns of the archive over its runs, `titles` the runs to show with their names in the legend; two edges
    of the command stand `spacing` [ms] apart at least, and a stroke may take `cost` [ms] longer.

    >>> v = {"spacing": 1e-3 * np.array([1.0, 4.0])}
    >>> for stroke in STROKES:
    ...     v[f"{stroke}_speed_over_spacing"] = np.array([[0.3, 0.6]])
    ...     v[f"{stroke}_seating_speed"] = np.array([1.2])
    >>> _, axis = open_one()
    >>> axis = draw_over_spacing(axis, v, [(0, "0.4 MPa gauge")], 4.17, 1.0)
    >>> axis.lines[0].get_label(), axis.lines[0].get_ydata().tolist()
    ('0.4 MPa gauge, opening', [0.25, 0.5])
    """
    for (run, title), look in zip(titles, looks_of(len(titles)), strict=True):
        for stroke, style in STROKE_STYLES.items():
            share = v[f"{stroke}_speed_over_spacing"][run] / v[f"{stroke}_seating_speed"][run]
            axis.plot(1e3 * v["spacing"], share, ls=style, ms=3.5, label=f"{title}, {stroke}", **look)
    axis.axvline(spacing, color="0.3", lw=0.9, ls=":", label=f"the solenoids' {spacing:.3g} ms")
    x, y = ("shortest time between two edges", "ms"), ("seating speed over unbraked", "-")
    label_axes(axis, x=x, y=y, title=f"Softest landing for {cost:.3g} ms")
    axis.set(ylim=(0.0, 1.05), xlim=(0.0, None))
    return axis


def _plot_traces(v: Columns, titles: Titles, stroke: str, dwell: float) -> Figure:
    """Plot commands of both solenoids, lift and speed of a stroke, without a brake and with the softest one."""
    figure, axes = _open(titles, 4, 7.0, sharex=True, sharey="row", height_ratios=(0.8, 0.8, 1.6, 1.6))

    # Time counts from the stroke's own command and speed towards its stop, so that both strokes read alike.
    command, sign = (0.0, 1.0) if stroke == "opening" else (dwell, -1.0)
    time = 1e3 * v["time"] - command
    last = 0.0
    for column, (run, _) in enumerate(titles):
        prefix = _prefix_of(v, stroke, run, "softest")
        edges = [1e3 * v[f"{prefix}_{edge}"][run] for edge in ("brake", "release")] if prefix else []
        last = max(last, 1.2e3 * v[f"{stroke}_contact"][run], *edges)
        for name in ("unbraked", "braked"):
            if name == "braked" and not edges:
                continue

            # The command is drawn with the brake only. A solenoid that the brake does not switch
            # has the one edge of the stroke.
            for row, solenoid in enumerate("ab"):
                if name == "braked":
                    braking = edges if v[f"{prefix}_solenoids"][run] in (0, row + 1) else []
                    levels = np.resize((0.0, 1.0) if stroke == "opening" else (1.0, 0.0), 2 + len(braking))
                    steps = [-1.0, 0.0, *braking, 1e3]
                    axes[row, column].step(steps, [*levels, levels[-1]], where="post", **TRACES["command"])
                axes[row, column].plot(time, v[f"{name}_energised_{solenoid}"][run], **TRACES[name])
            axes[2, column].plot(time, 1e3 * v[f"{name}_lift"][run], **TRACES[name])
            axes[3, column].plot(time, sign * v[f"{name}_velocity"][run], **TRACES[name])
        axes[3, column].set_xlabel(f"time after the command [ms], {stroke}")

    # All panels share the time, and those of a row the y axis. Room below zero shows a piston that turns back.
    axes[0, 0].set_xlim(-0.5, last)
    peak = max(np.nanmax(sign * v["unbraked_velocity"]), 0.1)
    axes[3, 0].set_ylim(-0.15 * peak, 1.1 * peak)
    for axis, label in zip(
        axes[:, 0], (*map(ENERGISED.format, "AB"), "lift [mm]", "speed to the stop [m/s]"), strict=True
    ):
        axis.set_ylabel(label)

    # The lines bear no labels, as each is drawn in several panels: the legend has lines of its own.
    names = ("unbraked", "softest brake", "its command")
    handles = [legend_handle(label=name, **look) for name, look in zip(names, TRACES.values(), strict=True)]
    add_figure_legend(figure, handles)
    return figure


def _plot_robustness(v: Columns, titles: Titles) -> Figure:
    """Plot the seating speed under other pressures and temperatures; hollow where the piston falls off its stop."""
    figure, axes = _open(titles, 2, 5.6, sharex=True, sharey=True)
    factors, offsets = v["pressure_factor"], v["temperature_offset"]
    for row, stroke in zip(axes, STROKES, strict=True):
        for axis, (run, _) in zip(row, titles, strict=True):
            axis.axhline(v[f"{stroke}_seating_speed"][run], **UNBRAKED)
            for kind, (colour, style) in BRAKES.items():
                prefix = _prefix_of(v, stroke, run, kind)
                if not prefix:
                    continue
                for number, marker in zip(range(len(offsets)), MARKERS, strict=True):
                    speed = v[f"{prefix}_speed_at"][run][:, number]
                    stays = v[f"{prefix}_stays_at"][run][:, number] == 1
                    axis.plot(100.0 * (factors - 1.0), speed, color=colour, lw=0.9, ls=style)

                    # Filled and hollow points are drawn apart, as one line has one colour of faces.
                    for chosen, face in ((stays, colour), (~stays, "white")):
                        points = {"marker": marker, "ls": "", "ms": 5, "mec": colour, "mfc": face}
                        axis.plot(100.0 * (factors - 1.0)[chosen], speed[chosen], **points)
        row[0].set_ylabel(f"seating speed,\n{stroke} [m/s]")
    for axis in axes[-1]:
        label_axes(axis, x=("gauge pressure off by", "%"))

    # All panels share both axes, so that one of them sets limits and ticks for all.
    axes[0, 0].set(ylim=(0.0, None), xticks=np.round(100.0 * (factors - 1.0)))

    # The legend explains colours and markers each by themselves, not every pair of them.
    handles = {"unbraked": legend_handle(**UNBRAKED)}
    handles |= {kind: legend_handle(color=colour, ls=style) for kind, (colour, style) in BRAKES.items()}
    for offset, marker in zip(offsets, MARKERS, strict=True):
        handles[f"{offset:+g} K"] = legend_handle(color="0.3", marker=marker, ls="", ms=5)
    handles["falls off its stop"] = legend_handle(color="0.3", marker="o", mfc="white", ls="", ms=5)
    add_figure_legend(figure, _labelled(handles))
    return figure
