"""How all figures look: matplotlib's settings, colours."""

from typing import Any

import matplotlib
import numpy as np

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
    "lines.linewidth": 1.6,
    "pdf.fonttype": 42,
    "svg.hashsalt": "apesim",
}
"""Settings of matplotlib that hold while a figure is drawn and written."""
Look = dict[str, Any]
"""Options of matplotlib that several lines share."""
RED, BLUE = "#c1440e", "#2a6f97"
"""The two colours that figures use where two things are compared."""
GREY = "0.4"
"""Colour of what stands for several colours in a legend."""


STYLES = ("-", "--", "-.", ":", (0, (6, 1, 1, 1, 1, 1)))
"""Styles of lines, in turn: what colours distinguish, grey print distinguishes by these or by markers."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
"""Markers of points, in turn."""


def looks_of(count: int, brightest: float = 0.85) -> list[Look]:
    """Colours for an ordered quantity, each with a marker of its own, so that grey print distinguishes them.

    Each is given as options of lines; `brightest` is the place of the last colour on the colour map, 0 to 1.
    """
    colours = colours_of(count, brightest)
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


def colours_of(count: int, brightest: float = 0.85) -> np.ndarray:
    """Colours for an ordered quantity, from dark to bright, (count, 4): red, green, blue, opacity.

    `brightest` is the place of the last one on the colour map, 0 to 1; the upper end of the map is too pale for lines.
    """
    return matplotlib.colormaps["viridis"](np.linspace(0.0, brightest, count))
