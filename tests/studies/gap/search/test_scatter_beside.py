"""Scatter that is taken at the best model with effects: all models are compared by it."""

from types import SimpleNamespace

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.estimation.scatter import Scatter, find_scatter_at
from apesim.studies.gap.example_bench import list_left_out, read_example
from apesim.studies.gap.search.calibrated_gap import find_gap
from apesim.studies.gap.search.candidate_fits import fit_candidates
from apesim.studies.gap.search.candidates import find_candidates
from apesim.studies.gap.search.library import select_effects
from apesim.studies.gap.search.model_selection import fit_singles
from apesim.studies.gap.search.scatter_beside import take_scatter_at_best
from apesim.studies.gap.stage_work import Work
from apesim.studies.measured import CHECK

KNOWN = Scatter(("valve.viscous_friction",), (0.3,), 5, {})


@pytest.fixture(scope="module")
def found():
    machine, measured = Machine(), read_example()
    candidates = find_candidates(machine, measured.bench, select_effects(measured.bench, list_left_out(), machine))
    gap, _, _ = find_gap(machine, measured, candidates, Work(), scatter=KNOWN)
    fits = fit_singles(gap.calibrated, gap.scores, len(candidates), Work())
    again, refitted = take_scatter_at_best(gap, fits, measured.of(CHECK), Work())
    return SimpleNamespace(measured=measured, gap=gap, fits=fits, again=again, refitted=refitted)


def test_all_models_are_compared_by_the_scatter_at_the_best_one(found):
    scatter = find_scatter_at(found.fits[0].model, found.measured.of(CHECK))
    models = [found.again.calibrated, *(choice.model for choice in found.refitted)]
    for model in models:
        for run, spread in model.residuals.scatter.spreads.items():
            assert spread.moves == pytest.approx(scatter.spreads[run].moves)
    assert {choice.names for choice in found.refitted} == {choice.names for choice in found.fits}
    assert found.refitted[0].names == ("side_force",)


def test_fits_are_ends_of_descents_by_that_scatter(found):
    for model in (found.again.calibrated, found.refitted[0].model):
        fitted = model.fitted
        assert fitted.residuals == pytest.approx(model.residuals.at(fitted.x), abs=1e-6)
        slope = fitted.jacobian.T @ fitted.residuals
        free = (fitted.x > model.residuals.low) & (fitted.x < model.residuals.high)
        step = np.linalg.solve(fitted.jacobian.T @ fitted.jacobian + 1e-9 * np.eye(len(slope)), slope)
        assert slope[free] @ step[free] < 0.1  # what a further step promises


def test_the_penalty_of_a_model_stays_as_it_was(found):
    before = {choice.names: choice.cost - choice.model.cost for choice in found.fits}
    assert {choice.names: choice.cost - choice.model.cost for choice in found.refitted} == pytest.approx(before)


def test_sensitivities_are_those_of_the_new_scatter(found):
    old, new = found.gap.sensitivities[0], found.again.sensitivities[0]
    assert old.probe.candidate.name == new.probe.candidate.name
    assert not np.allclose(old.effect, new.effect)
    assert new.effect @ new.projected == pytest.approx(new.projected @ new.projected, rel=1e-6)


def test_without_scatter_nothing_is_done_again():
    measured, machine = read_example(), Machine()
    candidates = find_candidates(machine, measured.bench, select_effects(measured.bench, list_left_out(), machine))
    gap, _, _ = find_gap(machine, measured, candidates, Work())
    again, _, _ = fit_candidates(gap, len(candidates), Work())
    assert again is gap
