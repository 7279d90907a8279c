"""Figures and their panels: opening them, naming their axes with units, lines and legend entries that many have."""

import re
import textwrap
from collections.abc import Sequence
from functools import partial
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D

from apesim.archive import Archive
from apesim.studies.drawing.style import GREY

ONE, TWO = (7.4, 3.8), (9.2, 3.9)
"""Usual size of a figure with one panel, and of one with two side by side [inch]."""
MIN_GAP = 4.0
"""Gap between samples over the usual step, from which no line is drawn across: a few cells may be missing."""
MAX_COLUMNS = 3
"""Panels side by side: more would make a strip that no page and no screen shows."""
LABEL_LETTERS = 44
"""Letters on a line of a legend: half the width of a page."""
NO_BREAK = "\N{NO-BREAK SPACE}"
"""What stands for a space where a line must not break."""
MIN_FREE = 0.3
"""Share of a panel that lines keep at least below a legend that stands above them."""
MIN_TITLE = 20
"""Letters of a title from which it is measured: shorter ones fit any panel."""
Side = Literal["lower", "upper"]
"""Places of the legend of a figure: below the panels, or above them."""
OUTSIDE: dict[Side, Literal["outside lower center", "outside upper center"]] = {
    "lower": "outside lower center",
    "upper": "outside upper center",
}
"""What matplotlib calls these places."""
MAX_SPECIFIC_AIR = 150.0
"""Upper end of axes of specific air [kg/kWh]: it grows without bound as the work goes to zero."""


def open_panels(rows: int, columns: int, size: tuple[float, float], **options: Any) -> tuple[Figure, np.ndarray]:
    """Open a figure with a (rows, columns) grid of panels, laid out so that no texts overlap.

    `size` is width and height [inch], `options` are those of `matplotlib.figure.Figure.subplots`. The figure belongs to
    no window and to no backend, so that it can be drawn anywhere, and is gone when it is no longer used.
    """
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def open_row(count: int, size: tuple[float, float] = TWO, **options: Any) -> tuple[Figure, np.ndarray]:
    """Open a figure of width and height `size` [inch] with panels side by side, (count,); see `open_panels`."""
    figure, panels = open_panels(1, count, size, **options)
    return figure, panels[0]


def open_column(count: int, size: tuple[float, float], **options: Any) -> tuple[Figure, np.ndarray]:
    """Open a figure with panels one above the other, (count,), which share the x axis; see `open_panels`.

    `size` is width and height of the figure [inch].
    """
    figure, panels = open_panels(count, 1, size, sharex=True, **options)
    return figure, panels[:, 0]


def open_one(size: tuple[float, float] = ONE) -> tuple[Figure, Axes]:
    """Open a figure of width and height `size` [inch] with one panel; see `open_panels`."""
    figure, panels = open_panels(1, 1, size)
    return figure, panels[0, 0]


def open_wrapped(count: int, panel: tuple[float, float], **options: Any) -> tuple[Figure, np.ndarray]:
    """Open a figure with panels side by side, (count,), `MAX_COLUMNS` a row; see `open_panels`.

    `panel` is width and height of each [inch]; those that are left over in the last row are gone.
    """
    columns = max(min(count, MAX_COLUMNS), 1)
    rows = max(-(-count // columns), 1)
    figure, panels = open_panels(rows, columns, (panel[0] * columns, panel[1] * rows), **options)
    for axis in panels.ravel()[count:]:
        axis.remove()
    return figure, panels.ravel()[:count]


def add_legend(axis: Axes, **options: Any) -> None:
    """Add a legend to a panel where none of its lines runs: where there is room, else above them all.

    The upper limit of `axis` is raised where no place is free; `options` are those of `matplotlib.axes.Axes.legend`.
    """
    handles = options.get("handles") or axis.get_legend_handles_labels()[0]
    if not handles:
        return
    figure = axis.get_figure(root=True)
    assert figure is not None
    axis.legend(loc="best", **options)
    figure.draw_without_rendering()
    if not _is_covered(axis):
        return
    axis.legend(loc="upper center", **{"ncols": min(len(handles), MAX_COLUMNS)} | options)
    figure.draw_without_rendering()
    legend = axis.get_legend()
    assert legend is not None
    free = 1.0 - (legend.get_window_extent().height + 12.0) / axis.get_window_extent().height
    if free <= MIN_FREE and isinstance(figure.get_layout_engine(), ConstrainedLayoutEngine):
        # Taller than the panel bears: beside it, in a figure that makes room for it.
        axis.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0), borderaxespad=0.0, **options)
        return
    scale = axis.transScale
    low, high = (scale.transform((1.0, end))[1] for end in axis.get_ylim())
    axis.set_ylim(top=scale.inverted().transform((1.0, low + (high - low) / max(free, MIN_FREE)))[1])


def _is_covered(axis: Axes) -> bool:
    """Whether a line, a marker, a bar or a text of a panel runs through its legend."""
    legend = axis.get_legend()
    assert legend is not None
    box = legend.get_window_extent().padded(2.0)
    for line in axis.lines:
        path = line.get_transform().transform_path(line.get_path()).cleaned(remove_nans=True, curves=False)
        points = np.asarray(path.vertices)
        half = 0.5 * line.get_markersize() if line.get_marker() != "None" else 0.0
        if len(points) and box.padded(half).count_contains(points[:-1]):
            return True
        if line.get_linestyle() != "None" and len(points) > 1 and path.intersects_bbox(box, filled=False):
            return True
    bars = [collection for collection in axis.collections if isinstance(collection, LineCollection)]
    paths = (bar.get_transform().transform_path(path) for bar in bars for path in bar.get_paths())
    if any(path.intersects_bbox(box, filled=False) for path in paths):
        return True
    whole = axis.get_window_extent()
    patches = [patch.get_window_extent() for patch in axis.patches]
    others = [patch for patch in patches if patch.height < whole.height and patch.width < whole.width]
    others += [text.get_window_extent() for text in axis.texts]
    return any(other.overlaps(box) for other in others)


def add_figure_legend(figure: Figure, handles: Sequence[Any], *, side: Side = "lower", **options: Any) -> None:
    """Add a legend outside all panels, in as many columns as the figure is wide; long labels are wrapped.

    It explains `handles` by their labels, and stands below the panels or, with "upper", above them; `options` are those
    of `matplotlib.figure.Figure.legend`.
    """
    labels = [textwrap.fill(str(handle.get_label()), LABEL_LETTERS) for handle in handles]
    for ncols in range(max(len(handles), 1), 0, -1):
        legend = figure.legend(handles, labels, loc=OUTSIDE[side], ncols=ncols, **options)
        if ncols == 1 or legend.get_window_extent().width < figure.bbox.width:
            return
        legend.remove()


def label_axes(
    axis: Axes, *, x: tuple[str, str] | None = None, y: tuple[str, str] | None = None, title: str | None = None
) -> None:
    """Write names with units at the axes of a panel, and its title.

    `x` and `y` are name and unit, "" being that of a pure number or of words; what is None stays as it is.
    """
    if x is not None:
        axis.set_xlabel(named(*x))
    if y is not None:
        axis.set_ylabel(named(*y))
    if title is not None:
        add_title(axis, title)


def add_title(axis: Axes, title: str) -> None:
    """Give a panel a title, in as many lines as its width asks for."""
    axis.set_title(title)
    if len(title) < MIN_TITLE:
        return
    lines = title.split("\n")
    too_wide = axis.title.get_window_extent().width / axis.get_window_extent().width
    if too_wide > 1.0:
        letters = int(max(map(len, lines)) / too_wide)
        axis.set_title("\n".join(_in_even_lines(line, letters) for line in lines))


def fit_titles(figure: Figure) -> bool:
    """Break titles that are wider than their panels, when these are placed; say whether there were such."""
    titles = [axis.get_title() for axis in figure.axes]
    for axis, title in zip(figure.axes, titles, strict=True):
        add_title(axis, title)
    return titles != [axis.get_title() for axis in figure.axes]


def _in_even_lines(text: str, letters: int) -> str:
    """Break a text into as few lines of so many letters at most as it takes, each about as long as the others.

    It is broken behind its commas and semicolons, unless what stands between these is longer than a line.

    >>> _in_even_lines("supply pressure 0.9 MPa gauge, 800 r/min, 300 K", 36).splitlines()
    ['supply pressure 0.9 MPa gauge,', '800 r/min, 300 K']
    """
    parts = split_at_commas(text)
    if max(map(len, parts)) <= letters:
        text = " ".join(part.replace(" ", NO_BREAK) for part in parts)
    wrap = partial(textwrap.wrap, text, break_long_words=False)
    count = len(wrap(letters))
    widths = range(max(len(text) // max(count, 1), 1), letters)
    evenly = (wrapped for width in widths if len(wrapped := wrap(width)) == count)
    return "\n".join(next(evenly, wrap(letters))).replace(NO_BREAK, " ")


def split_at_commas(text: str) -> list[str]:
    """Split a text behind its commas and semicolons, each of which stays with what is before it."""
    return re.split(r"(?<=[,;]) ", text)


def named(name: str, unit: str) -> str:
    """A name with its unit in brackets; the name alone where the unit is ""."""
    return f"{name} [{unit}]" if unit else name


def draw_zero(axis: Axes, *, colour: str = "0.6", width: float = 0.8) -> None:
    """Draw the line at zero of the y axis, so wide [pt]."""
    axis.axhline(0.0, color=colour, lw=width)


def add_legend_entry(axis: Axes, label: str, **look: Any) -> None:
    """Add an entry to the legend of a panel for which nothing is drawn, e.g. what a dashed line means.

    `look` holds options of `matplotlib.axes.Axes.plot`.
    """
    axis.plot([], [], label=label, **{"color": GREY} | look)


def legend_handle(**look: Any) -> Line2D:
    """A line for a legend that is drawn nowhere else; `look` holds options of `matplotlib.lines.Line2D`."""
    return Line2D([], [], **look)


def columns_of(archive: Archive) -> dict[str, np.ndarray]:
    """Values of all variables of an archive, by name."""
    return {name: variable.values for name, variable in archive.variables.items()}


def gauge_in_mpa(pressure: np.ndarray, ambient_pressure: float) -> np.ndarray:
    """Gauge pressure as figures show it [MPa gauge], from a pressure, float or array, and the ambient one [Pa abs].

    >>> gauge_in_mpa(np.array([0.6e6, 1.1e6]), 0.1e6)
    array([0.5, 1. ])
    """
    return (pressure - ambient_pressure) / 1e6


def break_at_gaps(x: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Break a line where samples are far apart, so that none is drawn over what nobody measured.

    `x` ascends. The result has a NaN among the values in each gap that is longer than `MIN_GAP` usual steps.

    >>> x, values = break_at_gaps(np.array([0.0, 1.0, 2.0, 12.0, 13.0]), np.arange(5.0))
    >>> values.tolist()
    [0.0, 1.0, 2.0, nan, 3.0, 4.0]
    """
    gaps = find_gaps(x)
    return np.insert(x, gaps, x[gaps]), np.insert(values, gaps, np.nan)


def find_gaps(x: np.ndarray) -> np.ndarray:
    """Find the first sample behind each gap that is longer than `MIN_GAP` usual steps of the ascending x, (k,)."""
    steps = np.diff(x)
    return np.flatnonzero(steps > MIN_GAP * np.median(steps)) + 1 if len(steps) else np.empty(0, dtype=np.int64)
