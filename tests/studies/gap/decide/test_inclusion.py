"""How far the data speak for each effect, over all models."""

from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest

from apesim.studies.estimation.parameters import Parameter
from apesim.studies.gap.decide.inclusion import find_inclusions, find_log_odds, find_twins
from apesim.studies.gap.search.candidate_fits import count_from_best
from apesim.studies.gap.search.candidates import Candidate, Probe
from apesim.studies.gap.search.linear_sets import Column, LinearModel, rank_sets
from apesim.studies.gap.search.model_selection import Foreseen, PricedModel, find_term_penalty, foresee_others

SHAPE, OTHER = np.sin(np.arange(50)), np.cos(np.arange(50))


def model(names, left):
    return SimpleNamespace(names=names, candidates=(), fitted=SimpleNamespace(data_residuals=left))


def choice(cost, *names, left=0.0 * SHAPE):
    return PricedModel(model(names, left), cost)


BASE = model((), 3.0 * SHAPE + 3.0 * OTHER)
BASE.cost = 100.0
LIBRARY = 6
STRENGTH = Parameter("effects.side_force.force", 12.0, -1.0, 1.0)


def candidate(name):
    return Candidate(name, (STRENGTH,), ())


def foreseen(excess, *names):
    return Foreseen(tuple(candidate(name) for name in names), excess)


def linear_problem(sizes, seed=1):
    """Six candidates that are somewhat alike, and a gap that has some size of each: the linear model and its costs."""
    rng = np.random.default_rng(seed)
    shapes = {name: rng.normal(size=50) + SHAPE for name in "abcdef"}
    gap = sum(size * shapes[name] for name, size in sizes.items()) + rng.normal(size=50)
    columns = [
        Column(candidate(name), (0.5,), shape, False, Probe(candidate(name), (0.5,), 0))
        for name, shape in shapes.items()
    ]
    costs = {}
    for size in range(4):
        for names in combinations("abcdef", size):
            matrix = np.column_stack([np.zeros(50), *(shapes[name] for name in names)])
            left = gap - matrix @ np.linalg.lstsq(matrix, gap)[0]
            costs[frozenset(names)] = left @ left + size * find_term_penalty(LIBRARY)
    return LinearModel(columns, -gap), costs


def split_problem(linear, costs, fitted):
    """The problem as the search sees it: the base, the best few sets fitted, and what is foreseen of the others."""
    ranked = rank_sets(linear, find_term_penalty(LIBRARY))
    tried = [each.names for each in ranked[:fitted]]
    choices = [choice(costs[names], *sorted(names)) for names in tried]
    best = choices[0]
    best.model.cost = best.model.fitted.cost = best.cost - len(best.names) * find_term_penalty(LIBRARY)
    base = model((), 0.0 * SHAPE)
    base.cost = costs[frozenset()]
    return base, choices, foresee_others(ranked, tried, best, choices, LIBRARY)


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


def test_odds_over_sets_few_of_which_were_fitted_are_those_over_all_sets():
    linear, costs = linear_problem({"a": 0.6, "b": 0.5, "c": 0.4})
    base, choices, others = split_problem(linear, costs, fitted=2)
    assert len(choices) + len(others) > 20
    for name in "abcdef":
        with_it = np.logaddexp.reduce([-0.5 * cost for names, cost in costs.items() if name in names])
        without_it = np.logaddexp.reduce([-0.5 * cost for names, cost in costs.items() if name not in names])
        assert find_log_odds(base, choices, [name], others) == pytest.approx(with_it - without_it, abs=1e-3)
    sure, known = (find_log_odds(base, choices, ["a"], each) for each in ((), others))
    assert sure > known + 10.0  # both that were fitted have it


def test_sets_that_are_far_behind_change_nothing():
    linear, costs = linear_problem({"a": 9.0, "b": 9.0})
    _, choices, others = split_problem(linear, costs, fitted=16)
    assert others == []
    assert {"a", "b"} <= set.intersection(*(set(each.names) for each in choices[:4]))


def test_an_effect_is_less_sure_beside_a_rival_that_was_not_fitted():
    choices = [choice(60.0, "a", "b"), choice(75.0, "a")]
    rival = foreseen(3.0, "a", "c")
    found, before = find_inclusions(BASE, choices, [rival]), find_inclusions(BASE, choices)
    assert [each.names for each in found] == [("a",), ("b",), ("c",)]
    assert found[1].log_odds == pytest.approx(1.5, abs=0.01)
    assert before[1].log_odds == pytest.approx(7.5, abs=0.01)
    assert found[0].log_odds > before[0].log_odds  # the rival has it, too
    assert found[2].log_odds == pytest.approx(-1.5, abs=0.01)


def test_what_is_foreseen_better_than_all_fits_counts_as_much_as_the_best():
    linear, costs = linear_problem({"a": 0.6, "b": 0.5, "c": 0.4})
    ranked = rank_sets(linear, find_term_penalty(LIBRARY))
    second = choice(costs[ranked[1].names], *ranked[1].names)
    second.model.cost = second.model.fitted.cost = second.cost - len(second.names) * find_term_penalty(LIBRARY)
    others = foresee_others(ranked, [ranked[1].names], second, [second], LIBRARY)
    assert set(others[0].names) == ranked[0].names
    assert others[0].excess == 0.0
    assert find_log_odds(BASE, [second], ["b"], others[:1]) == pytest.approx(0.0, abs=1e-3)


def test_what_a_set_promises_beyond_all_fits_is_not_believed_of_the_sets_that_contain_it():
    linear, costs = linear_problem({"a": 0.6, "b": 0.5, "c": 0.4})
    ranked = rank_sets(linear, find_term_penalty(LIBRARY))
    worse = choice(costs[frozenset("d")], "d")
    worse.model.cost = worse.model.fitted.cost = worse.cost - find_term_penalty(LIBRARY)
    excess = {frozenset(each.names): each.excess for each in foresee_others(ranked, [], worse, [worse], LIBRARY)}
    assert costs[frozenset("ab")] < costs[frozenset("abe")] < worse.cost
    assert excess[frozenset("ab")] == 0.0
    assert excess[frozenset("abe")] == pytest.approx(costs[frozenset("abe")] - costs[frozenset("ab")])


def test_a_candidate_whose_fits_fall_short_of_what_was_foreseen_is_not_believed():
    linear, costs = linear_problem({"a": 0.6, "b": 0.5, "c": 0.4})
    ranked = rank_sets(linear, find_term_penalty(LIBRARY))
    best = choice(costs[frozenset("ab")], "a", "b")
    best.model.cost = best.model.fitted.cost = best.cost - 2.0 * find_term_penalty(LIBRARY)
    tried = [frozenset("ab"), frozenset("ac"), frozenset("ad")]
    sound = [best, choice(costs[frozenset("ac")], "a", "c"), choice(costs[frozenset("ad")], "a", "d")]
    bent = [*sound[:1], sound[1]._replace(cost=sound[1].cost + 100.0), sound[2]._replace(cost=sound[2].cost - 5.0)]
    before, after = (foresee_others(ranked, tried, best, fits, LIBRARY) for fits in (sound, bent))
    assert any("c" in each.names for each in before)
    assert after == [each for each in before if "c" not in each.names]


def test_where_costs_have_changed_what_was_foreseen_is_counted_from_the_best_of_now():
    fits = [choice(60.0, "c"), choice(64.0, "a", "b"), choice(70.0, "a")]
    others = [foreseen(3.0, "a", "d"), foreseen(5.0, "b", "d")]
    assert [each.excess for each in count_from_best(others, ["a", "b"], fits)] == [7.0, 9.0]
    again = [*fits, choice(66.0, "a", "b")]  # the same set, fitted from elsewhere
    assert [each.excess for each in count_from_best(others, ["a", "b"], again)] == [7.0, 9.0]
    assert list(count_from_best(others, ["a", "b"], fits[:1])) == []
