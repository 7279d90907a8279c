"""Bars of a ledger: what enters, stacked into what it becomes, one bar for each of several machines or runs."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from apesim.studies.report.figures.drawing import (
    LETTER_WIDTH,
    WIDTH,
    open_picture,
    place_legend,
    write_rect,
    write_text,
)
from apesim.studies.report.figures.labels import ONE_FRAME, Frames, format_number
from apesim.studies.report.figures.packing import ArrayPool

BAR, GAP, TOP = 26.0, 22.0, 20.0
"""Height of a bar, of the gap above it with its name, and of what stands above all."""
EDGE = 4.0
"""What is left free at the sides."""
COLOURS = 10
"""Colours of parts that the style has."""
MIN_DRAWN = 0.2
"""Width of a part from which it is drawn."""
MIN_WRITTEN = 30.0
"""Width of a part from which it bears its share."""


@dataclass(frozen=True)
class Bars:
    """Bars of parts, each a share of what enters."""

    title: str
    unit: str
    rows: Sequence[tuple[str, Mapping[str, float]]]
    """Name of each bar, and its parts by name; a part below zero is left to the table."""
    note: str = ""
    frames: Frames = ONE_FRAME

    kind = "bars"

    def write_still(self) -> str:
        """Write the picture: each bar is as long as the sum of its parts over the largest sum."""
        names = list(dict.fromkeys(name for _, parts in self.rows for name in parts))
        totals = [sum(max(value, 0.0) for value in parts.values()) for _, parts in self.rows]
        scale = (WIDTH - 2.0 * EDGE) / (max(totals, default=0.0) or 1.0)
        places, lines = place_legend(names, swatch=20.0)
        foot = TOP + len(self.rows) * (BAR + GAP)
        texts = [open_picture(foot + 12.0 + 19.0 * lines, self.title)]
        for number, (label, parts) in enumerate(self.rows):
            texts += self._write_bar(label, parts, names, TOP + number * (BAR + GAP), scale)
        for number, (name, (x, row)) in enumerate(zip(names, places, strict=True)):
            y = foot + 8.0 + 19.0 * row
            texts.append(write_rect(x, y - 9.0, 13.0, 11.0, f'class="p{number % COLOURS}"'))
            texts.append(write_text(x + 19.0, y + 1.0, name))
        return "".join([*texts, "</svg>"])

    def _write_bar(
        self, label: str, parts: Mapping[str, float], names: Sequence[str], y: float, scale: float
    ) -> Iterator[str]:
        """Write a bar below its name, its parts side by side."""
        total, x = sum(max(value, 0.0) for value in parts.values()), EDGE
        yield write_text(EDGE, y - 5.0, f"{label}: {format_number(total)} {self.unit}", more=' class="strong"')
        for name, value in parts.items():
            width, kind = max(value, 0.0) * scale, names.index(name) % COLOURS
            if width < MIN_DRAWN:
                continue
            share = f"{100.0 * value / total:.0f} %"
            said = f"{label}, {name}: {format_number(value)} {self.unit}, {share}"
            yield write_rect(x, y, width, BAR, f'class="p{kind}"', said)
            if width > max(MIN_WRITTEN, LETTER_WIDTH * (len(share) + 1)):
                look = f' class="on p{kind}t" pointer-events="none"'
                yield write_text(x + 0.5 * width, y + 17.5, share, "middle", look)
            x += width

    def data(self, pool: ArrayPool) -> dict[str, Any] | None:
        """Nothing: the picture itself answers to the pointer, by the titles of its parts."""
        return None
