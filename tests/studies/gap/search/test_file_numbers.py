"""A wrong number of the machine file is found as such, and no effect is blamed for it."""

import pytest

from apesim import InputError, Machine
from apesim.engine.effects import exhaust_timing
from apesim.studies.gap.example_bench import list_left_out
from apesim.studies.gap.report.verdict_json import write_sentence
from apesim.studies.gap.search.candidates import find_candidates
from apesim.studies.gap.search.file_numbers import SUSPECTS, find_file_numbers, list_misstated
from apesim.studies.gap.search.library import select_effects
from apesim.studies.gap.workflow import explain
from apesim.studies.measured import ENGINE, VALVE, Measured
from apesim.valve.effects import slow_ramp
from tests.gap_bench import BUT_RIVALS
from tests.truth.simulator.valve import Bench


def suspects_of(machine, bench, known_to=None, **options):
    measured = Measured("", {}, (), bench)._replace(known_to=known_to or {})
    effects = find_candidates(machine, bench, select_effects(bench, (), machine))
    return [each.name for each in find_file_numbers(machine, measured, effects, **options)]


def test_each_number_that_counts_as_exact_is_tried_but_what_an_effect_stands_for():
    on_valve = suspects_of(Machine(), VALVE)
    assert on_valve == ["valve.stroke", "valve.piston_area", "valve.clearance_volume"]
    on_engine = suspects_of(Machine(), ENGINE)
    assert on_engine[:3] == on_valve
    assert {"engine.bore", "engine.exhaust.opens", "engine.exhaust.closes"} < set(on_engine)
    assert "engine.compression_ratio" not in on_engine  # which clearance_error stands for


def test_what_is_stated_or_left_out_is_not_tried():
    stated = Machine.load(None, ["known_to.valve.stroke=1 %", "known_to.valve.piston_area=0 %"])
    assert suspects_of(stated, VALVE) == ["valve.clearance_volume"]
    assert suspects_of(Machine(), VALVE, without=["valve.stroke"])[:1] == ["valve.piston_area"]


def test_only_errors_that_can_be_are_tried():
    at_zero = suspects_of(Machine.load(None, ["groove.lap=0 mm"]), ENGINE)
    assert "groove.lap" in at_zero
    assert "engine.exhaust_2.opens" not in at_zero
    assert "engine.exhaust_2.opens" in suspects_of(
        Machine.load(None, ["engine.exhaust_2.effective_area=1 cm^2"]), ENGINE
    )
    assert "engine.receiver.volume" not in suspects_of(Machine.load(None, ["engine.receiver.volume=inf"]), ENGINE)


def test_an_effect_is_an_error_of_all_numbers_that_it_acts_on_and_of_none_that_is_overruled():
    def keys(effect, *settings):
        return [each.key for each in list_misstated(Machine.load(None, settings), effect)]

    ramps = ["valve.solenoid.ramp_time", "valve.solenoid.release_ramp_time"]
    assert keys(slow_ramp.EFFECT, "valve.solenoid.release_ramp_time=1 ms") == ramps
    assert keys(slow_ramp.EFFECT) == ramps[:1]
    assert len(keys(exhaust_timing.EFFECT)) == 2
    assert len(keys(exhaust_timing.EFFECT, "engine.exhaust_2.effective_area=1 cm^2")) == 4


def test_a_number_stays_within_what_a_machine_file_takes():
    machine = Machine()
    for suspect in find_file_numbers(machine, Measured("", {}, (), ENGINE), []):
        parameter = suspect.strengths[0]
        low, high = parameter.declaration.ends
        first, last = sorted(parameter.value(x) for x in (parameter.low, parameter.high))
        assert low <= first < last <= high
        assert parameter.value(0.0) == parameter.origin


def test_only_effects_and_numbers_that_may_be_wrong_can_be_left_out(measure):
    with pytest.raises(InputError, match="strok' is no effect"):
        explain(Machine(), measure(Bench()), without=["valve.strok"])


@pytest.mark.parametrize(
    ("key", "wrong", "right"),
    [("valve.piston_area", "1250 mm^2", 1134.1), ("valve.stroke", "9.3 mm", 9.0)],
)
def test_a_wrong_number_is_named_with_its_value_and_the_machine_is_mended(measure, key, wrong, right):
    folder = measure(Bench())
    found = explain(Machine.load(None, [f"{key}={wrong}"]), folder, without=BUT_RIVALS)
    assert (found.verdict, found.decision.best.names) == ("CALIBRATION", (key,))
    [row] = found.effects
    low, high = row["interval_95"]
    assert (row["key"], row["before"]) == (key, wrong)
    assert low < right < high < 1.01 * low
    assert write_sentence(found).endswith(f", where the file says {wrong}).")
    again = explain(found.best.machine(), folder, without=BUT_RIVALS)
    assert again.verdict == "NO_GAP"


def test_an_effect_that_stands_for_a_number_says_what_the_number_would_be(measure):
    found = explain(Machine.load(None, ["valve.moving_mass=0.16 kg"]), measure(Bench()), without=BUT_RIVALS)
    assert (found.verdict, found.decision.best.names) == ("NAMED", ("moving_mass_error",))
    [row] = found.effects
    [number] = row["misstated"]
    assert (number["key"], number["before"]) == ("valve.moving_mass", "0.16 kg")
    assert float(number["text"].split()[0]) == pytest.approx(0.1145, rel=0.02)
    assert f"moving mass {number['text']} where the file says 0.16 kg" in write_sentence(found)


def test_the_example_searches_effects_alone():
    assert {suspect.key for suspect in SUSPECTS[VALVE]} < set(list_left_out())
