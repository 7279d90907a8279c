"""Whitened residuals give the same bits for the same question, whatever was asked of them before."""

import functools
import pickle

import numpy as np
import pytest

import apesim
from apesim.engine.machine import Machine
from apesim.studies.estimation.levenberg_marquardt import descend
from apesim.studies.estimation.noise.process import white
from apesim.studies.estimation.priors import Prior, nuisance
from apesim.studies.estimation.residuals import Counter, EndedEarly, WhitenedResiduals
from apesim.studies.gap.search.candidates import find_candidates
from apesim.studies.gap.search.library import select_effects
from apesim.studies.measured import MeasuredRun
from apesim.studies.measured.prediction import predict, run_of

MACHINE = Machine()
NOISE = {
    "lift": {0.0: white(3e-5, "stated")},
    "torque": {0.0: white(0.3, "stated")},
    "air_flow": {0.0: white(1e-4, "stated")},
}
PRIORS = (
    Prior("valve.viscous_friction", 0.10, True),
    Prior("supply.pressure", 0.01, True),
    Prior("effects.sensor_gain.lift", 0.005),
)
WITH_VOLUME = {"valve": "supply_droop", "engine": "intake_pipe_loss"}


@functools.cache
def run_on(bench):
    """A run without noise of a machine that is not quite the one that is fitted."""
    times = np.arange(0.0, 0.06, 2.5e-4)
    run = MeasuredRun("", "", 0.5e6, 287.0, 50e-3, "fit", times, {"lift": 0.0 * times})
    if bench == "engine":
        speed = 1000.0 * np.pi / 30.0
        run = MeasuredRun("", "", 1.1e6, 287.0, np.nan, "fit", np.empty(0), {}, "engine", speed, -0.1, 1.2)
        run = run._replace(means={"torque": 0.0, "air_flow": 0.0})
    other = MACHINE.with_(**{"valve.viscous_friction": 1.05 * MACHINE.valve.viscous_friction})
    shown = predict(run_of(other, run), run)
    return run._replace(channels=shown.channels, means=shown.means)


def fresh(bench, **options):
    """Residuals of which nothing was asked, with an effect among the parameters that adds a volume."""
    name = WITH_VOLUME[bench]
    (candidate,) = (one for one in find_candidates(MACHINE, bench, select_effects(bench)) if one.name == name)
    parameters = [
        *(nuisance(MACHINE, prior) for prior in PRIORS[: 3 if bench == "valve" else 2]),
        *candidate.parameters,
    ]
    return WhitenedResiduals(MACHINE, [run_on(bench)], parameters, NOISE, **options)


def bits(values):
    return np.ascontiguousarray(values).tobytes()


def points(residuals):
    """A point at which the volume is on, and one at which it is off."""
    on = np.full(len(residuals.parameters), 0.3)
    return on, np.where(residuals.known, on, 0.0)


@pytest.mark.parametrize("bench", ["valve", "engine"])
def test_residuals_and_sensitivities_are_those_of_a_fresh_object_after_any_other_calls(bench):
    used = fresh(bench)
    on, off = points(used)
    used.at(off)
    _, steps = used.jacobian(0.5 * on, used.at(0.5 * on))
    used.marks(off)
    pickle.loads(pickle.dumps(used)).at(on)
    assert not np.array_equal(steps, np.full(len(on), 0.01))
    for x in (on, off):
        new = fresh(bench)
        residuals, expected = used.at(x), new.at(x)
        assert bits(residuals) == bits(expected)
        for one, other in zip(used.jacobian(x, residuals), new.jacobian(x, expected), strict=True):
            assert bits(one) == bits(other)


def test_an_engine_s_sensitivities_are_those_of_runs_from_far_away():
    """Columns start from the periodic state at x; runs from the machine as it was before come to the same."""
    residuals, x = fresh("engine"), points(fresh("engine"))[0]
    errors = residuals.at(x)
    columns, _ = residuals.jacobian(x, errors, np.full(len(x), 0.05))
    for j in range(len(x)):
        moved = x.copy()
        moved[j] += 0.05 if x[j] + 0.05 <= residuals.high[j] else -0.05
        slow = (residuals.at(moved) - errors) / (moved[j] - x[j])
        assert columns[:, j] == pytest.approx(slow, abs=0.05)


@pytest.mark.parametrize("bench", ["valve", "engine"])
def test_two_fits_from_one_start_are_the_same_to_the_bit_whichever_ran_first(bench):
    shared = fresh(bench)
    _, off = points(shared)
    start, other_start = 0.5 * off, -0.5 * off
    first, second = descend(shared, start), descend(shared, other_start)
    second_alone, first_alone = descend(fresh(bench), other_start), descend(fresh(bench), start)
    for one, other in ((first, first_alone), (second, second_alone)):
        assert all(bits(a) == bits(b) for a, b in zip(one, other, strict=True))


def test_starts_are_moved_in_a_new_object_alone():
    residuals = fresh("engine")
    _, off = points(residuals)
    before = bits(residuals.at(off))
    moved = residuals.restarted_at(off)
    assert bits(moved.at(off)) != before
    assert bits(residuals.at(off)) == before
    assert moved.at(off) == pytest.approx(residuals.at(off), abs=1e-3)


def test_steps_that_are_handed_in_stay_as_they_are():
    residuals = fresh("valve")
    on, _ = points(residuals)
    steps = np.full(len(on), 0.02)
    _, adapted = residuals.jacobian(on, residuals.at(on), steps, only=[0])
    assert steps.tolist() == [0.02] * len(on)
    assert adapted[0] != 0.02
    assert adapted[1:].tolist() == steps[1:].tolist()


def test_simulations_are_counted_where_they_are_to_be():
    counter = Counter()
    residuals = fresh("valve", counter=counter)
    on, off = points(residuals)
    residuals.at(on)
    residuals.with_noise(NOISE).at(off)
    residuals.restarted_at(on).at(off)
    assert counter.number == residuals.simulations == 3
    other = residuals.with_parameters(residuals.parameters)
    other.at(on)
    assert (other.simulations, counter.number) == (1, 3)


def test_a_run_that_cannot_be_simulated_raises_what_the_face_exports_in_any_process():
    """What is raised in a worker process comes back pickled."""
    ended = pickle.loads(pickle.dumps(EndedEarly("p040")))
    assert isinstance(ended, apesim.NotConverged) and ended.result is None
    assert str(ended).startswith(
        "p040: the simulation does not come to its end; simulate its conditions with run_valve"
    )


def test_a_missing_cell_costs_its_sample_alone():
    run = run_on("valve")
    whole = fresh("valve")
    x = np.zeros(len(whole.parameters))
    lift = np.where(np.isin(np.arange(len(run.times)), [5, 90, 91]), np.nan, run.channels["lift"])
    residuals = whole.with_runs([run._replace(channels={"lift": lift})])
    kept = np.flatnonzero(~np.isnan(lift))
    [block] = residuals.blocks
    assert np.array_equal(block.times, run.times[kept]) and np.array_equal(block.values, lift[kept])
    pulls = np.arange(len(run.times), len(run.times) + len(x))
    assert bits(residuals.at(x)) == bits(whole.at(x)[np.append(kept, pulls)])


def test_a_missing_cell_of_an_engine_keeps_the_angles_of_the_others():
    angles = np.linspace(0.0, 6.0, 9)
    pressure = np.where(np.arange(9) == 4, np.nan, 1e5)
    run = run_on("engine")._replace(times=angles / 100.0, angles=angles, channels={"cylinder_pressure": pressure})
    block, *means = WhitenedResiduals(MACHINE, [run], []).blocks
    assert np.array_equal(block.angles, np.delete(angles, 4))
    assert [mean.sensor for mean in means] == ["torque", "air_flow"]
