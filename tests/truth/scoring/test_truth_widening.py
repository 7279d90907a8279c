"""The factor by which intervals of strengths would hold the truth, from verdicts whose errors are known."""

import numpy as np
import pytest

from tests.truth.scoring.score import Scored
from tests.truth.scoring.widening import (
    HALF,
    bootstrap_factor,
    find_distance,
    find_factor,
    list_missed,
    list_rows,
    row_of,
)
from tests.truth.sealed.schedule import SINGLE

TRUE = 3.0


def row(value, half, open_ends=(), name="side_force"):
    interval = [value - half, value + half]
    return {
        "name": name,
        "key": f"effects.{name}.force",
        "parameter": "force",
        "unit": "N",
        "value": value,
        "interval_95": interval,
        "open_ends": list(open_ends),
    }


def case(verdict="NAMED", effects=(), sure=()):
    hidden = [{"name": "side_force", "parameter": "force", "unit": "N", "value": TRUE, "deviations": 20.0}]
    answer = {"kind": SINGLE, "hidden": hidden, "deviations": 20.0, "rms": 1.0, "fault": None, "seed": 7}
    return Scored(answer, {"verdict": verdict, "effects": list(effects), "sure": list(sure)})


def test_a_pull_counts_standard_deviations_of_the_side_where_the_truth_is():
    wide_above = row(2.0, 1.0) | {"interval_95": [1.5, 2.0 + HALF]}
    assert find_distance(wide_above, 3.0) == pytest.approx(1.0)
    assert find_distance(wide_above, 1.5) == pytest.approx(-HALF)
    assert find_distance(row(2.0, 0.1, ["high"]), 9.0) == 0.0
    assert find_distance(row(2.0, 0.1, ["high"]), 1.9) == pytest.approx(-HALF)
    assert find_distance(row(2.0, 0.0), 2.0) == 0.0
    assert find_distance(row(2.0, 0.0), 2.1) == np.inf


@pytest.mark.parametrize("factor", [1.0, 1.6])
def test_errors_that_are_larger_than_is_said_give_their_factor(factor):
    distances = factor * np.random.default_rng(5).standard_normal(20000)
    assert find_factor(distances) == pytest.approx(factor, rel=0.03)
    low, high = bootstrap_factor(distances[:200].reshape(100, 2).tolist())
    assert low < factor < high
    assert 0.1 < (high - low) / factor < 0.6


def test_what_is_named_rightly_counts_and_what_is_sure_beside_it():
    half = 0.5
    held, missed, far = row(TRUE + 0.4, half), row(TRUE - 0.6, half), row(TRUE + 2.0, half)
    scored = [
        case(effects=[held]),
        case("AMBIGUOUS", sure=[missed | {"class": []}]),
        case("NAMED", effects=[far | {"name": "bounce"}]),
        case("REFUSED"),
    ]
    assert [[each["value"] for each, _ in one.strengths] for one in scored] == [[3.4], [2.4], [], []]
    strengths, cases, share, counts, _, factor, _ = row_of(scored)
    assert (strengths, cases, share, counts, factor) == (2, 2, "50.0 %", "1 of 2", "1.20")
    other = {"name": "bounce", "parameter": "restitution", "unit": "", "value": 0.2, "deviations": 2.0}
    masked = scored[1]._replace(answer=scored[1].answer | {"hidden": [*scored[1].answer["hidden"], other]})
    assert [cells[1] for cells in list_rows([scored[0], masked])] == [2, 1]
    assert list_missed(scored) == [[7, "side_force", "AMBIGUOUS", "side_force", "2.35"]]
    assert row_of([case("REFUSED")])[-2:] == ["–", "–"]
