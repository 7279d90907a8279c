"""How all figures look, and how they are written: PNG to look at, PDF to print, the same bytes each time."""

import io
from math import ceil
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.transforms import Bbox

STYLE = {
    "figure.dpi": 110,
    "savefig.dpi": 160,
    "font.size": 9.5,
    "axes.titlesize": 10,
    "axes.grid": True,
    "grid.color": "0.9",
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "pdf.fonttype": 42,
    "svg.hashsalt": "apesim",
}


FOOT_SIZE = 7.5
"""Size of the conditions below a figure [pt]."""
FOOT_LINE = 1.35 * FOOT_SIZE / 72.0
"""Height of a line of them [inch]."""
FOOT_STEP = 0.05
"""Whole pixels at any resolution that is a multiple of 20, so that the figure above is not blurred [inch]."""


def save(figure, folder, name, conditions=""):
    """Write a figure as PNG and PDF, the same bytes each time.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    folder : path
    name : str
    conditions : str
        What the figure was made at, written below it; the figure itself stays as it is.

    Returns
    -------
    list of Path
    """
    _lay_out(figure)
    width, height = figure.get_size_inches()
    foot = ceil(FOOT_LINE * (len(conditions.splitlines()) + 0.5) / FOOT_STEP) * FOOT_STEP if conditions else 0.0
    if conditions:
        _hold_legends(figure)
        figure.text(0.01, 0.0, conditions, va="top", fontsize=FOOT_SIZE, color="0.35", linespacing=1.2)
    whole = Bbox([[0.0, -foot], [width, height]])
    paths = [Path(folder) / f"{name}.png", Path(folder) / f"{name}.pdf"]
    figure.savefig(paths[0], bbox_inches=whole, metadata={"Software": None})
    figure.savefig(paths[1], bbox_inches=whole, metadata={"CreationDate": None, "Producer": None, "Creator": None})
    plt.close(figure)
    return paths


def _hold_legends(figure):
    """Keep the figure's own legends where they are: they would go along with its lower edge."""
    for legend in figure.legends:
        box = legend.get_window_extent().transformed(figure.transFigure.inverted())
        legend.borderaxespad = 0.0
        legend.set_loc("lower left")
        legend.set_bbox_to_anchor((box.x0, box.y0), transform=figure.transFigure)


def svg(figure):
    """A figure as SVG, the same text each time; to be called before `save`, which closes it."""
    _lay_out(figure)
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    return text.getvalue()


def _lay_out(figure):
    """Place all of a figure once, for every format: it takes longer than drawing."""
    if isinstance(figure.get_layout_engine(), ConstrainedLayoutEngine):
        figure.draw_without_rendering()
        figure.set_layout_engine("none")


def draw(figures, folder, conditions=""):
    """Draw and write figures.

    Parameters
    ----------
    figures : dict of str to function
        What draws each figure, by the name of its file.
    folder : path
        Made if it does not exist.
    conditions : str
        What they were made at, see `apesim.studies.figures.conditions.conditions_of`.

    Returns
    -------
    list of Path
    """
    Path(folder).mkdir(parents=True, exist_ok=True)
    with plt.rc_context(STYLE):
        return [path for name, make in figures.items() for path in save(make(), folder, name, conditions)]
