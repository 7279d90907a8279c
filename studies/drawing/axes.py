"""Axes to draw on; importing this module sets no backend, so that notebooks show what is drawn."""

import difflib
from collections.abc import Collection
from typing import TYPE_CHECKING

from apesim.quantities import Fault, InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def axes_for(ax: "Axes | None" = None) -> "Axes":
    """Take the axes of a user, or those of a new figure."""
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    _, ax = plt.subplots(layout="constrained")
    return ax


def check_plotted(what: str, plots: Collection[str]) -> None:
    """Refuse what a result cannot draw, with the nearest of its `plots`, or all of them."""
    if what not in plots:
        near = difflib.get_close_matches(str(what), plots, n=1)
        right = f"did you mean {near[0]}?" if near else f"give one of {', '.join(plots)}"
        raise InputError([Fault("plot()", "what", f"there is no plot of {what}", right)])
