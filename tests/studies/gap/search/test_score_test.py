"""Scores of effects, and the chance of noise alone to give as large a one."""

import numpy as np
import pytest

from apesim.engine.effects import ALL_EFFECTS
from apesim.engine.machine import Machine
from apesim.studies.estimation.nuisance_space import find_nuisance_space
from apesim.studies.estimation.parameters import Parameter
from apesim.studies.gap.search.candidates import Candidate, Probe, find_candidates, list_probes
from apesim.studies.gap.search.gap_test import compare_with_noise
from apesim.studies.gap.search.score_test import Sensitivity, find_scores

N = 400


def column(name, effect, space, low=-1.0):
    strength = Parameter("effects.side_force.force", 12.0, low, 1.0)
    probe = Probe(Candidate(name, (strength,), ()), (0.01,), 0)
    projected = space.project_out(effect)
    return Sensitivity(probe, effect, projected, float(np.linalg.norm(projected) / np.linalg.norm(effect)))


@pytest.fixture
def bench():
    """Nuisances, and three effects of which the first two look alike."""
    rng = np.random.default_rng(1)
    space = find_nuisance_space(rng.normal(size=(N, 4)))
    first, third = rng.normal(size=(2, N))
    second = first + 0.3 * rng.normal(size=N)
    return space, [column(name, v, space) for name, v in zip("abc", (first, second, third), strict=True)]


def test_what_nuisances_can_imitate_counts_nothing(bench):
    space, columns = bench
    errors = space.project_out(np.random.default_rng(2).normal(size=N))
    imitation = space.base @ [3.0, -2.0, 1.0, 4.0]
    for before, after in zip(find_scores(columns, errors), find_scores(columns, errors + imitation), strict=True):
        assert after.name == before.name
        assert after.n_sigma == pytest.approx(before.n_sigma)


def test_the_score_is_the_size_of_the_gap_along_an_effect(bench):
    _, columns = bench
    found = find_scores(columns, -2.5 * columns[2].projected)
    assert found[0].name == "c"
    assert found[0].n_sigma == pytest.approx(2.5 * columns[2].length)
    assert found[0].size == pytest.approx(2.5)


def test_an_effect_that_has_one_sign_explains_no_gap_of_the_other(bench):
    space, (first, *_) = bench
    only_up = column("a", first.effect, space, low=0.0)
    assert find_scores([only_up], 2.0 * only_up.projected)[0].n_sigma == 0.0
    assert find_scores([first], 2.0 * first.projected)[0].n_sigma > 0.0


@pytest.mark.slow
def test_noise_alone_opens_the_case_in_one_of_a_hundred(bench):
    space, columns = bench
    local = space.project_out(np.random.default_rng(3).normal(size=(N, 10)))
    rng = np.random.default_rng(4)
    found = [compare_with_noise(columns, local, space.project_out(rng.normal(size=N)), []).p_value for _ in range(400)]
    assert 0.002 <= np.mean(np.array(found) < 0.01) <= 0.025
    assert np.quantile(found, [0.25, 0.5, 0.75]) == pytest.approx([0.25, 0.5, 0.75], abs=0.08)


def test_a_gap_along_an_effect_opens_it(bench):
    space, columns = bench
    noise = space.project_out(np.random.default_rng(5).normal(size=N))
    gap = 6.0 * columns[0].projected / columns[0].length
    assert compare_with_noise(columns, np.zeros((N, 0)), noise + gap, []).alarm


def test_every_effect_that_is_off_is_a_candidate_and_nuisances_are_none():
    names = [candidate.name for candidate in find_candidates(Machine(), "engine", ALL_EFFECTS)]
    assert {"coulomb_friction", "blow_by", "tdc_error", "lift_sensor_lag"} <= set(names)
    assert not {"sensor_gain", "sensor_offset", "time_zero"} & set(names)
    machine = Machine()
    friction = machine.effects.coulomb_friction._replace(force=1.0)
    machine = machine._replace(effects=machine.effects._replace(coulomb_friction=friction))
    left = [candidate.name for candidate in find_candidates(machine, "engine", ALL_EFFECTS)]
    assert set(names) - set(left) == {"coulomb_friction"}


def test_probes_lie_in_the_range_and_reach_far_enough_for_an_effect_without_slope_at_zero():
    for candidate in find_candidates(Machine(), "engine", ALL_EFFECTS):
        probes = list(list_probes(candidate))
        assert max(abs(probe.x[probe.strength]) for probe in probes) >= 0.25
        for probe in probes:
            for parameter, x in zip(candidate.parameters, probe.x, strict=True):
                assert parameter.low <= x <= parameter.high


def test_a_rebound_is_probed_at_sizes_that_look_different():
    (bounce,) = (c for c in find_candidates(Machine(), "valve", ALL_EFFECTS) if c.name == "bounce")
    assert max(probe.x[0] for probe in list_probes(bounce)) == 1.0
    assert len(list(list_probes(bounce))) >= 4


def test_what_the_march_itself_errs_by_is_no_score(bench):
    _, (first, *_) = bench
    faint = first._replace(effect=1e-3 * first.effect / first.length, projected=1e-3 * first.projected / first.length)
    assert find_scores([faint], 5.0 * first.projected) == []
