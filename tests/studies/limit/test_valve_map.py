"""The map of the valve is its bench runs, and is drawn for any grid."""

import csv

import numpy as np
import pytest
import xarray

from apesim.archive import write
from apesim.archive.inspection import verify
from apesim.engine.machine import Machine
from apesim.studies.limit.valve_figures import map_figures, plot_velocities
from apesim.studies.limit.valve_map import compute_map, faults_of_map
from tests.folders import ACCEPTANCE

AMBIENT = Machine().ambient.pressure
REFERENCE = ACCEPTANCE / "reference-valve.csv"


@pytest.fixture(scope="module")
def paper_map():
    pressures = AMBIENT + 1e6 * np.arange(0.1, 2.0, 0.2)
    return compute_map(Machine(), pressures, np.arange(250.0, 323.0, 8.0))


def test_the_map_holds_the_rows_of_the_independent_solution():
    with open(REFERENCE) as file:
        rows = [[float(cell) for cell in row] for row in list(csv.reader(file))[1:]]
    pressures, temperatures = sorted({row[0] for row in rows}), sorted({row[1] for row in rows})
    archive = compute_map(Machine(), [AMBIENT + 1e6 * p for p in pressures], temperatures)
    v = {name: variable.values for name, variable in archive.variables.items()}
    for run, row in enumerate(rows):
        assert v["supply_pressure"][run] == pytest.approx(AMBIENT + 1e6 * row[0])
        assert v["supply_temperature"][run] == row[1]
        found = [
            v[f"{stroke}_{name}"][run] * factor
            for stroke in ("opening", "closing")
            for name, factor in (("delay_s", 1e3), ("stroke_time_s", 1e3), ("seating_speed_m_s", 1.0))
        ]
        assert found == pytest.approx(row[2:], rel=2e-5)


def test_the_papers_grid_is_ten_by_ten_and_complete(paper_map):
    assert len(paper_map.runs) == 100
    assert faults_of_map(paper_map) == []


def test_a_control_pressure_of_the_machine_does_not_stand_against_the_grid():
    machine = Machine()
    other = machine._replace(supply=machine.supply._replace(control_pressure=2e6))
    one, two = (compute_map(m, [5e5], [287.0]).variables["opening_delay_s"].values for m in (machine, other))
    np.testing.assert_array_equal(one, two)


def test_a_pulse_too_short_is_named():
    [line] = faults_of_map(compute_map(Machine(), [5e5], [287.0], pulse=2e-3))
    assert "not completed" in line and "0.5 MPa abs" in line


def test_the_archive_is_whole_and_opens_elsewhere(paper_map, tmp_path):
    path = write(paper_map, tmp_path / "map.h5")
    assert verify(path) == []
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        assert data["velocity"].dims == ("run", "time")
        assert data["opening_delay_s"].attrs["units"] == "s"


@pytest.mark.parametrize("grid", [([5e5, 9e5, 15e5], [260.0, 300.0]), ([5e5], [260.0, 300.0]), ([5e5], [287.0])])
def test_figures_are_drawn_for_any_grid(grid, tmp_path):
    names = {path.name for path in map_figures(compute_map(Machine(), *grid), AMBIENT, tmp_path)}
    kinds = ("delay_time", "stroke_time", "seating_speed", "fluctuation", "velocity")
    assert names == {f"{kind}.{ending}" for kind in kinds for ending in ("png", "pdf")}


def test_a_closing_that_takes_longer_than_the_opening_is_drawn_to_its_contact():
    late = Machine().with_(valve_solenoid_release_dead_time="15 ms")
    archive = compute_map(late, [0.5e6 + AMBIENT], [287.0], 60e-3)
    contact = sum(archive.variables[f"closing_{name}"].values[0] for name in ("delay_s", "stroke_time_s"))
    figure = plot_velocities(archive, AMBIENT)
    assert figure.axes[1].get_xlim()[1] > contact * 1e3 > 20.0
