"""What is said of a verdict, and what the machine that it leads to then does."""

from types import SimpleNamespace

import numpy as np
import pytest

from apesim.studies.estimation.levenberg_marquardt import Fitted
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.parameters import Parameter, put
from apesim.studies.estimation.priors import Prior, nuisance
from apesim.studies.estimation.profile_likelihood import End, EndKind
from apesim.studies.estimation.residuals import WhitenedResiduals, first_steps
from apesim.studies.gap.decide.verdict import Decision
from apesim.studies.gap.explanation import Explanation
from apesim.studies.gap.reasons import ReasonKind, Verdict
from apesim.studies.gap.report.effect_rows import SIDES, describe_effects, describe_numbers
from apesim.studies.gap.report.verdict_json import describe_sure, list_class, write_sentence
from apesim.studies.gap.search.candidates import Candidate, find_candidates
from apesim.studies.gap.search.model_selection import PricedModel
from apesim.studies.gap.stage_work import Work
from apesim.studies.gap.workflow import check_on_unused_runs
from apesim.studies.measured import Measured
from apesim.studies.measured.prediction import run_of
from apesim.valve.effects import VALVE_EFFECTS
from tests.machines import machine
from tests.studies.measured.test_prediction import AMBIENT, valve_run

GAUGE, THERMOMETER = Prior("supply.pressure", 0.01, True), Prior("supply.temperature", 2.0)
RUNS = [valve_run()._replace(supply=gauge + AMBIENT, temperature=t) for gauge, t in ((0.2e6, 281.0), (0.8e6, 293.0))]


def fitted(base, runs, parameters, x, candidates=()):
    """A model at given parameters, as if it had been fitted."""
    jacobian = np.vstack([np.eye(len(x)), np.eye(len(x))])
    residuals = WhitenedResiduals(base, runs, parameters)
    at_optimum = Fitted(np.array(x, dtype=float), np.zeros(2 * len(x)), jacobian, True, first_steps(len(x)))
    return Model(candidates, residuals, at_optimum)


def corrected_by(base, prior, x, runs=RUNS):
    """A calibrated machine whose nuisance is pulled far."""
    return fitted(base, runs, [nuisance(base, prior)], [x])


def with_effects(*sized):
    """A machine with effects at x, by name."""
    known = {c.name: c for c in find_candidates(machine(), "valve", VALVE_EFFECTS)}
    found = tuple(known[name] for name, *_ in sized)
    parameters = [p for candidate in found for p in candidate.parameters]
    return fitted(machine(), RUNS, parameters, [x for _, *own in sized for x in own], found)


def said(word, model, *rivals, reason=ReasonKind.DISTINGUISHABLE, balance=None, sure=()):
    told = decision_of(word, model, *rivals, reason=reason, sure=sure)
    table = balance and SimpleNamespace(balance=SimpleNamespace(balance=balance))
    return write_sentence(SimpleNamespace(decision=told, tabulated=table))


def decision_of(word, model, *rivals, reason=ReasonKind.DISTINGUISHABLE, sure=()):
    return Decision(
        word, PricedModel(model, 0.0), tuple(PricedModel(r, 0.0) for r in rivals), reason.with_facts(), sure
    )


@pytest.mark.parametrize(
    "known", [{}, {"sensor_gain__supply_pressure": 0.03, "sensor_offset__supply_temperature": 4.0}]
)
@pytest.mark.parametrize("prior", [GAUGE, THERMOMETER])
def test_a_machine_with_the_instrument_put_right_has_the_supply_that_was_found(known, prior):
    base = machine(**{f"effects__{name}": value for name, value in known.items()})
    model = corrected_by(base, prior, 6.0)
    corrected = model.machine()
    assert corrected.supply == base.supply
    for run in RUNS:
        meant = put(run_of(base, run), model.residuals.parameters, model.fitted.x).supply
        assert run_of(corrected, run).supply == pytest.approx(meant, rel=1e-12, nan_ok=True)


def test_a_supply_temperature_that_runs_do_not_state_is_the_machines():
    silent = [run._replace(temperature=np.nan) for run in RUNS]
    model = corrected_by(machine(), THERMOMETER, 6.0, silent)
    assert model.machine().supply.temperature == pytest.approx(machine().supply.temperature + 12.0)
    assert model.machine().effects == machine().effects
    (row,) = describe_effects(model)
    assert (row["key"], row["value"]) == ("supply.temperature", pytest.approx(machine().supply.temperature + 12.0))
    both = corrected_by(machine(), THERMOMETER, 6.0, [RUNS[0], silent[1]]).machine()
    assert [run_of(both, run).supply.temperature for run in (RUNS[0], silent[1])] == pytest.approx([293.0, 299.0])


def test_readings_are_told_from_numbers_of_the_machine():
    warm = said(Verdict.CALIBRATION, corrected_by(machine(), THERMOMETER, 4.5))
    assert warm == "Nothing is missing, but a reading is wrong: supply temperature reads 9 K too low."
    high = said(Verdict.CALIBRATION, corrected_by(machine(), GAUGE, -8.0))
    assert high == "Nothing is missing, but a reading is wrong: supply pressure reads 9 % too high."
    late = said(Verdict.CALIBRATION, corrected_by(machine(), Prior("valve.solenoid.dead_time", 1e-4), 5.0))
    assert late.startswith("Nothing is missing, but a number is wrong: valve, solenoid, dead time (")


def test_effects_of_the_record_are_never_called_physics():
    lag, drag, force = ("lift_sensor_lag", 0.5), ("quadratic_drag", 0.25), ("side_force", -0.5)
    lagging = said(Verdict.NAMED, with_effects(lag))
    assert lagging == "The model lacks nothing that these data show, but the record has lift sensor lag (time 0.25 ms)."
    assert said(Verdict.NAMED, with_effects(drag)) == "The model lacks quadratic drag (coefficient 10 N s^2/m^2)."
    both = said(Verdict.TWO_EFFECTS, with_effects(drag, lag))
    assert both == (
        "The model lacks quadratic drag (coefficient 10 N s^2/m^2), and the record has lift sensor lag (time 0.25 ms)."
    )
    two = said(Verdict.TWO_EFFECTS, with_effects(drag, force))
    assert two.startswith("The model lacks two effects: quadratic drag (")
    either = said(Verdict.NAMED_CLASS, with_effects(lag), with_effects(drag))
    assert either == (
        "The gap is lift sensor lag (time 0.25 ms), or what these data do not distinguish from it: quadratic drag."
    )


def test_a_wrong_number_is_told_beside_what_is_missing_and_not_as_a_part_of_it():
    force = with_effects(("side_force", -0.5))
    gauge = nuisance(machine(), GAUGE)
    beside = fitted(machine(), RUNS, [gauge, *force.residuals.parameters], [-8.0, -0.5], force.candidates)
    assert said(Verdict.NAMED, beside) == (
        "The model lacks side force (force -6 N). Besides, a reading is wrong: supply pressure reads 9 % too high."
    )


def test_what_is_refused_as_too_faint_is_told_with_its_explanations():
    either = with_effects(("quadratic_drag", 0.25)), with_effects(("side_force", -0.5))
    assert said(Verdict.REFUSED, *either) == "There is a gap, and nothing in the library closes it."
    assert said(Verdict.REFUSED, *either, reason=ReasonKind.FAINT, balance="force") == (
        "There is a gap, and these data hardly show what closes it: quadratic drag, or side force; "
        "a table of a force takes it best."
    )


def test_of_many_explanations_the_first_are_listed_in_words():
    names = ("run_offset of lift in run_02.csv", "seal_friction", "seat_leak", "bounce", "blow_by")
    plain = with_effects(("side_force", 0.1))
    rivals = [plain._replace(candidates=(plain.candidates[0]._replace(name=name),)) for name in names]
    assert said(Verdict.AMBIGUOUS, with_effects(("side_force", -0.5)), *rivals) == (
        "There is a gap, and these data do not show what closes it: side force, or run offset of lift in run_02.csv, "
        "or seal friction, or seat leak, or one of 2 others."
    )


FORCE, DRAG, LAG = ("side_force", -0.5), ("quadratic_drag", 0.25), ("lift_sensor_lag", 0.5)
STROKE = Parameter("valve.stroke", 0.1, -6.0, 6.0, machine().valve.stroke, shifts=True, relative=True)


def with_stroke(*sized):
    """A machine with effects at x, and a stroke that is 10 % less than its file says."""
    plain = with_effects(*sized)
    candidates = (Candidate("valve.stroke", (STROKE,), ()), *plain.candidates)
    return fitted(machine(), RUNS, [STROKE, *plain.residuals.parameters], [-1.0, *plain.fitted.x], candidates)


def test_two_readings_of_one_kind_are_both_told():
    gains = [Prior("effects.sensor_gain.lift", 0.005), Prior("effects.sensor_gain.pressure_a", 0.005)]
    two = fitted(machine(), RUNS, [nuisance(machine(), prior) for prior in gains], [8.0, -6.0])
    text = said(Verdict.CALIBRATION, two)
    assert "lift reads 4" in text and "pressure a reads 3" in text


def test_what_is_sure_of_an_ambiguous_gap_is_told_with_its_value_and_then_what_may_be_with_it():
    pair, other = with_effects(FORCE, DRAG), with_effects(FORCE, LAG)
    sure, others = said(Verdict.AMBIGUOUS, pair, other, sure=(("side_force",),)).split(". ")
    assert "side force (force -6 N)" in sure
    assert others.index("quadratic drag") < others.index("lift sensor lag")
    assert "10 N s^2/m^2" not in others  # of one that may not be there no value is told
    alone = said(Verdict.AMBIGUOUS, pair, with_effects(FORCE), sure=(("side_force",),))
    assert "quadratic drag, or nothing else" in alone


def test_what_data_do_not_distinguish_from_what_is_sure_stands_beside_it_and_not_among_what_is_open():
    pair, twin, other = with_effects(FORCE, DRAG), with_effects(DRAG, ("leakage_a", 0.1)), with_effects(FORCE, LAG)
    sure, others = said(Verdict.AMBIGUOUS, pair, twin, other, sure=(("side_force", "leakage_a"),)).split(". ")
    assert "side force (force -6 N)" in sure and "leakage a" in sure
    assert others.count("quadratic drag") == 1 and "leakage a" not in others
    rows = describe_sure(decision_of(Verdict.AMBIGUOUS, pair, twin, other, sure=(("side_force", "leakage_a"),)))
    assert [(row["key"], row["class"]) for row in rows] == [("effects.side_force.force", ["leakage_a"])]


def test_where_all_is_sure_but_which_of_a_class_the_reason_says_what_is_open():
    pair, twin = with_effects(FORCE, DRAG), with_effects(DRAG, ("leakage_a", 0.1))
    reason, sure = ReasonKind.SEVERAL_SETS, (("side_force", "leakage_a"), ("quadratic_drag",))
    text = said(Verdict.AMBIGUOUS, pair, twin, reason=reason, sure=sure)
    assert text.count("quadratic drag") == text.count("side force (") == text.count("leakage a") == 1
    assert str(reason.with_facts()) in text
    assert text.count("10 N s^2/m^2") == 1


def test_what_all_explanations_have_and_is_not_sure_is_told_as_less_sure():
    pair, twin = with_effects(FORCE, DRAG), with_effects(DRAG, ("leakage_a", 0.1))
    sure, open_part = said(Verdict.AMBIGUOUS, pair, twin, sure=(("side_force", "leakage_a"),)).split(". ")
    assert "less sure" in open_part and "quadratic drag" in open_part and "quadratic drag" not in sure


def test_a_number_of_the_file_and_what_a_sensor_adds_are_no_lack_of_the_model_where_they_are_sure():
    both = with_stroke(DRAG), with_stroke(FORCE)
    number = said(Verdict.AMBIGUOUS, *both, sure=(("valve.stroke",),))
    assert number.startswith("A number is wrong: valve, stroke (8.1 mm, where the file says 9 mm). With it quadratic")
    recorded = said(Verdict.AMBIGUOUS, with_effects(LAG, DRAG), with_effects(LAG, FORCE), sure=(("lift_sensor_lag",),))
    assert "lacks" not in recorded and "lift sensor lag (time 0.25 ms)" in recorded
    mixed = said(
        Verdict.AMBIGUOUS, with_stroke(FORCE, DRAG), with_stroke(FORCE, LAG), sure=(("side_force",), ("valve.stroke",))
    )
    assert mixed.index("lacks side force (force -6 N)") < mixed.index("number is wrong: valve, stroke (8.1 mm")


def test_rows_of_what_is_sure_are_those_of_the_best_explanation_and_of_no_file():
    model = with_stroke(FORCE, DRAG)
    rows = describe_sure(decision_of(Verdict.AMBIGUOUS, model, sure=(("side_force",), ("valve.stroke",))))
    assert [(row["key"], row["value"], row["class"]) for row in rows] == [
        ("effects.side_force.force", pytest.approx(-6.0), []),
        ("valve.stroke", pytest.approx(8.1), []),
    ]
    assert [{key: row[key] for key in row if key != "class"} for row in rows] == [
        describe_effects(model)[0],
        *describe_numbers(model),
    ]
    assert describe_sure(decision_of(Verdict.AMBIGUOUS, model)) == []


def test_parameters_of_one_effect_are_one_thing_in_a_sentence():
    (shape,) = {c.name: c for c in find_candidates(machine(), "valve", VALVE_EFFECTS)}["supply_droop"].shapes
    told = said(Verdict.NAMED, with_effects(("supply_droop", 0.1, 0.5)))
    assert shape.key.endswith("volume")
    assert told.startswith("The model lacks supply droop (feed area ")
    assert told.count("supply droop") == 1
    assert ", volume " in told


@pytest.mark.parametrize(
    ("open_ends", "told"),
    [((0, 0), "breakaway 20 N"), ((1, 0), "breakaway at most 25 N"), ((0, 1), "breakaway at least 5 N"), ((1, 1), "")],
)
def test_a_shape_is_told_as_far_as_the_data_hold_it(open_ends, told, monkeypatch):
    for module in ("decide.standard_errors", "report.effect_rows"):
        monkeypatch.setattr(f"apesim.studies.gap.{module}.WIDENING", 1.0)
    model = with_effects(("coulomb_friction", 0.75, 0.4))
    kinds = [EndKind.OPEN if is_open else EndKind.CLOSED for is_open in open_ends]
    sides = [End(x, kind, model.fitted.x) for x, kind in zip((0.1, 0.5), kinds, strict=True)]
    model = model._replace(profiles=dict.fromkeys((p.key for p in model.residuals.parameters), sides))
    assert said(Verdict.NAMED, model) == f"The model lacks coulomb friction (force 9 N{', ' if told else ''}{told})."
    assert [row["open_ends"] for row in describe_effects(model)] == [
        [s for s, o in zip(SIDES, open_ends, strict=True) if o]
    ] * 2


def test_what_is_fitted_beyond_its_range_is_told_and_written_as_its_end():
    model = with_effects(("side_force", 1.2), ("quadratic_drag", 0.5))
    model.residuals.runs = RUNS[:1]
    assert model.beyond == ["effects.side_force.force"]
    effects = model.machine().effects
    assert (effects.side_force.force, effects.quadratic_drag.coefficient) == (pytest.approx(12.0), pytest.approx(20.0))
    unsure = model._replace(fitted=model.fitted._replace(converged=False))
    found = check_on_unused_runs(explanation(unsure), Work())
    assert [text.split(" ")[-3:] for text in found.warnings] == [["did", "not", "converge"], ["end", "of", "it"]]
    assert found.checked is None


def explanation(model):
    """What was found, as far as the end of the workflow looks at it."""
    base = model._replace(candidates=())
    decision = Decision(Verdict.NAMED, PricedModel(model, 0.0), (), ReasonKind.DISTINGUISHABLE.with_facts())
    rest = dict.fromkeys(("sensitivities", "scores", "gap_test", "solver_error", "tolerance", "cells"))
    measured = Measured("", {}, ())
    return Explanation(**rest, measured=measured, calibrated=base, decision=decision, warnings=[])


def test_a_wrong_dead_time_may_be_a_wrong_zero_of_the_recorders_time():
    """No signal of the valve's bench knows whether the solenoids or the recorder are late."""
    dead_time = corrected_by(machine(), Prior("valve.solenoid.dead_time", 0.1e-3), 6.0)
    assert said("CALIBRATION", dead_time).endswith(", or the time zero of the record.")
    ramp = with_effects(("slow_ramp", 0.5))
    assert said("NAMED_CLASS", ramp, dead_time).endswith("valve solenoid dead time or time zero.")
    assert "time zero" not in said("NAMED", ramp)
    decision = SimpleNamespace(best=PricedModel(ramp, 0.0), rivals=(PricedModel(dead_time, 1.0),))
    assert list_class(decision) == ["slow_ramp", "valve.solenoid.dead_time", "time_zero"]
