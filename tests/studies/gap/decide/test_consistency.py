"""Whether each operating point alone leads to the same numbers."""

from types import SimpleNamespace

import numpy as np
import pytest

from apesim.studies.estimation.levenberg_marquardt import Fitted
from apesim.studies.estimation.model import Model
from apesim.studies.estimation.priors import Prior, nuisance
from apesim.studies.gap.decide.consistency import compare_points, select_significant
from apesim.studies.measured import MeasuredRun

RNG = np.random.default_rng(7)
SAMPLES, TIMES = 300, np.zeros(300)
RUNS = [MeasuredRun("", "", supply, 287.0, 50e-3, "fit", TIMES, {}) for supply in (0.3e6, 0.6e6, 0.9e6)]
PARAMETERS = [
    nuisance(SimpleNamespace(supply=SimpleNamespace(pressure=1e6, temperature=287.0)), prior)
    for prior in (Prior("supply.pressure", 0.01, True), Prior("supply.temperature", 2.0))
]
SLOPES = RNG.standard_normal((len(RUNS) * SAMPLES, 2)) / 5.0


def fitted(true, runs=RUNS):
    """All runs fitted by a straight model, the parameters at each run being what they truly are there, (runs, 2)."""
    slopes = SLOPES[: len(runs) * SAMPLES]
    seen = RNG.standard_normal(len(slopes)) - np.sum(slopes * np.repeat(true, SAMPLES, axis=0), axis=1)
    jacobian, known = np.vstack([slopes, np.eye(2)]), np.append(seen, np.zeros(2))
    x = -np.linalg.lstsq(jacobian, known, rcond=None)[0]
    blocks = [SimpleNamespace(run=run, values=TIMES) for run in runs]
    residuals = SimpleNamespace(runs=list(runs), blocks=blocks, parameters=PARAMETERS)
    return Model((), residuals, Fitted(x, known + jacobian @ x, jacobian, True, np.full(2, 0.01)))


def test_of_noise_alone_the_differences_are_standard_normal_numbers():
    drawn = [fitted(RNG.standard_normal(2) * np.ones((3, 1))) for _ in range(400)]
    farthest = np.array([[abs(one.n_sigma) for one in compare_points(model)] for model in drawn])
    assert farthest.shape == (400, 2)
    # Of three, which share what all of them have in common: between one and three independent numbers.
    assert 1.96 < np.quantile(farthest, 0.95) < 2.39 + 0.15
    told = np.mean([bool(select_significant(compare_points(model), len(RUNS))) for model in drawn])
    assert told < 0.03


def test_a_point_that_leads_elsewhere_is_told_with_its_number():
    model = fitted(np.array([[0.5, 0.0], [0.5, 0.0], [0.5, 1.5]]))
    first, *_ = found = compare_points(model)
    assert first.parameter.key == "supply.temperature"
    assert first.run is RUNS[2]
    assert first.x == pytest.approx(1.5, abs=0.9)
    assert [one.parameter.key for one in select_significant(found, len(RUNS))] == ["supply.temperature"]


def test_one_point_alone_has_nothing_to_be_held_against():
    again = RUNS[0]._replace(supply=1.002 * RUNS[0].supply)
    assert compare_points(fitted(np.zeros((2, 2)), [RUNS[0], again])) == []
