"""A sweep is what its operating points are one by one, however it was computed."""

import json

import numpy as np
import pytest
import xarray
from rich.console import Console as Terminal

from apesim.archive import ArchiveError, read
from apesim.archive.grid import read_grid
from apesim.archive.inspection import verify
from apesim.engine.angles import DEGREE
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cylinder import CAM, EPV, IDEAL_VALVE
from apesim.engine.indicators import indicators
from apesim.engine.machine import Machine
from apesim.engine.steady import run_steady
from apesim.engine.warnings import judge_point
from apesim.quantities.settings import dumps, load
from apesim.studies.run.march_status import STATUS_MEANINGS
from apesim.studies.sweep import CORRECTED, FIXED, TIMINGS, run_sweep
from apesim.studies.sweep.compute import WARNING_FLAGS, compute
from apesim.studies.sweep.figures import plot_cycle, plot_over_speed, sweep_figures
from apesim.studies.sweep.plan import actuation_of, in_one_unit, plan
from apesim.studies.sweep.results import archive_of, faults_of, warnings_of
from apesim.studies.sweep.table import MAX_ROWS_SHOWN, sweep_table
from apesim.studies.sweep.variation import Variation
from apesim.studies.timing import Reason
from apesim.valve.groove import area_table, lap_of

RPM = np.pi / 30.0
SPEEDS = [600.0 * RPM, 1200.0 * RPM]
INTAKES = [EPV, CAM, IDEAL_VALVE]
EPV_FIXED, EPV_CORRECTED, BY_CAM, IDEAL = range(4)
ONE = Variation((), (Machine(),))


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    return run_sweep(Machine(), SPEEDS, INTAKES, tmp_path_factory.mktemp("sweep") / "sweep.h5", timings=TIMINGS)


def values_of(archive, actuation, speed_rpm):
    """All results of one run by name."""
    v = {name: variable.values for name, variable in archive.variables.items()}
    [run] = np.flatnonzero((v["actuation"] == actuation) & (v["speed_rpm"] == speed_rpm))
    return {name: values[run] for name, values in v.items() if name != "crank_angle"}


def test_the_plan_is_every_intake_at_every_speed():
    points = plan(ONE, SPEEDS, INTAKES).points
    assert [point.run for point in points] == list(range(6))
    assert {(point.machine.engine.intake, point.speed) for point in points} == {(i, s) for i in INTAKES for s in SPEEDS}


@pytest.mark.parametrize(
    ("timings", "expected"),
    [
        ((FIXED,), [EPV_FIXED, BY_CAM, IDEAL]),
        ((CORRECTED,), [EPV_CORRECTED, BY_CAM, IDEAL]),
        (TIMINGS, [EPV_FIXED, EPV_CORRECTED, BY_CAM, IDEAL]),
    ],
)
def test_only_commands_of_an_electro_pneumatic_valve_are_corrected(timings, expected):
    planned = plan(ONE, SPEEDS[:1], INTAKES, timings)
    assert [actuation_of(point) for point in planned.points] == expected


def test_a_run_of_a_sweep_is_the_operating_point_alone(swept):
    archive = read(swept.path)
    found = values_of(archive, EPV_FIXED, 1200.0)
    alone = run_steady(Machine(), SPEEDS[1])
    for name, value in indicators(Machine(), alone).items():
        np.testing.assert_array_equal(found[name], value, err_msg=name)
    np.testing.assert_array_equal(found["cylinder_pressure"], alone.trace[:, 0])
    np.testing.assert_allclose(archive.variables["crank_angle"].values, np.degrees(alone.angles), rtol=0, atol=1e-9)
    assert (found["energise_deg"], found["release_deg"]) == pytest.approx((-5.0, 70.0), abs=1e-12)
    assert found["timing_reason"] == -1


def test_a_sweep_without_traces_is_the_same_but_for_them(swept, tmp_path):
    bare = run_sweep(Machine(), SPEEDS, INTAKES, tmp_path / "bare.h5", timings=TIMINGS, traces=False).archive
    whole = {name: one for name, one in swept.archive.variables.items() if "crank_angle" not in one.dims}
    assert bare.variables.keys() == whole.keys() != swept.archive.variables.keys()
    for name, variable in whole.items():
        np.testing.assert_array_equal(bare.variables[name].values, variable.values, err_msg=name)
    spared = swept.path.stat().st_size - (tmp_path / "bare.h5").stat().st_size
    assert spared > swept.archive.variables["lift"].values.nbytes * len(TRACE)
    drawn = {path.stem for path in sweep_figures(bare, tmp_path / "bare.figures")}
    assert drawn == {"torque_and_air"}
    with pytest.raises(ArchiveError, match="exists"):
        run_sweep(Machine(), SPEEDS, INTAKES, tmp_path / "bare.h5", timings=TIMINGS, resume=True)


def test_traces_that_could_not_be_read_again_are_refused_before_anything_is_run(tmp_path, monkeypatch):
    speeds = list(np.linspace(30.0, 250.0, 70_000))
    told = r"70000 runs with traces, 4\.4 GB; that is more than apesim reads of an archive, 4\.3 GB; .*--no-traces"
    monkeypatch.setattr("apesim.studies.sweep.run.available_memory", lambda: 100e9)
    with pytest.raises(ArchiveError, match=told):
        run_sweep(Machine(), speeds, [IDEAL_VALVE], tmp_path / "s.h5")
    monkeypatch.setattr("apesim.studies.sweep.run.available_memory", lambda: 1e6)
    with pytest.raises(ArchiveError, match=r"than the memory can hold while it is written, 0\.0 GB"):
        run_sweep(Machine(), speeds[:20], [IDEAL_VALVE], tmp_path / "s.h5")
    assert list(tmp_path.iterdir()) == []
    assert len(run_sweep(Machine(), speeds[:2], [IDEAL_VALVE], tmp_path / "s.h5", traces=False).archive.runs) == 2


def test_a_run_of_a_sweep_has_the_warnings_of_the_operating_point_alone(tmp_path):
    speeds = [1000.0 * RPM, 1800.0 * RPM, 6000.0 * RPM]
    archive = read(run_sweep(Machine(), speeds, [EPV], tmp_path / "s.h5").path)
    for run, speed in enumerate(speeds):
        alone = run_steady(Machine(), speed)
        expected = judge_point(Machine(), alone, indicators(Machine(), alone))
        assert archive.variables["warnings"].values[run] == len(expected) == (0, 2, 2)[run]
        assert {w for w, flag in WARNING_FLAGS.items() if archive.variables[flag].values[run] == 1} == set(expected)
    assert [line.partition(":")[0] for line in warnings_of(archive)] == [
        "brake work is not positive",
        "the valve does not open",
        "the valve does not open fully",
    ]


def test_an_incomplete_stroke_stands_in_the_archive_the_table_and_the_figure(swept):
    where = {"actuation": "epv corrected", "speed_rpm": 1200.0}
    data = read_grid(swept.path)
    assert data["lift"].sel(where).max() < Machine().valve.stroke - 0.1e-3
    [flag] = [flag for flag in WARNING_FLAGS.values() if (data[flag] == 1).any()]
    assert flag == "warning_opens_partly"
    assert data[flag].sum() == 1 and data[flag].sel(where) == 1 and data["warnings"].sum() == 1

    terminal = Terminal(width=120)
    with terminal.capture() as captured:
        terminal.print(sweep_table(swept.archive))
    *_, slow, fast = [line.split() for line in captured.get().splitlines() if line.strip()]
    assert [cell.endswith("*") for cell in fast] == [False, *2 * [False, True, False, False]]
    assert not any("*" in cell for cell in slow) and "incomplete stroke" in captured.get()

    left, right = plot_over_speed(swept.archive).axes
    for axis in (left, right):
        hollow = [x for line in axis.lines if line.get_markerfacecolor() == "white" for x in line.get_xdata()]
        assert hollow == [1200.0]


def test_of_a_long_table_the_first_rows_are_shown_and_how_many_there_are():
    speeds = RPM * np.linspace(600.0, 2400.0, MAX_ROWS_SHOWN + 1)
    planned = plan(Variation((), (Machine(),)), speeds, [IDEAL_VALVE])
    results = MAX_ROWS_SHOWN * compute(planned.points[:1], traces=False)
    archive = archive_of(planned.points[:-1], results, planned.variation, "", {"axes": json.dumps(planned.axes)})
    assert sweep_table(archive).row_count == MAX_ROWS_SHOWN
    assert "rows" not in str(sweep_table(archive).title)
    archive = archive_of(planned.points, [*results, results[0]], planned.variation, "", archive.provenance)
    table = sweep_table(archive)
    assert table.row_count == MAX_ROWS_SHOWN
    assert str(table.title).endswith(
        f"; {MAX_ROWS_SHOWN} of {MAX_ROWS_SHOWN + 1} rows, all of which are in the archive"
    )


@pytest.mark.parametrize("speed_rpm", [600.0, 1200.0])
def test_corrected_commands_meet_the_targets_and_are_told(swept, speed_rpm):
    archive = read(swept.path)
    found = values_of(archive, EPV_CORRECTED, speed_rpm)
    angles, lift = archive.variables["crank_angle"].values, found["lift"]
    machine = Machine()
    above = lift - lap_of(area_table(machine.groove, machine.valve.stroke))
    falls = np.flatnonzero((above[:-1] >= 0.0) & (above[1:] < 0.0))
    assert len(falls) == 1
    at = falls[0]
    assert angles[at] + 0.5 * above[at] / (above[at] - above[at + 1]) == pytest.approx(70.0, abs=0.1)
    assert abs(above[0]) < 0.1e-3  # the traces begin at the target of the opening
    assert found["valve_open_deg"] % 360.0 == pytest.approx(355.0, abs=0.05)
    command = machine.command._replace(energise=found["energise_deg"] * DEGREE, release=found["release_deg"] * DEGREE)
    alone = indicators(
        machine._replace(command=command), run_steady(machine._replace(command=command), speed_rpm * RPM)
    )
    for name in ("brake_torque_Nm", "specific_air_kg_per_kWh", "valve_close_deg"):
        assert found[name] == pytest.approx(alone[name], rel=1e-6), name


def test_traces_of_all_runs_stand_at_the_same_crank_angles(swept):
    """A corrected cycle starts elsewhere; its samples come from the dense output at the common angles."""
    archive = read(swept.path)
    found = values_of(archive, EPV_CORRECTED, 1200.0)
    machine = Machine()
    command = machine.command._replace(energise=found["energise_deg"] * DEGREE, release=found["release_deg"] * DEGREE)
    alone = run_steady(machine._replace(command=command), SPEEDS[1], angle_step=0.01 * DEGREE)
    angles = archive.variables["crank_angle"].values
    own = np.degrees(alone.angles)
    for number, name in ((0, "cylinder_pressure"), (2, "lift"), (10, "cylinder_volume")):
        expected = np.interp(own[0] + (angles - own[0]) % 360.0, own, alone.trace[:, number])
        np.testing.assert_allclose(found[name], expected, rtol=0, atol=2e-5 * np.ptp(expected), err_msg=name)


def test_a_point_out_of_reach_is_kept_with_its_reason(tmp_path):
    machine = Machine()
    machine = machine._replace(command=machine.command._replace(close_target=-4.5 * DEGREE))
    result = run_sweep(machine, [2400.0 * RPM], [EPV, CAM], tmp_path / "sweep.h5", timings=TIMINGS)
    assert verify(result.path) == []
    found = values_of(result.archive, EPV_CORRECTED, 2400.0)
    assert found["timing_reason"] == Reason.OPEN_TOO_LONG and found["status"] == -1
    numbers = ("brake_torque_Nm", "engine_air_kg_per_cycle", "energise_deg", "release_deg", "peak_lift_m")
    assert all(np.isnan(found[name]) for name in numbers) and np.isnan(found["lift"]).all()
    assert found["speed_rpm"] == 2400.0
    assert {found[name] for name in ("warnings", *WARNING_FLAGS.values())} == {-1}
    [line] = result.faults
    assert "epv corrected, 2400 r/min" in line and Reason(found["timing_reason"]).remedy in line
    assert np.isfinite(values_of(result.archive, EPV_FIXED, 2400.0)["brake_torque_Nm"])


def test_the_archive_is_whole_and_knows_its_machine(swept, tmp_path):
    assert verify(swept.path) == []
    archive = read(swept.path)
    path = tmp_path / "machine.toml"
    path.write_text(archive.machine)
    assert dumps(load(Machine, path)) == archive.machine == dumps(Machine())
    assert all(variable.unit for variable in archive.variables.values())
    assert all(variable.dims[0] in ("run", "crank_angle") for variable in archive.variables.values())


def test_other_programs_read_it_by_name_and_unit(swept):
    with xarray.open_dataset(swept.path, engine="h5netcdf") as data:
        assert data["cylinder_pressure"].dims == ("run", "crank_angle")
        assert data["cylinder_pressure"].attrs["units"] == "Pa"
        torque = data["torque"].mean("crank_angle")
        np.testing.assert_allclose(torque, data["indicated_torque_Nm"], rtol=5e-3, atol=0.2)


def test_several_processes_give_the_same_bits(swept, tmp_path):
    other = run_sweep(Machine(), SPEEDS, INTAKES, tmp_path / "two.h5", timings=TIMINGS, jobs=2)
    for name, variable in swept.archive.variables.items():
        np.testing.assert_array_equal(variable.values, other.archive.variables[name].values, err_msg=name)


def test_a_point_that_fails_is_named_and_the_others_are_kept(tmp_path):
    machine = Machine()
    impossible = machine._replace(valve=machine.valve._replace(clearance_volume=1e-15))
    result = run_sweep(impossible, SPEEDS[:1], [EPV, CAM], tmp_path / "sweep.h5")
    assert len(result.faults) == 1 and "epv, 600 r/min" in result.faults[0]
    status = result.archive.variables["status"].values
    assert status[0] != 0 and status[1] == 0
    assert f"{status[0]} " in STATUS_MEANINGS
    torque = result.archive.variables["brake_torque_Nm"].values
    assert np.isnan(torque[0]) and torque[1] > 0.0


def test_a_point_that_is_not_periodic_is_named(swept):
    from dataclasses import replace

    variables = dict(swept.archive.variables)
    flags = variables["converged"].values.copy()
    flags[4] = 0
    variables["converged"] = replace(variables["converged"], values=flags)
    [line] = faults_of(replace(swept.archive, variables=variables))
    assert line.startswith("run 4 (cam, 600 r/min): not periodic")


def test_a_second_sweep_does_not_write_the_same_target(swept):
    remedy = "exists already, finished on .* UTC, 8 runs; give --overwrite to compute it again, or choose another --out"
    with pytest.raises(ArchiveError, match=remedy):
        run_sweep(Machine(), SPEEDS, INTAKES, swept.path)


def test_the_traces_show_each_intake_whole(swept):
    lift = plot_cycle(swept.archive, speed_rpm=600.0).axes[0]
    assert len(lift.lines) == 4
    for line in lift.lines:
        angle, values = line.get_data()
        assert angle[0] == pytest.approx(-90.0, abs=0.5) and angle[-1] == pytest.approx(270.0, abs=1.0)
        assert (np.diff(angle) > 0.0).all()
        assert np.count_nonzero(np.diff(values > 0.0)) == 2, "it opens once and closes once within the window"


def test_figures_are_drawn_and_the_same_each_time(swept, tmp_path):
    first = sweep_figures(swept.archive, tmp_path / "a")
    second = sweep_figures(swept.archive, tmp_path / "b")
    assert [path.name for path in first] == [path.name for path in second]
    for one, other in zip(first, second, strict=True):
        assert one.stat().st_size > 5000
        assert one.read_bytes() == other.read_bytes()


def test_numbers_of_one_unit_are_told_from_words():
    assert in_one_unit(["0.6 MPa gauge", "1 MPa gauge"]) == (["0.6", "1"], "MPa gauge")
    assert in_one_unit(["1.3", "1.4"]) == (["1.3", "1.4"], "")
    for words in (["ideal", "thermally_perfect"], ["1 L", "inf"], ["curve a.csv", "curve b.csv"]):
        assert in_one_unit(words) == (words, "")
