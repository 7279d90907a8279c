"""Curves over an axis, and loops such as p-V: several lines told apart by colour, dash and marker."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from apesim.studies.report.figures.drawing import (
    COLOURS,
    DASHES,
    LETTER,
    Plot,
    open_picture,
    place_legend,
    write_marker,
    write_path,
    write_text,
)
from apesim.studies.report.figures.labels import ONE_FRAME, Axis, Frames, spread_ranges
from apesim.studies.report.figures.packing import ArrayPool

MAX_MARKED = 60
"""Samples up to which each one bears a marker, as in the script."""
ROOM = 0.025
"""Share of the x axis that is left free at each end, for markers."""
HEIGHT = 270.0
"""Height of a picture without its legend."""


@dataclass(frozen=True)
class Line:
    """One line of a figure, for each frame of it."""

    label: str
    values: Sequence[np.ndarray]
    """Numbers along the line, for each frame or for all."""
    x: Sequence[np.ndarray] | None = None
    """Places along the x axis, where the line has its own."""
    look: int = 0
    """Number of colour, dash and marker."""
    dash: int | None = None
    """Number of the dash, where it is another: lines of one colour."""
    has_line: bool = True
    """False: points alone, such as measured ones."""

    @property
    def dash_number(self) -> int:
        """Place in the list of dashes."""
        return (self.look if self.dash is None else self.dash) % len(DASHES)


@dataclass(frozen=True)
class Curves:
    """Lines over an axis; a loop where x goes forth and back."""

    title: str
    x: Axis
    y: Axis
    lines: Sequence[Line]
    x_values: Sequence[np.ndarray] = ()
    """Places along the x axis, for each frame or for all; none where each line has its own."""
    note: str = ""
    sync: str = ""
    """Figures of one name share the cursor."""
    is_loop: bool = False
    frames: Frames = ONE_FRAME
    name: str = ""
    """Variable of the archive that is drawn, where it is one."""

    kind = "curves"

    def with_ranges(self) -> "Curves":
        """Give both axes ends that hold for all frames, where they have none."""
        xs = [x for line in self.lines for x in (line.x or self.x_values)]
        ys = [values for line in self.lines for values in line.values]
        x_range = self.x.range or spread_ranges(np.concatenate(xs), ROOM)
        y_range = self.y.range or spread_ranges(np.concatenate(ys))
        if x_range and x_range[0] == x_range[1]:
            x_range = x_range[0] - 0.5, x_range[1] + 0.5
        return replace(self, x=self.x._replace(range=x_range), y=self.y._replace(range=y_range))

    def write_still(self) -> str:
        """Write the picture of the frame that is shown first."""
        figure = self.with_ranges()
        if figure.x.range is None or figure.y.range is None:
            return f"<p class=note>{self.y.label}: no numbers</p>"
        plot = Plot(figure.x.range, figure.y.range, HEIGHT)
        places, rows = place_legend([line.label for line in self.lines])
        height = HEIGHT + 18.0 * rows + (6.0 if rows else 0.0)
        parts = [
            open_picture(height, f"{self.y.named} over {self.x.named}"),
            *plot.write_axes(self.x.named, self.y.named),
        ]
        # A picture within the picture cuts off what lies beyond the ends of the axes.
        box = f"{plot.left:.1f} {plot.top:g} {plot.right - plot.left:.1f} {plot.bottom - plot.top:g}"
        left, top, width, depth = box.split()
        parts.append(f'<svg x="{left}" y="{top}" width="{width}" height="{depth}" viewBox="{box}">')
        parts += [*(self._write_line(line, plot) for line in self.lines), "</svg>"]
        for line, (x, row) in zip(self.lines, places, strict=True):
            y = HEIGHT + 14.0 + 18.0 * row
            middle = y - 0.34 * LETTER
            if line.has_line:
                parts.append(f'<path {_stroke(line)} d="M{x:.1f} {middle:.1f}h30"/>')
            if self._is_marked(line):
                parts.append(f'<path {_mark(line)} d="{write_marker(line.look, x + 15.0, middle)}"/>')
            parts.append(write_text(x + 36.0, y, line.label))
        return "".join([*parts, "</svg>"])

    def _write_line(self, line: Line, plot: Plot) -> str:
        """Write a line in its frame, with its markers."""
        xs = line.x or self.x_values
        x, y = plot.to_x(xs[self.frames.start % len(xs)]), plot.to_y(line.values[self.frames.start % len(line.values)])
        text = f'<path {_stroke(line)} d="{write_path(x, y)}"/>' if line.has_line else ""
        if self._is_marked(line):
            is_there = np.isfinite(x) & np.isfinite(y)
            marks = "".join(write_marker(line.look, a, b) for a, b in zip(x[is_there], y[is_there], strict=True))
            text += f'<path {_mark(line)} d="{marks}"/>'
        return text

    def _is_marked(self, line: Line) -> bool:
        """Whether each point of a line bears a marker."""
        return not line.has_line or (not self.is_loop and len(line.values[0]) <= MAX_MARKED)

    def data(self, pool: ArrayPool) -> dict[str, Any]:
        """The figure as the script takes it, its arrays in the pool."""
        figure = self.with_ranges()
        return {
            "kind": "loops" if self.is_loop else "curves",
            "x": figure.x.data | {"values": [pool.add(x) for x in self.x_values]},
            "y": figure.y.data,
            "sync": self.sync,
            "series": [
                {
                    "label": line.label,
                    "values": [pool.add(values) for values in line.values],
                    "x": [pool.add(x, is_exact=not line.has_line) for x in line.x] if line.x else None,
                    "colour": line.look % COLOURS,
                    "dash": line.dash_number,
                    "marker": line.look,
                    "line": line.has_line,
                }
                for line in self.lines
            ],
        }


def _stroke(line: Line) -> str:
    """Class and dash of a line."""
    dash = DASHES[line.dash_number]
    return f'class="l k{line.look % COLOURS}"' + (f' stroke-dasharray="{dash}"' if dash else "")


def _mark(line: Line) -> str:
    """Class of the markers of a line; those of points alone are filled."""
    filled = "" if line.has_line else " f"
    return f'class="m k{line.look % COLOURS}{filled}"'
