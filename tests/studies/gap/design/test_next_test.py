"""The next test: what it would tell is what a fit to its data tells."""

import re
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.estimation.calibration import calibrate
from apesim.studies.estimation.levenberg_marquardt import descend
from apesim.studies.estimation.noise.process import noise_for, white
from apesim.studies.estimation.parameters import put
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.estimation.scatter import Scatter
from apesim.studies.gap.design.expected_information import find_separation
from apesim.studies.gap.design.experiments import list_experiments, make_residuals
from apesim.studies.gap.design.forecasts import (
    AS_IT_IS,
    NONE_OF_THEM,
    NONE_SHARE,
    Alternative,
    list_alternatives,
    preview_experiment,
)
from apesim.studies.gap.design.next_test import MAX_EXPERIMENTS, find_next_test, rank_experiments
from apesim.studies.gap.design.outcomes import describe_outcomes, find_decimals, write_outcomes
from apesim.studies.gap.reasons import ReasonKind, Verdict
from apesim.studies.gap.search.candidates import find_candidates
from apesim.studies.gap.search.library import select_effects
from apesim.studies.gap.search.model_selection import PricedModel
from apesim.studies.gap.search.phases import find_phases
from apesim.studies.gap.search.refit import refit
from apesim.studies.gap.search.run_faults import FaultKind, list_faults
from apesim.studies.measured import MeasuredRun, read_measured
from tests.gap_bench import write_bench
from tests.machines import machine
from tests.studies.gap.report.test_verdict_json import GAUGE, corrected_by


@pytest.fixture(scope="module")
def rivals(tmp_path_factory):
    """The machine as it is, and with a side force or a leak."""
    machine = Machine()
    bench = write_bench(tmp_path_factory.mktemp("bench"))
    measured = read_measured(bench, machine.ambient.pressure)
    base, _ = calibrate(machine, measured)
    known = {candidate.name: candidate for candidate in find_candidates(machine, "valve", select_effects("valve"))}
    force, leak = (refit(base, (known[name],), ((0.1,),)) for name in ("side_force", "leakage_a"))
    return measured, base, force, leak


def findings_of(verdict, measured, base, best=None, others=(), scores=("bounce",), reason=ReasonKind.DISTINGUISHABLE):
    rivals = tuple(PricedModel(o, o.cost) for o in others)
    told = SimpleNamespace(
        verdict=verdict, best=best and PricedModel(best, best.cost), rivals=rivals, reason=reason.with_facts()
    )
    names = [SimpleNamespace(name=name) for name in scores]
    return SimpleNamespace(
        measured=measured,
        calibrated=base,
        best=best or base,
        noise=base.residuals.noise,
        decision=told,
        scores=names,
        sensitivities=[],
        rest=None,
        ranked=(),
        fits=[PricedModel(model, model.cost) for model in (best, *others) if model],
        gap_size=0.5,
    )


def preview_pair(rivals, text):
    """The preview of an experiment by both effects."""
    measured, base, force, leak = rivals
    (experiment,) = (each for each in list_experiments(measured, 101325.0) if each.text.startswith(text))
    pair = [Alternative("side_force", 0.5, force), Alternative("leakage_a", 0.5, leak)]
    return preview_experiment(experiment, findings_of(Verdict.AMBIGUOUS, measured, base, force, (leak,)), pair), pair


def test_deviations_are_what_fitting_the_rival_to_the_experiment_would_cost(rivals):
    _, base, force, leak = rivals
    noise = base.residuals.noise
    preview, _ = preview_pair(rivals, "a run at 0.10 MPa gauge, 12 ms")
    expected = find_separation(*preview.forecasts)
    # The experiment made by the truth, without noise, and the rival fitted to it and to the data that there are.
    made = make_residuals(preview.experiment, base.residuals.machine, force.residuals.parameters, noise)
    (shown,) = made.predicted(force.fitted.x)
    run = preview.experiment.run._replace(channels={"lift": shown})
    both = WhitenedResiduals(base.residuals.machine, [*base.residuals.runs, run], leak.residuals.parameters, noise)
    refitted = descend(both, leak.fitted.x)
    assert expected > 1.0
    assert np.sqrt(refitted.cost - leak.cost) == pytest.approx(expected, rel=0.15)  # straight priors, and bent ones


def test_the_cheap_estimate_is_near_the_full_one(rivals):
    measured, base, force, leak = rivals
    full, pair = preview_pair(rivals, "a run at 0.10 MPa gauge, 12 ms")
    findings = findings_of(Verdict.AMBIGUOUS, measured, base, force, (leak,))
    cheap = preview_experiment(full.experiment, findings, pair, refine=False)
    assert find_separation(*cheap.forecasts) == pytest.approx(find_separation(*full.forecasts), rel=0.2)


def test_an_unknown_effect_is_as_large_as_the_gap_and_of_no_known_shape(rivals):
    measured, base, force, _ = rivals
    findings = findings_of(Verdict.REFUSED, measured, base, force)
    alternatives = list_alternatives(findings)
    experiment = list_experiments(measured, 101325.0)[0]
    preview = preview_experiment(experiment, findings, alternatives)
    added = preview.forecasts[-1].spread[:, preview.base.spread.shape[1] :]
    sizes = [np.sqrt(np.mean(column[column != 0.0] ** 2)) for column in added.T]
    (block,) = preview.residuals.blocks
    assert len(sizes) == 2 * len(np.unique(find_phases(block, preview.marks)))  # a constant and a slope in each phase
    assert sizes == pytest.approx([findings.gap_size] * len(sizes))
    assert preview.forecasts[-1].mean == pytest.approx(preview.base.mean)


def test_a_run_to_come_scatters_as_those_that_there_are(rivals):
    measured, base, force, leak = rivals
    full, pair = preview_pair(rivals, "a run at 0.10 MPa gauge, 12 ms")
    scatter = Scatter(("valve.viscous_friction",), (0.3,), 1, {})
    scattering = [model._replace(residuals=model.residuals.with_scatter(scatter)) for model in (base, force, leak)]
    findings = findings_of(Verdict.AMBIGUOUS, measured, *scattering[:2], scattering[2:])
    pair = [each._replace(model=model) for each, model in zip(pair, scattering[1:], strict=True)]
    preview = preview_experiment(full.experiment, findings, pair)
    scattered = preview.base.spread[:, -1]
    slopes = full.residuals.jacobian(base.fitted.x, full.residuals.at(base.fitted.x))[0][: len(scattered)]
    number = [p.key for p in full.residuals.parameters].index("valve.viscous_friction")
    left = scattered - 0.3 * slopes[:, number]
    assert np.linalg.norm(left) < 0.1 * np.linalg.norm(scattered)  # found by other steps at the ends of the stroke
    assert find_separation(*preview.forecasts) < find_separation(*full.forecasts)


def test_weights_are_those_of_the_penalised_costs_and_what_a_rule_keeps_is_not_without(rivals):
    measured, base, force, leak = rivals
    tied = findings_of(Verdict.AMBIGUOUS, measured, base, force, (leak,))
    near, far = (
        SimpleNamespace(**vars(tied) | {"decision": SimpleNamespace(**vars(tied.decision) | {"rivals": rival})})
        for rival in ((PricedModel(leak, force.cost + 2.0),), (PricedModel(leak, force.cost + 80.0),))
    )
    weights = [[each.weight for each in list_alternatives(findings)] for findings in (near, far)]
    assert weights[0] == pytest.approx([1.0 / (1.0 + np.exp(-1.0)), np.exp(-1.0) / (1.0 + np.exp(-1.0))])
    assert weights[1] == pytest.approx([100.0 / 101.0, 1.0 / 101.0])


def test_after_a_refusal_the_machine_as_it_is_and_none_of_the_library_are_in_play(rivals):
    measured, base, force, leak = rivals
    alternatives = list_alternatives(findings_of(Verdict.REFUSED, measured, base, force, (leak,)))
    assert [each.name for each in alternatives] == ["side_force", "leakage_a", AS_IT_IS, NONE_OF_THEM]
    assert sum(each.weight for each in alternatives) == pytest.approx(1.0)
    assert alternatives[-1].weight == NONE_SHARE
    assert [each.name for each in list_alternatives(findings_of(Verdict.REFUSED, measured, base))] == [
        AS_IT_IS,
        NONE_OF_THEM,
    ]


def test_the_experiment_that_tells_most_comes_first(rivals):
    measured, base, force, leak = rivals
    told = rank_experiments(findings_of(Verdict.AMBIGUOUS, measured, base, force, (leak, base)))
    rows, listed = told["experiments"], list_experiments(measured, 101325.0)
    assert len(rows) >= MAX_EXPERIMENTS
    assert len(rows) + len(told["others"]) == len(listed)
    assert rows[0]["information_bits"] >= max(row["information_bits"] for row in rows) - 0.05 * told["entropy_bits"]
    assert all(0.0 <= row["information_bits"] <= told["entropy_bits"] for row in rows)
    assert all(row["least"] == min(row["deviations"].values()) for row in rows)
    assert list(rows[0]["deviations"]) == ["leakage_a", AS_IT_IS]
    assert [each["name"] for each in told["explanations"]] == [told["truth"], "leakage_a", AS_IT_IS]
    assert rows[0]["text"] in told["text"]


def test_of_those_that_tell_as_much_the_one_that_keeps_them_farther_apart_comes_first(rivals, monkeypatch):
    told = iter([(0.50, 9.0), (0.90, 3.0), (0.91, 6.0), (0.20, 20.0), (0.88, 4.0)])
    outcome = {
        "explanation": NONE_OF_THEM,
        "quantity": "mean lift",
        "unit": "mm",
        "value": None,
        "tells": 1.0,
        "decimals": 1,
    }

    def describe(*_):
        settled, least = next(told)
        return {"text": f"run {least:g}", "settled": settled, "least": least, "outcomes": [outcome]}

    monkeypatch.setattr("apesim.studies.gap.design.next_test._describe_experiment", describe)
    measured, base, force, leak = rivals
    ranked = rank_experiments(findings_of(Verdict.AMBIGUOUS, measured, base, force, (leak,)))
    assert [row["least"] for row in ranked["experiments"]] == [6.0, 4.0, 3.0, 9.0, 20.0]
    assert ranked["text"].startswith("Make run 6: it is expected to settle 91 % of what is open.")


@pytest.mark.parametrize(("settled", "is_beyond"), [(0.6, False), (0.2, True)])
def test_what_was_never_run_is_looked_at_only_where_nothing_within_decides(rivals, monkeypatch, settled, is_beyond):
    outcome = {"explanation": NONE_OF_THEM, "quantity": "mean lift", "unit": "mm", "value": None}
    row = {"settled": settled, "least": 1.0, "outcomes": [outcome | {"tells": 1.0, "decimals": 1}]}
    monkeypatch.setattr(
        "apesim.studies.gap.design.next_test._describe_experiment",
        lambda preview, *_: row | {"text": preview.experiment.text, "within": preview.experiment.is_within},
    )
    measured, base, force, leak = rivals
    ranked = rank_experiments(findings_of(Verdict.AMBIGUOUS, measured, base, force, (leak,)))
    beyond = [each["text"] for each in ranked["experiments"] if not each["within"]]
    assert bool(beyond) == is_beyond
    assert all("beyond what was run" in text for text in beyond)


def test_runs_are_offered_between_those_that_there_are(rivals):
    """The bench was run at 0.4 and 0.6 MPa gauge: halfway is not among the usual pressures."""
    supplies = sorted({run.supply for run in rivals[0].runs})
    listed = list_experiments(rivals[0], 101325.0)
    within = {each.run.supply for each in listed if each.is_within and not each.added}
    assert {0.5 * sum(pair) for pair in pairwise(supplies)} <= within
    assert all(supplies[0] - 0.05e6 < supply < supplies[-1] + 0.05e6 for supply in within)


def test_an_experiment_says_how_it_is_run(rivals):
    measured, base, force, leak = rivals
    told = rank_experiments(findings_of(Verdict.AMBIGUOUS, measured, base, force, (leak,)))
    for row in (*told["experiments"], *told["others"]):
        assert 0.2e6 < row["supply_Pa_abs"] < 1.2e6
        assert row["temperature_K"] == pytest.approx(287.0)
        assert row["interval_s"] == pytest.approx(0.4e-3)
        assert set(row["added_sensors"]) <= set(row["sensors"]) <= {"lift", "pressure_a", "pressure_b"}
        assert row["recorded_s"] > row["pulse_s"]
        assert np.isnan(row["speed_rad_s"])


def test_each_outcome_is_what_its_explanation_would_show(rivals):
    preview, pair = preview_pair(rivals, "a run at 0.10 MPa gauge, 50 ms")
    outcomes = describe_outcomes(preview, pair)
    assert [outcome["explanation"] for outcome in outcomes] == ["side_force", "leakage_a"]
    flights = {"opening flight": ("energising", 0.0), "closing flight": ("release", 50.0)}
    stroke, start = flights[outcomes[0]["phase"]]
    assert (outcomes[0]["signal"], outcomes[0]["unit"]) == ("lift", "ms")
    assert outcomes[0]["quantity"] == f"time from {stroke} to half of the stroke"
    for outcome, (lift,) in zip(outcomes, preview.values, strict=True):
        at = np.interp(1e-3 * (start + outcome["value"]), preview.residuals.blocks[0].times, lift)
        assert at == pytest.approx(4.5e-3, abs=1e-5)
    (base,) = preview.base_values
    at = np.interp(
        1e-3 * (start + outcomes[0]["value"] - outcomes[0]["change"]), preview.residuals.blocks[0].times, base
    )
    assert at == pytest.approx(4.5e-3, abs=1e-5)
    assert outcomes[0]["deviations"] > 1.0
    assert 0.5 < outcomes[0]["tells"] <= 1.0
    assert "No single number" not in write_outcomes(outcomes)
    assert "No single number" in write_outcomes([outcome | {"tells": 0.2} for outcome in outcomes])


def test_what_an_outcome_means_is_written_with_no_more_digits_than_its_error():
    rows = [("side_force", 8.71343, -0.28657, 12.34), ("leakage_a", 9.00213, 0.00213, 0.4), (AS_IT_IS, 9.0, 0.0, 0.0)]
    outcomes = [
        {"explanation": name, "value": value, "change": change, "deviations": n_sigma}
        for name, value, change, n_sigma in rows
    ]
    shared = {"quantity": "mean lift in dwell", "unit": "mm", "tells": 0.9, "decimals": find_decimals(outcomes)}
    unknown = {"explanation": NONE_OF_THEM, "value": None, "change": None, "deviations": None}
    text = write_outcomes([outcome | shared for outcome in (*outcomes, unknown)])
    assert text == (
        "Look at the mean lift in dwell. If it is side force: 8.71 mm, 0.29 mm less than the machine as it is says "
        "(12 sigmas). If it is leakage a: 9.00 mm, as the machine as it is says, within 1 sigma. "
        "If nothing is missing: 9.00 mm. If the record fits none of these, it is none of the library."
    )


def test_what_is_refused_as_too_faint_is_to_be_told_from_its_rivals_and_from_nothing(rivals):
    measured, base, force, leak = rivals
    told = find_next_test(findings_of(Verdict.REFUSED, measured, base, force, (leak,), reason=ReasonKind.FAINT))
    assert list(told["experiments"][0]["deviations"]) == ["leakage_a", AS_IT_IS]


@pytest.mark.parametrize(
    ("verdict", "reason", "has_gate", "role"),
    [
        (Verdict.REFUSED, ReasonKind.REMOVES_NOTHING, True, "gate"),
        (Verdict.REFUSED, ReasonKind.REMOVES_NOTHING, False, "fit"),
        (Verdict.REFUSED, ReasonKind.FAINT, True, "fit"),
        (Verdict.AMBIGUOUS, ReasonKind.SEVERAL_SINGLES, True, "fit"),
    ],
)
def test_what_gates_have_refused_asks_for_a_gate(rivals, verdict, reason, has_gate, role):
    measured, base, force, leak = rivals
    if has_gate:
        measured = measured._replace(runs=(*measured.runs, measured.runs[0]._replace(role="gate")))
    findings = findings_of(verdict, measured, base, force, (leak,))
    findings.decision.reason = SimpleNamespace(kind=reason)
    told = rank_experiments(findings)
    assert {row["role"] for row in (*told["experiments"], *told["others"])} == {role}
    assert ("Give it the role gate" in told["text"]) == (role == "gate")


def test_sensors_are_offered_that_are_not_there(rivals):
    measured, base, _, _ = rivals
    added = [experiment.added for experiment in list_experiments(measured, 101325.0) if experiment.added]
    assert added == [("pressure_a",), ("pressure_b",), ("pressure_a", "pressure_b")]
    again = next(e for e in list_experiments(measured, 101325.0) if e.added == ("pressure_a",))
    assert list(again.run.channels) == ["lift", "pressure_a"]
    residuals = make_residuals(again, base.residuals.machine, base.residuals.parameters, base.residuals.noise)
    new = [parameter.key for parameter in residuals.parameters[len(base.residuals.parameters) :]]
    assert new == ["effects.sensor_offset.pressure_a", "effects.sensor_gain.pressure_a"]
    assert [noise_for(residuals.noise, block).deviation for block in residuals.blocks][1] == 2e3


def test_a_fault_of_a_file_is_in_no_experiment(rivals):
    measured, base, _, _ = rivals
    (first, *_), experiments = measured.runs, list_experiments(measured, 101325.0)
    fault = next(each for each in list_faults(first) if each.kind == FaultKind.OFFSET)
    parameters = [*base.residuals.parameters, *fault.parameters]
    x = np.zeros(len(parameters))
    for experiment in (experiments[0], experiments[-1]):
        residuals = make_residuals(experiment, base.residuals.machine, parameters, base.residuals.noise)
        new = np.zeros(len(residuals.parameters) - len(x))
        plain, faulty = (residuals.predicted(np.concatenate([x[:-1], [size], new]))[0] for size in (0.0, 1.0))
        assert (plain == faulty).all()


def test_runs_that_there_are_are_not_offered_again(rivals):
    texts = [experiment.text for experiment in list_experiments(rivals[0], 101325.0)]
    assert "a run at 0.40 MPa gauge, 50 ms" not in texts  # 0.40 MPa gauge and 30 ms are there
    assert "a run at 0.40 MPa gauge, 12 ms" in texts


@pytest.mark.parametrize(
    ("verdict", "says"),
    [
        (Verdict.REFUSED, "settle"),
        (Verdict.NO_GAP, "None is due"),
        (Verdict.NAMED, "side force"),
        (Verdict.CALIBRATION, "another instrument, or in another way: side force"),
    ],
)
def test_every_verdict_has_its_next_test(rivals, verdict, says):
    measured, base, force, _ = rivals
    told = find_next_test(findings_of(verdict, measured, base, force))
    assert "isolate" in told
    assert says in told["text"]
    if verdict == Verdict.REFUSED:
        assert told["isolate"][0]["effect"] == "bounce"


def pulled_by(model, **pulls):
    """The model with some nuisances moved by prior sigmas, by the last parts of their keys; the others as stated."""
    keys = [p.key.split(".", 1)[1].replace(".", "_") for p in model.residuals.parameters]
    x = np.where(model.residuals.known, [pulls.get(key, 0.0) for key in keys], model.fitted.x)
    assert set(pulls) <= set(keys)
    return model._replace(fitted=model.fitted._replace(x=x))


def numbers_in(text):
    return [float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", text)]


def test_a_refusal_beside_a_number_that_is_far_off_asks_first_to_measure_it(rivals):
    measured, base, force, _ = rivals
    far = pulled_by(force, viscous_friction=5.0)
    (parameter,) = (p for p in far.residuals.parameters if p.key == "valve.viscous_friction")
    asked, stated = put(Machine(), [parameter], [5.0]).valve.viscous_friction, Machine().valve.viscous_friction
    told, plain = (find_next_test(findings_of(Verdict.REFUSED, measured, base, model)) for model in (far, force))
    for key in ("text", "action"):
        first, _, then = told[key].partition(" Then: ")
        assert "viscous friction" in first
        assert numbers_in(first) == pytest.approx([asked, stated], rel=0.01)
        assert "settle" in then and "viscous friction" not in then + plain[key]
    assert len(told["experiments"]) == len(plain["experiments"]) == MAX_EXPERIMENTS
    assert told["isolate"] == plain["isolate"] != []


RANKED = {"text": "Make a run. Look at it.", "action": "Make a run.", "experiments": []}
FAR = [
    ({"sensor_gain_lift": 6.0}, ("gain", "lift", "%"), [3.0, 0.0]),
    ({"sensor_offset_lift": -6.0}, ("zero", "lift", "mm"), [0.12, 0.0]),
    ({"pressure": -6.0}, ("gain", "supply pressure", "%"), [6.4, 0.0]),
    ({"solenoid_dead_time": 6.0}, ("solenoid dead time", "ms"), [2.1, 1.5]),
]
"""Numbers that are pulled far, what the advice has to name, and the values by the data and by the machine file."""


@pytest.mark.parametrize(("pulls", "words", "values"), FAR, ids=["gain", "zero", "gauge", "number"])
@pytest.mark.parametrize("added", [True, False], ids=["best", "calibrated"])
def test_a_far_number_and_a_sensor_to_check_are_told_with_their_values(
    rivals, monkeypatch, pulls, words, values, added
):
    monkeypatch.setattr("apesim.studies.gap.design.next_test.rank_experiments", lambda _: dict(RANKED))
    measured, base, force, _ = rivals
    models = (base, pulled_by(force, **pulls)) if added else (pulled_by(base, **pulls), None)
    first, _, then = find_next_test(findings_of(Verdict.REFUSED, measured, *models))["text"].partition(" Then: ")
    assert all(word in first for word in words)
    assert numbers_in(first) == pytest.approx(values, rel=0.07)  # rounded to their errors
    assert then.lower() == RANKED["text"].lower()
    assert find_next_test(findings_of(Verdict.AMBIGUOUS, measured, *models)) == RANKED


def test_a_gain_that_the_machine_file_states_is_told_in_per_cent_too(rivals, monkeypatch):
    monkeypatch.setattr("apesim.studies.gap.design.next_test.rank_experiments", lambda _: dict(RANKED))
    far = corrected_by(machine(effects__sensor_gain__supply_pressure=0.03), GAUGE, -8.0)
    first, _, _ = find_next_test(findings_of(Verdict.REFUSED, rivals[0], far))["text"].partition(" Then: ")
    assert "gain of the supply pressure" in first
    assert numbers_in(first) == pytest.approx([100.0 * (1.03 / 0.92 - 1.0), 3.0], rel=0.02)


def test_what_the_refused_explanation_pulls_far_is_to_be_measured_though_a_table_took_its_place(rivals, monkeypatch):
    monkeypatch.setattr("apesim.studies.gap.design.next_test.rank_experiments", lambda _: dict(RANKED))
    measured, base, force, _ = rivals
    findings = findings_of(Verdict.REFUSED, measured, base, pulled_by(force, solenoid_dead_time=12.0))
    findings.best = base
    assert "dead time" in find_next_test(findings)["text"]


def test_of_many_far_numbers_the_farthest_are_named_and_the_others_counted(rivals, monkeypatch):
    monkeypatch.setattr("apesim.studies.gap.design.next_test.rank_experiments", lambda _: dict(RANKED))
    measured, base, force, _ = rivals
    sizes = {"viscous_friction": 5.0, "solenoid_dead_time": -8.0, "heat_capacity_ratio": 6.0, "sensor_gain_lift": 7.0}
    reason = ReasonKind.FAINT
    far = pulled_by(force, **sizes)
    first, _, _ = find_next_test(findings_of(Verdict.REFUSED, measured, base, far, reason=reason))["text"].partition(
        " Then"
    )
    places = [first.index(text) for text in ("dead time", "lift", "heat capacity ratio", "1 more")]
    assert places == sorted(places)
    assert "viscous friction" not in first


def test_without_the_library_the_next_test_is_to_try_it(rivals):
    measured, base, force, _ = rivals
    told = find_next_test(findings_of(Verdict.REFUSED, measured, base, force, scores=()))
    assert "with the library" in told["text"]


def test_an_engine_starts_with_the_volumes_that_are_on():
    machine = Machine()
    speed = 1000.0 * np.pi / 30.0
    means = {"torque": 30.0}
    run = MeasuredRun("", "", 1.1e6, 287.0, np.nan, "fit", np.empty(0), {}, "engine", speed, -0.1, 1.2, means=means)
    (candidate,) = (
        c for c in find_candidates(machine, "engine", select_effects("engine")) if c.name == "intake_pipe_loss"
    )
    noise = {"torque": {0.0: white(0.3, "stated")}}
    own = WhitenedResiduals(machine, [run], candidate.parameters, noise)
    off = np.zeros(len(candidate.parameters))
    on = off.copy()
    on[0] = 0.4
    found = [own.at(x)[0] for x in (on, off)]
    alone = [WhitenedResiduals(machine, [run], candidate.parameters, noise).at(x)[0] for x in (on, off)]
    assert found == pytest.approx(alone, rel=1e-6)
    sizes = [len(own.starts.near(0, put(machine, candidate.parameters, x)).correction) for x in (on, off)]
    assert sizes[0] > sizes[1]
    assert abs(found[0] - found[1]) > 0.1
