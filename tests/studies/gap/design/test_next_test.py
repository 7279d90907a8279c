"""The next test: what it would tell is what a fit to its data tells."""

from types import SimpleNamespace

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.estimation.calibration import calibrate
from apesim.studies.estimation.levenberg_marquardt import descend
from apesim.studies.estimation.noise.process import noise_for, white
from apesim.studies.estimation.parameters import put
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.gap.design.experiments import list_experiments, make_residuals
from apesim.studies.gap.design.next_test import find_next_test, find_separation, rank_experiments
from apesim.studies.gap.reasons import ReasonKind, Verdict
from apesim.studies.gap.search.candidates import find_candidates
from apesim.studies.gap.search.library import select_effects
from apesim.studies.gap.search.model_selection import Choice
from apesim.studies.gap.search.refit import refit
from apesim.studies.measured import MeasuredRun, read_measured
from tests.gap_bench import write_bench


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
    rivals = tuple(Choice(o, 1.0) for o in others)
    told = SimpleNamespace(verdict=verdict, best=best and Choice(best, 0.0), rivals=rivals, reason=reason.with_facts())
    names = [SimpleNamespace(name=name) for name in scores]
    return SimpleNamespace(
        measured=measured,
        calibrated=base,
        noise=base.residuals.noise,
        decision=told,
        scores=names,
        sensitivities=[],
        rest=None,
    )


def test_deviations_are_what_fitting_the_rival_to_the_experiment_would_cost(rivals):
    measured, base, force, leak = rivals
    noise = base.residuals.noise
    experiments = {e.text: e for e in list_experiments(measured, 101325.0)}
    chosen = experiments["a run at 0.10 MPa gauge, 12 ms"]
    expected = find_separation(chosen, force, leak, noise, {})
    # The experiment made by the truth, without noise, and the rival fitted to it and to the data that there are.
    made = make_residuals(chosen, base.residuals.machine, force.residuals.parameters, noise)
    (shown,) = made.predicted(force.fitted.x)
    run = chosen.run._replace(channels={"lift": shown})
    both = WhitenedResiduals(base.residuals.machine, [*base.residuals.runs, run], leak.residuals.parameters, noise)
    refitted = descend(both, leak.fitted.x)
    assert expected > 1.0
    assert np.sqrt(refitted.cost - leak.cost) == pytest.approx(expected, rel=0.1)


def test_nothing_is_told_from_itself(rivals):
    measured, base, force, _ = rivals
    for experiment in list_experiments(measured, 101325.0)[:2]:
        assert find_separation(experiment, force, force, base.residuals.noise, {}) == pytest.approx(0.0, abs=1e-6)


def test_the_experiment_that_splits_best_comes_first(rivals):
    measured, base, force, leak = rivals
    told = rank_experiments(findings_of(Verdict.AMBIGUOUS, measured, base, force, (leak, base)))
    least = [row["least"] for row in told["experiments"]]
    assert least == sorted(least, reverse=True)
    assert all(row["least"] == min(row["deviations"].values()) for row in told["experiments"])
    assert list(told["experiments"][0]["deviations"]) == ["leakage_a", "the machine as it is"]
    assert told["truth"] == "side_force"
    assert told["experiments"][0]["text"] in told["text"]


def test_what_is_refused_as_too_faint_is_to_be_told_from_its_rivals_and_from_nothing(rivals):
    measured, base, force, leak = rivals
    told = find_next_test(findings_of(Verdict.REFUSED, measured, base, force, (leak,), reason=ReasonKind.FAINT))
    assert list(told["experiments"][0]["deviations"]) == ["leakage_a", "the machine as it is"]


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


def test_runs_that_there_are_are_not_offered_again(rivals):
    texts = [experiment.text for experiment in list_experiments(rivals[0], 101325.0)]
    assert "a run at 0.40 MPa gauge, 50 ms" not in texts  # 0.40 MPa gauge and 30 ms are there
    assert "a run at 0.40 MPa gauge, 12 ms" in texts


@pytest.mark.parametrize(
    ("verdict", "says"),
    [
        (Verdict.REFUSED, "high-speed"),
        (Verdict.NO_GAP, "None is due"),
        (Verdict.NAMED, "side force"),
        (Verdict.CALIBRATION, "side_force"),
    ],
)
def test_every_verdict_has_its_next_test(rivals, verdict, says):
    measured, base, force, _ = rivals
    told = find_next_test(findings_of(verdict, measured, base, force))
    assert "isolate" in told
    if verdict != Verdict.REFUSED:
        assert says in told["text"]
    else:
        assert told["isolate"][0]["effect"] == "bounce"
        assert told["isolate"][0]["isolated_by"] in told["text"]


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
