"""Sealed cases of the independent simulator, solved by the command line; their seeds are development's."""

import sys

import pytest

from tests.truth.benchmark import benchmark
from tests.truth.schedule import DOUBLE, FOREIGNER, NONE, REMOVED, SINGLE
from tests.truth.score import CLEAR, figures

TOOLS = {"apesim": [sys.executable, "-c", "from apesim.studies.cli import main; main()"]}
SIX = {20282: NONE, 20226: SINGLE, 20320: SINGLE, 20414: DOUBLE, 20329: REMOVED, 20255: FOREIGNER}
"""Kinds by seed, such as are soon made; the first is an engine's."""


@pytest.fixture(scope="module")
def scored(tmp_path_factory):
    """The six cases by seed."""
    found = benchmark(SIX, tmp_path_factory.mktemp("blind"), TOOLS)["apesim"]
    assert [(one.answer["seed"], one.kind) for one in found] == list(SIX.items())
    return {one.answer["seed"]: one for one in found}


def test_nothing_is_found_where_nothing_is_hidden(scored):
    one = scored[20282]
    assert one.answer["bench"] == "engine"
    assert (one.said, one.verdict["alarm"]) == ("NO_GAP", False)


@pytest.mark.parametrize("seed", [20226, 20320])
def test_a_hidden_effect_is_named_and_its_size_told(scored, seed):
    one = scored[seed]
    assert one.deviations >= CLEAR
    assert one.right and one.class_first
    assert all(one.intervals)


def test_two_hidden_effects_are_both_named(scored):
    one = scored[20414]
    assert one.said == "TWO_EFFECTS"
    assert set(one.first) == set(one.hidden)


@pytest.mark.parametrize("seed", [20329, 20255])
def test_what_is_not_in_the_library_gets_no_name(scored, seed):
    one = scored[seed]
    assert one.verdict["alarm"] and not one.named
    assert one.right is not False


@pytest.mark.slow
def test_over_two_dozen_cases_nothing_is_said_that_is_wrong(tmp_path):
    found = benchmark(range(5100, 5124), tmp_path, TOOLS, jobs=2)["apesim"]
    assert len(found) == 24
    table = {figure.what: figure for figure in figures(found)}
    assert table["names given, nothing hidden"].hits == 0
    assert table["wrong name or all-clear, of cases with something hidden"].hits <= 1
    clear = table["right class first, single, ≥ 10 deviations"]
    assert clear.hits >= clear.cases - 1
