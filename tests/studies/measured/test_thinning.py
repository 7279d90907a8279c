"""Thinning: long records become means over what the model does not resolve, and short ones stay as they are."""

import numpy as np
import pytest

from apesim.engine.angles import DEGREE
from apesim.studies.measured import read_measured
from apesim.studies.measured.thinning import MAX_ROWS, RESOLVED, thin
from tests.machines import AMBIENT


def test_a_short_record_stays_to_the_bit():
    times = 1e-9 * np.arange(MAX_ROWS)
    columns = {"time": times, "lift": times.copy()}
    thinned, hints = thin(columns, "time")
    assert thinned["time"] is times and thinned["lift"] is columns["lift"] and hints == []


def test_a_record_as_coarse_as_the_model_stays():
    times = RESOLVED["time"] * np.arange(MAX_ROWS + 1)
    thinned, hints = thin({"time": times}, "time")
    assert thinned["time"] is times and hints == []


@pytest.mark.parametrize(("axis", "interval"), [("time", 3.1e-7), ("crank_angle", 0.013 * DEGREE)])
def test_means_keep_what_varies_slowly_and_lose_what_would_fold(axis, interval):
    number = int(RESOLVED[axis] / interval)
    places = interval * (np.arange(4 * MAX_ROWS) - 1000.3)
    slow = np.sin(2.0 * np.pi * places / (4000.0 * interval))
    fast = np.sin(2.0 * np.pi * places / (number * interval))  # left out rows would make a constant of it
    thinned, [hint] = thin({axis: places, "slow": slow, "fast": 1.0 + fast}, axis)
    spacing = np.diff(thinned[axis])
    assert spacing == pytest.approx(number * interval, rel=1e-6)
    assert spacing.max() <= RESOLVED[axis]
    assert thinned["slow"] == pytest.approx(np.sin(2.0 * np.pi * thinned[axis] / (4000.0 * interval)), abs=1e-3)
    assert thinned["fast"] == pytest.approx(1.0, abs=1e-6)
    assert hint.startswith(f"{len(places)} rows are thinned to {len(spacing) + 1} means of {number} rows")


def test_no_mean_has_rows_before_and_after_the_command():
    times = 1e-6 * (np.arange(2 * MAX_ROWS) - 777.0)
    after = (times >= 0.0).astype(float)
    thinned, _ = thin({"time": times, "after": after}, "time")
    assert set(thinned["after"].tolist()) == {0.0, 1.0}
    assert np.array_equal(thinned["after"] == 1.0, thinned["time"] > 0.0)


def test_missing_cells_are_left_out_of_means():
    times = 1e-6 * np.arange(2 * MAX_ROWS)
    lift = np.ones(len(times))
    lift[::3] = np.nan
    lift[200:320] = np.nan
    thinned, _ = thin({"time": times, "lift": lift}, "time")
    assert np.flatnonzero(np.isnan(thinned["lift"])).tolist() == list(range(10, 16))
    assert np.all(thinned["lift"][~np.isnan(thinned["lift"])] == 1.0)


def test_uneven_rows_are_thinned_by_their_times():
    rng = np.random.default_rng(1)
    times = np.cumsum(rng.uniform(0.5e-6, 1.5e-6, 2 * MAX_ROWS))
    thinned, _ = thin({"time": times, "lift": 2.0 * times}, "time")
    assert thinned["lift"] == pytest.approx(2.0 * thinned["time"])
    assert np.all(np.diff(thinned["time"]) > 0.5 * RESOLVED["time"])


def test_a_long_file_is_thinned_and_says_so(tmp_path):
    number = 4 * MAX_ROWS
    times = 2.5e-4 * np.arange(number)
    text = "".join(f"{t:.5f},{t:.4f}\n" for t in times.tolist())
    (tmp_path / "a.csv").write_text(f"time [ms],lift [um]\n{text}")
    about = 'bench = "valve"\n[[run]]\ndata = "a.csv"\nsupply = "5 bar abs"\npulse = "50 ms"\n'
    (tmp_path / "measured.toml").write_text(about)
    measured = read_measured(tmp_path, AMBIENT)
    [run] = measured.runs
    assert measured.hints == (
        "a.csv: 400000 rows are thinned to 5000 means of 80 rows; a stated noise is that of a mean",
    )
    assert 1e6 * run.channels["lift"] == pytest.approx(1e3 * run.times, abs=1e-4)
