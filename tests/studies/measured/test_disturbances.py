"""Disturbances of single samples are masked as a folder is read, and honest records are left as they are.

What is masked is reported; where it is much, or hides the same of most runs, the data are refused.
"""

from functools import cache

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.measured import MeasuredRun, read_measured
from apesim.studies.measured.plausibility import examine
from apesim.studies.measured.plausibility.disturbances import find_disturbances
from apesim.studies.measured.prediction import predict, run_of
from tests.machines import AMBIENT

MACHINE = Machine()
NOISE = {"lift": 3e-5, "velocity": 0.02, "pressure_a": 2e3, "pressure_b": 2e3, "temperature_a": 1.0}
UNITS = {
    "lift": "mm",
    "velocity": "m/s",
    "pressure_a": "kPa abs",
    "pressure_b": "kPa abs",
    "temperature_a": "K",
}
SCALES = {"lift": 1e3, "pressure_a": 1e-3, "pressure_b": 1e-3}


@cache
def clean(supply=0.4, step=0.25e-3, end=0.12):
    """Times [s] and channels without noise [SI]."""
    times = np.arange(-5e-3, end, step)
    run = MeasuredRun("a", "a.csv", supply * 1e6 + AMBIENT, 290.0, 50e-3, "fit", times, dict.fromkeys(NOISE, times))
    shown = predict(run_of(MACHINE, run), run)
    assert not shown.failed
    return times, shown.channels


def noisy(supply=0.4, step=0.25e-3, seed=0, size=1.0, end=0.12):
    rng = np.random.default_rng(seed)
    times, channels = clean(supply, step, end)
    noise = {name: size * NOISE[name] * rng.standard_normal(len(times)) for name in channels}
    return times, {name: values + noise[name] for name, values in channels.items()}


def folder_of(folder, *runs, digits=8):
    """A folder with a file for each run, as it is read."""
    about = ['bench = "valve"']
    for number, (times, channels) in enumerate(runs):
        header = ",".join(["time [ms]", *(f"{name} [{UNITS[name]}]" for name in channels)])
        table = np.column_stack([1e3 * times, *(SCALES.get(name, 1.0) * each for name, each in channels.items())])
        form = ["%.9g", *[f"%.{digits}g"] * len(channels)]
        np.savetxt(folder / f"p{number}.csv", table, form, ",", header=header, comments="")
        about += ["[[run]]", f'data = "p{number}.csv"', 'supply = "0.4 MPa gauge"', 'pulse = "50 ms"']
    (folder / "measured.toml").write_text("\n".join(about))
    return read_measured(folder, AMBIENT)


def said(measured):
    return [(str(one.kind), str(one.check)) for one in examine(MACHINE, measured).findings]


# --- what is masked ---


@pytest.mark.parametrize("share", [0.002, 0.01])
@pytest.mark.parametrize("channel", ["lift", "velocity", "pressure_a", "pressure_b"])
def test_spikes_are_masked_and_nothing_else_is(tmp_path, channel, share):
    times, channels = noisy()
    rng = np.random.default_rng(5)
    places = np.sort(rng.choice(np.arange(10, len(times) - 10, 4), round(share * len(times)), replace=False))
    spiked = channels[channel].copy()
    spiked[places] += rng.choice([-1.0, 1.0], len(places)) * np.ptp(spiked)
    measured = folder_of(tmp_path, (times, channels | {channel: spiked}))
    [masked] = measured.masked
    assert (masked.run, masked.channel, str(masked.disturbance)) == (0, channel, "spikes")
    assert masked.places == pytest.approx(times[places], abs=1e-9)
    for name, values in measured.runs[0].channels.items():
        expected = channels[name].copy()
        if name == channel:
            expected[places] = np.nan
        assert values == pytest.approx(expected, rel=1e-6, abs=1e-8, nan_ok=True)
    assert said(measured) == [("warning", "spikes")]


def test_a_small_spike_of_a_single_sample_is_masked_in_a_fine_record(tmp_path):
    """Twelve times the noise, 4 % of the span, as high as a rebound."""
    times, channels = noisy(step=0.2e-3)
    places = [np.searchsorted(times, at) for at in (2e-3, 4e-3, 30e-3, 0.1)]
    spiked = channels["lift"].copy()
    spiked[places] += 12.0 * NOISE["lift"] * np.array([1.0, -1.0, -1.0, 1.0])
    [masked] = folder_of(tmp_path, (times, channels | {"lift": spiked})).masked
    assert masked.places == pytest.approx(times[places], abs=1e-9)


@pytest.mark.parametrize("step", [0.05e-3, 0.1e-3, 0.2e-3])
def test_a_rebound_is_no_spike(step):
    machine = MACHINE.with_(**{"effects.bounce.restitution": 0.6})
    for supply in np.arange(0.2, 1.01, 0.1):
        times = np.arange(-5e-3, 0.12, step)
        asked = {"lift": times, "pressure_a": times, "pressure_b": times}
        run = MeasuredRun("a", "a.csv", supply * 1e6 + AMBIENT, 290.0, 50e-3, "fit", times, asked)
        for name, trace in predict(run_of(machine, run), run).channels.items():
            values = trace + 0.1 * NOISE[name] * np.random.default_rng(1).standard_normal(len(times))
            assert not list(find_disturbances(times, values, "time")), (supply, name)


def test_a_pair_of_samples_and_a_spike_in_flight_are_masked(tmp_path):
    times, channels = noisy()
    channels["lift"][[60, 61, 300]] = 30e-3, 31e-3, -8e-3
    measured = folder_of(tmp_path, (times, channels))
    assert np.flatnonzero(np.isnan(measured.runs[0].channels["lift"])).tolist() == [60, 61, 300]


@pytest.mark.parametrize(("first", "held"), [(60, 10), (120, 9), (250, 12)])
def test_a_value_that_is_held_is_masked(tmp_path, first, held):
    times, channels = noisy()
    channels["lift"][first : first + held] = channels["lift"][first]
    measured = folder_of(tmp_path, (times, channels))
    assert np.flatnonzero(np.isnan(measured.runs[0].channels["lift"])).tolist() == list(range(first, first + held))
    assert said(measured) == [("warning", "stuck")]


def test_a_short_clipped_stretch_of_one_run_of_three_is_masked_with_what_is_beside_it(tmp_path):
    runs = [noisy(seed=seed) for seed in range(3)]
    values = runs[1][1]["pressure_b"]
    values[150:158] = 1.2 * values.max()
    measured = folder_of(tmp_path, *runs)
    lost = np.isnan(measured.runs[1].channels["pressure_b"])
    assert np.flatnonzero(lost).tolist() == list(range(147, 161))
    assert said(measured) == [("warning", "clipped")]


def test_spikes_of_a_long_record_are_masked_before_it_is_thinned(tmp_path):
    times, channels = noisy(step=1e-6)
    spiked = channels["lift"].copy()
    spiked[50_000] = 0.5
    measured = folder_of(tmp_path, (times, {"lift": spiked}))
    assert [each.places.tolist() for each in measured.masked] == [[pytest.approx(times[50_000], abs=1e-9)]]
    assert len(measured.runs[0].times) < 10_000
    assert measured.runs[0].channels["lift"].max() < 1.02 * MACHINE.valve.stroke


# --- what is refused ---


def test_what_is_much_is_left_and_refused(tmp_path):
    rng = np.random.default_rng(5)
    times, channels = noisy()
    channels["lift"][rng.choice(np.arange(10, len(times) - 10, 4), 20, replace=False)] += 20e-3
    channels["pressure_a"][300:330] = channels["pressure_a"][300]
    measured = folder_of(tmp_path, (times, channels))
    assert measured.masked == ()
    assert not any(np.isnan(values).any() for values in measured.runs[0].channels.values())
    assert said(measured) == [("fault", "spikes"), ("fault", "stuck")]


def test_a_held_stretch_as_long_as_a_part_of_a_stroke_is_refused_in_a_long_record(tmp_path):
    times, channels = noisy(end=1.0)
    channels["lift"][60:80] = channels["lift"][60]
    measured = folder_of(tmp_path, (times, channels))
    assert 0.03 * len(times) > 20 and measured.masked == ()
    assert said(measured) == [("fault", "stuck")]


@pytest.mark.parametrize("number", [1, 2])
def test_an_end_that_clips_most_runs_is_refused(tmp_path, number):
    runs = [noisy(seed=seed) for seed in range(number + number // 2)]
    for _, channels in runs[:number]:
        channels["pressure_b"][150:158] = 1.2 * channels["pressure_b"].max()
    measured = folder_of(tmp_path, *runs)
    assert len(measured.masked) == number
    assert said(measured) == [("fault", "clipped")] * number


# --- honest records ---


@pytest.mark.parametrize("size", [0.0, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("supply", [0.14, 0.4, 1.0])
@pytest.mark.parametrize("step", [5e-5, 0.25e-3, 1e-3, 3e-3])
def test_nothing_of_an_honest_record_is_masked(tmp_path, step, supply, size):
    assert folder_of(tmp_path, noisy(supply, step, size=size)).masked == ()


@pytest.mark.parametrize("digits", [3, 4, 6])
@pytest.mark.parametrize("size", [0.0, 1.0])
def test_nothing_of_a_rounded_record_is_masked(tmp_path, size, digits):
    assert folder_of(tmp_path, noisy(size=size), digits=digits).masked == ()


@pytest.mark.parametrize("bits", [6, 8, 10, 12])
@pytest.mark.parametrize("step", [5e-5, 0.25e-3])
def test_nothing_of_a_record_of_few_bits_is_masked(tmp_path, step, bits):
    times, channels = noisy(step=step)
    coarse = {}
    for name, values in channels.items():
        least = 2.0 * np.abs(values).max() / 2**bits
        coarse[name] = np.round(values / least) * least
    assert folder_of(tmp_path, (times, coarse)).masked == ()
