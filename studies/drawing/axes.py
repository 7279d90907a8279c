"""Axes to draw on; importing this module sets no backend, so that notebooks show what is drawn."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def axes_for(ax: "Axes | None" = None) -> "Axes":
    """Take the axes of a user, or those of a new figure."""
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    _, ax = plt.subplots(layout="constrained")
    return ax
