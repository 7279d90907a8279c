"""Parts of a page: facts at its head, and sections of figures, some with a slider for all of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from apesim.studies.report.figures.bars import Bars
from apesim.studies.report.figures.curves import Curves
from apesim.studies.report.figures.maps import Map
from apesim.studies.report.figures.moving import Moving
from apesim.studies.report.figures.rings import Rings

Figure = Curves | Map | Bars | Rings | Moving


class Fact(NamedTuple):
    """A headline number: what a reader looks for first."""

    value: str
    unit: str
    label: str


class Table(NamedTuple):
    """Rows of texts under a head."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""
    is_folded: bool = False
    """Whether it is opened by a click."""
    is_prose: bool = False
    """Whether its cells are words, which stand to the left and may be broken."""


@dataclass(frozen=True)
class Section:
    """Figures and tables under one heading; figures of the same frames share a slider."""

    title: str
    figures: Sequence[Figure] = ()
    note: str = ""
    tables: Sequence[Table] = ()
    is_folded: bool = False
    """Whether it is opened by a click; what few readers want."""


@dataclass(frozen=True)
class Content:
    """What a page says of its archive, beside machine and provenance."""

    title: str
    summary: str
    facts: Sequence[Fact]
    sections: Sequence[Section]
