"""A tolerance in the unit of a channel: how far the model may be off, so that one that is not exact can be named."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from apesim import InputError, Machine
from apesim.studies.estimation.noise.discrepancy import state_discrepancy
from apesim.studies.estimation.noise.process import Noise, Whitening, list_slow_columns, white
from apesim.studies.gap import workflow
from apesim.studies.gap.decide.facts import Facts
from apesim.studies.gap.decide.left import find_left, is_good_enough
from apesim.studies.gap.decide.verdict import decide
from apesim.studies.gap.example_bench import explain_example, list_left_out, read_example
from apesim.studies.gap.report.discrepancy import describe_discrepancy, describe_left
from apesim.studies.gap.report.effect_rows import describe_effects
from apesim.studies.gap.tolerance import read_tolerance
from apesim.studies.gap.workflow import explain
from apesim.studies.measured.prediction import predict, run_of, with_value

PLACE = ("explain()", "tolerance")


@pytest.mark.parametrize(("raw", "read"), [(0.3, (0.3, {})), ("0.3", (0.3, {})), ("0.02 mm", (0.15, {"lift": 2e-5}))])
def test_a_number_is_over_the_noise_and_a_size_with_a_unit_is_of_its_channel(raw, read):
    share, sizes = read_tolerance(raw, read_example(), PLACE)
    assert share == read[0]
    assert sizes == pytest.approx(read[1])


@pytest.mark.parametrize("raw", ["2 kPa", "0.02 mm, 2 kPa", "-1", "much", "-0.02 mm"])
def test_what_is_of_no_channel_is_refused_with_what_there_is(raw):
    with pytest.raises(InputError, match="tolerance") as refused:
        read_tolerance(raw, read_example(), PLACE)
    if raw != "-1":
        assert "lift [mm]" in str(refused.value)


@pytest.mark.parametrize("times", [np.arange(400) * 1e-3, np.sort(np.random.default_rng(2).uniform(0.0, 0.4, 400))])
def test_white_noise_with_such_an_error_is_white_once_it_is_whitened(times):
    rng, size, draws = np.random.default_rng(1), 5e-5, 2000
    noise = white(3e-5, "stated")._replace(discrepancy=size)
    slow = list_slow_columns(len(times), size * np.sqrt(0.5))
    seen = rng.normal(0.0, 3e-5, (len(times), draws)) + rng.normal(0.0, size * np.sqrt(0.5), (len(times), draws))
    seen += slow @ rng.standard_normal((slow.shape[1], draws))
    whitened = Whitening(noise, times).whiten(seen)
    covariance = whitened @ whitened.T / draws
    assert np.diag(covariance).mean() == pytest.approx(1.0, abs=0.02)
    assert abs(covariance[0, 1:].mean()) < 0.01
    plain = Whitening(white(3e-5, "stated"), times).whiten(seen)
    assert (plain**2).mean() > 3.0


def test_coloured_noise_with_such_an_error_is_white_once_it_is_whitened():
    rng, size, draws, times = np.random.default_rng(1), 3e-5, 4000, np.arange(200) * 1e-3
    red = Noise(3e-5, (np.zeros(0), np.array([0.9])), np.array([1.0, np.sqrt(0.19)]), "stated")
    samples = np.zeros((len(times), draws))
    samples[0] = rng.normal(0.0, 3e-5, draws)
    for i in range(1, len(times)):
        samples[i] = 0.9 * samples[i - 1] + rng.normal(0.0, 3e-5 * np.sqrt(0.19), draws)
    slow = list_slow_columns(len(times), size * np.sqrt(0.5))
    samples += rng.normal(0.0, size * np.sqrt(0.5), samples.shape) + slow @ rng.standard_normal((slow.shape[1], draws))
    whitened = Whitening(red._replace(discrepancy=size), times).whiten(samples)
    covariance = whitened @ whitened.T / draws
    assert np.linalg.eigvalsh(covariance) == pytest.approx(1.0, abs=0.55)  # of so many draws alone 0.6 to 1.5
    for periods in (1, 10, 90):
        shape = np.sin(2.0 * np.pi * periods * np.arange(len(times)) / len(times))
        assert (shape @ covariance @ shape) / (shape @ shape) == pytest.approx(1.0, abs=0.1)


def bent(size):
    """The example's bench, each lift off by a slow wave besides."""
    measured = read_example()
    pushed = with_value(Machine(), "effects.side_force.force", 3.0)
    rng, runs = np.random.default_rng(3), []
    for number, run in enumerate(measured.runs):
        wave = size * np.sin(2.0 * np.pi * (3.0 + number) * run.times / run.times[-1] + number)
        lift = predict(run_of(pushed, run), run).channels["lift"] + wave + rng.normal(0.0, 3e-5, len(run.times))
        runs.append(run._replace(channels={"lift": lift}))
    return measured._replace(runs=tuple(runs))


def test_an_effect_is_named_within_what_the_model_may_be_off():
    measured, without = bent(4e-5), list_left_out()
    assert explain(Machine(), measured, without=without).verdict == "REFUSED"
    found = explain(Machine(), measured, without=without, tolerance="0.04 mm")
    assert (found.verdict, found.decision.best.names) == ("NAMED", ("side_force",))
    [row] = describe_effects(found.best)
    low, high = row["interval_95"]
    assert low < 3.0 < high
    assert describe_discrepancy(found.best) == {"lift": {"value": pytest.approx(0.04), "unit": "mm"}}
    assert describe_left(found.best)["lift"]["value"] == pytest.approx(0.04 / np.sqrt(2.0), rel=0.3)


def test_a_model_is_good_enough_that_leaves_less_of_every_channel():
    explanation = explain_example()
    size = find_left(explanation.best)["lift"]

    def is_within(**sizes):
        noise = state_discrepancy(explanation.noise, sizes)
        return is_good_enough(explanation.best._replace(residuals=explanation.best.residuals.with_noise(noise)))

    assert [is_within(lift=1.01 * size), is_within(lift=0.99 * size), is_within()] == [True, False, False]


def test_a_model_that_is_good_enough_is_not_refused_for_a_table(monkeypatch):
    """A table takes of what is left, too, which such a model may leave."""
    explanation = explain_example()
    size = find_left(explanation.best)["lift"]
    table = SimpleNamespace(balance="force")
    monkeypatch.setattr(workflow, "find_likelier_table", lambda *_: table)

    def refuse(stated):
        noise = state_discrepancy(explanation.noise, {"lift": stated})
        best = explanation.best._replace(residuals=explanation.best.residuals.with_noise(noise))
        facts = Facts(
            explanation.calibrated,
            0.0,
            choices=(explanation.decision.best._replace(model=best),),
            size=explanation.gap_size,
            judged=explanation.judged,
        )
        assert decide(facts).verdict == "NAMED"
        return workflow._find_likelier_balance(facts, None, 4)

    assert (refuse(1.01 * size), refuse(0.99 * size)) == (None, "force")


def test_what_is_smaller_than_the_model_may_be_off_is_not_named():
    found = explain(Machine(), read_example(), without=list_left_out(), tolerance="1 mm")
    assert found.verdict == "NO_GAP"


def test_the_command_takes_both_kinds_and_names_what_is_wrong(apesim, tmp_path):
    from tests.gap_bench import write_bench

    folder = write_bench(tmp_path)
    code, _, err = apesim("gap", "explain", str(folder), "--out", "report", "--tolerance", "3 kPa")
    assert code == 2
    assert "--tolerance" in err
    assert "lift [mm]" in err
    options = [f"--without={name}" for name in list_left_out()]
    code, *_ = apesim("gap", "explain", str(folder), "--out", "report", "--tolerance", "0.02 mm", *options)
    assert code == 0
    assert json.loads((tmp_path / "report" / "verdict.json").read_text())["discrepancy"]["lift"]["unit"] == "mm"
