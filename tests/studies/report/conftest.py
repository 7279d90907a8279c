"""Results whose pages are tested, computed once."""

from functools import cache

import pytest

import apesim
from apesim.engine.machine import Machine
from apesim.studies.report.page import render_page

STUDIES = {
    "sweep": lambda: apesim.sweep(Machine(), "600, 1000, 1400 rpm"),
    "transient": lambda: apesim.run_transient(Machine(), duration="0.4 s", angle="30 deg"),
    "start": lambda: apesim.start_engine(Machine(), angle="30 deg"),
    "map": lambda: apesim.map_valve(Machine(), pressure="0.6:1.0:0.2 MPa gauge", temperature="260:300:20 K"),
}
"""Studies whose pages are looked at in a browser."""


@cache
def found(name):
    """Result of a study."""
    return STUDIES[name]()


@cache
def page_of(name):
    """Page of a study as HTML."""
    return render_page(found(name))


@pytest.fixture(scope="session")
def pages(tmp_path_factory):
    """Addresses of the pages, by the names of their studies."""
    folder = tmp_path_factory.mktemp("pages")

    def address(name, text=None):
        path = folder / f"{name}.html"
        path.write_text(page_of(name) if text is None else text, encoding="utf-8")
        return path.as_uri()

    return address
