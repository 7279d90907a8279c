"""From measured data to a verdict, on data of the independent simulator."""

import json

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.quantities.settings import load
from apesim.studies.estimation.parameters import DECLARED, shown, value_of
from apesim.studies.execution import pool
from apesim.studies.gap import workflow
from apesim.studies.gap.decide.facts import Facts, find_explained_gap
from apesim.studies.gap.decide.verdict import decide
from apesim.studies.gap.example_bench import explain_example, find_example_gap
from apesim.studies.gap.report.effect_rows import describe_effects
from apesim.studies.gap.report.likely_cause import describe_cause
from apesim.studies.gap.report.verdict_json import write_sentence
from apesim.studies.gap.search.candidate_fits import fit_candidates
from apesim.studies.gap.search.candidates import Candidate
from apesim.studies.gap.search.localisation import localise
from apesim.studies.gap.search.model_selection import Foreseen
from apesim.studies.gap.stage_work import Work
from apesim.studies.gap.workflow import explain
from apesim.studies.measured import Measured, MeasuredRun, read_measured
from apesim.studies.measured.prediction import predict, run_of, with_value
from apesim.valve.effects import VALVE_EFFECTS
from tests.gap_bench import BUT_RIVALS
from tests.studies.gap.conftest import SEED
from tests.truth.simulator.valve import Bench

AMBIENT = 101325.0
among = pytest.mark.parametrize("without", [BUT_RIVALS, pytest.param((), marks=pytest.mark.slow)], ids=["few", "all"])
"""Mark of tests among the rivals of what is hidden; among the whole library they are slow, and those of sealed cases
run by default."""


def explained(folder, **options):
    return explain(Machine(), read_measured(folder, AMBIENT), **options)


def test_where_nothing_is_missing_nothing_is_found(measure):
    found = explained(measure(Bench()))
    assert found.verdict == "NO_GAP"
    assert not found.gap_test.alarm
    assert np.abs(found.calibrated.fitted.x).max() < 3.0
    checked = found.held_out
    assert checked["before"] == checked["after"] == pytest.approx(1.0, abs=0.05)


def test_what_is_foreseen_of_sets_that_were_not_fitted_reaches_the_verdict_and_the_explanation(measure, monkeypatch):
    rival = Foreseen((Candidate("bounce", (), ()),), 20.0)
    monkeypatch.setattr(workflow, "fit_candidates", lambda *how: (*fit_candidates(*how)[:2], [rival]))
    seen = []
    monkeypatch.setattr(workflow, "decide", lambda facts: seen.append(facts.foreseen) or decide(facts))
    found = explained(measure(Bench(dry_friction=3.0, breakaway=3.0)), without=BUT_RIVALS)
    assert found.foreseen == seen[-1] == (rival,)


def test_where_gates_change_the_order_what_is_foreseen_is_counted_from_their_best(monkeypatch):
    explanation, gap = explain_example(), find_example_gap()
    fits = sorted(explanation.fits, key=lambda choice: choice.cost)
    behind = fits[1].cost - fits[0].cost
    assert behind > 0.0
    rivals = tuple(Foreseen((Candidate("bounce", (), ()),), excess) for excess in (behind + 7.0, 0.5 * behind))
    facts = Facts(gap.calibrated, 0.0, foreseen=rivals)
    for ranked, expected in ((fits, (behind + 7.0, 0.5 * behind)), (fits[1::-1], (7.0, 0.0))):
        monkeypatch.setattr(workflow, "judge_held_out", lambda *_, ranked=ranked: (ranked, None))
        found, _ = workflow._judge_fits(explanation, facts, gap, fits, [], Work())
        assert [each.excess for each in found.foreseen] == pytest.approx(expected)


@among
def test_a_hidden_effect_is_named_sized_and_added(measure, apesim, tmp_path, without):
    path = measure(Bench(dry_friction=3.0, breakaway=3.0))
    options = [f"--without={name}" for name in without]
    code, out, _ = apesim("gap", "explain", str(path), "--out", str(tmp_path / "out"), "--json", *options)
    data = json.loads(out)
    assert code == 0
    assert data["verdict"] == "NAMED"
    assert json.loads((tmp_path / "out/verdict.json").read_text())["verdict"] == "NAMED"
    force = next(row for row in data["effects"] if row["parameter"] == "force")
    assert force["name"] == "coulomb_friction"
    assert force["interval_95"][0] < 3.0 < force["interval_95"][1]
    assert force["interval_95"][1] - force["interval_95"][0] < 3.0
    # On runs that were opened once the gap is gone.
    held_out = data["held_out"]
    assert held_out["before"] > held_out["after"]
    assert held_out["size_before"] > 0.15 > held_out["size_after"]
    assert held_out["after"] == pytest.approx(1.0, abs=0.05)
    # The machine that was written has the effect, and lacks nothing to explain fresh data of the same rig.
    machine = load(Machine, tmp_path / "out/machine.toml")
    assert machine.effects.coulomb_friction.force == pytest.approx(force["value"], rel=1e-9)
    fresh = measure(Bench(dry_friction=3.0, breakaway=3.0), seed=SEED + 1)
    again = explain(machine, read_measured(fresh, AMBIENT))
    assert again.verdict == "NO_GAP"
    # Its own numbers are the calibrated ones: other data of the rig hardly move them again.
    own = {row["key"]: row for row in data["nuisances"] if row["key"].startswith("valve.")}
    for key, row in own.items():
        assert shown(DECLARED[key], value_of(machine, key)) == pytest.approx(row["value"], rel=1e-9)
    pulls = {p.key: x for p, x in zip(again.calibrated.residuals.parameters, again.calibrated.fitted.x, strict=True)}
    assert max(abs(pulls[key]) for key in own) < 0.5


@among
@pytest.mark.slow
def test_an_effect_that_the_library_lacks_is_not_given_another_name(measure, without):
    path = measure(Bench(dry_friction=12.0, breakaway=12.0))
    found = explained(path, without=["coulomb_friction", "stribeck_friction", "seal_friction", *without])
    assert found.gap_test.alarm
    assert found.verdict in ("REFUSED", "AMBIGUOUS")


def test_a_wrong_number_of_the_machine_is_a_finding_of_its_own(measure):
    found = explained(measure(Bench(), gauge_error=0.08))
    assert found.verdict == "CALIBRATION"
    assert found.decision.best.names == ("supply.pressure",)
    (row,) = describe_effects(found.best)
    assert (row["name"], row["key"]) == ("supply.pressure", "effects.sensor_gain.supply_pressure")
    assert row["interval_95"][0] < -0.08 / 1.08 < row["interval_95"][1]
    assert found.sentence.startswith("Nothing is missing, but a reading is wrong: supply pressure reads 7.")
    # What the machine says of the gauge holds for these runs, and explains them.
    again = explain(found.best.machine(), found.measured)
    assert again.verdict == "NO_GAP"
    assert abs(again.calibrated.fitted.x).max() < 3.0


def test_a_nuisance_that_takes_all_of_a_gap_is_a_finding_though_little_is_left(measure):
    found = explained(measure(Bench(), late=0.8e-3, chambers=False))
    assert found.gap_size < 0.15
    assert found.verdict == "CALIBRATION"
    assert found.decision.best.names == ("valve.solenoid.dead_time",)
    assert found.best is found.calibrated  # what compares both with the data knows by this that nothing was added


@pytest.mark.parametrize(("late", "verdict"), [(0.0, "NO_GAP"), (4e-4, "AMBIGUOUS")])
def test_a_file_that_differs_from_its_repeats_stops_the_all_clear(late, verdict):
    times, rng = np.arange(0.0, 0.05, 5e-5), np.random.default_rng(3)
    runs = []
    for name, supply in ("p040", 0.4e6), ("p050", 0.5e6), ("p060", 0.6e6):
        for number, more in enumerate((3e-5, -4e-5, late if name == "p060" else 0.0)):
            data = f"{name}_{number}.csv"
            one = MeasuredRun(name, data, supply, 293.15, 30e-3, "fit", times, {"lift": 0.0 * times})
            rig = with_value(Machine(), "valve.solenoid.dead_time", Machine().valve.solenoid.dead_time + more)
            lift = predict(run_of(rig, one), one).channels["lift"] + rng.normal(0.0, 3e-5, len(times))
            runs.append(one._replace(channels={"lift": lift}))
    found = explain(Machine(), Measured("", {"lift": 3e-5}, tuple(runs), "valve"), without=BUT_RIVALS)
    assert found.verdict == verdict
    if late:
        assert str(found.reason).startswith("p060_2.csv differs from its repeats")
        assert write_sentence(found).endswith(f"but {found.reason}.")
        assert "p060_2.csv" in found.next_test["text"]
        assert describe_cause(found, {})["text"].startswith("a fault in the record")


def test_one_operating_point_alone_names_nothing(measure):
    found = explained(measure(Bench(dry_friction=8.0, breakaway=8.0), {0.16e6: "fit"}, chambers=False))
    assert found.verdict in ("AMBIGUOUS", "NO_GAP")


@pytest.mark.parametrize("jobs", [2, pytest.param(None, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_what_is_found_does_not_depend_on_how_many_processes_share_the_work(measure, monkeypatch, jobs):
    path = measure(Bench(dry_friction=12.0, breakaway=12.0), {0.16e6: "fit", 0.40e6: "fit", 0.55e6: "gate"})
    few = ("quadratic_drag", "leakage_a", "slow_ramp", "spring_rate_error", "tabulated_force")
    without = [effect.name for effect in VALVE_EFFECTS if effect.name not in few]
    alone = explained(path, without=without)
    monkeypatch.setattr(pool, "SECONDS_ALONE", 0.5)
    shared = explained(path, without=without, jobs=jobs)
    assert any(len(choice.names) == 2 for choice in alone.fits)
    assert alone.tabulated
    assert shared.to_dict() | {"wall_time_s": 0.0} == alone.to_dict() | {"wall_time_s": 0.0}
    assert shared.simulations == alone.simulations


def test_a_gap_that_the_calibration_has_taken_up_is_counted_from_the_numbers_of_the_explanation():
    """The side force of the example pulls the ratio of heat capacities far, which leaves little of the gap."""
    explanation = explain_example()
    assert explanation.calibrated.corrected
    assert not explanation.best.corrected
    residuals, old = explanation.calibrated.residuals, len(explanation.calibrated.fitted.x)
    without = residuals.at(explanation.best.fitted.x[:old])
    taken = without[: len(explanation.best.fitted.data_residuals)] - explanation.best.fitted.data_residuals
    largest = max(cell.size for cell in localise(residuals, find_example_gap().marks, taken, holds_noise=False))
    assert explanation.gap_size == pytest.approx(largest)
    left = find_explained_gap(explanation.calibrated, explanation.best)
    assert np.linalg.norm(taken) > 1.5 * np.linalg.norm(left)
