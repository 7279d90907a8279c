"""How all figures look, and how they are written: PNG to look at, PDF to print, the same bytes each time."""

import io
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.layout_engine import ConstrainedLayoutEngine

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


def save(figure, folder, name):
    """Write a figure as PNG and PDF, the same bytes each time.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    folder : path
    name : str

    Returns
    -------
    list of Path
    """
    _lay_out(figure)
    paths = [Path(folder) / f"{name}.png", Path(folder) / f"{name}.pdf"]
    figure.savefig(paths[0], metadata={"Software": None})
    figure.savefig(paths[1], metadata={"CreationDate": None, "Producer": None, "Creator": None})
    plt.close(figure)
    return paths


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


def draw(figures, folder):
    """Draw and write figures.

    Parameters
    ----------
    figures : dict of str to function
        What draws each figure, by the name of its file.
    folder : path
        Made if it does not exist.

    Returns
    -------
    list of Path
    """
    Path(folder).mkdir(parents=True, exist_ok=True)
    with plt.rc_context(STYLE):
        return [path for name, make in figures.items() for path in save(make(), folder, name)]
