"""Sealed cases of the independent simulator, solved by the command line; their seeds are development's."""

import sys
from functools import cache

import pytest

from tests.folders import SAMPLES
from tests.truth.scoring.again import AGAIN, explain_again, measure_again
from tests.truth.scoring.benchmark import benchmark
from tests.truth.scoring.figures import figures
from tests.truth.scoring.score import CLEAR
from tests.truth.sealed.challenge import draw, restore, write
from tests.truth.sealed.schedule import DOUBLE, FOREIGNER, NONE, REMOVED, SINGLE

pytestmark = pytest.mark.slow
TOOLS = {"apesim": [sys.executable, "-c", "from apesim.studies.commands.cli import main; main()"]}
FIVE = {20226: SINGLE, 20320: SINGLE, 20414: DOUBLE, 20329: REMOVED, 20255: FOREIGNER}
"""Kinds of cases by seed; cases that are soon made, all of the valve."""
KEPT = 20226, 20414, 20329
"""Seeds of cases whose sizes were searched once and are kept."""
ENGINE = 20282
"""Seed of a case of the engine where nothing is hidden."""


def kept(seed):
    return SAMPLES / f"case_{seed}.json"


def leaves(tree, path=""):
    """Numbers and words of a tree of dicts and lists, by their paths."""
    if not isinstance(tree, dict | list):
        return {path: tree}
    branches = tree.items() if isinstance(tree, dict) else enumerate(tree)
    return {key: leaf for name, branch in branches for key, leaf in leaves(branch, f"{path}/{name}").items()}


@pytest.mark.parametrize("seed", KEPT)
def test_a_case_that_is_kept_is_the_one_that_its_seed_draws(seed):
    case, drawn = restore(kept(seed)), draw(seed)
    assert case.rng.bit_generator.state == drawn.rng.bit_generator.state
    told, expected = (leaves(each.answer) for each in (case, drawn))
    assert told.keys() == expected.keys()
    for path, value in expected.items():
        exact = isinstance(value, str | bool | int)
        assert told[path] == (value if exact else pytest.approx(value, rel=1e-3, abs=1e-9)), path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder of the cases that are solved once."""
    return tmp_path_factory.mktemp("blind")


@pytest.fixture(scope="module")
def scored(folder):
    """A function: the case of the valve with a seed, solved once; a case that is kept need not be drawn again."""

    @cache
    def solved(seed):
        if seed in KEPT:
            write(restore(kept(seed)), folder / "cases" / str(seed))
        (one,) = benchmark([seed], folder, TOOLS)["apesim"]
        assert (one.answer["seed"], one.kind) == (seed, FIVE[seed])
        return one

    return solved


def test_nothing_is_found_in_an_engine_where_nothing_is_hidden(tmp_path):
    (one,) = benchmark([ENGINE], tmp_path, TOOLS)["apesim"]
    assert (one.answer["bench"], one.kind) == ("engine", NONE)
    assert (one.said, one.verdict["alarm"]) == ("NO_GAP", False)


@pytest.mark.parametrize("seed", [20226, 20320])
def test_a_hidden_effect_is_named_and_its_size_told(scored, seed):
    one = scored(seed)
    assert one.deviations >= CLEAR
    assert one.right and one.class_first
    assert all(one.intervals)


def test_the_machine_that_was_written_explains_fresh_data_of_the_same_rig(scored, folder):
    one, case = scored(20226), folder / "cases" / "20226"
    measure_again(restore(kept(20226)), case / AGAIN)
    first, fresh = ((at / "case" / "run01.csv").read_text() for at in (case, case / AGAIN))
    assert first != fresh and one.verdict["alarm"]
    assert explain_again(case, TOOLS["apesim"]) == "NO_GAP"


def test_two_hidden_effects_are_both_named(scored):
    one = scored(20414)
    assert one.said == "TWO_EFFECTS"
    assert set(one.first) == set(one.hidden)


@pytest.mark.parametrize("seed", [20329, 20255])
def test_what_is_not_in_the_library_gets_no_name(scored, seed):
    one = scored(seed)
    assert one.verdict["alarm"] and not one.named
    assert one.right is not False


def test_over_two_dozen_cases_nothing_is_said_that_is_wrong(tmp_path):
    found = benchmark(range(5100, 5124), tmp_path, TOOLS, jobs=2)["apesim"]
    assert len(found) == 24
    table = {figure.what: figure for figure in figures(found)}
    assert table["names given, nothing hidden"].hits == 0
    assert table["wrong name or all-clear, of cases with something hidden"].hits <= 1
    clear = table["right class first, single, ≥ 10 sigmas"]
    assert clear.hits >= clear.cases - 1
