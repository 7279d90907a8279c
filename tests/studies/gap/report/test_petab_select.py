"""The search as a model space, read back and judged by PEtab Select itself."""

from itertools import combinations
from math import log
from types import SimpleNamespace

import pytest
import yaml
from petab.v1.yaml import validate
from petab_select import Criterion, Models, Problem, ui

from apesim.engine.machine import Machine
from apesim.studies.estimation.calibration import calibrate
from apesim.studies.estimation.parameters import value_of
from apesim.studies.estimation.priors import ENGINE, VALVE, nuisance
from apesim.studies.gap.report.petab_select import export_model_space, format_id, format_yaml
from apesim.studies.gap.search.calibrated_gap import check_against_noise, score_candidates
from apesim.studies.gap.search.candidate_fits import fit_candidates
from apesim.studies.gap.search.candidates import find_candidates
from apesim.studies.gap.search.library import select_effects
from apesim.studies.gap.stage_work import Work
from apesim.studies.measured import FIT, read_measured
from tests.gap_bench import AMBIENT, write_bench

pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning:petab.v1.parameters")
FREED = {
    "solenoid_b_delay": {"effects__solenoid_b_delay__time"},
    "coulomb_friction": {"effects__coulomb_friction__force", "effects__coulomb_friction__breakaway"},
    "bounce": {"effects__bounce__restitution"},
}
"""Effects of a library without the side force that the data have, so that pairs are tried."""


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    machine = Machine()
    measured = read_measured(write_bench(tmp_path_factory.mktemp("bench")), AMBIENT)
    base, _ = calibrate(machine, measured)
    effects = [effect for effect in select_effects("valve") if effect.name in FREED]
    base, columns, _ = score_candidates(base, find_candidates(machine, "valve", effects), Work())
    _, tried, _ = fit_candidates(check_against_noise(base, columns, []), len(effects), Work())
    return SimpleNamespace(measured=measured, calibrated=base, sensitivities=columns, fits=tried)


@pytest.fixture
def folder(found, tmp_path):
    for name, text in export_model_space(found).items():
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.fixture
def problem(folder):
    return Problem.from_yaml(folder / "petab_select_problem.yaml")


@pytest.fixture
def models(folder, problem):
    return Models.from_yaml(folder / "calibrated_models.yaml", problem=problem)


def fitted_of(found):
    """The fitted models of the space by what they add, the calibrated machine under nothing."""
    models = [choice.model for choice in found.fits if choice.model.candidates]
    known = {frozenset(model.names): model for model in models}
    return {frozenset(): found.calibrated} | known


def added_by(model):
    """Names of the effects that a model of PEtab Select estimates."""
    freed = set(model.get_estimated_parameter_ids(full=False))
    assert freed == set().union(*(own for own in FREED.values() if own & freed))
    return frozenset(name for name, own in FREED.items() if own & freed)


def test_the_space_is_the_machine_each_effect_and_each_pair(problem, folder):
    validate(str(folder / "petab_problem.yaml"))
    spaces = problem.model_space.model_subspaces.values()
    assert [len(space) for space in spaces] == [1] * 7
    models = [space.indices_to_model([0] * len(space.parameters)) for space in spaces]
    expected = [frozenset(names) for size in range(3) for names in combinations(FREED, size)]
    assert sorted(map(added_by, models), key=sorted) == sorted(expected, key=sorted)
    assert {value for model in models for value in model.parameters.values()} == {0, "estimate"}


def test_the_fitted_models_are_of_the_space_and_the_others_are_left_to_fit(problem, models, found):
    assert {added_by(model) for model in models} == set(fitted_of(found))
    assert len({len(names) for names in fitted_of(found)}) == 3
    for model in models:
        space = problem.model_space.model_subspaces[model.model_subspace_id]
        assert model.parameters == space.indices_to_model(model.model_subspace_indices).parameters
        assert set(model.estimated_parameters) == set(model.get_estimated_parameter_ids())
    left = ui.start_iteration(problem=problem, user_calibrated_models=models)["uncalibrated_models"]
    assert len(left) == 7 - len(models)
    assert not {added_by(model) for model in left} & set(fitted_of(found))


def test_estimates_are_those_of_the_machine_that_the_fit_makes(models, found):
    for model in models:
        fit = fitted_of(found)[added_by(model)]
        machine = fit.machine()
        for key in (parameter.key for parameter in fit.residuals.parameters if not parameter.prior):
            estimate = model.estimated_parameters[key.replace(".", "__")]
            assert estimate == pytest.approx(value_of(machine, key), rel=1e-12, abs=1e-15)
        # A gauge errs by a share of what it shows: 1 % is a standard deviation.
        x = next(x for p, x in zip(fit.residuals.parameters, fit.fitted.x, strict=True) if p.key == "supply.pressure")
        stated = machine.supply.pressure
        expected = stated + 0.01 * x * (stated - AMBIENT)
        assert model.estimated_parameters["nuisance__supply__pressure"] == pytest.approx(expected, rel=1e-12)


def test_priors_stand_in_the_table_of_parameters(problem):
    table = next(iter(problem.model_space.model_subspaces.values())).petab_problem.parameter_df
    known = table[table["estimate"] == 1]
    assert all(name.startswith("nuisance__") for name in known.index)
    assert set(known["objectivePriorType"]) == {"normal"}
    assert set(table.index[table["estimate"] == 0]) == set().union(*FREED.values())
    mean, deviation = map(float, known["objectivePriorParameters"]["nuisance__valve__viscous_friction"].split(";"))
    assert deviation == pytest.approx(0.1 * mean)
    assert known["parameterName"]["nuisance__valve__viscous_friction"] == "valve.viscous_friction [kg s^-1]"


@pytest.mark.parametrize("criterion", ["NLLH", "AIC", "BIC"])
def test_its_best_model_is_the_least_by_the_cost_of_the_fits(problem, models, found, criterion):
    samples = sum(len(run.times) for run in found.measured.of(FIT))
    priors = len(found.calibrated.residuals.parameters)

    def expected(fit):
        freed = priors + sum(len(FREED[name]) for name in fit.names)
        penalties = {"NLLH": 0.0, "AIC": 2.0 * freed, "BIC": freed * log(samples + priors)}
        return (fit.cost + penalties[criterion]) / (2.0 if criterion == "NLLH" else 1.0)

    values = {names: expected(fit) for names, fit in fitted_of(found).items()}
    for model in models:
        assert model.criteria[Criterion(criterion)] == pytest.approx(values[added_by(model)], rel=1e-12)
    best = ui.get_best(problem=problem, models=models, criterion=Criterion(criterion))
    assert added_by(best) == min(values, key=values.get)
    if criterion == "BIC":  # which is the problem's own
        assert ui.get_best(problem=problem, models=models).hash == best.hash


def test_it_computes_the_same_criterion_from_the_likelihood_and_its_own_count_of_parameters(models):
    for model in models:
        told = model.criteria.pop(Criterion.AIC)
        assert model.get_criterion(Criterion.AIC) == pytest.approx(told, rel=1e-12)


def test_a_machine_that_lacks_nothing_is_the_only_model_fitted(found, tmp_path):
    texts = export_model_space(SimpleNamespace(calibrated=found.calibrated, sensitivities=found.sensitivities, fits=[]))
    (entry,) = yaml.safe_load(texts["calibrated_models.yaml"])
    assert entry["model_subspace_id"] == "calibrated_machine"
    assert entry["criteria"]["NLLH"] == pytest.approx(found.calibrated.cost / 2.0)


def test_a_nuisance_and_an_effect_on_one_key_keep_their_names_apart():
    machine = Machine().with_(
        valve_solenoid_release_dead_time="2 ms", **{"engine.exhaust_2.effective_area": "100 mm^2"}
    )
    freed = [p for one in find_candidates(machine, "engine", select_effects("engine")) for p in one.parameters]
    known = [nuisance(machine, prior) for prior in VALVE + ENGINE]
    assert {p.key for p in freed} & {p.key for p in known} == {"effects.tdc_error.angle"}
    names = [format_id(p) for p in (*known, *freed)]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("value", [1e-05, -3e22, 0.1, 2.5e-07, 0.0, 3, "estimate", [0, 0], [], {"a": {"b": 1e-300}}])
def test_yaml_reads_back_as_it_was(value):
    assert yaml.safe_load(format_yaml({"key": value, "next": 1})) == {"key": value, "next": 1}
