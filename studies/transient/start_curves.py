"""Numbers of starts over the keys that were varied, as curves."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes

from apesim.archive import Archive
from apesim.archive.grid import axes_of, places_of
from apesim.studies.drawing.panels import add_legend, add_legend_entry, label_axes
from apesim.studies.drawing.spread import spread_out
from apesim.studies.drawing.style import Look, looks_of
from apesim.studies.sweep.plan import in_one_unit
from apesim.studies.transient.start_archive import named

MAX_LINES = 8
"""Lines of a plot: more are no longer told from each other."""
MAX_TICKS = 10
"""Values of an axis up to which each has a tick of its own."""
CROSS: Look = {"ls": "", "ms": 6.5, "mew": 1.6}
"""Look of crosses for machines that have no number to draw."""
MISSING = {"x": "does not start", "+": "starts, but does not reach the speed"}
"""What the crosses mean."""
PLOTS = {
    "time": ("time_s", 1.0, "time to start [s]"),
    "turns": ("turns", 1.0, "turns to start"),
    "engine_air": ("engine_air_kg", 1e3, "engine air to start [g]"),
    "control_air": ("control_air_kg", 1e3, "control air to start [g]"),
    "share": ("starting_share", 100.0, "share of all angles that it starts from [%]"),
}
"""What is drawn over the keys that were varied."""


def draw_over_keys(ax: Axes, archive: Archive, what: str, *, legend: bool = True) -> None:
    """Draw a number over the axis with the most values, a line for each combination of the others.

    Machines that do not start are crosses at the bottom, those of each line in a row; of more than `MAX_LINES` lines
    some are drawn.
    """
    # Values of the longest axis as numbers where all of them are, else at equal distances under their words.
    column_name, factor, label = PLOTS[what]
    axes, places = axes_of(archive), places_of(archive)
    along = max(range(len(axes)), key=lambda axis: len(list(axes.values())[axis]))
    name, texts = list(axes.items())[along]
    at, unit = _positions_of(texts)

    # A line for each combination of the other axes.
    others = [axis for axis in range(len(axes)) if axis != along]
    combinations = sorted({tuple(int(places[axis][run]) for axis in others) for run in range(len(archive.runs))})
    shown = [combinations[number] for number in spread_out(len(combinations), MAX_LINES)]
    values, starts = factor * archive.variables[column_name].values, archive.variables["starts"].values == 1
    missing = {} if what == "share" else {"x": ~starts, "+": starts & np.isnan(values)}
    for number, (combination, look) in enumerate(zip(shown, looks_of(len(shown)), strict=True)):
        chosen = np.all([places[axis] == place for axis, place in zip(others, combination, strict=True)], axis=0)
        runs = np.flatnonzero(np.broadcast_to(chosen, len(values)))
        words = [named(*_value(axes, axis, place)) for axis, place in zip(others, combination, strict=True)]
        ax.plot(at[places[along][runs]], values[runs], label=", ".join(words) or None, **look)
        for marker, which in missing.items():
            lacks = at[places[along][runs[which[runs]]]]
            height = np.full(len(lacks), 0.05 + 0.07 * number)
            ax.plot(lacks, height, color=look["color"], transform=ax.get_xaxis_transform(), marker=marker, **CROSS)
    for marker, which in missing.items():
        if which.any():
            add_legend_entry(ax, MISSING[marker], marker=marker, **CROSS)
    top = np.nanmax(values, initial=0.0)
    ax.set_ylim(0.0, 1.1 * top if top > 0.0 else 1.0)
    if unit is None:
        ax.set_xticks(at, texts)
    elif len(at) < MAX_TICKS:
        ax.set_xticks(at)
    title = f"{len(shown)} of {len(combinations)} lines" if len(shown) < len(combinations) else None
    quantity, _, unit_of_label = label.partition(" [")
    label_axes(ax, x=(name.replace("_", " "), unit or ""), y=(quantity, unit_of_label.rstrip("]")), title=title)
    if legend:
        add_legend(ax)


def _positions_of(texts: Sequence[str]) -> tuple[np.ndarray, str | None]:
    """Numbers of the values of an axis, and their unit; without numbers equal distances, and None."""
    numbers, unit = in_one_unit(texts)
    try:
        at = np.array(numbers, dtype=float)
    except ValueError:
        at = np.array([np.inf])
    return (at, unit) if np.isfinite(at).all() else (np.arange(len(texts), dtype=float), None)


def _value(axes: Mapping[str, Sequence[str]], axis: int, place: int) -> tuple[str, str]:
    """Name of an axis and the text of one of its values."""
    name, texts = list(axes.items())[axis]
    return name, texts[place]
