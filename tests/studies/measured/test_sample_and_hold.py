"""A channel that was sampled more slowly than its rows come is used where it was sampled, and said to be."""

import numpy as np
import pytest

import apesim
from apesim.engine.machine import Machine
from apesim.studies.measured.plausibility import examine
from apesim.studies.measured.plausibility.sample_and_hold import find_repeated
from tests.studies.measured.test_disturbances import clean, folder_of, noisy

MACHINE = Machine()
PRESSURES = "pressure_a", "pressure_b"


def held(values, period, first=3):
    """Values as a sampler of a period in rows shows them, its first sample in one of the first rows."""
    rows = np.arange(len(values))
    looked = first + period * np.floor((rows - first) / period)
    return values[np.clip(np.ceil(looked).astype(int), 0, None)]


@pytest.mark.parametrize("period", [2, 3, 5, 10, 6.667])
@pytest.mark.parametrize("size", [0.0, 1.0])
def test_rows_that_repeat_a_slow_sampler_are_found(period, size):
    _, channels = noisy(step=0.1e-3, size=size)
    for name in PRESSURES:
        values = held(channels[name], period)
        used = np.flatnonzero(~find_repeated(values))
        rows = np.ceil(np.arange(3 % period, len(values), period)).astype(int)
        near = np.min(np.abs(rows[:, None] - used), axis=0)
        assert near.max() <= (0 if period % 1 == 0 or size else 1)
        assert len(used) == pytest.approx(len(rows), rel=0.05 if size else 0.15)


@pytest.mark.parametrize("bits", [5, 8, 12, 16, None])
@pytest.mark.parametrize("size", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("step", [2e-5, 0.1e-3, 1e-3])
def test_a_record_in_which_each_row_was_sampled_is_left_as_it_is(bits, size, step):
    for seed in range(3):
        _, channels = noisy(step=step, size=size, seed=seed)
        for name, values in channels.items():
            if bits:
                least = np.ptp(values) / 2**bits
                values = np.round(values / least) * least
            assert not find_repeated(values).any(), name


def test_a_slow_pressure_is_warned_of_and_counts_as_sampled_where_it_was(tmp_path):
    times, channels = noisy(step=0.1e-3)
    slow = {"lift": channels["lift"]} | {name: held(channels[name], 10) for name in PRESSURES}
    measured = folder_of(tmp_path, (times, slow))
    found = examine(MACHINE, measured).findings
    assert [(str(one.kind), one.channel) for one in found] == [("warning", name) for name in PRESSURES]
    assert all("10 rows" in one.seen for one in found)
    run = measured.runs[0]
    assert np.isfinite(run.channels["lift"]).all()
    assert np.isfinite(run.channels["pressure_a"]).mean() == pytest.approx(0.1, abs=0.005)


def test_a_dead_time_is_found_back_from_slow_pressures(tmp_path):
    times, channels = noisy(step=0.1e-3, seed=2)
    slow = {name: held(channels[name], 10) for name in PRESSURES}
    folder_of(tmp_path, (times, slow))
    with (tmp_path / "measured.toml").open("a") as about:
        about.write('\ntemperature = "290 K"\n')
    fitted = apesim.fit(tmp_path, ["valve.solenoid.dead_time"])
    low, high = fitted.interval_95["valve.solenoid.dead_time"]
    assert low < 1.5e-3 < high
    assert high - low < 0.1e-3


def test_held_values_without_noise_count_where_the_sampler_looked():
    times, channels = clean(step=0.1e-3)
    used = np.flatnonzero(~find_repeated(held(channels["pressure_b"], 10)))
    assert len(used) == pytest.approx(len(times) / 10, rel=0.1)
    assert {*((used - 3) % 10)} == {0}
