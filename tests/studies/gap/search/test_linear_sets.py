"""Sets of candidates are ranked by what a linear model leaves, and the best of all sets comes first."""

import numpy as np
import pytest

from apesim.studies.estimation.parameters import Parameter
from apesim.studies.gap.example_bench import explain_example
from apesim.studies.gap.search import model_selection
from apesim.studies.gap.search.candidates import Candidate, Probe
from apesim.studies.gap.search.linear_sets import Column, LinearModel, linearise_base, linearise_best, rank_sets
from apesim.studies.gap.search.model_selection import fit_sets
from apesim.studies.gap.stage_work import Work

N = 200
PENALTY = 16.0
BASIS = np.linalg.qr(np.random.default_rng(1).normal(size=(N, 8)))[0].T


def column(name, change, low=-1.0, size=0.5):
    strength = Parameter("effects.side_force.force", 12.0, low, 1.0)
    probe = Probe(Candidate(name, (strength,), ()), (size,), 0)
    return Column(probe.candidate, probe.x, size * change, low >= 0.0, probe)


def ranked(columns, gap):
    return rank_sets(LinearModel(columns, -gap), PENALTY)


def test_the_single_that_takes_the_gap_comes_before_sets_that_contain_it():
    columns = [column(name, shape) for name, shape in zip("abcd", BASIS, strict=False)]
    first, *others = ranked(columns, 10.0 * BASIS[1])
    assert first.names == {"b"}
    assert first.cost == pytest.approx(0.0, abs=1e-9)
    assert first.guesses[0] == pytest.approx((1.0,))  # clipped to the end of its range
    assert len(others) + 1 == 4 + 6 + 4


def test_two_that_mask_each_other_are_found_by_the_pair():
    first, second = BASIS[0], -0.98 * BASIS[0] + 0.2 * BASIS[1]
    columns = [
        column("a", first),
        column("b", second),
        *(column(name, each) for name, each in zip("cd", BASIS[2:], strict=False)),
    ]
    gap = 50.0 * first + 50.0 * second
    alone = {each.names: each.cost for each in ranked(columns, gap) if len(each.names) == 1}
    assert min(alone.values()) > 0.9 * gap @ gap
    assert ranked(columns, gap)[0].names == {"a", "b"}


def test_three_are_found_where_no_two_will_do():
    columns = [column(name, shape) for name, shape in zip("abcdef", BASIS, strict=False)]
    found = ranked(columns, 10.0 * (BASIS[0] + BASIS[2] - BASIS[4]))[0]
    assert found.names == {"a", "c", "e"}
    assert found.cost == pytest.approx(0.0, abs=1e-9)


def test_of_three_that_depend_on_one_another_no_set_is_made():
    both = (BASIS[0] + BASIS[1]) / np.sqrt(2.0)
    columns = [column("opens", BASIS[0]), column("closes", BASIS[1]), column("timing", both), column("d", BASIS[2])]
    sets = {each.names for each in ranked(columns, 5.0 * BASIS[0] + BASIS[3])}
    assert {"opens", "closes", "timing"} not in sets
    assert {"opens", "closes", "d"} in sets
    flat = [column(name, shape[:2]) for name, shape in zip("abcd", 3.0 * BASIS, strict=False)]
    assert max(len(each.names) for each in rank_sets(LinearModel(flat, np.ones(2)), PENALTY)) == 2


def test_a_strength_that_cannot_be_negative_is_not_asked_to_be():
    columns = [column("leak", BASIS[0], low=0.0), column("force", BASIS[1])]
    names = [each.names for each in ranked(columns, -10.0 * BASIS[0] + BASIS[1])]
    assert names == [{"force"}]


def test_two_probes_of_one_candidate_are_no_set_and_the_better_one_counts():
    columns = [column("a", BASIS[0]), column("a", BASIS[0] + 0.5 * BASIS[1], size=0.25)]
    (found,) = ranked(columns, 4.0 * (BASIS[0] + 0.5 * BASIS[1]))
    assert found.cost == pytest.approx(0.0, abs=1e-9)


def test_what_a_fit_took_alone_foretells_more_than_a_sensitivity_where_an_effect_bends_the_data():
    explanation = explain_example()
    base = explanation.calibrated
    [model] = [choice.model for choice in explanation.fits if choice.names == ("side_force",)]
    linear = linearise_base(base, [], [model])
    (found,) = rank_sets(linear, PENALTY)
    assert found.names == {"side_force"}
    assert found.guesses[0] == pytest.approx(tuple(model.own(0)), rel=0.05)
    assert found.cost == pytest.approx(model.fitted.cost, abs=1.0)


def test_about_a_fit_the_linear_model_foresees_that_fit_and_what_the_others_would_do_in_its_place():
    explanation = explain_example()
    fits = {frozenset(choice.names): choice.model for choice in explanation.fits}
    best = fits[frozenset({"side_force"})]
    foreseen = {each.names: each.cost for each in rank_sets(linearise_best(best, explanation.sensitivities), PENALTY)}
    assert foreseen[frozenset({"side_force"})] == pytest.approx(best.fitted.cost, abs=0.5)
    for names, model in fits.items():
        if len(names) == 2 and "side_force" in names:
            assert foreseen[names] == pytest.approx(model.fitted.cost, abs=2.0)


def test_a_shape_stays_where_its_effect_is_taken_to_be_off():
    [model] = [choice.model for choice in explain_example().fits if choice.names == ("coulomb_friction",)]
    [candidate] = model.candidates
    strengths, places = len(candidate.strengths), model.places(0)
    assert strengths < len(places)
    shapes = model.fitted.jacobian[:, places[strengths:]]
    for factor in (1.0, 3.0):  # what a shape would do counts for nothing
        jacobian = np.array(model.fitted.jacobian)
        jacobian[:, places[strengths:]] = factor * shapes
        other = model._replace(fitted=model.fitted._replace(jacobian=jacobian))
        assert np.array_equal(linearise_best(other, []).errors, linearise_best(model, []).errors)


def test_no_set_is_fitted_twice_and_every_fit_is_as_good_as_what_it_contains():
    explanation = explain_example()
    alone = [choice for choice in explanation.fits if len(choice.names) == 1]
    found, _ = fit_sets(explanation.calibrated, explanation.sensitivities, alone, 3, Work())
    names = [frozenset(choice.names) for choice in (*alone, *found)]
    assert len(set(names)) == len(names)
    costs = {frozenset(choice.names): choice.model.cost for choice in (*alone, *found)}
    for one, cost in costs.items():
        assert all(cost <= costs[other] + 1e-6 for other in costs if other < one)


def test_what_is_foreseen_of_sets_that_were_not_fitted_is_near_what_their_fits_give(monkeypatch):
    monkeypatch.setattr(model_selection, "MIN_SETS", 0)
    monkeypatch.setattr(model_selection, "MAX_SETS", 0)
    explanation = explain_example()
    costs = {frozenset(choice.names): choice.cost for choice in explanation.fits}
    best = [choice for choice in explanation.fits if choice.names == ("side_force",)]
    fitted, foreseen = fit_sets(explanation.calibrated, explanation.sensitivities, best, 3, Work())
    names = {frozenset(each.names) for each in foreseen}
    assert not names & {frozenset(choice.names) for choice in (*best, *fitted)}
    assert len(names) == 3
    for each in foreseen:
        error = each.excess - (costs[frozenset(each.names)] - min(costs.values()))
        assert abs(error) < (0.5 if len(each.names) == 2 else 3.0)


def test_a_set_whose_simulation_does_not_come_to_its_end_is_not_foreseen(monkeypatch):
    explanation = explain_example()
    best = [choice for choice in explanation.fits if choice.names == ("side_force",)]
    monkeypatch.setattr(model_selection, "_fit_all", lambda *_: [])
    assert fit_sets(explanation.calibrated, explanation.sensitivities, best, 3, Work()) == ([], [])
