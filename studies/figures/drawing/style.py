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


def colours_of(count: int, brightest: float = 0.85) -> np.ndarray:
    """Colours for an ordered quantity, from dark to bright.

    Parameters
    ----------
    count : int
    brightest : float
        Place of the last colour on the colour map, 0 to 1; the upper end of the map is too pale for lines.

    Returns
    -------
    (count, 4) float array
        Red, green, blue, opacity.

    Examples
    --------
    >>> colours_of(3).shape
    (3, 4)
    """
    return matplotlib.colormaps["viridis"](np.linspace(0.0, brightest, count))
