"""A sweep is what its operating points are one by one, however it was computed."""

import numpy as np
import pytest
import xarray

from apesim.archive import ArchiveError, read
from apesim.archive.inspection import verify
from apesim.quantities.settings import dumps, load
from engine.cylinder import CAM, EPV, IDEAL_VALVE
from engine.indicators import indicators
from engine.machine import Machine
from engine.steady import run_steady
from studies.figures.sweep import sweep_figures
from studies.sweep import STATUS_MEANINGS, faults_of, plan, run_sweep

RPM = np.pi / 30.0
SPEEDS = [600.0 * RPM, 1200.0 * RPM]
INTAKES = [EPV, CAM, IDEAL_VALVE]


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    return run_sweep(Machine(), SPEEDS, INTAKES, tmp_path_factory.mktemp("sweep") / "sweep.h5")


def test_the_plan_is_every_intake_at_every_speed():
    points = plan(Machine(), SPEEDS, INTAKES)
    assert [point.run for point in points] == list(range(6))
    assert {(point.machine.engine.intake, point.speed) for point in points} == {(i, s) for i in INTAKES for s in SPEEDS}


def test_a_run_of_a_sweep_is_the_operating_point_alone(swept):
    archive = read(swept.path)
    v = {name: variable.values for name, variable in archive.variables.items()}
    [run] = np.flatnonzero((v["intake"] == EPV) & (v["speed_rpm"] == 1200.0))
    alone = run_steady(Machine(), SPEEDS[1])
    for name, value in indicators(Machine(), alone).items():
        np.testing.assert_array_equal(v[name][run], value, err_msg=name)
    np.testing.assert_array_equal(v["cylinder_pressure"][run], alone.trace[:, 0])
    np.testing.assert_allclose(v["crank_angle"], np.degrees(alone.angles), rtol=0, atol=1e-9)


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
        assert data["cylinder_pressure"].attrs["units"] == "Pa abs"
        torque = data["torque"].mean("crank_angle")
        np.testing.assert_allclose(torque, data["indicated_torque_Nm"], rtol=5e-3, atol=0.2)


def test_several_processes_give_the_same_bits(swept, tmp_path):
    other = run_sweep(Machine(), SPEEDS, INTAKES, tmp_path / "two.h5", jobs=2)
    for name, variable in swept.archive.variables.items():
        np.testing.assert_array_equal(variable.values, other.archive.variables[name].values, err_msg=name)


def test_a_point_that_fails_is_named_and_the_others_are_kept(tmp_path):
    machine = Machine()
    impossible = machine._replace(valve=machine.valve._replace(clearance_volume=1e-15))
    result = run_sweep(impossible, SPEEDS[:1], [EPV, CAM], tmp_path / "sweep.h5")
    assert len(result.faults) == 1 and "epv at 600 r/min" in result.faults[0]
    status = result.archive.variables["status"].values
    assert status[0] != 0 and status[1] == 0
    assert f"{status[0]} " in STATUS_MEANINGS
    torque = result.archive.variables["brake_torque_Nm"].values
    assert np.isnan(torque[0]) and torque[1] > 0.0


def test_a_point_that_is_not_periodic_is_named(swept):
    from dataclasses import replace

    variables = dict(swept.archive.variables)
    flags = variables["converged"].values.copy()
    flags[2] = 0
    variables["converged"] = replace(variables["converged"], values=flags)
    [line] = faults_of(replace(swept.archive, variables=variables))
    assert line.startswith("run 2 (cam at 600 r/min): not periodic")


def test_a_second_sweep_does_not_write_the_same_target(swept):
    with pytest.raises(ArchiveError, match="exists already"):
        run_sweep(Machine(), SPEEDS, INTAKES, swept.path)


def test_figures_are_drawn_and_the_same_each_time(swept, tmp_path):
    first = sweep_figures(swept.archive, tmp_path / "a")
    second = sweep_figures(swept.archive, tmp_path / "b")
    assert [path.name for path in first] == [path.name for path in second]
    for one, other in zip(first, second, strict=True):
        assert one.stat().st_size > 5000
        assert one.read_bytes() == other.read_bytes()
