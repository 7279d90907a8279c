"""What a user is told of a run beside its numbers: what is so, and nothing that is not."""

import json
import re

import pytest
from scipy.optimize import brentq

from apesim.air import HOTTEST, THERMALLY_PERFECT
from apesim.engine.angles import DEGREE
from apesim.engine.cycle.state import ENGINE_LEDGER, EngineLedger, engine_ledger
from apesim.engine.indicators import indicators
from apesim.engine.steady import run_steady
from apesim.engine.warnings import SUMMARIES, EngineWarning, judge_point
from apesim.march.error_bounds import MAX_CLOSURE, MAX_EXERGY_CLOSURE, MAX_QUADRATURE_CHANGE, MAX_TOLERANCE_CHANGE
from apesim.restriction import Flow
from apesim.studies.optimise.landscape import judged
from apesim.valve.bench import run_bench
from apesim.valve.ledger import FLOW_ENTRIES
from apesim.valve.measures import Travel
from apesim.valve.warnings import TRAVEL_TEXTS, BenchWarning, judge_bench
from tests.machines import RPM, machine, settled

EXHAUST = EngineLedger._fields.index("exhaust")
"""Place of the exhaust's flow in the engine air's ledger."""

HOT_WALLS = {
    "intake": "ideal",
    "targets": (0.0, 30.0),
    "effects__cylinder_wall_heat__h": 500.0,
    "effects__cylinder_wall_heat__wall_temperature": 500.0,
}
HOT_AIR = {"intake": "ideal", "temperature": 600.0, "engine__exhaust__closes": 230.0 * DEGREE}
ALWAYS_OPEN = {"energise": 0.0, "release": 359.0}
AT_A_GROOVE_THAT_HARDLY_OPENS = 3133.0


def told(rpm=1000.0, **options):
    a_machine = machine(**options)
    run = settled(a_machine, rpm)
    return judge_point(a_machine, run, indicators(a_machine, run)), run


def lines_of(apesim, *arguments):
    _, out, err = apesim(*arguments, "--json")
    lines = json.loads(out)["warnings"]
    assert all(f"warning: {line}" in err for line in lines)
    return lines


def lift_in(text, before):
    """The lift [mm] that stands behind some words of a text."""
    return float(re.search(rf"{before} ([0-9.]+) of 9 mm", text)[1])


@pytest.mark.compiled
def test_of_a_usual_operating_point_nothing_is_told():
    assert told(800.0)[0] == {}


# --- how far the valve travels, of an engine ---


@pytest.mark.compiled
def test_a_valve_that_never_leaves_its_open_stop_is_not_said_to_open_in_part(apesim):
    options = ("--set", "command.energise=0 deg", "--set", "command.release=359 deg")
    [line] = lines_of(apesim, "engine", "run", "--speed", "1000 rpm", *options)
    assert "does not close" in line and "stays on the open stop" in line


@pytest.mark.compiled
def test_a_valve_that_never_leaves_its_closed_stop_is_not_said_to_miss_it(apesim):
    lines = lines_of(apesim, "engine", "run", "--speed", "6000 rpm")
    assert [line for line in lines if "stop" in line] == [line for line in lines if "does not open" in line]
    assert any("stays on the closed stop" in line for line in lines)


@pytest.mark.parametrize(
    ("travel", "rpm", "options"),
    [
        (Travel.STAYS_CLOSED, 6000.0, {}),
        (Travel.OPENS_PARTLY, 1600.0, {}),
        (Travel.COMPLETE, 1000.0, {}),
        (Travel.CLOSES_PARTLY, 2500.0, {"release": 235.0}),
        (Travel.BETWEEN_STOPS, 3500.0, {"release": 175.0, "supply__control_pressure": 3e5}),
        (Travel.STAYS_OPEN, 1000.0, ALWAYS_OPEN),
    ],
)
@pytest.mark.compiled
def test_the_stops_that_a_valve_meets_are_those_that_its_lift_comes_to(travel, rpm, options):
    found, run = told(rpm, **options)
    lift = run.trace[:, 2]
    assert [warning.name for warning in found if warning.is_incomplete_stroke] == [travel.name] * bool(travel)
    assert travel.opens_fully == (lift.max() == 9e-3)
    assert (travel in (Travel.COMPLETE, Travel.STAYS_CLOSED, Travel.OPENS_PARTLY)) == (lift.min() == 0.0)
    [text] = [text for warning, text in found.items() if warning.is_incomplete_stroke] or [""]
    if travel == Travel.OPENS_PARTLY:
        assert lift_in(text, "reaches") == pytest.approx(lift.max() * 1e3, abs=0.02)
    if travel == Travel.CLOSES_PARTLY:
        assert lift_in(text, "falls to") == pytest.approx(lift.min() * 1e3, abs=0.02)


@pytest.mark.compiled
def test_commands_that_hold_the_valve_open_count_as_full_lift():
    a_machine = machine(**ALWAYS_OPEN)
    assert judged(a_machine, run_steady(a_machine, 1000.0 * RPM)).full_lift
    assert not judged(machine(), run_steady(machine(), 1600.0 * RPM)).full_lift


# --- the same of the valve's bench ---


def test_a_single_run_that_ends_under_way_is_not_said_to_swing_between_two_lifts(apesim):
    _, _, err = apesim("valve", "run", "--pulse", "5 ms")
    [line] = [line for line in err.splitlines() if line.startswith("warning: ")]
    assert "goes from" not in line and "end the run later" in line
    assert lift_in(line, "reaches") > float(re.search(r"is ([0-9.]+) mm where the run ends", line)[1]) > 0.0
    _, _, err = apesim("valve", "run", "--pulse", "5 ms", "--until", "20 ms")  # it closes by then
    [line] = [line for line in err.splitlines() if line.startswith("warning: ")]
    assert "does not open fully" in line and "end the run" not in line


@pytest.mark.parametrize("pulse", ["0.01 ms", "0.05 ms", "0.2 ms", "1 ms"])
def test_a_pulse_too_short_to_move_anything_closes_and_is_said_to_open_nothing(apesim, pulse):
    _, out, _ = apesim("valve", "run", "--pulse", pulse, "--json")
    found = json.loads(out)
    assert max(found["closure"].values()) < MAX_CLOSURE
    [line] = found["warnings"]
    assert "does not open" in line and "stays on the closed stop" in line


def test_a_repeated_pulse_that_holds_the_valve_open_is_not_said_to_open_in_part(apesim):
    [line] = lines_of(apesim, "valve", "run", "--pulse", "49 ms", "--repeat", "20 Hz")
    assert "does not close" in line and "stays on the open stop" in line


@pytest.mark.parametrize(
    ("travel", "pulse", "until"),
    [(Travel.OPENS_PARTLY, 7e-3, None), (Travel.CLOSES_PARTLY, 50e-3, 60e-3), (Travel.COMPLETE, 50e-3, None)],
)
def test_a_stroke_of_the_bench_is_incomplete_where_its_stop_is_not_met(travel, pulse, until):
    run = run_bench(machine(), pulse, until)
    assert run.travel == travel
    assert [warning.name for warning in judge_bench(run)] == [travel.name] * bool(travel)
    if until:
        text = judge_bench(run)[BenchWarning.CLOSES_PARTLY]
        assert lift_in(text, "falls to") == pytest.approx(run.trace[-1, 0] * 1e3, abs=0.01)


# --- control air ---


@pytest.mark.compiled
def test_control_air_that_flows_back_into_its_supply_is_told(apesim):
    lines = lines_of(apesim, "valve", "run", "--supply", "0.05 MPa abs")
    assert any("0.05 MPa abs, is below that of the vents" in line for line in lines)
    assert EngineWarning.CONTROL_BELOW_AMBIENT in told(600.0, supply__control_pressure=8e4)[0]
    from_receiver, _ = told(600.0, supply=-0.02, control_air="receiver")
    assert "0.08132 MPa abs" in from_receiver[EngineWarning.CONTROL_BELOW_AMBIENT]
    assert EngineWarning.CONTROL_BELOW_AMBIENT not in told(600.0, supply=-0.02, supply__control_pressure=6e5)[0]


# --- how exact the numbers are ---


def test_air_that_hangs_on_the_tolerance_is_told(apesim):
    speed = f"{AT_A_GROOVE_THAT_HARDLY_OPENS} rpm"
    _, out, _ = apesim("engine", "run", "--speed", speed, "--json")
    found = json.loads(out)
    assert found["closure"]["air_at_tenfold_tolerance"] > MAX_TOLERANCE_CHANGE
    assert any("engine air changes by" in line for line in found["warnings"])


@pytest.mark.compiled
def test_work_that_hangs_on_the_tolerance_is_told():
    def work(rpm):
        return engine_ledger(run_steady(machine(), rpm * RPM).end).work

    found, run = told(brentq(work, 1700.0, 1900.0, xtol=1e-6))
    assert abs(engine_ledger(run.end).work) < 1e-3 and run.work_change > MAX_TOLERANCE_CHANGE
    assert "indicated work" in found[EngineWarning.WORK_TOLERANCE]
    assert EngineWarning.WORK_TOLERANCE not in told(1700.0)[0]


@pytest.mark.parametrize("entry", Flow._fields)
def test_a_ledger_that_does_not_close_is_told(entry):
    a_machine = machine()
    run = settled(a_machine, 800.0)
    for share, warnings in ((0.1, set()), (10.0, {EngineWarning.CLOSURE})):
        end = run.end.copy()
        end[ENGINE_LEDGER + FLOW_ENTRIES * EXHAUST + Flow._fields.index(entry)] *= 1.0 + share * MAX_CLOSURE
        lossy = run._replace(end=end)
        assert set(judge_point(a_machine, lossy, indicators(a_machine, lossy))) == warnings


def test_work_that_its_quadrature_contradicts_is_told():
    a_machine = machine()
    run = settled(a_machine, 800.0)
    off = run._replace(work_by_quadrature=engine_ledger(run.end).work * (1.0 + 2.0 * MAX_QUADRATURE_CHANGE))
    assert list(judge_point(a_machine, off, indicators(a_machine, off))) == [EngineWarning.QUADRATURE]
    bench = run_bench(machine(), 50e-3)
    for name, warning in (
        ("mass", BenchWarning.CLOSURE),
        ("energy", BenchWarning.CLOSURE),
        ("work", BenchWarning.QUADRATURE),
    ):
        assert list(judge_bench(bench._replace(closure=bench.closure | {name: 1e-4}))) == [warning]


def test_an_exergy_ledger_that_leaves_more_open_than_promised_is_told():
    a_machine = machine()
    run = settled(a_machine, 800.0)
    values = indicators(a_machine, run)
    assert values["exergy_closure"] < MAX_EXERGY_CLOSURE and judge_point(a_machine, run, values) == {}
    off = values | {"exergy_closure": 2.0 * MAX_EXERGY_CLOSURE}
    assert list(judge_point(a_machine, run, off)) == [EngineWarning.EXERGY_CLOSURE]


# --- the rest ---


@pytest.mark.compiled
def test_more_than_isentropic_work_is_told_to_come_from_the_walls():
    assert "heat from the walls" in told(60.0, **HOT_WALLS)[0][EngineWarning.ABOVE_ISENTROPIC]
    assert EngineWarning.ABOVE_ISENTROPIC not in told(60.0, intake="ideal", targets=(0.0, 30.0))[0]


@pytest.mark.parametrize(("air", "is_told"), [(THERMALLY_PERFECT, True), (0, False)])
def test_cp_beyond_its_range_is_told(air, is_told):
    found, run = told(air__model=air, engine__compression_ratio=60.0, **HOT_AIR)
    assert run.trace[:, 1].max() > HOTTEST
    assert (EngineWarning.BEYOND_CP in found) == is_told


def test_a_state_that_does_not_repeat_is_told():
    run = run_steady(machine(), 1000.0 * RPM, max_cycles=3)
    assert EngineWarning.NOT_PERIODIC in judge_point(machine(), run, indicators(machine(), run))


def test_after_how_many_cycles_a_state_repeats_is_told():
    a_machine = machine()
    run, bench = settled(a_machine, 1000.0), run_bench(a_machine, 12e-3, period=0.05)
    values = indicators(a_machine, run)
    after_three = [one._replace(orbit=one.orbit._replace(period=3)) for one in (run, bench)]
    assert "after 3 cycles" in judge_point(a_machine, after_three[0], values)[EngineWarning.SUBHARMONIC]
    assert "after 3 cycles" in judge_bench(after_three[1])[BenchWarning.SUBHARMONIC]
    assert EngineWarning.SUBHARMONIC not in judge_point(a_machine, run, values)
    assert BenchWarning.SUBHARMONIC not in judge_bench(bench)


def test_every_warning_has_its_words_and_every_travel_a_warning_on_both_benches():
    assert list(EngineWarning) == list(range(len(EngineWarning.__members__)))  # no two of them are one
    assert set(SUMMARIES) == set(EngineWarning) and len(set(SUMMARIES.values())) == len(SUMMARIES)
    incomplete = {travel.name for travel in Travel if travel != Travel.COMPLETE}
    assert {travel.name for travel in TRAVEL_TEXTS} == incomplete
    assert incomplete <= set(EngineWarning.__members__) and incomplete <= set(BenchWarning.__members__)
