"""Parts of inline SVG: ticks, axes, thinned paths, markers and legends, each as text."""

from collections.abc import Iterable, Sequence
from html import escape
from math import ceil, floor, log10

import numpy as np

WIDTH = 480.0
"""Width of a still picture in its own units: a phone shows it a quarter smaller, half a desk's screen a bit larger."""
LETTER = 12.5
"""Size of letters."""
LETTER_WIDTH = 0.54 * LETTER
"""Mean width of a letter, as far as it is known without a font."""
Tick = tuple[float, str]
"""Place of a tick on its axis, and its text."""
DASHES = ("", "8 4", "2 3", "11 3 2 3", "16 4", "5 2 1 2")
"""Dashes of lines by number, as in the script."""
COLOURS = 8
"""Colours of lines that the style has."""
TOLERANCE = 0.25
"""Distance from a path within which its points are left out; half a pixel of a large screen."""


def find_ticks(low: float, high: float, count: int) -> tuple[list[float], int]:
    """Find round numbers between two ends, about `count`, and how many decimals they need.

    >>> find_ticks(-2.0, 11.0, 3)
    ([0.0, 5.0, 10.0], 0)
    """
    raw = (high - low) / max(count, 1)
    power = 10.0 ** floor(log10(raw))
    step = power * next(factor for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= 0.999 * raw)
    first, last = ceil(low / step - 1e-9), floor(high / step + 1e-9)
    return [k * step for k in range(first, last + 1)], max(0, -floor(log10(step) + 1e-9))


def write_tick(value: float, decimals: int) -> str:
    """Write the number of a tick with a true minus."""
    text = f"{value:.{decimals}f}"
    return text.replace("-", "−") if float(text) else text.removeprefix("-")


def write_text(x: float, y: float, text: str, anchor: str = "start", more: str = "") -> str:
    """Write a text at a point; whatever it holds stays text."""
    where = f' text-anchor="{anchor}"' if anchor != "start" else ""
    return f'<text x="{x:.1f}" y="{y:.1f}" font-size="{LETTER}"{where}{more}>{escape(text)}</text>'


def write_rect(x: float, y: float, width: float, height: float, look: str, title: str = "") -> str:
    """Write a rectangle by its upper left corner; `look` are its other attributes, `title` what the pointer is told."""
    box = f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" {look}'
    return f"{box}><title>{escape(title)}</title></rect>" if title else f"{box}/>"


def thin_path(points: np.ndarray, tolerance: float = TOLERANCE) -> np.ndarray:
    """Leave out points of a path that lie near the lines between those that stay, after Ramer, Douglas and Peucker.

    `points` is (n, 2), without NaN, and `tolerance` the farthest that one lies away.

    >>> thin_path(np.array([[0.0, 0.0], [1.0, 0.01], [2.0, 0.0], [2.0, 5.0]])).tolist()
    [[0.0, 0.0], [2.0, 0.0], [2.0, 5.0]]
    """
    stays = np.zeros(len(points), dtype=bool)
    stays[[0, -1]] = True
    spans = [(0, len(points) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        along, away = points[last] - points[first], points[first + 1 : last] - points[first]
        length = np.hypot(*along)
        distance = np.abs(along[0] * away[:, 1] - along[1] * away[:, 0]) / length if length else np.hypot(*away.T)
        farthest = int(distance.argmax())
        if distance[farthest] > tolerance:
            middle = first + 1 + farthest
            stays[middle] = True
            spans += [(first, middle), (middle, last)]
    return points[stays]


def write_path(x: np.ndarray, y: np.ndarray) -> str:
    """Write the outline of a line in picture units, broken where a number is missing, as an SVG path's text."""
    points = np.column_stack([x, y])
    is_there = np.isfinite(points).all(axis=1)
    parts = []
    for part in np.split(np.arange(len(points)), np.flatnonzero(np.diff(is_there)) + 1):
        if len(part) and is_there[part[0]]:
            drawn = thin_path(points[part]) if len(part) > 2 else points[part]
            parts.append("M" + "L".join(f"{_short(a)} {_short(b)}" for a, b in drawn))
    return "".join(parts)


def _short(value: float) -> str:
    """A coordinate with one decimal where it needs one."""
    return f"{value:.1f}".removesuffix(".0")


def write_marker(kind: int, x: float, y: float, r: float = 3.4) -> str:
    """Write the outline of a marker about a point as an SVG path's text; the shapes are those of the script."""
    at, wide = f"M{_short(x - r)} {_short(y - r)}", 1.3 * r
    shapes = (
        f"M{_short(x - r)} {_short(y)}a{r} {r} 0 1 0 {2 * r:g} 0a{r} {r} 0 1 0 {-2 * r:g} 0z",
        f"{at}h{2 * r:g}v{2 * r:g}h{-2 * r:g}z",
        f"M{_short(x)} {_short(y - 1.2 * r)}l{1.1 * r:.1f} {2.1 * r:.1f}h{-2.2 * r:.1f}z",
        f"M{_short(x)} {_short(y - wide)}l{wide:.1f} {wide:.1f}l{-wide:.1f} {wide:.1f}l{-wide:.1f} {-wide:.1f}z",
        f"M{_short(x)} {_short(y + 1.2 * r)}l{1.1 * r:.1f} {-2.1 * r:.1f}h{-2.2 * r:.1f}z",
        f"{at}l{2 * r:g} {2 * r:g}M{_short(x - r)} {_short(y + r)}l{2 * r:g} {-2 * r:g}",
    )
    return shapes[kind % len(shapes)]


class Plot:
    """Plot with two axes within a picture: where numbers lie, and the grid with its ticks as SVG."""

    def __init__(
        self,
        x_range: tuple[float, float],
        y_range: tuple[float, float],
        height: float,
        right: float = 16.0,
        y_ticks: Sequence[Tick] = (),
    ) -> None:
        """Place a plot in a picture of a height, so far from its right edge; `y_ticks` replace round numbers."""
        self.x_range, self.y_range, self.height = x_range, y_range, height
        found, decimals = find_ticks(*y_range, 5)
        ticks = list(y_ticks) or [(value, write_tick(value, decimals)) for value in found]
        self.y_ticks, self.y_texts = [value for value, _ in ticks], [text for _, text in ticks]
        self.left = 14.0 + LETTER_WIDTH * max(map(len, self.y_texts), default=1)
        self.right, self.top, self.bottom = WIDTH - right, 24.0, height - 38.0

    def to_x(self, x: np.ndarray) -> np.ndarray:
        """Places of numbers along the x axis."""
        low, high = self.x_range
        return self.left + (np.asarray(x, dtype=float) - low) / (high - low) * (self.right - self.left)

    def to_y(self, y: np.ndarray) -> np.ndarray:
        """Places of numbers along the y axis."""
        low, high = self.y_range
        return self.bottom - (np.asarray(y, dtype=float) - low) / (high - low) * (self.bottom - self.top)

    def write_axes(self, x_name: str, y_name: str, x_ticks: Sequence[Tick] = ()) -> Iterable[str]:
        """Write grid, ticks and names; `x_ticks` are those along x where they are not to be round numbers."""
        ticks = list(x_ticks)
        if not ticks:
            found, decimals = find_ticks(*self.x_range, 5)
            ticks = [(value, write_tick(value, decimals)) for value in found]
        xs = self.to_x(np.array([value for value, _ in ticks]))
        ys = self.to_y(np.array(self.y_ticks))
        lines = "".join(f"M{_short(x)} {self.top:g}V{self.bottom:g}" for x in xs)
        lines += "".join(f"M{self.left:.1f} {_short(y)}H{self.right:g}" for y in ys)
        yield f'<path class="grid" d="{lines}"/>'
        yield f'<path class="axis" d="M{self.left:.1f} {self.top:g}V{self.bottom:g}H{self.right:g}"/>'
        yield from (write_text(x, self.bottom + 16.0, text, "middle") for x, (_, text) in zip(xs, ticks, strict=True))
        yield from (write_text(self.left - 6.0, y + 4.0, text, "end") for y, text in zip(ys, self.y_texts, strict=True))
        yield write_text(0.5 * (self.left + self.right), self.bottom + 33.0, x_name, "middle")
        yield write_text(2.0, 13.0, y_name, more=' class="strong"')


def open_picture(height: float, title: str) -> str:
    """Begin a picture that scales with its place; its title is what a screen reader says."""
    return f'<svg viewBox="0 0 {WIDTH:g} {height:g}" role="img" aria-label="{escape(title)}">'


def place_legend(labels: Sequence[str], swatch: float = 36.0) -> tuple[list[tuple[float, int]], int]:
    """Place entries of a legend in rows as wide as a picture: x and row of each, and how many rows there are."""
    places, x, row = [], 4.0, 0
    for label in labels:
        width = swatch + LETTER_WIDTH * len(label) + 16.0
        if x > 4.0 and x + width > WIDTH:
            x, row = 4.0, row + 1
        places.append((x, row))
        x += width
    return places, row + 1 if labels else 0
