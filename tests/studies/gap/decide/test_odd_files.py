"""Test of the residuals of each channel of each run."""

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.estimation.noise.process import white
from apesim.studies.estimation.residuals import WhitenedResiduals
from apesim.studies.gap.decide.odd_files import find_excesses, find_odd_channels
from apesim.studies.measured import MeasuredRun

SAMPLES = 1000
TIMES = np.arange(SAMPLES) * 1e-4


def channels(number):
    """Residuals of runs with a lift each, and white noise that is stated."""
    runs = [
        MeasuredRun(f"p{n}", f"p{n}.csv", 0.5e6, 287.0, 50e-3, "fit", TIMES, {"lift": 0.0 * TIMES})
        for n in range(number)
    ]
    return WhitenedResiduals(Machine(), runs, [], {"lift": {1e-4: white(3e-5, "stated")}})


def noise(number, seed=1):
    return np.random.default_rng(seed).standard_normal(number * SAMPLES)


def test_noise_alone_makes_no_channel_odd():
    residuals = channels(40)
    assert [find_odd_channels(residuals, noise(40, seed)) for seed in range(20)] == [[]] * 20


@pytest.mark.parametrize(
    "fault",
    [np.full(SAMPLES, 0.5), 8.0 * (np.arange(SAMPLES) % 100 == 0), np.linspace(-1.0, 1.0, SAMPLES)],
    ids=["offset", "spikes", "drift"],
)
def test_the_file_with_a_fault_is_found_among_good_ones(fault):
    errors = noise(5)
    errors[3 * SAMPLES : 4 * SAMPLES] += fault
    (odd,) = find_odd_channels(channels(5), errors)
    assert (odd.file, odd.sensor) == ("p3.csv", "lift")
    assert odd.size == pytest.approx(np.sqrt(np.mean(np.square(fault))), rel=0.25)


def test_what_does_not_matter_is_not_odd():
    errors = noise(3)
    errors[:SAMPLES] += 0.2
    assert find_odd_channels(channels(3), errors) == []


def test_noise_that_is_known_from_few_samples_leaves_more_room():
    values = 1.4 * noise(1)
    known, unknown = (find_excesses(values, white(3e-5, "", samples))[0] for samples in (np.inf, 60.0))
    assert known.n_sigma > 5.0 > unknown.n_sigma
    assert known.energy == unknown.energy
