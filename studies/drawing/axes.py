"""Axes to draw on; importing this module sets no backend, so that notebooks show what is drawn."""

import difflib
from collections.abc import Callable, Collection
from functools import wraps
from typing import TYPE_CHECKING, Any, TypeVar, cast

from apesim.quantities import Fault, InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Plot = TypeVar("Plot", bound=Callable[..., Any])
"""A method that draws on axes, its first argument, or on those of a new figure."""


def axes_for(ax: "Axes | None" = None, **options: Any) -> "Axes":
    """Take the axes of a user, or those of a new figure; `options` are those of `matplotlib.pyplot.subplots`."""
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    _, ax = plt.subplots(layout="constrained", **options)
    return ax


def in_house_style(plot: Plot) -> Plot:
    """Let a method draw its new figures in the style of all figures; a user's axes keep the user's settings.

    What matplotlib is set to holds again when the method returns.
    """

    @wraps(plot)
    def styled(self: Any, ax: "Axes | None" = None, *args: Any, **options: Any) -> "Axes":
        if ax is not None:
            return plot(self, ax, *args, **options)
        import matplotlib

        from apesim.studies.drawing.style import STYLE

        with matplotlib.rc_context(STYLE):
            drawn: Axes = plot(self, None, *args, **options)
            for axis in (drawn.xaxis, drawn.yaxis):
                axis.get_major_ticks(1)  # later ticks, which are made as the figure is drawn, are copies of this one
        return drawn

    return cast("Plot", styled)


def check_plotted(what: str, plots: Collection[str]) -> None:
    """Refuse what a result cannot draw, with the nearest of its `plots`, or all of them."""
    if what not in plots:
        near = difflib.get_close_matches(str(what), plots, n=1)
        right = f"did you mean {near[0]}?" if near else f"give one of {', '.join(plots)}"
        raise InputError([Fault("plot()", "what", f"there is no plot of {what}", right)])
