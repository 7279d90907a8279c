"""Rings: angles of the crank from which engines start, around a circle, one ring for each engine."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from math import cos, radians, sin
from typing import Any

from apesim.studies.report.figures.drawing import COLOURS, LETTER, WIDTH, open_picture, write_text
from apesim.studies.report.figures.labels import ONE_FRAME, Frames
from apesim.studies.report.figures.packing import ArrayPool

OUTER, INNER = 128.0, 44.0
"""Radii of the outermost and the innermost ring."""
CENTRE = 170.0
"""Height of the middle of the circle."""
FULL = 359.99
"""Length of an arc that is drawn as a whole circle [deg]: an arc that ends where it begins is nothing."""


@dataclass(frozen=True)
class Rings:
    """Intervals of angles [deg] for each of several engines, from the inside out; zero is the top dead centre."""

    title: str
    rows: Sequence[tuple[str, Sequence[tuple[float, float]]]]
    note: str = ""
    frames: Frames = ONE_FRAME

    kind = "rings"

    def write_still(self) -> str:
        """Write the picture: arcs, spokes each 30 degrees, and a legend."""
        x = 0.5 * WIDTH
        step = (OUTER - INNER) / max(len(self.rows), 1)
        width = min(0.72 * step, 22.0)
        height = CENTRE + OUTER + 34.0 + 18.0 * len(self.rows)
        parts = [open_picture(height, self.title)]
        spokes = "".join(
            "M{:.1f} {:.1f}L{:.1f} {:.1f}".format(*_at(x, INNER, angle), *_at(x, OUTER + 6.0, angle))
            for angle in range(0, 360, 30)
        )
        parts.append(f'<path class="grid" d="{spokes}"/>')
        for angle in range(0, 360, 30):
            px, py = _at(x, OUTER + 19.0, angle)
            parts.append(write_text(px, py + 4.0, f"{angle}°", "middle"))
        for number, (label, intervals) in enumerate(self.rows):
            radius, colour = INNER + step * (number + 0.5), f"k{number % COLOURS}"
            parts.append(f'<circle class="grid" cx="{x:g}" cy="{CENTRE:g}" r="{radius:.1f}"/>')
            look = f'class="{colour}" fill="none" stroke-width="{width:.1f}"'
            for low, high in intervals:
                said = escape(f"{label}: {low:.1f} to {high % 360.0:.1f} deg")
                parts.append(f'<path {look} d="{_arc(x, radius, low, high)}"><title>{said}</title></path>')
            y = CENTRE + OUTER + 44.0 + 18.0 * number
            parts.append(f'<path class="{colour}" stroke-width="9" d="M90 {y - 0.34 * LETTER:.1f}h18"/>')
            parts.append(write_text(116.0, y, f"ring {number + 1}: {label}"))
        return "".join([*parts, "</svg>"])

    def data(self, pool: ArrayPool) -> dict[str, Any] | None:
        """Nothing: the picture itself answers to the pointer, by the titles of its arcs."""
        return None


def _at(x: float, radius: float, angle: float) -> tuple[float, float]:
    """Point at an angle [deg], clockwise from the top."""
    return x + radius * sin(radians(angle)), CENTRE - radius * cos(radians(angle))


def _arc(x: float, radius: float, low: float, high: float) -> str:
    """Outline of an arc, clockwise."""
    high = min(high, low + FULL)
    (x0, y0), (x1, y1) = _at(x, radius, low), _at(x, radius, high)
    return f"M{x0:.1f} {y0:.1f}A{radius:.1f} {radius:.1f} 0 {int(high - low > 180.0)} 1 {x1:.1f} {y1:.1f}"
