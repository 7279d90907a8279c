"""Figure of what each candidate promised and what fitting it gave."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from apesim.studies.drawing.panels import add_figure_legend, legend_handle, open_one
from apesim.studies.gap.figures.style import AFTER, BEFORE, THRESHOLD, WIDTH

if TYPE_CHECKING:
    from apesim.studies.gap.report.html import TriedCandidate

TICKS = (0, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000)
"""Ticks of the x axis, which is linear up to 10 and logarithmic beyond."""
CLEAR = 5.0
"""Sigmas from which an effect is beyond doubt, marked by a line."""


def plot_candidates(rows: "Sequence[TriedCandidate]") -> Figure:
    """Plot what each candidate promised and what fitting it gave, with the legend above.

    >>> from apesim.studies.gap.report.html import TriedCandidate
    >>> figure = plot_candidates([TriedCandidate("ring_leakage", 12.0, 11.5), TriedCandidate("side_force", 3.0, None)])
    >>> [label.get_text() for label in figure.axes[0].get_yticklabels()]
    ['ring leakage', 'side force']
    """
    figure, axis = open_one((WIDTH, 0.9 + 0.3 * len(rows)))
    _draw_candidates(axis, rows)
    handles = [
        legend_handle(ls="", marker="o", mfc="none", mec=BEFORE, mew=1.4, label="expected, by its score"),
        legend_handle(ls="", marker="o", color=AFTER, label="realised, fitted through the simulator"),
        legend_handle(label=f"{CLEAR:g} sigmas", **THRESHOLD),
    ]
    add_figure_legend(figure, handles, side="upper")
    return figure


def _draw_candidates(axis: Axes, rows: "Sequence[TriedCandidate]") -> Axes:
    """Draw the part of the gap that each candidate promised as a circle, and what fitting it gave as a dot."""
    for place, row in enumerate(rows):
        if row.realised is not None:
            axis.plot([row.expected, row.realised], [place, place], color="0.7", lw=1.2, zorder=1)
            axis.plot(row.realised, place, "o", color=AFTER, ms=6)
        axis.plot(row.expected, place, "o", mfc="none", mec=BEFORE, mew=1.4, ms=6)
    axis.axvline(CLEAR, **THRESHOLD)
    end = 1.15 * max(6.0, *(value for row in rows for value in (row.expected, row.realised or 0.0)))
    axis.set_xscale("symlog", linthresh=10.0, linscale=1.5)
    axis.set_xlim(-0.3, end)
    axis.set_xticks([tick for tick in TICKS if tick < end], [f"{tick:g}" for tick in TICKS if tick < end])
    axis.set_xticks([], minor=True)
    axis.set_yticks(range(len(rows)), [row.name.replace("_", " ") for row in rows])
    axis.set_ylim(len(rows) - 0.4, -0.6)
    axis.set_xlabel("part of the gap that it explains [sigmas]")
    return axis
