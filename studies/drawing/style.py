"""How all figures look: matplotlib's settings, colours."""

from typing import Any

import matplotlib
import numpy as np
from cycler import cycler

RED, BLUE = "#c1440e", "#2a6f97"
"""The two colours that figures use where two things are compared."""
GREY = "0.4"
"""Colour of what stands for several colours in a legend."""
STYLE: dict[Any, Any] = {
    "figure.dpi": 110,
    "savefig.dpi": 160,
    "font.size": 9.5,
    "axes.titlesize": 10,
    "axes.grid": True,
    "grid.color": "0.9",
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "legend.handlelength": 2.8,
    "lines.linewidth": 1.6,
    "axes.prop_cycle": cycler(color=[BLUE, RED, "#3a7d44", "#7a4e9c", "#e0a030", "0.3"]),
    "pdf.fonttype": 42,
    "svg.hashsalt": "apesim",
}
"""Settings of matplotlib that hold while a figure is drawn and written."""
Look = dict[str, Any]
"""Options of matplotlib that several lines share."""
BRIGHTEST = 0.78
"""Place of the brightest colour of a line on the colour map, 0 to 1: beyond, lines are too pale on white."""


STYLES = ("-", "--", "-.", ":", (0, (6, 1, 1, 1, 1, 1)), (0, (10, 3)))
"""Styles of lines, in turn: what colours distinguish, grey print distinguishes by these or by markers."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
"""Markers of points, in turn."""


def looks_of(count: int) -> list[Look]:
    """Colours for an ordered quantity, each with a marker of its own, so that grey print distinguishes them.

    Each is given as options of lines.
    """
    colours = colours_of(count)
    return [{"color": colour, "marker": MARKERS[number % len(MARKERS)]} for number, colour in enumerate(colours)]


def spaced(size: int, number: int, count: int) -> tuple[int, int]:
    """Samples of a trace that bear a marker: a few, and others for each of several traces.

    The trace has `size` samples and is `number`, from 0, of `count`; first sample and step are given, as ``markevery``
    of a line takes them.

    >>> spaced(720, 1, 4)
    (11, 45)
    """
    step = max(size // 16, 1)
    return step * number // max(count, 1), step


def colours_of(count: int) -> np.ndarray:
    """Colours for an ordered quantity, from dark to bright, (count, 4): red, green, blue, opacity."""
    return matplotlib.colormaps["viridis"](np.linspace(0.0, BRIGHTEST, count))
