"""How far strengths may be off: what operating points and other models add to the curvature of linear problems."""

from math import log
from types import SimpleNamespace

import numpy as np
import pytest

from apesim.studies.estimation.cluster_robust import compare_groups
from apesim.studies.estimation.levenberg_marquardt import Fitted
from apesim.studies.gap.decide import standard_errors
from apesim.studies.gap.decide.operating_points import list_point_rows
from apesim.studies.gap.decide.standard_errors import find_standard_errors, find_variances_between
from apesim.studies.gap.example_bench import explain_example
from apesim.studies.gap.report.effect_rows import describe_effects
from apesim.studies.gap.search.model_selection import PricedModel
from apesim.studies.gap.search.score_test import Sensitivity
from apesim.studies.gap.thresholds import AMBIGUOUS_COST, TERM_CHANCE

SAMPLES, LIBRARY = 200, 30
SIZE, END = 0.25, 1.0
"""Size of a probe, and end of the range of its strength, in x."""
REBATE = 2.0 * log(standard_errors.FURTHER_CHANCE / TERM_CHANCE)
PRICE = 2.0 * log(LIBRARY / standard_errors.FURTHER_CHANCE)


def fit(columns, measured):
    """Least squares of linear columns, each with a prior that says next to nothing."""
    jacobian = np.vstack([columns, 1e-6 * np.eye(columns.shape[1])])
    x = np.linalg.lstsq(jacobian, np.append(measured, np.zeros(columns.shape[1])), rcond=None)[0]
    return Fitted(x, jacobian @ x - np.append(measured, np.zeros(len(x))), jacobian, True, np.zeros(len(x)))


def choice(fitted, names, cost):
    """A model with a nuisance and the effects of some names, as a choice."""
    parameters = [SimpleNamespace(key=key, file="") for key in ("nuisance", *names)]
    residuals = SimpleNamespace(parameters=parameters)
    model = SimpleNamespace(
        fitted=fitted, residuals=residuals, names=names, candidates=names, added=len(names), corrected=()
    )
    return PricedModel(model, cost)


def probe(name, effect, one_sided=False):
    """What an effect does to the samples at `SIZE`, and to the prior of the nuisance, which is nothing."""
    strength = SimpleNamespace(ends=(0.0, END))
    what = SimpleNamespace(
        candidate=SimpleNamespace(name=name), x=(SIZE,), strength=0, parameter=strength, one_sided=one_sided
    )
    return Sensitivity(what, np.append(effect, 0.0), np.append(effect, 0.0), 1.0)


def columns(seed=1):
    """What a nuisance, a strength and another effect do to the samples; the last two have a cosine of 0.7."""
    rng = np.random.default_rng(seed)
    nuisance, strength, own = rng.standard_normal((3, SAMPLES))
    return nuisance, strength, 0.7 * strength + 0.7 * own


def test_the_errors_are_those_of_the_operating_points_and_of_the_models_between(monkeypatch):
    model = explain_example().best
    groups = list_point_rows(model.residuals)
    assert len(groups) == 2
    factors = compare_groups(model.fitted.jacobian, model.fitted.residuals, groups).factors
    own = np.diag(model.fitted.covariance) * factors
    monkeypatch.setattr(standard_errors, "WIDENING", 1.0)
    assert find_standard_errors(model._replace(between=None)) == pytest.approx(np.sqrt(own))
    between = 3.0 * own
    assert find_standard_errors(model._replace(between=between)) == pytest.approx(2.0 * np.sqrt(own))
    monkeypatch.setattr(standard_errors, "WIDENING", 1.5)
    assert find_standard_errors(model._replace(between=between)) == pytest.approx(3.0 * np.sqrt(own))


def test_intervals_of_effects_are_those_of_the_errors(monkeypatch):
    monkeypatch.setattr(standard_errors, "WIDENING", 1.0)
    model = explain_example().best
    assert model.between is not None
    (row,) = describe_effects(model)
    (wider,) = describe_effects(model._replace(between=3.0 * find_standard_errors(model) ** 2))
    low, high = (np.diff(each["interval_95"])[0] for each in (row, wider))
    assert (row["open_ends"], wider["open_ends"]) == ([], [])
    whole = find_standard_errors(model)[-1] ** 2
    assert high / low == pytest.approx(np.sqrt((4.0 * whole - model.between[-1]) / whole))


def test_one_operating_point_tells_nothing_beside_the_curvature(monkeypatch):
    monkeypatch.setattr(standard_errors, "WIDENING", 1.0)
    model = explain_example().best
    runs = [run._replace(supply=model.residuals.runs[0].supply) for run in model.residuals.runs]
    alike = model._replace(residuals=model.residuals.with_runs(runs), between=None)
    assert find_standard_errors(alike) == pytest.approx(np.sqrt(np.diag(model.fitted.covariance)))


def test_a_fitted_model_within_reach_adds_by_its_weight():
    nuisance, strength, other = columns()
    measured = strength + 0.1 * np.sin(np.arange(SAMPLES))
    best = choice(fit(np.column_stack([nuisance, strength]), measured), ("a",), 50.0)
    both = fit(np.column_stack([nuisance, strength, other]), measured)
    moved = both._replace(x=both.x + np.array([0.0, 0.2, 0.0]))
    excess = 3.0
    rivals = [choice(moved, ("a", "b"), 50.0 + excess + REBATE), choice(moved, ("c", "d"), 50.0)]
    weight = np.exp(-0.5 * excess)
    own = best.model.fitted.covariance[1, 1]
    shift = moved.x[1] - best.model.fitted.x[1]
    expected = weight / (1.0 + weight) * (moved.covariance[1, 1] - own + shift**2)
    assert find_variances_between(best, [best, *rivals], [], LIBRARY)[1] == pytest.approx(expected)
    far = [choice(moved, ("a", "b"), 50.0 + AMBIGUOUS_COST + REBATE + 0.1)]
    assert not find_variances_between(best, [best, *far], [], LIBRARY).any()


def test_one_effect_more_adds_what_a_fit_with_its_prior_would():
    nuisance, strength, other = columns()
    rng = np.random.default_rng(7)
    measured = strength + 0.3 * other + rng.standard_normal(SAMPLES)
    best = choice(fit(np.column_stack([nuisance, strength]), measured), ("a",), 50.0)

    # The fit has the other effect's strength in x, and its prior as a row more.
    jacobian = np.vstack([np.column_stack([nuisance, strength, other / SIZE]), [0.0, 0.0, 1.0 / END]])
    wanted = np.append(measured, 0.0)
    x, (cost,), *_ = np.linalg.lstsq(jacobian, wanted, rcond=None)
    variance = np.linalg.inv(jacobian.T @ jacobian)[1, 1]
    excess = PRICE - (best.model.fitted.cost - cost)
    assert 0.0 < excess < AMBIGUOUS_COST
    weight, own = np.exp(-0.5 * excess), best.model.fitted.covariance[1, 1]
    expected = weight / (1.0 + weight) * (variance - own + (x[1] - best.model.fitted.x[1]) ** 2)
    sensitivities = [probe("b", other), probe("a", strength)]
    assert find_variances_between(best, [best], sensitivities, LIBRARY)[1] == pytest.approx(expected, rel=1e-6)

    # Where it was fitted, that counts; and an effect of the wrong sign is none.
    fitted = choice(best.model.fitted, ("a", "b"), 1e3)
    assert not find_variances_between(best, [best, fitted], sensitivities, LIBRARY).any()
    assert not find_variances_between(best, [best], [probe("b", -other, one_sided=True)], LIBRARY).any()


def test_an_effect_of_the_wrong_sign_adds_nothing_where_even_none_of_it_would_be_within_reach():
    """Among few candidates one more is cheap: with its size held at zero it would still count as a model."""
    nuisance, strength, other = columns()
    measured = strength - 0.02 * other + np.random.default_rng(7).standard_normal(SAMPLES)
    best, few = choice(fit(np.column_stack([nuisance, strength]), measured), ("a",), 50.0), 2
    assert 2.0 * log(few / standard_errors.FURTHER_CHANCE) < AMBIGUOUS_COST
    both, one = (
        find_variances_between(best, [best], [probe("b", other, one_sided=is_one)], few) for is_one in (False, True)
    )
    assert both[1] > best.model.fitted.covariance[1, 1] / 10.0
    assert not one.any()


def test_intervals_hold_a_strength_more_often_where_an_effect_is_hidden_beside_it():
    nuisance, strength, other = columns()
    rng, held = np.random.default_rng(8), []
    visible = (
        other
        - np.column_stack([nuisance, strength])
        @ np.linalg.lstsq(np.column_stack([nuisance, strength]), other, rcond=None)[0]
    )
    for hidden in rng.uniform(1.0, 5.0, 400):
        measured = strength + hidden / np.linalg.norm(visible) * other + rng.standard_normal(SAMPLES)
        best = choice(fit(np.column_stack([nuisance, strength]), measured), ("a",), 50.0)
        own = best.model.fitted.covariance[1, 1]
        added = find_variances_between(best, [best], [probe("b", other)], LIBRARY)[1]
        off = abs(best.model.fitted.x[1] - 1.0)
        held.append((off <= 1.96 * np.sqrt(own), off <= 1.96 * np.sqrt(own + added)))
    by_curvature, averaged = np.mean(held, axis=0)
    assert averaged > by_curvature + 0.2
