"""Angles of the crank around a circle: from which of them engines start."""

from typing import TYPE_CHECKING, Any

import numpy as np

from apesim.engine.angles import DEGREE
from apesim.studies.drawing.style import BLUE, GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INNERMOST, SINGLE = 1.2, 2.4
"""Radius of the innermost of several rings, which are 1 apart, and of a single one."""
THICK, THIN = 0.62, 0.07
"""Thickness of a ring where the engine starts and where it does not, so that grey print tells them apart."""
LABEL_HEIGHT = 0.86
"""Height of a label over the radius of its ring: its leader leaves the ring where it is steep."""


def size_for(names: list[str]) -> tuple[float, float]:
    """Size of a figure whose circle has room beside it for the names of its rings [inch]."""
    return (5.8 + 0.085 * max(map(len, names)) if len(names) > 1 else 5.8), 5.8


def open_circle(names: list[str]) -> "Axes":
    """Open a figure with polar axes, for rings of these names."""
    import matplotlib.pyplot as plt

    _, ax = plt.subplots(figsize=size_for(names), subplot_kw={"projection": "polar"}, layout="constrained")
    return ax


def draw_circle(ax: "Axes", rings: list[tuple[tuple[float, float], ...]], names: list[str]) -> None:
    """Draw intervals of angles [deg] as a ring for each of several engines, from the inside out, on polar axes.

    The name of a single ring stands in the middle; those of several stand beside the circle, each led to its ring.
    """
    polar: Any = ax
    polar.set_theta_zero_location("N")
    polar.set_theta_direction(-1)
    first = INNERMOST if len(rings) > 1 else SINGLE
    outside = first + len(rings) - 0.5
    for i, intervals in enumerate(rings):
        radius = first + i
        polar.bar(0.0, THIN, 2.0 * np.pi, bottom=radius - 0.5 * THIN, color="0.6", edgecolor="none", align="edge")
        for low, high in intervals:
            width = (high - low) * DEGREE
            polar.bar(
                low * DEGREE, THICK, width, bottom=radius - 0.5 * THICK, color=BLUE, edgecolor="none", align="edge"
            )
    polar.set_ylim(0.0, outside)
    polar.set_yticks([])
    polar.spines["polar"].set_visible(False)

    # A line every 30 degrees; beside several rings only the quarters are named, as leaders pass where others would be.
    angles = np.arange(0, 360, 30)
    named = angles if len(rings) == 1 else angles[::3]
    polar.set_xticks(angles * DEGREE, [f"{angle}°" if angle in named else "" for angle in angles])
    polar.grid(visible=False)
    polar.vlines(angles * DEGREE, first - 0.5, outside, color="0.88", lw=0.7, zorder=0)
    polar.set_xlabel("angle of the shaft at rest; thick: the engine starts", labelpad=10)
    if len(rings) == 1:
        polar.text(0.0, 0.0, names[0], ha="center", va="center")
        return
    for i, name in enumerate(names):
        _label_ring(polar, first + i, outside, name)


def _label_ring(polar: Any, radius: float, outside: float, name: str) -> None:
    """Write a name beside the circle, and lead it to its ring."""
    from matplotlib.patheffects import Stroke

    # In the plane of the circle: the axes are a square of twice the outer radius.
    height = LABEL_HEIGHT * radius
    start, end = np.sqrt(radius**2 - height**2), 1.22 * outside
    to_axes = [(0.5 + 0.5 * x / outside, 0.5 + 0.5 * height / outside) for x in (start, end)]
    (line,) = polar.plot(*zip(*to_axes, strict=True), transform=polar.transAxes, color=GREY, lw=0.8, clip_on=False)
    line.set_path_effects([Stroke(linewidth=2.4, foreground="white"), Stroke(linewidth=0.8, foreground=GREY)])  # a halo
    polar.plot(*to_axes[0], "o", transform=polar.transAxes, ms=4, mfc="white", mec=GREY, mew=0.9, clip_on=False)
    polar.text(*to_axes[1], f" {name}\N{NO-BREAK SPACE}", transform=polar.transAxes, ha="left", va="center")
