"""Maps: a number over two axes as coloured cells, with their values where there is room, and a scale beside."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from apesim.studies.report.figures.drawing import (
    LETTER,
    LETTER_WIDTH,
    Plot,
    find_ticks,
    open_picture,
    write_rect,
    write_text,
    write_tick,
)
from apesim.studies.report.figures.labels import ONE_FRAME, Axis, Frames, format_number, spread_ranges
from apesim.studies.report.figures.packing import ArrayPool

HEIGHT = 300.0
"""Height of a map."""
SCALE = 96.0
"""Width that the scale of colours takes at the right."""
ANCHORS = ("#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725")
"""Colours of viridis at nine places: dark to bright in grey print, too."""
MAX_WRITTEN = 80
"""Cells up to which each one bears its value."""
DARK = 0.55
"""Place of the scale below which a value is written white."""
OVERLAP = 0.3
"""What a cell reaches over its neighbour, so that no line shines through between them."""
STEPS = 24
"""Steps of the scale of colours."""


@dataclass(frozen=True)
class Map:
    """A number over a grid of two axes, for each frame."""

    title: str
    x: Axis
    y: Axis
    z: Axis
    x_values: np.ndarray
    y_values: np.ndarray
    values: Sequence[np.ndarray]
    """Numbers (len(y_values), len(x_values)) for each frame or for all; NaN where there is none."""
    note: str = ""
    frames: Frames = ONE_FRAME

    kind = "map"

    def write_still(self) -> str:
        """Write the picture of the frame that is shown first."""
        edges_x, edges_y = find_edges(self.x_values), find_edges(self.y_values)
        plot = self._open_plot(edges_x, edges_y)
        low, high = self.find_range()
        values = self.values[self.frames.start % len(self.values)]
        is_written = values.size <= MAX_WRITTEN and plot.right - plot.left > 5 * LETTER_WIDTH * len(self.x_values)
        x_ticks = _find_sparse_ticks(self.x_values, plot.right - plot.left, across=True)
        parts = [open_picture(HEIGHT, f"{self.z.named} over {self.x.named} and {self.y.named}")]
        parts += plot.write_axes(self.x.named, self.y.named, x_ticks)
        cells, texts = [], []
        xs, ys = plot.to_x(edges_x), plot.to_y(edges_y)
        for row, column in np.argwhere(np.isfinite(values)):
            share = (values[row, column] - low) / (high - low)
            x, y, width, height = xs[column], ys[row + 1], xs[column + 1] - xs[column], ys[row] - ys[row + 1]
            cells.append(write_rect(x, y, width + OVERLAP, height + OVERLAP, f'fill="{find_colour(share)}"'))
            if is_written and height > LETTER:
                look = f' class="in" style="fill:{"#fff" if share < DARK else "#000"}"'
                text = format_number(float(values[row, column]), 3)
                texts.append(write_text(x + 0.5 * width, y + 0.5 * height + 4.0, text, "middle", look))
        parts += [f'<g class="cells">{"".join(cells)}</g>', *texts, *self._write_scale(plot, low, high)]
        return "".join([*parts, "</svg>"])

    def _open_plot(self, edges_x: np.ndarray, edges_y: np.ndarray) -> Plot:
        """Place the map in its picture, with a tick for each row of cells that has room for one."""
        ends = (edges_x[0], edges_x[-1]), (edges_y[0], edges_y[-1])
        return Plot(*ends, HEIGHT, right=SCALE, y_ticks=_find_sparse_ticks(self.y_values, HEIGHT - 62.0, across=False))

    def find_range(self) -> tuple[float, float]:
        """Ends of the scale of colours, for all frames."""
        if self.z.range:
            return self.z.range
        low, high = spread_ranges(np.concatenate([values.ravel() for values in self.values]), 0.0) or (0.0, 1.0)
        return (low, high) if high > low else (low - 0.5, high + 0.5)

    def _write_scale(self, plot: Plot, low: float, high: float) -> list[str]:
        """Write the scale of colours with its ticks."""
        x, height = plot.right + 14.0, plot.bottom - plot.top
        step = height / STEPS
        looks = [f'fill="{find_colour((k + 0.5) / STEPS)}"' for k in range(STEPS)]
        steps = [
            write_rect(x, plot.bottom - (k + 1) * step, 14.0, step + OVERLAP, look) for k, look in enumerate(looks)
        ]
        ticks, decimals = find_ticks(low, high, 5)
        texts = [
            write_text(x + 19.0, plot.bottom - (value - low) / (high - low) * height + 4.0, write_tick(value, decimals))
            for value in ticks
        ]
        return [*steps, *texts, write_text(478.0, 13.0, self.z.unit, "end")]

    def data(self, pool: ArrayPool) -> dict[str, Any]:
        """The figure as the script takes it: where the cells lie in the picture, and their numbers."""
        edges_x, edges_y = find_edges(self.x_values), find_edges(self.y_values)
        plot = self._open_plot(edges_x, edges_y)
        return {
            "kind": "map",
            "x": self.x.data
            | {"values": pool.add(self.x_values), "edges": [round(float(x), 1) for x in plot.to_x(edges_x)]},
            "y": self.y.data
            | {"values": pool.add(self.y_values), "edges": [round(float(y), 1) for y in plot.to_y(edges_y)]},
            "z": self.z.data | {"range": list(self.find_range())},
            "values": [pool.add(values.ravel()) for values in self.values],
        }


def find_edges(places: np.ndarray) -> np.ndarray:
    """Find the edges of cells about places that ascend: half way between neighbours.

    >>> find_edges(np.array([1.0, 2.0, 4.0])).tolist()
    [0.5, 1.5, 3.0, 5.0]
    """
    if len(places) == 1:
        half = 0.05 * abs(float(places[0])) or 0.5
        return np.array([places[0] - half, places[0] + half])
    middle = 0.5 * (places[1:] + places[:-1])
    return np.concatenate([[2.0 * places[0] - middle[0]], middle, [2.0 * places[-1] - middle[-1]]])


def find_colour(share: float) -> str:
    """Find the colour at a place of the scale, 0 to 1.

    >>> find_colour(0.0), find_colour(1.0), find_colour(0.5)
    ('#440154', '#fde725', '#21918c')
    """
    place = min(max(share, 0.0), 1.0) * (len(ANCHORS) - 1)
    first = min(int(place), len(ANCHORS) - 2)
    mix = place - first
    low, high = (tuple(int(text[k : k + 2], 16) for k in (1, 3, 5)) for text in ANCHORS[first : first + 2])
    return "#" + "".join(f"{round(a + mix * (b - a)):02x}" for a, b in zip(low, high, strict=True))


def _find_sparse_ticks(values: np.ndarray, room: float, *, across: bool) -> list[tuple[float, str]]:
    """Ticks at the places of cells, as many as there is room for across the picture, or up it."""
    texts = [format_number(float(value)) for value in values]
    size = LETTER_WIDTH * (max(map(len, texts)) + 1.5) if across else 1.4 * LETTER
    step = max(1, -(-len(values) * size // room))
    return [(float(value), text) for value, text in list(zip(values, texts, strict=True))[:: int(step)]]
