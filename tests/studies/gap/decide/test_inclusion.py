"""How far the data speak for each effect, over all models."""

from types import SimpleNamespace

import numpy as np
import pytest

from apesim.studies.gap.decide.inclusion import find_inclusions, find_log_odds, find_twins
from apesim.studies.gap.search.model_selection import PricedModel

SHAPE, OTHER = np.sin(np.arange(50)), np.cos(np.arange(50))


def model(names, left):
    return SimpleNamespace(names=names, fitted=SimpleNamespace(data_residuals=left))


def choice(cost, *names, left=0.0 * SHAPE):
    return PricedModel(model(names, left), cost)


BASE = model((), 3.0 * SHAPE + 3.0 * OTHER)
BASE.cost = 100.0


def test_odds_are_the_weights_of_all_models_with_an_effect_over_those_of_all_without():
    choices = [choice(60.0, "a", "b"), choice(64.0, "a"), choice(70.0, "c")]
    weights = {names: np.exp(-0.5 * cost) for names, cost in (("ab", 60.0), ("a", 64.0), ("c", 70.0), ("", 100.0))}
    found = {"".join(each.names): each.log_odds for each in find_inclusions(BASE, choices)}
    assert list(found) == ["a", "b", "c"]
    for name in "abc":
        with_it = sum(weight for names, weight in weights.items() if name in names)
        assert found[name] == pytest.approx(np.log(with_it / (sum(weights.values()) - with_it)))


def test_effects_that_do_the_same_to_the_data_are_one():
    gap = BASE.fitted.data_residuals
    best, twin = choice(60.0, "a", left=gap - 3.0 * SHAPE), choice(61.0, "b", left=gap - 2.9 * SHAPE)
    other, far = choice(62.0, "c", left=gap - 3.0 * OTHER), choice(75.0, "d", left=gap - 3.0 * SHAPE)
    assert find_twins(BASE, [best, twin, other, far]) == {"a": ("b",)}
    merged, *rest = find_inclusions(BASE, [best, twin, other, far])
    assert merged.names == ("a", "b")
    assert merged.log_odds > find_log_odds(BASE, [best, twin, other, far], ["a"])
    assert [each.names for each in rest] == [("c",), ("d",)]


def test_a_twin_in_a_pair_takes_the_part_that_its_partner_leaves():
    """Both pairs take nearly all of the gap; by the part beside b alone, a and c are nothing alike."""
    gap = 30.0 * OTHER + 3.0 * SHAPE
    base = model((), gap)
    base.cost = 1000.0
    single = choice(80.0, "b", left=3.0 * SHAPE)
    best, other = choice(60.0, "a", "b", left=0.0 * SHAPE), choice(61.0, "c", "b", left=3.0 * SHAPE - 0.5 * SHAPE**2)
    assert find_twins(base, [best, other, single]) == {"a": (), "b": ()}
    alike = choice(61.0, "c", "b", left=0.2 * SHAPE)
    assert find_twins(base, [best, alike, single]) == {"a": ("c",), "b": ()}


def test_odds_beyond_all_numbers_are_the_largest():
    assert find_log_odds(BASE, [choice(-3000.0, "a")], ["a"]) == 700.0
    assert find_log_odds(BASE, [], ["a"]) == -700.0
