"""The regression that turns what is known of a statement into a probability."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.truth.scoring.figures import calibration_error
from tests.truth.scoring.reliability import (
    MIN_STATEMENTS,
    calibrate,
    fit,
    probabilities,
    probabilities_apart,
    statements_of,
)
from tests.truth.scoring.score import Scored
from tests.truth.sealed.schedule import SINGLE

TRUE = np.array([-1.0, 0.8, -0.5, 0.0])


def drawn(number, seed=3):
    """Features of statements, and whether each is right, by true coefficients."""
    rng = np.random.default_rng(seed)
    features = rng.normal(size=(number, 3)) * [3.0, 1.0, 1.0]
    return features, rng.uniform(size=number) < probabilities(TRUE, features)


def statement(kind, about, evidence=2.0):
    return {"kind": kind, "about": about, "evidence": evidence, "shortfall": 0.0, "pull": 1.0}


def case(seed, right, hidden, statements, fault=None, rest=None):
    answer = {"seed": seed, "kind": SINGLE, "hidden": [{"name": name} for name in hidden], "fault": fault}
    scored = Scored(answer, {"statements": statements, "rest": rest})
    return SimpleNamespace(answer=answer, right=right, verdict=scored.verdict, is_there=scored.is_there)


def test_true_coefficients_are_found():
    assert fit(*drawn(20000)) == pytest.approx(TRUE, abs=0.1)


def test_what_is_always_right_has_a_high_probability_and_no_certainty():
    features = np.zeros((20, 3))
    (chance,) = probabilities(fit(features, np.ones(20, dtype=bool)), features[:1])
    assert 0.9 < chance < 0.999


def test_probabilities_of_drawn_statements_are_reliable():
    features, right = drawn(4000, seed=4)
    stated = probabilities(fit(*drawn(4000, seed=5)), features)
    assert calibration_error(list(zip(stated, right, strict=True))) < 0.03
    assert calibration_error(list(zip(np.clip(1.5 * stated, 0.0, 1.0), right, strict=True))) > 0.05


def test_a_case_does_not_judge_its_own_statements():
    features, right = drawn(60)
    owners = np.repeat(np.arange(20), 3)
    apart = probabilities_apart(owners, features, right)
    flipped = right.copy()
    flipped[:3] = ~flipped[:3]
    again = probabilities_apart(owners, features, flipped)
    assert again[:3] == pytest.approx(apart[:3])
    assert not np.allclose(again[3:], apart[3:])


def test_statements_are_held_against_what_is_hidden():
    said = [
        statement("name", ["blow_by"]),
        statement("effect", ["blow_by", "seat_leak"]),
        statement("effect", ["bounce"]),
    ]
    assert [right for _, right in statements_of(case(1, True, ["seat_leak"], said))] == [True, True, False]
    assert [right for _, right in statements_of(case(1, None, ["bounce"], said))] == [False, True]


def test_a_number_of_the_machine_and_a_fault_are_known_by_their_own_names():
    fault = {"name": "run_gain", "file": "run02.csv"}
    spoilt, sound = (case(1, True, ["sensor_offset"], [], fault=each) for each in (fault, None))
    assert spoilt.is_there(["effects.sensor_offset.lift"])
    assert spoilt.is_there(["bounce", "run_gain of lift in run02.csv"])
    assert not spoilt.is_there(["run_gain of lift in run01.csv"])
    assert not spoilt.is_there(["run_offset of lift in run02.csv"])
    assert not sound.is_there(["run_gain of lift in run02.csv"])


def test_what_is_said_without_a_file_counts_its_effects():
    rest = {"statements": [statement("name", ["bounce"]), statement("effect", ["bounce"])]}
    found = list(statements_of(case(1, True, ["bounce"], [], rest=rest)))
    assert [(one["kind"], right) for one, right in found] == [("effect", True)]


def test_a_kind_of_few_statements_has_no_coefficients():
    many = [case(seed, seed % 3 > 0, [], [statement("no gap", [])]) for seed in range(MIN_STATEMENTS)]
    few = [case(100, True, ["bounce"], [statement("name", ["bounce"])])]
    found = calibrate(many + few)
    assert found["cases"] == {"number": MIN_STATEMENTS + 1, "first_seed": 0, "last_seed": 100}
    assert found["kinds"]["name"] == {"statements": 1, "right": 1}
    assert len(found["kinds"]["no gap"]["coefficients"]) == 4


def count_features(slope, seed):
    """Whether features count, of forty names whose evidence tells by some slope whether they are right."""
    rng = np.random.default_rng(seed)
    evidence = rng.normal(size=40)
    right = rng.uniform(size=40) < probabilities(np.array([1.0, slope]), evidence[:, None])
    cases = [
        case(number, told, [], [statement("name", [], value) | {"shortfall": rng.normal(), "pull": rng.normal()}])
        for number, (told, value) in enumerate(zip(right, evidence, strict=True))
    ]
    return any(calibrate(cases)["kinds"]["name"]["coefficients"][1:])


def test_features_count_where_they_tell_more_than_a_constant_does():
    assert sum(count_features(0.0, seed) for seed in range(10)) < 4
    assert sum(count_features(2.0, seed) for seed in range(10)) > 8
