"""Figure of how large the gap of each run is."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from apesim.studies.drawing.panels import add_figure_legend, legend_handle, open_one
from apesim.studies.drawing.style import Look
from apesim.studies.gap.decide.operating_points import label_point
from apesim.studies.gap.figures.style import AFTER, BEFORE, THRESHOLD, WIDTH, WORDS
from apesim.studies.gap.report.comparison import find_rms, group_by_run
from apesim.studies.measured import CHECK

if TYPE_CHECKING:
    from apesim.studies.gap.report.comparison import ComparedSignal

HATCH = "////"
"""Stripes of the bars after something was added: in grey print their colour is that of the others."""
SPACE = 0.6
"""Space between runs of different roles, in heights of a run."""


def plot_sizes(compared: "Sequence[ComparedSignal]", added: str, ambient_pressure: float) -> Figure:
    """Plot the gap of each run before and after, over the noise, with the legend above.

    `added` says in words what was added to the model; `ambient_pressure` is in [Pa abs].

    >>> import numpy as np
    >>> from apesim.studies.estimation.residuals import Block
    >>> from apesim.studies.gap.report.comparison import ComparedSignal
    >>> from apesim.studies.measured import MeasuredRun
    >>> times, lift = np.linspace(0.0, 40e-3, 81), np.zeros(81)
    >>> run = MeasuredRun("p040", "p040.csv", 0.5e6, 287.0, 20e-3, "check", times, {"lift": lift})
    >>> signal = ComparedSignal(Block(0, run, "lift", times, lift, 5e-4), 3e-5, lift + 1e-4, None, lift + 3.0, None, {})
    >>> [text.get_text() for text in plot_sizes([signal], "nothing", 0.1e6).axes[0].texts]
    ['3.00']
    """
    figure, axis = open_one((WIDTH, 0.9 + 0.36 * len(group_by_run(compared))))
    _draw_sizes(axis, compared, ambient_pressure)
    handles: list[Patch | Line2D] = [Patch(color=BEFORE, label="calibrated model")]
    if _has_after(compared):
        handles.append(Patch(fc=AFTER, ec="white", lw=0, hatch=HATCH, label=added))
    handles.append(legend_handle(label="noise alone", **THRESHOLD))
    add_figure_legend(figure, handles, side="upper")
    return figure


def _has_after(compared: "Sequence[ComparedSignal]") -> bool:
    """Whether something was added to the model."""
    return compared[0].residuals_after is not None


def _draw_sizes(axis: Axes, compared: "Sequence[ComparedSignal]", ambient_pressure: float) -> Axes:
    """Draw the gap of each run as bars, pale where the run was used, over the noise."""
    runs = group_by_run(compared)
    place, labels, places = 0.0, [], []
    for number, signals in enumerate(runs):
        role = signals[0].role
        place += SPACE * bool(number and role != runs[number - 1][0].role)

        # One bar, or two where something was added to the model: they share the height that a run has.
        bars = [(find_rms(signal.residuals_before for signal in signals), BEFORE)]
        after = [signal.residuals_after for signal in signals if signal.residuals_after is not None]
        if after:
            bars.append((find_rms(after), AFTER))
        for k, (size, colour) in enumerate(bars):
            striped: Look = {"hatch": HATCH, "ec": "white"} if colour == AFTER else {}
            height = 0.8 / len(bars)
            y = place - 0.4 + (k + 0.5) * height
            axis.barh(y, size, height=height, fc=colour, lw=0, alpha=1.0 if role == CHECK else 0.55, **striped)

            # The number stands at the end of its bar, on white, so that no line runs through it.
            where: Look = {"xytext": (3, 0), "textcoords": "offset points", "va": "center", "fontsize": 8, "zorder": 4}
            axis.annotate(f"{size:.2f}", (size, y), **where, bbox={"fc": "white", "ec": "none", "pad": 0.6})
        labels.append(f"{label_point(signals[0].block.run, ambient_pressure)} ({WORDS[role]})")
        places.append(place)
        place += 1.0

    # At 1 the noise alone is left. The y axis points down, so that the first run stands at the top.
    axis.axvline(1.0, **THRESHOLD)
    axis.set_yticks(places, labels)
    axis.set_ylim(place - 0.4, -0.6)
    axis.grid(axis="y", visible=False)
    axis.set_xlabel("root mean square of what is left, over the noise [-]")
    axis.margins(x=0.08)
    return axis
