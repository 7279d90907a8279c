"""Strokes of a cylinder: cut at the turning points, averaged over cells, read from a folder."""

import numpy as np
import pytest

from apesim.quantities import InputError
from apesim.studies.measured import CYLINDER, read_measured
from apesim.studies.measured.runs import MeasuredRun
from apesim.studies.measured.strokes import MIN_TURNING, estimate_velocity, split_record
from tests.machines import AMBIENT

LENGTH, PERIOD = 40e-3, 8.0


def clock(end, seed=1):
    """An uneven clock of about 100 Hz [s]."""
    return np.cumsum(np.random.default_rng(seed).uniform(0.008, 0.012, int(end / 0.01)))


def triangle(times):
    """A stroke that rises from 10 mm on, turns every 4 s, and so begins and ends on the way [m]."""
    return LENGTH * (1.0 - abs(1.0 - 2.0 * ((times / PERIOD + 0.125) % 1.0)))


def record(end, friction=5.0, keep=None):
    times = clock(end)
    stroke = triangle(times)
    rising = np.sign(triangle(times + 1e-6) - stroke)
    given = {"stroke": stroke, "pressure": np.full(len(times), AMBIENT + 2e5)}
    channels = {"force": 100.0 + friction * rising}
    if keep is not None:
        inside = keep(times)
        times = times[inside]
        given, channels = ({name: values[inside] for name, values in each.items()} for each in (given, channels))
    return MeasuredRun("a", "a.csv", AMBIENT + 2e5, 293.0, np.nan, "fit", times, channels, CYLINDER, given=given)


def test_the_velocity_and_its_error_hold_on_an_uneven_clock():
    times, noise = clock(60.0), 2e-5
    errors = []
    for seed in range(20):
        stroke = 0.012 * times + np.random.default_rng(seed).normal(0.0, noise, len(times))
        velocity, stated = estimate_velocity(times, stroke)
        errors.append(velocity - 0.012)
    scatter = np.std(errors, axis=0)
    assert np.mean(np.mean(errors, axis=0)) == pytest.approx(0.0, abs=1e-6)
    assert np.median(scatter[20:-20]) == pytest.approx(np.median(stated[20:-20]), rel=0.1)


def test_a_record_is_split_into_whole_ways_that_are_repeats():
    repeats = split_record(record(end=2.5 * PERIOD))
    assert len(repeats) == 2
    first, second = repeats
    assert first.times.tobytes() == second.times.tobytes()  # the noise is found from what repeats differ by
    assert first.name == second.name == "a"
    assert np.all(np.diff(first.times) > 0.0)
    for run in repeats:
        stroke, velocity = run.given["stroke"], run.given["velocity"]
        assert stroke.min() > MIN_TURNING and stroke.max() < LENGTH - MIN_TURNING
        assert np.sum(velocity > 0.0) == pytest.approx(36, abs=1)
        assert np.sum(velocity < 0.0) == pytest.approx(36, abs=1)
        assert abs(velocity) == pytest.approx(np.full(len(velocity), 0.01), rel=1e-6)
        assert run.channels["force"] == pytest.approx(100.0 + 5.0 * np.sign(velocity), rel=1e-12)


def test_what_one_repeat_lacks_is_left_out_of_all():
    whole = split_record(record(end=2.5 * PERIOD))
    holed = split_record(record(end=2.5 * PERIOD, keep=lambda times: (times < 4.0) | (times > 5.0)))
    assert len(holed) == len(whole)
    lost = len(whole[0].times) - len(holed[0].times)
    assert 9 <= lost <= 13  # 1 s at 10 mm/s, in cells of 1 mm
    assert len({run.times.tobytes() for run in holed}) == 1


def test_a_record_without_a_way_to_and_fro_is_refused():
    with pytest.raises(InputError, match=r"folder/a.csv: stroke: 0 ways to and fro"):
        split_record(record(end=2.0), "folder")


def test_a_folder_is_read_with_gauge_pressures(tmp_path):
    run = record(end=2.5 * PERIOD)
    columns = np.column_stack([run.times * 1e3, run.given["stroke"] * 1e3, np.full(len(run.times), 2.0)])
    rows = np.column_stack([columns, run.channels["force"]])
    header = "time [ms],stroke [mm],pressure [bar gauge],force [N]"
    np.savetxt(tmp_path / "a.csv", rows, "%.9g", ",", header=header, comments="")
    toml = 'bench = "cylinder"\n[[run]]\ndata = "a.csv"\nsupply = "2 bar gauge"\nrole = "fit"\n'
    (tmp_path / "measured.toml").write_text(toml)
    measured = read_measured(tmp_path, AMBIENT)
    assert measured.bench == CYLINDER
    assert len(measured.runs) == 2
    assert measured.runs[0].given["pressure"] == pytest.approx(AMBIENT + 2e5)
    assert measured.runs[0].channels.keys() == {"force"}


@pytest.mark.parametrize("lacking", ["stroke", "pressure", "force"])
def test_columns_that_are_due_are_asked_for(tmp_path, lacking):
    heads = {"time": "ms", "stroke": "mm", "pressure": "bar gauge", "force": "N"}
    names = [name for name in heads if name != lacking]
    rows = "".join(",".join([f"{i}"] * len(names)) + "\n" for i in range(20))
    (tmp_path / "a.csv").write_text(",".join(f"{name} [{heads[name]}]" for name in names) + "\n" + rows)
    toml = 'bench = "cylinder"\n[[run]]\ndata = "a.csv"\nsupply = "2 bar gauge"\nrole = "fit"\n'
    (tmp_path / "measured.toml").write_text(toml)
    with pytest.raises(InputError) as caught:
        read_measured(tmp_path, AMBIENT)
    said = str(caught.value)
    assert ("no column of a sensor" in said) == (lacking == "force")
    assert (f"{lacking}: there is no such column" in said) == (lacking != "force")


def test_a_missing_cell_costs_its_row():
    run = record(end=2.5 * PERIOD)
    force = run.channels["force"].copy()
    force[500:503] = np.nan
    missing = run._replace(channels={"force": force})
    kept = np.isfinite(force)
    given = {name: values[kept] for name, values in run.given.items()}
    without = run._replace(times=run.times[kept], channels={"force": force[kept]}, given=given)
    for a, b in zip(split_record(missing), split_record(without), strict=True):
        assert a.channels["force"].tobytes() == b.channels["force"].tobytes()


def test_all_records_without_a_way_are_said_at_once(tmp_path):
    run = record(end=2.0)
    rows = np.column_stack([run.times * 1e3, run.given["stroke"] * 1e3, np.full(len(run.times), 2.0), run.times])
    toml = 'bench = "cylinder"\n'
    for name in ("a.csv", "b.csv"):
        np.savetxt(tmp_path / name, rows, "%.9g", ",", header="time [ms],stroke [mm],pressure [bar gauge],force [N]")
        text = (tmp_path / name).read_text().removeprefix("# ")
        (tmp_path / name).write_text(text)
        toml += f'[[run]]\ndata = "{name}"\nsupply = "2 bar gauge"\nrole = "fit"\n'
    (tmp_path / "measured.toml").write_text(toml)
    with pytest.raises(InputError) as caught:
        read_measured(tmp_path, AMBIENT)
    assert [fault.key for fault in caught.value.faults] == ["stroke", "stroke"]
