"""The working limit of the valve is where its strokes stop being complete."""

import json

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.limit.points import Point
from apesim.studies.limit.valve_figures import limit_figures
from apesim.studies.limit.valve_limit import (
    CRITERION,
    RESOLUTION,
    faults_of_limits,
    is_complete,
    limit_map,
    working_limit,
)
from apesim.studies.run.operating_conditions import with_supply
from tests.machines import changed

AMBIENT = Machine().ambient.pressure


@pytest.mark.parametrize("pressure", [0.2e6, 1.0e6])
@pytest.mark.parametrize("duty", [0.3, 0.5])
def test_strokes_are_complete_just_below_the_limit_and_not_just_above(pressure, duty):
    machine = with_supply(Machine(), AMBIENT + pressure, 287.0)
    limit = working_limit(machine, duty).limit
    assert is_complete(machine, limit, duty)
    assert not is_complete(machine, limit + 2.0 * RESOLUTION, duty)


def test_opening_and_closing_change_places_with_the_duty():
    # The springs are antisymmetric, so a short pulse to open is a short pause to close.
    machine = with_supply(Machine(), AMBIENT + 0.4e6, 287.0)
    assert working_limit(machine, 0.3).limit == pytest.approx(working_limit(machine, 0.7).limit, rel=2e-3)


def test_the_limit_falls_with_viscous_friction_and_rises_with_the_solenoids_area():
    machine = Machine()
    valve = machine.valve
    solenoid = valve.solenoid._replace(effective_area=2.0 * valve.solenoid.effective_area)
    plain = working_limit(machine).limit
    assert working_limit(machine._replace(valve=valve._replace(viscous_friction=400.0))).limit < plain
    assert working_limit(machine._replace(valve=valve._replace(solenoid=solenoid))).limit > plain


def test_a_valve_that_its_springs_hold_has_no_limit():
    machine = with_supply(Machine(), AMBIENT + 2e3, 287.0)
    stiff = machine._replace(valve=machine.valve._replace(spring_rate=1e5))
    assert np.isnan(working_limit(stiff).limit)


def test_the_archive_states_its_criterion_and_counts_a_turn_an_event(tmp_path):
    archive = limit_map(Machine(), [AMBIENT + 0.3e6], [287.0], [0.3, 0.5])
    assert archive.provenance["criterion"] == CRITERION
    limit, speed = (archive.variables[name].values for name in ("limit_hz", "limit_rpm"))
    np.testing.assert_allclose(speed, 60.0 * limit)
    assert not np.isnan(limit).any()
    assert all(path.stat().st_size > 5000 for path in limit_figures(archive, AMBIENT, tmp_path))


def test_a_short_pulse_takes_the_same_time_from_lap_to_lap_at_any_duty():
    limits = {duty: working_limit(Machine(), duty) for duty in (0.15, 0.3)}
    assert limits[0.15].limit < 0.6 * limits[0.3].limit
    # That of the engine's design rule, which knows no bench; an independent program has 10.93 ms.
    assert [limit.open_time for limit in limits.values()] == pytest.approx([10.93e-3] * 2, rel=1e-3)


def test_the_machine_s_own_limit_is_that_of_its_own_air_and_commands():
    own = changed(Machine(), {"supply.control_pressure": AMBIENT + 0.4e6, "command.release": 1.0})
    archive = limit_map(own, [AMBIENT + 0.2e6], [287.0], [0.3])
    v = {name: variable.values for name, variable in archive.variables.items()}
    duty = (1.0 - own.command.energise) / (2.0 * np.pi)
    assert v["point"].tolist() == [Point.GRID, Point.OWN] and v["duty"][1] == duty
    assert v["limit_hz"][1] == working_limit(own, duty).limit


def test_the_command_states_the_machine_s_own_limit_and_where_the_lowest_of_the_grid_is(apesim):
    grid = ["--pressure", "0.2 MPa gauge, 1 MPa gauge", "--temperature", "287 K", "--duty", "0.3", "--no-figures"]
    code, out, _ = apesim("valve", "limit", *grid, "--json")
    data = json.loads(out)
    machine = Machine()
    assert code == 0 and data["criterion"] == CRITERION
    assert data["limit_hz"] == working_limit(machine, 75.0 / 360.0).limit == pytest.approx(data["limit_rpm"] / 60.0)
    assert data["limit_at"]["supply_pressure_Pa"] == AMBIENT + 1e6
    lowest = working_limit(with_supply(machine, AMBIENT + 0.2e6, 287.0), 0.3).limit
    assert data["min_limit_hz"] == lowest and data["min_limit_at"]["supply_pressure_Pa"] == AMBIENT + 0.2e6
    assert data["design_rule"]["lap_to_lap_s"] == pytest.approx(10.93e-3, rel=1e-3)
    assert data["paper"]["window_for_30_hz_deg"] == pytest.approx(117.0, abs=0.2)
    code, out, _ = apesim("valve", "limit", *grid, "--overwrite")
    assert code == 0 and "own" in out and "lowest" in out and "10.93" in out


def test_any_number_of_processes_finds_the_same_limits():
    grid = [AMBIENT + 0.2e6, AMBIENT + 1.0e6], [287.0], [0.3, 0.5]
    reports = []
    one = limit_map(Machine(), *grid, jobs=1)
    two = limit_map(Machine(), *grid, jobs=2, report=lambda *done: reports.append(done))
    assert reports == [(done, 5) for done in (1, 2, 3, 4, 5)]
    assert one.variables.keys() == two.variables.keys()
    for name, variable in one.variables.items():
        np.testing.assert_array_equal(variable.values, two.variables[name].values)
    for run, (pressure, duty) in enumerate((p, d) for p in grid[0] for d in grid[2]):
        expected = working_limit(with_supply(Machine(), pressure, 287.0), duty).limit
        assert two.variables["limit_hz"].values[run] == expected


def test_points_without_a_limit_are_named():
    machine = Machine()._replace(valve=Machine().valve._replace(spring_rate=1e5))
    archive = limit_map(machine, [AMBIENT + 2e3], [287.0], [0.5])
    [line] = faults_of_limits(archive)
    assert "run 0 (0.103325 MPa abs, 287 K, duty 0.5)" in line and "not even 1 Hz" in line
