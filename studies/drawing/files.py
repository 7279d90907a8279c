"""How figures are written: PNG to look at, PDF to print, SVG for pages; the same bytes each time."""

import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from math import ceil
from os import PathLike
from pathlib import Path
from typing import Any

import matplotlib
from fontTools.subset import Options
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.transforms import Bbox

from apesim.archive import write_file
from apesim.quantities import Fault, InputError
from apesim.studies.drawing.panels import fit_titles, split_at_commas
from apesim.studies.drawing.style import STYLE
from apesim.studies.execution.output import make_folder, refuse_to_replace
from apesim.studies.execution.pool import done_beside

LEFT_OUT = {"png": ("Software",), "pdf": ("CreationDate", "Producer", "Creator")}
"""Endings of the files of a figure, and metadata that would differ from one time to the next."""
FORMATS = (*LEFT_OUT, "svg")
"""Formats of a figure that a user names."""
LAYOUT_TABLES = ("GDEF", "GPOS", "GSUB")
"""Tables of a font that choose and place its glyphs in a text."""
FOOT_SIZE = 7.5
"""Size of the letters of the conditions below a figure [pt]."""
FOOT_LINE = 1.35 * FOOT_SIZE / 72.0
"""Height of a line of the conditions [inch]."""
FOOT_LETTER = 0.53 * FOOT_SIZE / 72.0
"""Width of a letter of the conditions, as most of them are no wider [inch]."""
FOOT_STEP = 0.05
"""Step in the height of the conditions [inch]: whole pixels at any resolution that is a multiple of 20, so that the
figure above is not blurred."""


def write_figures(
    figures: Mapping[str, Callable[[], Figure]], folder: str | PathLike[str], conditions: str = ""
) -> list[Path]:
    """Draw figures in the house style, and write each as PNG and PDF into a folder, made if it does not exist.

    `figures` holds what draws each, by the name of its file without the ending; `conditions` are as
    `apesim.studies.drawing.conditions.conditions_of` gives them.
    """
    make_folder(folder, overwrite=True)
    names = list(figures)

    def draw(names: Sequence[str]) -> None:
        for name in names:
            save(figures[name](), folder, name, conditions)

    with matplotlib.rc_context(STYLE):
        if len(names) == 1:
            draw(names)
        else:
            with done_beside(partial(draw, names[1::2])):
                draw(names[::2])
    return [path for name in names for path in _paths_of(folder, name)]


def _paths_of(folder: str | PathLike[str], name: str) -> list[Path]:
    """Paths of the files of a figure."""
    return [Path(folder) / f"{name}.{ending}" for ending in LEFT_OUT]


def save(figure: Figure, folder: str | PathLike[str], name: str, conditions: str = "") -> list[Path]:
    """Write a figure as PNG and PDF, the same bytes each time, into a folder that exists.

    `name` is without an ending. `conditions` are written below the figure, which itself stays as it is.
    """
    _lay_out(figure)
    width, height = figure.get_size_inches()
    conditions = _in_lines(conditions, int(0.98 * width / FOOT_LETTER))
    foot = ceil(FOOT_LINE * (len(conditions.splitlines()) + 0.5) / FOOT_STEP) * FOOT_STEP if conditions else 0.0
    if conditions:
        _hold_legends(figure)
        figure.text(0.01, 0.0, conditions, va="top", fontsize=FOOT_SIZE, color="0.35", linespacing=1.2)
    whole = Bbox([[0.0, -foot], [width, height]])
    paths = _paths_of(folder, name)
    for path, (ending, left_out) in zip(paths, LEFT_OUT.items(), strict=True):
        content = io.BytesIO()
        with _fewer_font_tables():
            figure.savefig(content, format=ending, bbox_inches=whole, metadata=dict.fromkeys(left_out))
        write_file(path, content.getvalue())
    return paths


def _in_lines(text: str, letters: int) -> str:
    """Break a text into lines of so many letters at most, behind its commas and semicolons."""
    lines = [""]
    for part in split_at_commas(text):
        if lines[-1] and len(lines[-1]) + 1 + len(part) > letters:
            lines.append(part)
        else:
            lines[-1] = f"{lines[-1]} {part}".strip()
    return "\n".join(lines)


def write_figure(figure: Figure, path: str | PathLike[str], *, overwrite: bool = False) -> None:
    """Write a figure as the one file that a user names, in the format of its ending, the same bytes each time."""
    ending = check_ending(path)
    refuse_to_replace(path, overwrite=overwrite)
    if ending == "svg":
        write_file(path, svg(figure).encode())
        return
    _lay_out(figure)
    content = io.BytesIO()
    figure.savefig(content, format=ending, metadata=dict.fromkeys(LEFT_OUT[ending]))
    write_file(path, content.getvalue())


def check_ending(path: str | PathLike[str]) -> str:
    """Return the format of a figure by the ending of its file, and refuse those that are not written."""
    ending = Path(path).suffix.lstrip(".").lower()
    if ending not in FORMATS:
        right = f"end it with .{', .'.join(FORMATS)}"
        raise InputError([Fault(str(path), "", "has no ending of a figure", right)])
    return ending


@contextmanager
def _fewer_font_tables() -> Iterator[None]:
    """Leave out of the fonts in a PDF what places letters of a text: they are placed, and sorting it out takes long."""
    options: Any = Options
    kept = options._drop_tables_default
    options._drop_tables_default = [*kept, *LAYOUT_TABLES]
    try:
        yield
    finally:
        options._drop_tables_default = kept


def svg(figure: Figure) -> str:
    """Write a figure, which is laid out once, as the text of an SVG, the same each time."""
    _lay_out(figure)
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    return text.getvalue()


def _lay_out(figure: Figure) -> None:
    """Place all of a figure once, for every format: it takes longer than drawing.

    With no engine at all: the placeholder that "none" stands for would have every figure drawn twice.
    """
    if isinstance(figure.get_layout_engine(), ConstrainedLayoutEngine):
        figure.draw_without_rendering()
        if fit_titles(figure):
            figure.draw_without_rendering()
        figure.set_layout_engine(None)


def _hold_legends(figure: Figure) -> None:
    """Keep the figure's own legends where they are: they would go along with its lower edge."""
    for legend in figure.legends:
        box = legend.get_window_extent().transformed(figure.transFigure.inverted())
        legend.borderaxespad = 0.0
        legend.set_loc("lower left")
        legend.set_bbox_to_anchor((box.x0, box.y0), transform=figure.transFigure)
