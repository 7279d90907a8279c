"""The theory pages name code that is there, keys that a machine file takes, and constants as they are."""

import re
from math import floor, log10, sqrt

import pytest

from apesim.engine.indicators import INDICATORS
from apesim.engine.machine import Machine
from apesim.march import adaptive, error_bounds, periodic, rosenbrock
from apesim.quantities.settings import schema
from apesim.restriction import ROOM, ROOM_TO_TURN
from apesim.studies.gap import thresholds
from tests.folders import ROOT

THEORY = ROOT / "docs" / "theory"
PAGES = [*sorted(THEORY.glob("*.md")), ROOT / "docs" / "nomenclature.md"]
NAMES_IN_FILE = re.compile(r"((?:`[A-Za-z_]\w*`(?:,\s|\sand\s|\sof\s)?)+)\s?in\s`([\w/]+\.py)`")
MACHINE = Machine()


def text_of(name):
    """Text of a theory page, on one line: a phrase may go over the end of one."""
    return " ".join((THEORY / f"{name}.md").read_text().split())


def power(value):
    """The power of ten of a value, as the pages write it."""
    return f"10^{{{floor(log10(value) + 1e-9)}}}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_file_that_a_page_names_is_there(page):
    files = set(re.findall(r"`((?:apesim|valve|engine|studies|tests)/[\w/]+\.py)`", page.read_text()))
    assert not [file for file in files if not (ROOT / file).is_file()]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_function_that_a_page_names_stands_in_its_file(page):
    missing = []
    for names, file in NAMES_IN_FILE.findall(" ".join(page.read_text().split())):
        code = (ROOT / file).read_text()
        for name in re.findall(r"`(\w+)`", names):
            if not re.search(rf"^\s*(?:def|class) {name}\b|^{name}\b", code, re.MULTILINE):
                missing.append(f"{name} in {file}")
    assert not missing


def test_pages_name_many_functions():
    found = [pair for page in PAGES for pair in NAMES_IN_FILE.findall(" ".join(page.read_text().split()))]
    assert len(found) > 60


def test_every_key_of_the_nomenclature_is_one_of_the_machine_file():
    text = (ROOT / "docs" / "nomenclature.md").read_text()
    sections = "|".join(Machine._fields)
    keys = set(re.findall(rf"`((?:{sections})\.[\w.]+)`", text))
    assert len(keys) > 30
    assert keys <= {leaf.key for leaf in schema(Machine)}


def test_every_indicator_is_defined_on_a_page():
    text = "".join(page.read_text() for page in PAGES)
    undefined = []
    for name in INDICATORS:
        term = name.removeprefix("exergy_").removesuffix("_J") if name.startswith("exergy_") else name
        if f"`{name}`" not in text and f"`{term}`" not in text:
            undefined.append(name)
    assert undefined == []


@pytest.mark.parametrize(
    ("page", "phrase"),
    [
        ("gas", f"${power(ROOM)}$, or has passed"),
        ("valve", f"| {MACHINE.valve.clearance_volume * 1e9:,.0f} mm³, Table 1 |".replace(",", " ", 1)),
        ("engine", f"${power(periodic.PERIODIC_TOLERANCE)}$ by default"),
        ("engine", f"{'ten' if periodic.MAX_DISTANCE == 10.0 else periodic.MAX_DISTANCE} times that tolerance"),
        ("numerics", f"${power(adaptive.TOLERANCE)}$ by default"),
        ("numerics", f"| shortest step | ${power(adaptive.MIN_STEP)}$ s;"),
        ("numerics", f"within ${power(adaptive.ROOT_TOLERANCE)}$ s"),
        ("numerics", f"${sqrt(periodic.FIRST_LEAP):g}\\sqrt{{d}}$ cycles"),
        ("numerics", f"up to {'five' if periodic.MAX_SHORT_STEPS == 5 else periodic.MAX_SHORT_STEPS}, as"),
        ("numerics", f"if {'ten' if periodic.REST_CYCLES == 10 else periodic.REST_CYCLES} cycles"),
        ("numerics", f"over {'a million' if periodic.MAX_SETTLING_CYCLES == 1e6 else periodic.MAX_SETTLING_CYCLES},"),
        ("numerics", rf"${rosenbrock.NUDGE * 1e7:g} \cdot 10^{{-7}}$"),
        ("numerics", rf"${rosenbrock.NUDGE_IN_SCALE * 1e9:g} \cdot 10^{{-9}}$"),
        ("numerics", f"by more than ${power(ROOM)}$; beyond 1 by more than ${power(ROOM_TO_TURN)}$"),
        ("numerics", f"`energy_closure` | ${power(error_bounds.MAX_CLOSURE)}$ |"),
        ("numerics", f"`exergy_closure` | ${power(error_bounds.MAX_EXERGY_CLOSURE)}$ of"),
        ("numerics", f"`air_tolerance_change` | ${power(error_bounds.MAX_TOLERANCE_CHANGE)}$ |"),
        ("numerics", rf"| $2 \cdot {power(error_bounds.MAX_QUADRATURE_CHANGE)}$ |"),
        ("numerics", rf"\max\bigl(|\text{{moved}}|,\ {power(error_bounds.MIN_SHARE_MOVED)}\,\text{{held}}\bigr)"),
        ("estimation", f"$p < {thresholds.ALARM:g}$"),
        ("estimation", rf"2 \ln\frac{{N_e}}{{{thresholds.TERM_CHANCE:g}}}"),
        ("estimation", rf"E_\text{{left}} - {thresholds.SURE:g} \sqrt"),
    ],
)
def test_a_constant_that_no_role_prints_is_as_the_code_has_it(page, phrase):
    """In formulas, as a power of ten, in words or in groups of digits; all others are printed from `docs.results`."""
    assert phrase in text_of(page)
