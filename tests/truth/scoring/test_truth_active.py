"""The loop of next tests: what it records, when it ends, and what it counts."""

import json
import shutil
import sys

import numpy as np
import pytest

from apesim.studies.measured import read_measured
from tests.folders import SAMPLES
from tests.truth.scoring.active import (
    ARMS,
    CHOSEN,
    FIRST_CASE,
    KEPT,
    RANDOM,
    Course,
    add_run,
    choose,
    is_likely_open,
    run_loops,
    seeds_from,
    table,
)
from tests.truth.scoring.score import Scored
from tests.truth.sealed.challenge import restore, write
from tests.truth.sealed.library import CALIBRATED, VALVE
from tests.truth.sealed.schedule import SINGLE, plan_of
from tests.truth.sealed.setting import AMBIENT

SEED = 20226
TOOL = [sys.executable, "-c", "from apesim.studies.commands.cli import main; main()"]
NAMED_AFTER_ONE = 70052
"""Seed of a case that is refused, and named with one more run."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A case with a hidden effect, as it is explained first."""
    path = tmp_path_factory.mktemp("loop") / str(SEED)
    path.mkdir()
    shutil.copy(SAMPLES / f"case_{SEED}.json", path / KEPT)
    write(restore(path / KEPT), path / FIRST_CASE)
    return path


def record(folder, where, wanted, seed=1):
    """The runs of a case with one more, and the run."""
    add_run(restore(folder / KEPT), folder / FIRST_CASE, folder / where, wanted, np.random.default_rng(seed))
    runs = read_measured(folder / where / "case", AMBIENT).runs
    return runs, runs[-1]


def asked_again(run):
    """The wish for a run that there is."""
    return {
        "role": "fit",
        "supply_Pa_abs": run.supply,
        "temperature_K": run.temperature,
        "pulse_s": run.pulse,
        "interval_s": float(np.median(np.diff(run.times))),
        "recorded_s": float(run.times[-1]),
        "sensors": list(run.channels),
    }


def test_an_added_run_is_of_the_same_rig_with_fresh_noise(folder):
    before = read_measured(folder / FIRST_CASE / "case", AMBIENT).runs
    old = before[0]
    runs, again = record(folder, "again", asked_again(old))
    assert [run.data for run in runs[:-1]] == [run.data for run in before]
    assert (again.role, again.supply, again.pulse) == ("fit", pytest.approx(old.supply), pytest.approx(old.pulse))
    assert again.times == pytest.approx(old.times, abs=1e-7)
    setting = restore(folder / KEPT).lab.setting
    for sensor, values in again.channels.items():
        apart = (values - old.channels[sensor]) / setting.deviation(sensor)
        assert np.sqrt(np.mean(apart**2)) == pytest.approx(np.sqrt(2.0), rel=0.15)


def test_an_added_run_is_the_same_for_the_same_draws_alone(folder):
    wanted = asked_again(read_measured(folder / FIRST_CASE / "case", AMBIENT).runs[0])
    lifts = [record(folder, f"draw{seed}", wanted, seed)[1].channels["lift"] for seed in (1, 1, 2)]
    assert (lifts[0] == lifts[1]).all()
    assert not (lifts[0] == lifts[2]).any()


def test_a_sensor_that_is_asked_for_is_added_to_the_run_alone(folder):
    old = read_measured(folder / FIRST_CASE / "case", AMBIENT).runs[0]
    wanted = asked_again(old) | {"sensors": ["lift", "pressure_a"], "supply_Pa_abs": 0.3e6 + AMBIENT, "pulse_s": 0.012}
    runs, added = record(folder, "sensor", wanted | {"role": "gate"})
    assert (list(added.channels), added.role) == (["lift", "pressure_a"], "gate")
    assert added.supply == pytest.approx(0.3e6 + AMBIENT)
    assert 0.9e5 < added.channels["pressure_a"].min() < added.channels["pressure_a"].max() < 4.3e5
    assert [list(run.channels) for run in runs[:-1]] == [list(old.channels)] * (len(runs) - 1)


def test_the_first_of_the_list_is_chosen_and_each_is_drawn_at_random():
    runs = [{"text": text} for text in "abcd"]
    verdict = {"next_test": {"experiments": runs[:2], "others": runs[2:]}}
    assert choose(verdict)["text"] == "a"
    drawn = [choose(verdict, np.random.default_rng(seed))["text"] for seed in range(400)]
    assert all(70 < drawn.count(text) < 130 for text in "abcd")
    assert choose({"next_test": {"text": "none"}}) is None


def test_seeds_hide_one_effect_of_a_valve_that_is_no_error_of_a_sensor():
    seeds = seeds_from(70050, 4)
    assert seeds == sorted(seeds)
    for seed in range(70050, seeds[-1] + 1):
        plan = plan_of(seed)
        fits = plan.kind == SINGLE and plan.bench == VALVE and plan.effects[0] not in CALIBRATED
        assert is_likely_open(seed) == (seed in seeds)
        assert fits or seed not in seeds


def course(*said, hidden="side_force"):
    answer = {"kind": SINGLE, "hidden": [{"name": hidden, "deviations": 8.0}], "class": [], "rms": 0.3}
    told = [
        {"verdict": verdict, "effects": [{"name": "side_force"}], "class": ["side_force"], "probability": None}
        for verdict in said
    ]
    return Course(1, CHOSEN, [Scored(answer, each) for each in told], ["a run"] * (len(said) - 1))


def test_a_name_counts_from_the_run_with_which_it_is_given_and_a_class_is_no_name():
    right, wrong = course("REFUSED", "NAMED_CLASS", "NAMED"), course("AMBIGUOUS", "NAMED", hidden="bounce")
    assert [right.named(runs) for runs in range(4)] == [None, None, True, True]
    assert [wrong.named(runs) for runs in range(4)] == [None, False, False, False]
    assert course("REFUSED", "NO_GAP").named(3) is None


def test_the_table_counts_both_arms():
    right, wrong = course("REFUSED", "NAMED"), course("REFUSED", "NAMED", hidden="bounce")
    lines = table([{CHOSEN: right, RANDOM: wrong}, {CHOSEN: right, RANDOM: course(*["REFUSED"] * 4)}]).splitlines()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]
    assert [row[0] for row in cells] == ["0", "1", "2", "3"]
    assert cells[0][1::3] == ["0 of 2 (0.0 %)"] * 2
    assert cells[1][1::3] == ["2 of 2 (100.0 %)", "0 of 2 (0.0 %)"]
    assert cells[3][3::3] == ["0", "1"]


@pytest.mark.slow
def test_a_refused_case_is_named_with_the_run_that_is_asked_for(tmp_path):
    ((seed, courses),) = run_loops([NAMED_AFTER_ONE], tmp_path, TOOL)
    assert (seed, list(courses)) == (NAMED_AFTER_ONE, list(ARMS))
    assert courses[CHOSEN].scored[0].said == "REFUSED"
    assert courses[CHOSEN].named(3) is True
    first = json.loads((tmp_path / str(seed) / "0" / "apesim" / "verdict.json").read_text())["next_test"]
    assert courses[CHOSEN].added[0] == first["experiments"][0]["text"]
