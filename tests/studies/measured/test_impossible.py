"""What no rig can show is masked with a warning or refused, in blocks of any length, and never passes."""

import numpy as np
import pytest

import apesim
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.measured import Measured, read_measured
from apesim.studies.measured.arguments import open_measured
from apesim.studies.measured.plausibility import examine
from apesim.studies.measured.plausibility.impossible import mask_impossible
from tests.machines import AMBIENT
from tests.studies.measured.test_disturbances import folder_of, noisy
from tests.studies.measured.test_plausibility import engine

MACHINE = Machine()
IMPOSSIBLE = [
    ("lift", 1e34),
    ("lift", 9.999),
    ("lift", -1e-3),
    ("pressure_a", 1e40),
    ("pressure_a", 9.999e6),
    ("pressure_b", -1e3),
    ("velocity", 9999.0),
    ("temperature_a", -1.0),
]


def with_block(values, first, length, value):
    values = values.copy()
    values[first : first + length] = value
    return values


def said(measured):
    _, measured, _ = open_measured("check", MACHINE, measured)
    return measured, [(str(one.kind), str(one.check)) for one in examine(MACHINE, measured).findings]


@pytest.mark.parametrize("length", [3, 5, 12, 20])
@pytest.mark.parametrize("at", [-2e-3, 7.5e-3, 54e-3])
@pytest.mark.parametrize(("channel", "value"), IMPOSSIBLE)
def test_a_block_of_what_cannot_be_is_masked_or_refused_on_the_bench_of_the_valve(tmp_path, channel, value, at, length):
    times, channels = noisy()
    first = int(np.searchsorted(times, at))
    spoilt = channels | {channel: with_block(channels[channel], first, length, value)}
    measured, found = said(folder_of(tmp_path, (times, spoilt)))
    if length > 12:  # longer than 4 ms, and more than 3 %
        assert found == [("fault", "impossible values")]
        return
    assert found == [("warning", "impossible values")]
    lost = np.flatnonzero(np.isnan(measured.runs[0].channels[channel]))
    assert {*range(first, first + length)} <= {*lost} and len(lost) <= length + 6


@pytest.mark.parametrize("length", [3, 5, 20])
@pytest.mark.parametrize("first", [0, 8, 60, 200])
@pytest.mark.parametrize(
    ("channel", "value"),
    [("lift", 1e34), ("lift", 9.999), ("lift", -1e-3), ("cylinder_pressure", -1e3), ("cylinder_pressure", 9.999e6)],
)
def test_a_block_of_what_cannot_be_is_masked_or_refused_on_the_bench_of_the_engine(channel, value, first, length):
    run = engine()
    spoilt = run._replace(channels=run.channels | {channel: with_block(run.channels[channel], first, length, value)})
    measured, found = said(Measured("measured", {}, (spoilt,), run.bench))
    assert found == [("fault" if length > 8 else "warning", "impossible values")]
    assert bool(measured.masked) == (length <= 8)


def test_what_is_masked_is_said_with_its_value_and_its_place(tmp_path):
    times, channels = noisy()
    spoilt = channels | {"lift": with_block(channels["lift"], 50, 5, -1e-3)}
    _, measured, _ = open_measured("check", MACHINE, folder_of(tmp_path, (times, spoilt)))
    [finding] = examine(MACHINE, measured).findings
    assert "-1 mm" in finding.seen and "7.5 to 8.5 ms" in finding.seen and "masked" in finding.seen


def test_nothing_of_what_can_be_is_masked():
    for seed in range(5):
        for run in (engine(rpm=2000.0, seed=seed), engine(seed=seed)):
            measured = Measured("measured", {}, (run,), run.bench)
            assert mask_impossible(MACHINE, measured) is measured


def test_a_unit_that_is_wrong_is_still_named():
    run = engine()
    measured = Measured("measured", {}, (run._replace(channels={"lift": 1e3 * run.channels["lift"]}),), run.bench)
    _, found = said(measured)
    assert found == [("fault", "lift out of its range")]


def test_samples_that_cannot_be_leave_a_fit_where_it_was(tmp_path):
    times, channels = noisy(seed=1)
    first = int(np.searchsorted(times, 7.5e-3))
    intervals = []
    for name, length in (("clean", 0), ("spoilt", 5)):
        folder = tmp_path / name
        folder.mkdir()
        folder_of(folder, (times, {"lift": with_block(channels["lift"], first, length, -1e-3)}))
        with (folder / "measured.toml").open("a") as about:
            about.write('\ntemperature = "290 K"\n')
        fit = apesim.fit(folder, ["valve.viscous_friction"])
        intervals.append(fit.interval_95["valve.viscous_friction"])
        assert intervals[-1][0] < 111.08 < intervals[-1][1]
    assert np.ptp(intervals[1]) < 1.5 * np.ptp(intervals[0])


def test_what_cannot_be_is_refused_where_samples_are_averaged(tmp_path):
    times = np.arange(0.0, 22.0, 0.01)
    stroke = 20.0 * np.abs((times + 1.0) % 8.0 / 2.0 - 2.0)
    force = 50.0 + 5.0 * np.sign(np.gradient(stroke))
    (tmp_path / "measured.toml").write_text('bench = "cylinder"\n[[run]]\ndata = "a.csv"\nsupply = "2 bar gauge"\n')
    for column, value in (("force", 1e37), ("pressure", -1.0)):
        columns = {"time [ms]": 1e3 * times, "stroke [mm]": stroke, "pressure [kPa abs]": 0.0 * times + 300.0}
        columns["force [N]"] = force
        name = next(name for name in columns if name.startswith(column))
        columns[name] = with_block(columns[name], 300, 5, value)
        table = np.column_stack([*columns.values()])
        np.savetxt(tmp_path / "a.csv", table, "%.9g", ",", header=",".join(columns), comments="")
        with pytest.raises(InputError, match=f"{column}: 5 values cannot be, the first in row 301"):
            read_measured(tmp_path, AMBIENT)
