"""Figure of the residuals of every signal over the stroke or cycle."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from apesim.studies.drawing.panels import open_row
from apesim.studies.gap.decide.operating_points import label_point
from apesim.studies.gap.figures.style import MARKS, WIDTH
from apesim.studies.gap.report.comparison import find_display

if TYPE_CHECKING:
    from apesim.studies.gap.report.residual_map import ResidualMap

COLOUR_ENDS = 4.0, 12.0
"""Least and largest end of a map's colours, in standard deviations: below, noise would look like a gap; above, the
small gaps would be white."""
SHARE_SHOWN = 0.98
"""Share of the cells whose values lie within the ends of the colours."""


def plot_residual_map(residuals: "ResidualMap", added: str, ambient_pressure: float) -> Figure:
    """Plot the residuals of every signal over the stroke or cycle, before and after, on one scale.

    `added` says in words what was added to the model; `ambient_pressure` is in [Pa abs].
    """
    pictures = [picture for picture in (residuals.before, residuals.after) if picture is not None]
    limit = float(np.clip(np.nanquantile(np.abs(residuals.before), SHARE_SHOWN), *COLOUR_ENDS))
    figure, panels = open_row(len(pictures), (WIDTH, 1.6 + 0.21 * len(residuals.rows)), sharey=True)
    for axis, picture, title in zip(panels, pictures, ("calibrated model", added), strict=False):
        image = _draw_picture(axis, residuals, picture, limit)
        axis.set_title(title, loc="left")
    labels = [
        f"{find_display(row.block).name}, {label_point(row.block.run, ambient_pressure)}{MARKS[row.role]}"
        for row in residuals.rows
    ]
    panels[0].set_yticks(range(len(labels)), labels, fontsize=7)
    bar = figure.colorbar(image, ax=panels, location="bottom", extend="both", shrink=0.5, aspect=40)
    bar.set_label("model less measured, over what noise leaves of a cell's mean [-]", fontsize=8.5)
    return figure


def _draw_picture(axis: Axes, residuals: "ResidualMap", picture: np.ndarray, limit: float) -> AxesImage:
    """Draw one map, with a line between the rows of different sensors."""
    image = axis.imshow(picture, aspect="auto", cmap="RdBu_r", vmin=-limit, vmax=limit, interpolation="none")
    axis.set_facecolor("0.75")
    axis.grid(visible=False)
    _name_columns(axis, residuals.sections)
    sensors = [row.block.sensor for row in residuals.rows]
    for row in range(1, len(sensors)):
        if sensors[row] != sensors[row - 1]:
            axis.axhline(row - 0.5, color="0.2", lw=0.8)
    return image


def _name_columns(axis: Axes, sections: Sequence[tuple[str, int]]) -> None:
    """Name the sections under their columns; a cycle has its angles there."""
    if len(sections) == 1:
        ((_, columns),) = sections
        axis.set_xticks(np.linspace(0.0, columns, 5) - 0.5, [f"{angle}°" for angle in range(0, 361, 90)])
        axis.set_xlabel("crank angle")
        return
    ends = np.cumsum([0, *(columns for _, columns in sections)]) - 0.5
    for end in ends[1:-1]:
        axis.axvline(end, color="0.2", lw=0.6, ls=":")
    names, middles = [name for name, _ in sections], 0.5 * (ends[1:] + ends[:-1])
    axis.set_xticks(middles, names, rotation=35, ha="right", rotation_mode="anchor", fontsize=7)
    axis.tick_params(axis="x", length=0)
