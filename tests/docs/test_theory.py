"""The theory pages name code that is there, keys that a machine file takes, and constants as they are."""

import re
from math import degrees, floor, log10, sqrt

import pytest

from apesim.air import ANR_DENSITY, COLDEST, HOTTEST
from apesim.engine.breathing import MAX_VOLUME
from apesim.engine.cycle.operating_point import MAX_TURN
from apesim.engine.cycle.rates import MAX_PATH
from apesim.engine.indicators import INDICATORS
from apesim.engine.machine import Machine
from apesim.flow_function import NEARLY_EQUAL
from apesim.march import adaptive, error_bounds, periodic, rosenbrock
from apesim.quantities.settings import schema
from apesim.restriction import AREA_OF_CONDUCTANCE, ROOM, ROOM_TO_TURN
from apesim.studies.estimation import levenberg_marquardt, priors
from apesim.studies.estimation.noise import process
from apesim.studies.gap import thresholds
from apesim.studies.gap.search import gap_test
from apesim.studies.gap.thresholds import WINDOWS
from apesim.studies.limit.design_rule import MAX_WINDOW, WITHIN
from apesim.valve.actuator import MAX_STEP
from apesim.valve.motion import CREEP, DETECTED
from apesim.valve.piston import REST_SPEED
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
    keys = set(re.findall(r"`((?:air|ambient|supply|valve|groove|engine|command|effects)\.[\w.]+)`", text))
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
        ("gas", f"| {NEARLY_EQUAL:g}, chosen |"),
        ("gas", f"left the regime by ${power(ROOM)}$"),
        ("gas", f"{ANR_DENSITY:g} kg/m³"),
        ("gas", f"of {AREA_OF_CONDUCTANCE * 1e-2:.2f} mm² passes"),
        ("gas", f"{COLDEST:g}…{HOTTEST:g} K"),
        ("gas", f"| {MACHINE.air.gas_constant:g} J/(kg·K), key"),
        ("gas", f"| {MACHINE.air.heat_capacity_ratio:g}, key"),
        ("valve", f"| {MACHINE.valve.stroke * 1e3:g} mm, Table 1 |"),
        ("valve", f"| {MACHINE.valve.moving_mass:g} kg, Table 1 |"),
        ("valve", f"| {MACHINE.valve.piston_area * 1e6:.1f} mm², Table 1 |"),
        ("valve", f"| {MACHINE.valve.clearance_volume * 1e9:,.0f} mm³, Table 1 |".replace(",", " ", 1)),
        ("valve", f"| {MACHINE.valve.spring_rate:g} N/m, Table 1 |"),
        ("valve", f"| {MACHINE.valve.viscous_friction:g} N·s/m, identified"),
        ("valve", f"| {MACHINE.valve.solenoid.effective_area * 1e6:.1f} mm², chosen;"),
        ("valve", f"| dead time | s | {MACHINE.valve.solenoid.dead_time * 1e3:g} ms,"),
        ("valve", f"| ramp time | s | {MACHINE.valve.solenoid.ramp_time * 1e3:g} ms,"),
        ("valve", f"| {MACHINE.groove.effective_area * 1e6:g} mm², chosen |"),
        ("valve", f"| {MACHINE.groove.lap * 1e3:.1f} mm, chosen |"),
        ("valve", f"slower than {REST_SPEED * 1e3:g} mm/s"),
        ("valve", f"rises through {DETECTED * 100:g} % of the stroke"),
        ("engine", f"| {MACHINE.engine.bore * 1e3:g} mm |"),
        ("engine", f"| {MACHINE.engine.stroke * 1e3:g} mm |"),
        ("engine", f"| {MACHINE.engine.rod_length * 1e3:g} mm |"),
        ("engine", f"| {MACHINE.engine.compression_ratio:g} |"),
        ("engine", f"| {MACHINE.engine.receiver.volume * 1e3:g} L, chosen |"),
        ("engine", f"| {MACHINE.engine.receiver.feed_area * 1e6:g} mm², chosen |"),
        ("engine", f"is {MACHINE.engine.exhaust.effective_area * 1e6:g} mm² by default"),
        ("engine", f"0.01…{MAX_VOLUME * 1e3:g} L"),
        ("engine", f"| {MACHINE.engine.friction.constant / 1e5:g} bar |"),
        ("engine", f"| {MACHINE.engine.friction.peak_pressure:g} |"),
        ("engine", f"| {MACHINE.engine.friction.piston_speed / 1e5:g} bar·s/m |"),
        ("engine", f"| {MACHINE.engine.friction.piston_speed_squared / 1e5:g} bar·s²/m² |"),
        ("engine", f"tolerance, ${power(periodic.PERIODIC_TOLERANCE)}$ by default"),
        ("engine", f"at most {'ten' if periodic.FARTHEST == 10.0 else periodic.FARTHEST} times that tolerance"),
        ("engine", f"up to {periodic.MAX_CYCLES} cycles"),
        ("numerics", f"| tolerance, ${power(adaptive.TOLERANCE)}$ by default |"),
        ("numerics", f"| longest step, bench | {MAX_STEP * 1e3:g} ms |"),
        ("numerics", f"{degrees(MAX_TURN):g}° of crank angle; while the valve moves {MAX_STEP * 1e3:g} ms, or"),
        ("numerics", f"or {MAX_PATH * 100:g} % of the stroke if that takes longer"),
        ("numerics", f"beyond {CREEP * 1e6:g} µm/s"),
        ("numerics", f"| shortest step | ${power(adaptive.MIN_STEP)}$ s;"),
        ("numerics", f"in a march | {adaptive.MAX_EVALUATIONS // 10**6} million; in all cycles"),
        ("numerics", f"periodic state {adaptive.MAX_EVALUATIONS_TO_PERIODIC // 10**6} million |"),
        ("numerics", f"| events of a march | {adaptive.MAX_EVENTS} |"),
        ("numerics", f"located within ${power(adaptive.ROOT_TOLERANCE)}$ s"),
        ("numerics", f"and more than {adaptive.STIFF:g}. After {adaptive.MAX_SHORT_STEPS} such steps"),
        ("numerics", f"After {periodic.FAR} cycles the way"),
        ("numerics", f"over more than {periodic.ROUGH_LEAP:g} cycles"),
        ("numerics", f"by differences of {periodic.FINE_NUDGE * 100:.4f} %"),
        ("numerics", f"where a difference of {periodic.NUDGE * 100:g} % tells"),
        ("numerics", f"$D$ was off by more than {periodic.FORETOLD * 100:g} % of the gain before"),
        ("numerics", f"gains other than $\\Delta y / d$, by more than {periodic.FORETOLD * 100:g} %"),
        ("numerics", f"follow a step over more than {periodic.FAR} cycles where"),
        ("numerics", f"${sqrt(periodic.FIRST_LEAP):g}\\sqrt{{d}}$ cycles each"),
        ("numerics", f"up to {'five' if periodic.MOST_SHORT_STEPS == 5 else periodic.MOST_SHORT_STEPS}, as long as"),
        ("numerics", f"brings the gain below {periodic.NEARER:g} of what it was"),
        ("numerics", f"moves a state by more than {periodic.FAR_STEP * 100:g} %"),
        ("numerics", f"below {periodic.SAME:g} tolerances of a step"),
        ("numerics", f"come first, {periodic.BURST} at a time"),
        ("numerics", f"by more than {periodic.CLIP * 100:g} % in a step"),
        ("numerics", f"below {periodic.NEARER:g} of those before it"),
        ("numerics", f"after {periodic.PATIENCE} cycles"),
        ("numerics", f"followed through {2 * periodic.LONGEST_PERIOD} plain cycles"),
        ("numerics", f"up to {periodic.MOST_PERIODS * periodic.LONGEST_PERIOD} where the change over some 3 to"),
        ("engine", f"after up to {periodic.LONGEST_PERIOD}, as the response"),
        ("numerics", f"below {periodic.NOISE:g} tolerances of a step"),
        ("numerics", f"if {'ten' if periodic.STILL == 10 else periodic.STILL} cycles lead no farther"),
        ("numerics", f"or over {'a million' if periodic.LONGEST_WAY == 1e6 else periodic.LONGEST_WAY}, is below"),
        ("numerics", rf"${rosenbrock.NUDGE * 1e7:g} \cdot 10^{{-7}}$ of themselves"),
        ("numerics", rf"${rosenbrock.NUDGE_IN_SCALE * 1e9:g} \cdot 10^{{-9}}$ of their scale"),
        ("numerics", f"beyond 1 by more than ${power(ROOM_TO_TURN)}$"),
        ("numerics", f"within {periodic.MAX_CORRECTIONS} cycles"),
        ("numerics", f"`energy_closure` | ${power(error_bounds.MAX_CLOSURE)}$ |"),
        ("numerics", f"`exergy_closure` | ${power(error_bounds.MAX_EXERGY_CLOSURE)}$ of what enters |"),
        ("numerics", f"`air_tolerance_change` | ${power(error_bounds.MAX_TOLERANCE_CHANGE)}$ |"),
        ("numerics", rf"| $2 \cdot {power(error_bounds.MAX_QUADRATURE_CHANGE)}$ |"),
        ("numerics", rf"\max\bigl(|\text{{moved}}|,\ {power(error_bounds.MIN_SHARE_MOVED)}\,\text{{held}}\bigr)"),
        ("indicators", f"within {degrees(WITHIN):g}° of its targets"),
        ("indicators", f"windows up to {degrees(MAX_WINDOW):g}°"),
        ("estimation", f"{priors.FARTHEST:g} prior standard deviations at most"),
        ("estimation", f"is at most {process.MAX_ORDER}, and"),
        ("estimation", f"with fewer than {process.ENOUGH} the noise counts as white"),
        ("estimation", f"fall of less than {levenberg_marquardt.CONVERGED:g}, after at most"),
        ("estimation", f"after at most {levenberg_marquardt.MAX_STEPS} steps"),
        (
            "estimation",
            f"{gap_test.NOISE_DRAWS} noises, each of which may be the true one, and {gap_test.SCORE_DRAWS} sets",
        ),
        ("estimation", f"where $p < {thresholds.ALARM:g}$"),
        ("estimation", f"has to be at least {thresholds.TOLERANCE:g}, or"),
        ("estimation", rf"2 \ln\frac{{N_e}}{{{thresholds.TERM_CHANCE:g}}}"),
        ("estimation", f"is {thresholds.N_SIGMA_VISIBLE:g} sigmas"),
        ("estimation", f"is above {thresholds.ALIKE:g} (`find_detection_limits`"),
        ("estimation", f"up to {WINDOWS} windows"),
        ("estimation", rf"E_\text{{left}} - {thresholds.SURE:g} \sqrt"),
    ],
)
def test_a_page_quotes_a_constant_as_the_code_has_it(page, phrase):
    assert phrase in text_of(page)
