"""The result of the workflow, from Python."""

import copy
import json
import pickle
from dataclasses import replace

import numpy as np
import pytest

from apesim.archive import ArchiveError
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.gap.reasons import Verdict
from apesim.studies.gap.report.calibrated_numbers import apply_numbers, find_calibrated_numbers
from apesim.studies.gap.report.verdict_json import describe
from apesim.studies.gap.search.candidates import find_candidates
from apesim.studies.gap.search.library import select_effects
from apesim.studies.gap.search.refit import refit
from apesim.studies.gap.workflow import explain
from apesim.studies.measured import read_measured
from tests.gap_bench import AMBIENT, write_bench


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_bench(tmp_path_factory.mktemp("bench"))


@pytest.fixture(scope="module")
def stages():
    return []


@pytest.fixture(scope="module")
def explanation(folder, stages):
    return explain(Machine(), folder, progress=lambda stage, done, total: stages.append(stage))


def test_an_explanation_says_its_verdict_and_what_it_rests_on(explanation, stages):
    assert explanation.verdict in Verdict
    assert explanation.verdict is not Verdict.NO_GAP
    assert explanation.reason in repr(explanation)
    assert explanation.sentence in repr(explanation)
    assert explanation.gap["before"] > explanation.gap["after"]
    assert explanation.held_out["before"] > explanation.held_out["after"]
    assert explanation.localised["signal"] == "lift"
    assert explanation.next_test["text"]
    assert "calibrating" in stages and "scoring" in stages
    assert "side_force" in explanation._repr_html_()


def test_an_explanation_can_be_pickled_and_copied(explanation):
    for again in (pickle.loads(pickle.dumps(explanation)), copy.deepcopy(explanation)):
        assert repr(again) == repr(explanation) and json.dumps(again.to_dict()) == json.dumps(explanation.to_dict())


def test_what_is_written_is_what_is_said(explanation, tmp_path):
    written = explanation.write(tmp_path / "out")
    assert json.loads((tmp_path / "out/verdict.json").read_text()) == written
    told = {key: value for key, value in explanation.to_dict().items() if key != "wall_time_s"}
    assert written["wall_time_s"] > explanation.wall_time_s > 0.0
    assert {key: written[key] for key in told} == told
    assert (written["verdict"], written["effects"]) == (explanation.verdict, explanation.effects)
    numbers = find_calibrated_numbers(explanation.best) if explanation.effects else []
    added = explanation.best.machine() if explanation.effects else Machine()
    assert Machine.load(tmp_path / "out/machine.toml").to_toml() == apply_numbers(added, numbers).to_toml()
    assert (tmp_path / "out/sensors.toml").exists() == bool(explanation.effects)
    with pytest.raises(ArchiveError, match="not empty"):
        explanation.write(tmp_path / "out")


def test_what_is_sure_of_an_ambiguous_gap_is_reported_and_not_added_to_the_machine(explanation, tmp_path):
    assert explanation.to_dict()["sure"] == explanation.sure == []
    names = explanation.decision.best.names
    open_yet = explanation.decision._replace(verdict=Verdict.AMBIGUOUS, sure=tuple((name,) for name in names))
    found = replace(explanation, decision=open_yet)
    assert {row["name"] for row in found.sure} == set(names)
    assert all(row["interval_95"] for row in found.sure)
    written = found.write(tmp_path / "open")
    assert (written["sure"], written["effects"]) == (found.sure, [])
    assert Machine.load(tmp_path / "open/machine.toml").to_toml() == Machine().to_toml()
    assert "sure, whatever is with it" in (tmp_path / "open/report.html").read_text()


def test_what_is_left_is_drawn_before_and_after_on_a_run_that_was_never_fitted(explanation):
    axes = explanation.plot()
    assert (
        axes.get_title().endswith("never used")
        and axes.get_xlabel()
        and axes.get_ylabel().endswith("[sigmas of the noise]")
    )
    before, after = (line.get_ydata() for line in axes.lines if not line.get_label().startswith("_"))
    assert np.mean(before**2) > 2.0 * np.mean(after**2)
    assert explanation.plot(sensor="lift", ax=axes) is axes
    with pytest.raises(InputError, match="no trace of pressure_a; give lift"):
        explanation.plot(sensor="pressure_a")


def test_changing_what_was_handed_out_changes_no_explanation(explanation):
    told = explanation.to_dict()
    told["gap"]["before"] = -1.0
    told["scores"].clear()
    assert explanation.gap["before"] > 0.0
    assert explanation.to_dict()["scores"]


@pytest.mark.parametrize(
    ("given", "wrong"),
    [
        ({"tolerance": -1.0}, "tolerance"),
        ({"jobs": 0}, "jobs"),
        ({"without": ["side_forse"]}, "side_forse"),
    ],
)
def test_wrong_arguments_are_refused_before_anything_is_computed(folder, given, wrong):
    with pytest.raises(InputError, match=wrong):
        explain(Machine(), folder, **given)


def test_data_that_were_read_at_another_ambient_pressure_are_refused(folder):
    with pytest.raises(InputError, match="gauge pressures above 90000 Pa"):
        explain(Machine(), read_measured(folder, 90e3))
    assert read_measured(folder).ambient_pressure == AMBIENT


def test_what_is_fitted_first_changes_no_result(explanation):
    base = explanation.calibrated
    known = {one.name: one for one in find_candidates(Machine(), "valve", select_effects("valve"))}

    def fitted(*names):
        return {name: refit(base, (known[name],), ((0.1,),)).fitted.x.tolist() for name in names}

    assert fitted("side_force", "leakage_a") == fitted("leakage_a", "side_force")


def test_numbers_that_a_faulty_record_pulls_are_no_wrong_numbers_of_the_rig(explanation):
    best = explanation.decision.best
    far = np.where(best.model.residuals.known, 5.0, best.model.fitted.x)
    pulled = best._replace(model=best.model._replace(fitted=best.model.fitted._replace(x=far)))
    for verdict, is_told in ((Verdict.NAMED, True), (Verdict.MEASUREMENT, False)):
        decision = explanation.decision._replace(verdict=verdict, best=pulled)
        assert bool(describe(replace(explanation, decision=decision))["calibration"]) is is_told
