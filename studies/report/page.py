"""The page of a result: its content, machine and provenance in one HTML text, which asks for nothing outside."""

import json
from collections.abc import Sequence
from typing import Any, NamedTuple

import jinja2
from markupsafe import Markup

from apesim.results import Result
from apesim.studies.archives.archive_result import ArchiveResult
from apesim.studies.archives.result_kinds import kind_of
from apesim.studies.measured import Measured
from apesim.studies.report.assets import read_asset
from apesim.studies.report.figures.labels import Frames
from apesim.studies.report.figures.maps import ANCHORS
from apesim.studies.report.figures.packing import ArrayPool
from apesim.studies.report.machine import describe_machine, list_assumptions, list_departures
from apesim.studies.report.measured_points import add_measured
from apesim.studies.report.pages.kinds import BARE, PAGES
from apesim.studies.report.sections import Content, Figure, Section, Table

STYLES = "uplot.min.css", "style.css", "motion.css"
SCRIPTS = "uplot.iife.min.js", "curves.js", "motion.js", "page.js"
MAX_WARNINGS = 5
"""Warnings that are shown at once; the others are folded."""
MAX_ENTRY = 200
"""Letters of an entry of the provenance that are shown; longer ones are data for programs."""
LEFT_OUT = "axes", "conditions"
"""Entries that the page shows elsewhere."""
FIRST_ENTRIES = "command", "created", "apesim", "machine_sha256"
"""Entries of the provenance that come first."""


class PlacedFigure(NamedTuple):
    """A figure on its page."""

    title: str
    note: str
    still: Markup
    frames: Frames
    kind: str
    number: int | None
    """Place of its data among those of the page; None: it has none."""
    slider: int | None
    """Slider that chooses its frame."""


class PlacedSlider(NamedTuple):
    """A slider on its page."""

    number: int
    name: str
    texts: Sequence[str]
    start: int


class Builder:
    """Puts figures on a page: their pictures, their data and the sliders that choose their frames."""

    def __init__(self) -> None:
        self.pool = ArrayPool()
        self.figures: list[dict[str, Any]] = []
        self.sliders: list[Sequence[str]] = []

    def place(self, section: Section) -> dict[str, Any]:
        """Lay out a section as the template takes it."""
        frames = dict.fromkeys(figure.frames for figure in section.figures if len(figure.frames.texts) > 1)
        sliders = {each: PlacedSlider(len(self.sliders) + k, *each) for k, each in enumerate(frames)}
        self.sliders += [each.texts for each in sliders.values()]
        figures = [self._place_figure(figure, sliders) for figure in section.figures]
        return {
            "title": section.title,
            "note": section.note,
            "figures": figures,
            "sliders": list(sliders.values()),
            "tables": section.tables,
            "is_folded": section.is_folded,
        }

    def _place_figure(self, figure: Figure, sliders: dict[Frames, PlacedSlider]) -> PlacedFigure:
        """Write the picture of a figure, and keep its data."""
        data, number = figure.data(self.pool), None
        if data is not None:
            number = len(self.figures)
            self.figures.append(data)
        slider = sliders.get(figure.frames)
        still = Markup(figure.write_still())
        return PlacedFigure(
            figure.title,
            figure.note.rstrip("."),
            still,
            figure.frames,
            figure.kind,
            number,
            slider.number if slider else None,
        )

    @property
    def data(self) -> dict[str, Any]:
        """All that scripts take."""
        return {"arrays": self.pool.arrays, "figures": self.figures, "sliders": self.sliders, "colours": ANCHORS}


def render_page(result: ArchiveResult, *, digest: str = "", measured: Measured | None = None) -> str:
    """Render the page of a result as HTML, the same text each time.

    `digest` is that of the archive's file, "" where it has none. Means of `measured` are drawn over the curves; raises
    InputError where there is nothing to draw, or to draw it over.
    """
    kind = kind_of(result.archive.variables, result.archive.provenance)
    content, odd = write_content(result, kind)
    if measured is not None:
        content = add_measured(content, measured)
    builder = Builder()
    sections = [builder.place(section) for section in content.sections]
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    return environment.from_string(read_asset("page.html")).render(
        kind=kind if kind in PAGES else "archive",
        content=content,
        sections=sections,
        warnings=[*result.failed, *result.warnings, *odd],
        max_warnings=MAX_WARNINGS,
        machine=result.archive.machine,
        engine=describe_machine(result.archive, kind),
        departures=list_departures(result.archive.machine),
        assumptions=list_assumptions(result.archive.machine),
        provenance=list_provenance(result, digest),
        version=_version_of(result),
        styles=Markup("\n".join(map(read_asset, STYLES))),
        scripts=[Markup(read_asset(name)) for name in SCRIPTS],
        data=Markup(write_data(builder.data)),
    )


def write_content(result: ArchiveResult, kind: str) -> tuple[Content, list[str]]:
    """Write what a page says of its archive, by its kind, or else its variables, and why in a line."""
    if type(result) is ArchiveResult or kind not in PAGES:
        return BARE(result), []
    try:
        return PAGES[kind](result), []
    except (KeyError, ValueError, IndexError, TypeError) as error:  # whoever wrote it
        why = f"something is missing or odd in it: {type(error).__name__}: {error}"
        return BARE(result), [f"not shown as what it is, {result.title}, as {why}"]


def write_data(data: dict[str, Any]) -> str:
    r"""Write data as JSON within a script: what would end it, or begin a comment, is written by its code.

    >>> write_data({"label": "</script><b>"})
    '{"label":"\\u003c/script\\u003e\\u003cb\\u003e"}'
    """
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    for letter, code in (
        ("<", "\\u003c"),
        (">", "\\u003e"),
        ("&", "\\u0026"),
        ("\u2028", "\\u2028"),
        ("\u2029", "\\u2029"),
    ):
        text = text.replace(letter, code)
    return text


def list_provenance(result: ArchiveResult, digest: str) -> Table:
    """List where the archive comes from, what is asked for first at the head."""
    entries = dict(result.archive.provenance)
    names = [*(name for name in FIRST_ENTRIES if name in entries), *sorted(set(entries) - set(FIRST_ENTRIES))]
    rows = [
        (name.replace("_", " "), entries[name])
        for name in names
        if len(entries[name]) <= MAX_ENTRY and name not in LEFT_OUT
    ]
    if digest:
        rows.insert(min(2, len(rows)), ("SHA-256 of its content", digest))
    return Table("", ("entry", "value"), rows, is_prose=True)


def _version_of(result: Result) -> str:
    """Version of the program that makes the page."""
    from apesim import __version__

    return __version__
