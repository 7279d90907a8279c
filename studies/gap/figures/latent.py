"""Figure of what a tabulated effect says, over what it was made to depend on."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from apesim.studies.drawing.panels import MAX_COLUMNS, draw_zero, open_wrapped
from apesim.studies.drawing.style import Look
from apesim.studies.gap.figures.style import AFTER, WIDTH
from apesim.studies.gap.report.effect_rows import NORMAL_95

if TYPE_CHECKING:
    from apesim.studies.gap.tables.latent import Branch


def plot_branches(latent: "Sequence[Branch]") -> Figure:
    """Plot what a table says, a panel for each of its branches.

    >>> import numpy as np
    >>> from apesim.studies.gap.tables.latent import Branch
    >>> places, values = np.array([0.0, 50.0, 100.0]), np.array([0.0, 12.0, 5.0])
    >>> figure = plot_branches([Branch("tabulated_force", "force", places, values, np.ones(3), "N")])
    >>> figure.axes[0].get_ylabel()
    'force to closed [N]'
    """
    figure, panels = open_wrapped(len(latent), (WIDTH / min(len(latent), MAX_COLUMNS), 2.9))
    for axis, branch in zip(panels, latent, strict=True):
        _draw_branch(axis, branch)
    return figure


def _draw_branch(axis: Axes, branch: "Branch") -> Axes:
    """Draw the values of a branch over its nodes, with their intervals of 95 %."""
    draw_zero(axis, colour="0.2")
    if len(branch.positions) > 1:
        axis.plot(*branch.interpolate(), color=AFTER, lw=1.4)
    bars: Look = {"fmt": "o", "color": AFTER, "ms": 4, "elinewidth": 1.0, "capsize": 2}
    axis.errorbar(branch.positions, branch.values, NORMAL_95 * branch.standard_deviations, **bars)
    axis.set(xlabel=branch.abscissa, ylabel=branch.quantity.replace("^2", "²"))
    if branch.is_periodic:
        axis.set_xticks(range(0, 361, 90))
    return axis
