"""The regression that turns what is known of a statement into a probability."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.truth.scoring import reliability
from tests.truth.scoring.reliability import (
    DIRECTIONS,
    FEATURES,
    KINDS,
    Statements,
    calibrate,
    choose_spreads,
    fit,
    gather,
    probabilities,
    probabilities_apart,
    statements_of,
)
from tests.truth.scoring.score import Scored
from tests.truth.sealed.library import ENGINE, VALVE
from tests.truth.sealed.schedule import SINGLE

WIDE = {"common_slopes": 3.0, "slopes": 1.0, "kinds": 3.0, "benches": 1.0}
"""Spreads of priors that leave coefficients to the data."""
NAME, EFFECT = KINDS.index("name"), KINDS.index("effect")
OFFSETS = {"effect": 0.5, "name": 1.5}
TRUE = np.array([0.8, -0.5, -0.2, -0.3])
"""Slopes of both kinds."""


def drawn(number, seed=3, slopes=TRUE, names=0.5, per_case=1):
    """Statements of two kinds and benches, a share of them names, each right by true coefficients."""
    rng = np.random.default_rng(seed)
    features = rng.normal(size=(number, len(FEATURES))) * [3.0, 1.0, 1.0, 1.0] + [1.0, 0.0, 0.0, 0.0]
    kinds = np.where(rng.uniform(size=number) < names, "name", "effect")
    benches = np.where(rng.uniform(size=number) < 0.5, VALVE, ENGINE)
    scores = np.where(kinds == "name", OFFSETS["name"], OFFSETS["effect"]) + features @ slopes
    right = rng.uniform(size=number) < 1.0 / (1.0 + np.exp(-scores))
    return Statements(np.arange(number) // per_case, kinds, benches, features, right)


def statement(kind, about, evidence=2.0):
    known = {"shortfall": 0.0, "pull": 1.0, "has_rivals": False}
    return {"kind": kind, "about": about, "bench": VALVE, "evidence": evidence, "is_counted": True} | known


def case(seed, right, hidden, statements, fault=None, rest=None):
    answer = {"seed": seed, "kind": SINGLE, "bench": VALVE, "fault": fault}
    answer["hidden"] = [{"name": name} for name in hidden]
    scored = Scored(answer, {"statements": statements, "rest": rest})
    return SimpleNamespace(answer=answer, right=right, verdict=scored.verdict, is_there=scored.is_there)


def test_true_coefficients_are_found():
    found = fit(drawn(20000), WIDE)
    for kind, offset in ((NAME, OFFSETS["name"]), (EFFECT, OFFSETS["effect"])):
        assert found.kinds[kind] + found.benches.mean() == pytest.approx(offset, abs=0.2)
    for kind in (NAME, EFFECT):
        assert found.slopes[kind] == pytest.approx(TRUE, abs=0.1)


def test_no_slope_turns_against_its_direction():
    found = fit(drawn(4000, slopes=-TRUE), WIDE)
    assert np.all(found.slopes[NAME] * DIRECTIONS["name"] > 0.0)
    assert found.slopes[NAME] == pytest.approx(0.0, abs=0.02)


def test_what_is_always_right_has_a_high_probability_and_no_certainty():
    always = drawn(20)._replace(right=np.ones(20, dtype=bool))
    chances = probabilities(fit(always, WIDE), always)
    assert np.all((chances > 0.8) & (chances < 0.9999))


def test_a_kind_of_few_statements_leans_on_the_others():
    many = drawn(3000, names=0.0)
    few = many._replace(kinds=np.where(many.owners < 3, "name", "effect"))
    found = fit(few, WIDE | {"slopes": 0.1, "kinds": 0.3})
    assert found.slopes[NAME] == pytest.approx(found.slopes[EFFECT], abs=0.1)
    assert found.kinds[NAME] == pytest.approx(found.kinds[EFFECT], abs=0.5)


@pytest.mark.parametrize(("apart", "chosen"), [(0.0, 0.1), (4.0, 3.0)])
def test_spreads_are_narrow_where_kinds_do_not_differ_and_wide_where_they_do(monkeypatch, apart, chosen):
    tried = {name: (size,) for name, size in (WIDE | {"common_slopes": 0.1, "slopes": 0.1}).items()}
    monkeypatch.setattr(reliability, "SPREADS", tried | {"kinds": (0.1, 3.0)})
    rng, found = np.random.default_rng(6), []
    for _ in range(5):
        which = rng.integers(len(KINDS), size=60)
        right = rng.uniform(size=60) < 1.0 / (1.0 + np.exp(apart * (-1.0) ** which))
        statements = drawn(60)._replace(kinds=np.array(KINDS)[which], right=right)
        found.append(choose_spreads(statements)["kinds"])
    assert np.median(found) == chosen


def test_a_case_does_not_judge_its_own_statements():
    statements = drawn(60, per_case=3)
    apart = probabilities_apart(statements, WIDE, statements.owners)
    flipped = statements.right.copy()
    flipped[:3] = ~flipped[:3]
    again = probabilities_apart(statements._replace(right=flipped), WIDE, statements.owners)
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


def test_what_no_sealed_case_tells_of_is_not_gathered():
    said = [statement("name", ["bounce"]), statement("effect", ["valve.stroke"]) | {"is_counted": False}]
    gathered = gather([case(7, True, ["bounce"], said), case(8, False, ["bounce"], said[:1])])
    assert [*gathered.kinds] == ["name", "name"]
    assert [*gathered.owners] == [0, 1]
    assert [*gathered.right] == [True, False]
    assert [*gathered.features[0]] == [2.0, 0.0, 1.0, 0.0]


def test_what_cannot_be_counted_is_told_with_what_is_absent():
    older = statement("name", ["bounce"])
    del older["pull"], older["is_counted"]
    with pytest.raises(SystemExit, match=r"seed 8: .* no is_counted, pull"):
        gather([case(7, True, ["bounce"], [statement("name", ["bounce"])]), case(8, True, ["bounce"], [older])])
    with pytest.raises(SystemExit, match="no statement"):
        gather([case(7, True, ["bounce"], [statement("name", ["bounce"]) | {"is_counted": False}])])


def test_what_is_written_has_each_kind_and_bench_and_a_table_beside_it():
    many = [case(seed, seed % 3 > 0, [], [statement("no gap", [], seed % 4)]) for seed in range(30)]
    told, table = calibrate([*many, case(100, True, ["bounce"], [statement("name", ["bounce"])])])
    assert told["cases"] == {"number": 31, "first_seed": 0, "last_seed": 100}
    assert (told["benches"][VALVE]["cases"], told["benches"][VALVE]["statements"]) == (31, 31)
    assert (told["kinds"]["name"]["statements"], told["kinds"]["no gap"]["right"]) == (1, 20)
    assert set(told["kinds"]["name"]["slopes"]) == set(FEATURES)
    assert [line.split(" | ")[0] for line in table.splitlines()[2:]] == ["| name", "| no gap", "| all, valve", "| all"]
