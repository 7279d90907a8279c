"""What an explanation claims, and how probable it says that to be."""

from dataclasses import replace
from itertools import product
from math import asinh, exp, sinh

import pytest

from apesim.studies.estimation.noise.discrepancy import state_discrepancy
from apesim.studies.estimation.parameters import Parameter
from apesim.studies.gap.decide import reliability
from apesim.studies.gap.decide.reliability import FEATURES, StatementKind, find_probability, list_statements
from apesim.studies.gap.example_bench import explain_example
from apesim.studies.gap.reasons import Verdict
from apesim.studies.gap.report.verdict_json import describe
from apesim.studies.gap.search.candidates import Candidate
from apesim.studies.gap.search.model_selection import Foreseen
from apesim.studies.measured import CYLINDER, ENGINE, VALVE
from tests.truth.scoring import reliability as scoring

OFFSETS = {StatementKind.EFFECT: -1.0, StatementKind.NAME: 0.5}
SLOPES = {"evidence": 0.2, "shortfall": -0.1, "pull": -0.4, "has_rivals": -0.8}
ON_VALVE = 0.25
"""Coefficients of a regression: offsets of kinds, slopes of all, and the offset of the valve's bench."""


@pytest.fixture
def counted(monkeypatch):
    """Probabilities of effects and of names of a valve alone, as sealed cases might tell them."""
    kinds = {kind: {"offset": offset, "slopes": SLOPES} for kind, offset in OFFSETS.items()}
    told = {"cases": {}, "kinds": kinds, "benches": {VALVE: {"offset": ON_VALVE}}}
    monkeypatch.setattr(reliability, "load_reliability", lambda: told)


def said(verdict, **changes):
    explanation = explain_example()
    return replace(explanation, decision=explanation.decision._replace(verdict=verdict), **changes)


def test_a_verdict_claims_its_name_and_each_effect(counted):
    name, effect = list_statements(explain_example())
    assert (name.kind, effect.kind) == (StatementKind.NAME, StatementKind.EFFECT)
    assert name.about == effect.about == ("side_force",)
    assert name.evidence == effect.evidence > asinh(20.0)
    assert (name.bench, name.has_rivals) == (VALVE, False)
    score = 0.5 + ON_VALVE + 0.2 * name.evidence - 0.1 * name.shortfall - 0.4 * name.pull
    assert find_probability(name) == pytest.approx(1.0 / (1.0 + exp(-score)))
    open_one = name._replace(has_rivals=True)
    assert find_probability(open_one) == pytest.approx(1.0 / (1.0 + exp(0.8 - score)))


def test_what_is_written_is_what_was_counted(counted):
    data = describe(explain_example())
    name, effect = list_statements(explain_example())
    assert data["probability"] == find_probability(name)
    assert data["inclusion"] == {"side_force": find_probability(effect)}
    assert [each["kind"] for each in data["statements"]] == ["name", "effect"]
    assert [each["probability"] for each in data["statements"]] == [data["probability"], *data["inclusion"].values()]


def test_a_tie_claims_nothing_but_of_its_effects(counted):
    tie = said(Verdict.AMBIGUOUS)
    effects = list_statements(tie)
    assert {each.kind for each in effects} == {StatementKind.EFFECT}
    assert describe(tie)["probability"] is None
    assert describe(tie)["inclusion"]["side_force"] == find_probability(effects[0])


@pytest.mark.parametrize("verdict", [Verdict.REFUSED, Verdict.NO_GAP, Verdict.CALIBRATION, Verdict.MEASUREMENT])
def test_what_no_sealed_case_tells_of_has_no_probability(counted, verdict):
    assert find_probability(list_statements(said(verdict))[0]) is None


def test_data_of_another_kind_than_the_sealed_cases_have_no_probability(counted):
    explanation = explain_example()
    on_rig = replace(explanation, measured=explanation.measured._replace(bench=CYLINDER))
    assert [find_probability(each) for each in list_statements(on_rig)] == [None, None]
    noise = state_discrepancy(explanation.noise, {"lift": 2e-5})
    calibrated = explanation.calibrated
    off = replace(explanation, calibrated=calibrated._replace(residuals=calibrated.residuals.with_noise(noise)))
    assert [find_probability(each) for each in list_statements(off)] == [None, None]


def test_of_numbers_of_the_machine_file_no_probability_is_given(counted):
    explanation = explain_example()
    best = explanation.ranked[0]
    number = Candidate("valve.stroke", (Parameter("valve.stroke", 0.1, -6.0, 6.0, 9e-3, True, True),), ())
    wrong = best._replace(model=best.model._replace(candidates=(number,)))
    found = replace(explanation, ranked=[wrong], decision=explanation.decision._replace(best=wrong))
    assert [find_probability(each) for each in list_statements(found)] == [None, None]
    assert None not in [find_probability(each) for each in list_statements(explanation)]


def test_sets_that_were_not_fitted_count_in_what_is_stated(counted):
    explanation = explain_example()
    number = Candidate("valve.stroke", (Parameter("valve.stroke", 0.1, -6.0, 6.0, 9e-3, True, True),), ())
    found = replace(explanation, foreseen=[Foreseen((number,), 4.0)])
    name, effect, *_, stroke = list_statements(found)
    assert name.evidence < list_statements(explanation)[0].evidence
    assert sinh(effect.evidence) == pytest.approx(2.0, abs=0.1)
    assert (stroke.about, stroke.is_counted) == (("valve.stroke",), False)


@pytest.mark.parametrize("verdict", [Verdict.REFUSED, Verdict.NO_GAP])
def test_a_refusal_and_an_all_clear_deny_the_surest_effect(verdict):
    denial = list_statements(said(verdict))[0]
    assert denial.about == ()
    assert denial.evidence == list_statements(explain_example())[1].evidence


def test_what_noise_would_hardly_leave_makes_every_statement_fall_short():
    sound, short = (list_statements(said(Verdict.NAMED, left_p_value=chance))[0] for chance in (1.0, 1e-9))
    assert (sound.shortfall, short.shortfall) == (0.0, 6.0)


def test_what_sealed_cases_are_counted_by_is_what_a_statement_has():
    assert scoring.FEATURES == FEATURES
    assert set(scoring.DIRECTIONS) == set(StatementKind)


def test_the_coefficients_of_this_release_are_whole():
    told = reliability.load_reliability()
    assert set(told["benches"]) == {VALVE, ENGINE}
    for kind, counted in told["kinds"].items():
        assert kind in list(StatementKind)
        assert counted["statements"] > 0
        assert set(counted["slopes"]) == set(FEATURES)


def test_more_evidence_raises_the_probability_of_what_is_named_and_more_left_lowers_it():
    name, effect = list_statements(explain_example())
    for statement in (name, effect):
        for field, way in (("evidence", 1.0), ("shortfall", -1.0)):
            before, after = (statement._replace(**{field: size}) for size in (1.0, 3.0))
            assert way * (find_probability(after) - find_probability(before)) > 0.0


def test_an_effect_that_the_data_speak_against_is_less_likely_than_not():
    """Whatever else is known: all pulls and shortfalls that there may be, with rivals and without, on both benches."""
    effect = list_statements(explain_example())[1]
    for bench, log_odds, shortfall, pull, has_rivals in product(
        (VALVE, ENGINE), (-3.0, -7.0), (0.0, 6.0), (0.0, 6.0), (False, True)
    ):
        others = {"bench": bench, "shortfall": shortfall, "pull": pull, "has_rivals": has_rivals}
        assert find_probability(effect._replace(evidence=asinh(log_odds), **others)) < 0.5


def test_names_differ_by_what_the_best_model_leaves():
    near, far = (list_statements(said(Verdict.NAMED, left_p_value=chance))[0] for chance in (0.53, 0.0147))
    assert find_probability(far) < find_probability(near)
