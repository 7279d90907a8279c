"""Cases with one wrong number in the machine file: what they are drawn from, and how what is said is counted."""

from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest

from apesim import Machine
from apesim.studies.estimation.parameters import value_of
from apesim.studies.gap.workflow import explain
from docs.results import wrong_numbers as page
from tests.campaigns import record, wrong_numbers
from tests.campaigns.campaign import Outcome
from tests.campaigns.record import add_round
from tests.campaigns.wrong_numbers import (
    AMONG,
    HOLDS,
    IN_A_CLASS,
    MISSES,
    NAMED,
    NO_INTERVAL,
    OPEN,
    REFUSED,
    UNSEEN,
    WRONG,
    find_interval,
    judge,
    list_cells,
    trial,
    weigh,
)
from tests.gap_bench import BUT_RIVALS
from tests.truth.sealed import wrong_numbers as cases
from tests.truth.sealed.library import ENGINE, VALVE
from tests.truth.sealed.observation import Laboratory
from tests.truth.sealed.wrong_numbers import (
    BLOCK,
    MIN_SIGMAS,
    NUMBERS,
    SETTINGS,
    draw_written,
    draw_wrong_number,
    write_wrong_number,
)
from tests.truth.simulator.effects import Rig

STROKE, AREA, MASS = "valve.stroke", "valve.piston_area", "valve.moving_mass"
FOR_SEED = {number.key: place for place, number in reversed(list(enumerate(BLOCK)))}
"""The first seed of each number."""


@pytest.fixture
def few_runs(monkeypatch):
    """A laboratory that records three runs of the valve, coarsely."""
    setting = SETTINGS[VALVE]
    fewer = setting._replace(points=(*setting.points[0:4:3], setting.points[-1]), samples=201)
    lab = Laboratory(fewer)
    monkeypatch.setattr(cases, "laboratory", lambda bench: lab)


def test_a_block_makes_each_number_of_the_valve_wrong_twice_and_each_of_the_engine_once():
    assert Counter(number.bench for number in BLOCK) == {VALVE: 12, ENGINE: 8}
    assert Counter(number.key for number in BLOCK) == {n.key: 2 if n.bench == VALVE else 1 for n in NUMBERS}


def test_each_number_is_that_of_the_default_machine_and_is_put_into_the_rig_alone():
    for number in NUMBERS:
        right = number.read(Rig())
        assert value_of(Machine(), number.key) == pytest.approx(right * number.scale)
        rig = number.put(Rig(), 1.1 * right)
        assert number.read(rig) == pytest.approx(1.1 * right)
        assert all(other.read(rig) == other.read(Rig()) for other in NUMBERS if other is not number)


def test_errors_are_of_either_sign_and_between_their_ends():
    for number in NUMBERS:
        right = number.read(Rig())
        rng = np.random.default_rng(1)
        errors = [draw_written(number, rng) - right for _ in range(40)]
        shares = [abs(error) / right if number.is_share else abs(error) for error in errors]
        low, high = number.ends
        assert 0.95 * low < min(shares) < max(shares) < 1.05 * high
        assert min(errors) < 0.0 < max(errors)


def test_a_case_shows_and_half_of_all_rigs_are_off_besides():
    drawn = {seed: draw_wrong_number(seed) for seed in (1, 2, 7, 22)}
    assert all(case.sigmas >= MIN_SIGMAS for case in drawn.values())
    assert [bool(case.nuisances) for case in drawn.values()] == [False, False, True, False]
    assert draw_wrong_number(2).written == drawn[2].written != drawn[22].written


def test_what_does_too_little_is_drawn_anew(monkeypatch):
    monkeypatch.setattr(cases, "MIN_SIGMAS", 100.0)
    assert draw_wrong_number(FOR_SEED[AREA] + len(BLOCK)).sigmas > 100.0
    monkeypatch.setattr(cases, "TRIES", 1)
    assert draw_wrong_number(FOR_SEED[MASS]).sigmas < 100.0


def test_the_machine_file_is_the_default_one_but_for_one_number(few_runs, tmp_path):
    case = draw_wrong_number(FOR_SEED[AREA])
    write_wrong_number(case, tmp_path)
    machine, right = Machine.load(tmp_path / "machine.toml"), Machine()
    assert value_of(machine, AREA) == pytest.approx(case.written * 1e-6)
    assert machine == right._replace(valve=right.valve._replace(piston_area=machine.valve.piston_area))
    assert float(case.error.split()[0]) == pytest.approx(100.0 * (case.written / 1134.1 - 1.0), abs=0.06)


def test_a_wrong_number_is_named_with_an_interval_that_holds_it(few_runs, monkeypatch, tmp_path):
    monkeypatch.setattr(wrong_numbers, "explain", lambda *given: explain(*given, without=BUT_RIVALS))
    case = draw_wrong_number(FOR_SEED[AREA])
    write_wrong_number(case, tmp_path)
    outcome, told = judge(case, tmp_path)
    assert (outcome, told.verdict, told.said, told.interval) == (NAMED, "CALIBRATION", AREA, HOLDS)
    assert 0.0 < float(told.seconds) < 60.0


def test_a_stroke_that_the_lift_contradicts_is_refused_with_its_key(few_runs, tmp_path):
    case = draw_wrong_number(FOR_SEED[STROKE])._replace(written=7.2)
    write_wrong_number(case, tmp_path)
    outcome, told = judge(case, tmp_path)
    assert (outcome, told.said, told.interval) == (REFUSED, "–", NO_INTERVAL)
    assert judge(case._replace(number=BLOCK[FOR_SEED[MASS]]), tmp_path)[0] == WRONG


def row(name, *misstated):
    key = name if "." in name else f"effects.{name}.share"
    return {"name": name, "key": key, "misstated": [{"key": each} for each in misstated]}


def said(verdict, *rows, rivals=(), numbers=()):
    """An explanation, as far as it is weighed."""
    best = SimpleNamespace(names=tuple(each["name"] for each in rows))
    rivals = tuple(SimpleNamespace(names=names) for names in rivals)
    decision = SimpleNamespace(best=best, rivals=rivals)
    return SimpleNamespace(verdict=verdict, effects=list(rows), decision=decision, best=list(numbers))


@pytest.mark.parametrize(
    ("explanation", "outcome"),
    [
        (said("CALIBRATION", row(MASS)), NAMED),
        (said("CALIBRATION", row(STROKE)), WRONG),
        (said("CALIBRATION", row(MASS), row(STROKE)), AMONG),
        (said("NAMED", row("moving_mass_error", MASS)), NAMED),
        (said("NAMED", row("moving_mass_error", MASS), numbers=[row(STROKE)]), AMONG),
        (said("NAMED", row("side_force"), numbers=[row(MASS)]), AMONG),
        (said("NAMED", row("side_force")), WRONG),
        (said("TWO_EFFECTS", row("side_force"), row("moving_mass_error", MASS)), AMONG),
        (said("NAMED_CLASS", row("side_force"), rivals=[("moving_mass_error",)]), IN_A_CLASS),
        (said("NAMED_CLASS", row(MASS), rivals=[("side_force",)]), IN_A_CLASS),
        (said("NAMED_CLASS", row("side_force"), rivals=[("slow_ramp",)]), WRONG),
        (said("MEASUREMENT", row("offset")), WRONG),
        (said("REFUSED"), OPEN),
        (said("AMBIGUOUS", row("moving_mass_error", MASS)), OPEN),
        (said("NO_GAP"), UNSEEN),
    ],
)
def test_what_is_said_is_counted_by_whether_the_number_alone_is_named(explanation, outcome, monkeypatch):
    monkeypatch.setattr(wrong_numbers, "describe_numbers", lambda model: model)
    assert weigh(MASS, explanation)[0] == outcome


def test_the_interval_of_an_effect_is_told_as_that_of_the_number():
    machine = Machine.load(None, ["valve.moving_mass=0.2 kg", "valve.solenoid.ramp_time=2 ms"])
    share = {"key": "effects.moving_mass_error.share", "interval_95": [-0.5, -0.25], "unit": ""}
    assert find_interval(MASS, [share], machine) == pytest.approx((0.1, 0.15))
    time = {"key": "effects.slow_ramp.time", "interval_95": [-0.6, -0.4], "unit": "ms"}
    assert find_interval("valve.solenoid.ramp_time", [time], machine) == pytest.approx((1.4, 1.6))
    number = {"key": STROKE, "interval_95": [8.9, 9.1], "unit": "mm"}
    assert find_interval(STROKE, [number], machine) == (8.9, 9.1)
    assert find_interval(STROKE, [share, number | {"interval_95": None}], machine) is None


def test_the_page_counts_a_round_and_lists_its_cases(tmp_path, monkeypatch):
    monkeypatch.setattr(record, "FOLDER", tmp_path)
    outcomes = {
        1000: Outcome(f"{STROKE}: {NAMED}", False, f"+3.5 %; off; 38; CALIBRATION; {STROKE}; {HOLDS}; 6.1"),
        1001: Outcome(f"{AREA}: {NAMED}", False, f"+9.0 %; off; 80; CALIBRATION; {AREA}; {MISSES}; 7.0"),
        1002: Outcome(f"{STROKE}: {REFUSED}", False, f"+9.5 %; off; 99; refused; –; {NO_INTERVAL}; 0.4"),
        1003: Outcome(f"{MASS}: {UNSEEN}", True, f"+3.0 %; off; 10; NO_GAP; –; {NO_INTERVAL}; 1.0"),
        1004: Outcome("groove.lap: named", False, f"+0.3 mm; off; 20; CALIBRATION; groove.lap; {HOLDS}; 11.5"),
    }
    add_round("wrong_numbers", outcomes)
    values = page.compute()
    assert values["cases"].rows == [list_cells(seed, one) for seed, one in outcomes.items()]
    counts = {name: count for name, count, *_ in values["figures"].rows}
    assert (counts["named"], counts[UNSEEN], counts[WRONG]) == ("4 of 5", "1 of 5", "0 of 5")
    assert [count for name, count in counts.items() if "interval" in name] == ["2 of 3"]
    assert [count for name, count in counts.items() if "processor" in name] == ["4 of 5"]
    assert [[cell.value if hasattr(cell, "value") else cell for cell in each] for each in values["times"].rows] == [
        [VALVE, 4, "3.5", "7.0"],
        [ENGINE, 1, "11.5", "11.5"],
    ]


def test_a_case_without_a_verdict_is_listed_all_the_same():
    assert list_cells(7, Outcome("hangs", True, "longer than 600 s"))[1::6] == ["any", "hangs"]


@pytest.mark.slow
@pytest.mark.parametrize("key", ["valve.clearance_volume", "engine.exhaust.opens"])
def test_a_trial_names_its_number(key):
    assert trial(FOR_SEED[key]).word == f"{key}: {NAMED}"
