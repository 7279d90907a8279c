"""The engine's limit is where its targets, full strokes or repetition stop being had, and what fails first is named."""

import json

import numpy as np
import pytest

from apesim.archive.inspection import verify
from apesim.engine.angles import DEGREE
from apesim.engine.machine import Machine
from apesim.studies.limit.design_rule import MAX_WINDOW, PAPER_RPM, DesignRule, fit_rule, rule_columns
from apesim.studies.limit.engine_figures import engine_limit_figures
from apesim.studies.limit.engine_limit import (
    CRITERION,
    RESOLUTION,
    STEP_UP,
    Failure,
    _bisected,
    _scanned,
    engine_limit,
    failure_of,
    judged,
    lasting,
    map_engine_limit,
)
from apesim.studies.run.operating_conditions import Supplies, with_supply
from apesim.studies.timing.solve import Reason, corrected
from tests.machines import RPM, changed, machine, settled

AMBIENT = Machine().ambient.pressure


@pytest.fixture(scope="module")
def found():
    return engine_limit(machine())


def test_the_engine_does_at_the_limit_what_the_criterion_says(found):
    run = settled(found.timing.machine, found.limit / RPM, angle_step=0.05 * DEGREE)
    lift, angle = run.trace[:, 2], np.degrees(run.angles)
    assert run.orbit.period == 1
    assert lift.max() == pytest.approx(9e-3, abs=1e-7) and lift.min() == pytest.approx(0.0, abs=1e-9)
    opened = angle[lift > 1e-3]
    # The trace has a row every 0.05 deg, and the commands may use half a degree on either side.
    assert -5.5 <= opened[0] <= -4.45 and 69.45 <= opened[-1] <= 70.5


def test_just_above_the_limit_it_does_not_and_full_lift_fails_first(found):
    assert judged(machine(), found.limit)[0] == Failure.NONE
    assert judged(machine(), found.limit + 2.0 * RESOLUTION)[0] == Failure.FULL_LIFT == found.fails
    assert np.isnan(found.works_again)


def test_the_half_degree_on_either_side_is_made_use_of(found):
    # At the targets themselves the piston turns back earlier: full lift takes the same time from lap to lap.
    exact = corrected(machine(), found.limit)
    assert exact.reachable and failure_of(exact) == Failure.FULL_LIFT
    slower = found.limit * 75.0 / 76.0
    assert failure_of(corrected(machine(), slower - 2.0 * RESOLUTION)) == Failure.NONE
    assert failure_of(corrected(machine(), slower + 10.0 * RESOLUTION)) == Failure.FULL_LIFT


def test_full_lift_takes_the_same_time_whatever_the_window(found):
    longer = engine_limit(lasting(machine(), 110.0 * DEGREE))
    assert longer.fails == Failure.FULL_LIFT
    assert 111.0 / longer.limit == pytest.approx(76.0 / found.limit, rel=0.01)


def test_the_limit_rises_with_pressure_and_temperature(found):
    assert engine_limit(with_supply(machine(), AMBIENT + 0.6e6, 287.0)).limit < found.limit
    assert engine_limit(with_supply(machine(), AMBIENT + 1.0e6, 320.0)).limit > found.limit


def test_a_valve_that_hardly_closes_fails_by_full_closure():
    assert engine_limit(machine(targets=(-5.0, 340.0))).fails == Failure.FULL_CLOSURE


def test_a_valve_that_its_springs_hold_has_no_limit():
    held = engine_limit(changed(machine(supply=2e-3), {"valve.spring_rate": 1e5}))
    assert np.isnan(held.limit) and held.fails == Failure.TIMING and held.timing is None


def test_what_does_not_repeat_is_named_so():
    timing = corrected(machine(), 600.0 * RPM)
    assert failure_of(timing) == Failure.NONE
    assert failure_of(timing._replace(reason=Reason.NOT_PERIODIC)) == Failure.REPETITION
    assert failure_of(timing._replace(reason=Reason.MISSED)) == Failure.TIMING


class Islands:
    """A judge of an engine that works below 1000 r/min, and again from 1400 to 1800."""

    def failure(self, speed):
        rpm = speed / RPM
        return Failure.NONE if rpm < 1000.0 or 1400.0 < rpm < 1800.0 else Failure.FULL_LIFT


def test_the_search_finds_the_first_limit_and_tells_of_an_island_above_it():
    good, bad, again = _scanned(Islands())
    assert good < 1000.0 * RPM < bad and bad == pytest.approx(STEP_UP * good)
    assert 1400.0 * RPM < again < 1800.0 * RPM
    good, bad = _bisected(Islands(), good, bad, RESOLUTION)
    assert 999.0 * RPM < good < 1000.0 * RPM <= bad


def test_a_map_is_its_limits_one_by_one_and_states_its_criterion(found, tmp_path):
    archive = map_engine_limit(
        machine(), Supplies([AMBIENT + 1.0e6], [287.0], machine()), [60.0 * DEGREE, 75.0 * DEGREE], jobs=1
    )
    v = {name: variable.values for name, variable in archive.variables.items()}
    assert v["limit_rpm"][1] == found.limit / RPM and v["limit_hz"][1] == pytest.approx(found.limit / RPM / 60.0)
    assert v["duration_deg"].tolist() == pytest.approx([60.0, 75.0]) and v["fails"][1] == Failure.FULL_LIFT
    assert v["lap_to_lap_s"][1] == pytest.approx(76.0 / 6.0 / v["limit_rpm"][1])
    assert np.isnan(v["works_again_rpm"]).all() and v["peak_lift_m"][1] == pytest.approx(9e-3)
    assert archive.provenance["criterion"] == CRITERION
    assert all(path.stat().st_size > 5000 for path in engine_limit_figures(archive, AMBIENT, tmp_path))


def test_the_design_rule_is_fitted_where_full_lift_bounds_and_foretells_the_window_that_a_speed_needs(found):
    windows = np.array([60.0, 75.0, 340.0]) * DEGREE
    limits = np.array([engine_limit(lasting(machine(), window)).limit for window in windows])
    v = rule_columns([287.0] * 3, windows, limits, np.array([True, True, False]))
    assert v["rule_fitted"].values.tolist() == [1, 1, 0]
    [time] = set(v["rule_lap_to_lap_s"].values)
    assert time == pytest.approx(10.93e-3, rel=1e-3)
    assert limits[2] < 0.4 * v["rule_limit_rpm"].values[2] * RPM  # there the time closed bounds it
    [needed] = set(v["rule_window_deg"].values)
    assert engine_limit(lasting(machine(), needed * DEGREE)).limit / RPM == pytest.approx(1800.0, rel=1e-3)


def test_a_rule_gives_back_the_time_it_was_made_of_for_each_supply_alone():
    windows = np.array([60.0, 90.0, 120.0, 60.0, 200.0, 90.0]) * DEGREE
    cold, warm = DesignRule(12e-3), DesignRule(10e-3)
    limits = np.array([*map(cold.limit, windows[:3]), *map(warm.limit, windows[3:])])
    limits[4] *= 0.5  # beyond the longest window that is fitted
    assert fit_rule(windows[:3], limits[:3]).lap_to_lap == pytest.approx(12e-3)
    assert np.isnan(fit_rule([], []).lap_to_lap)
    assert cold.window(cold.limit(1.0)) == pytest.approx(1.0)
    v = rule_columns(["cold"] * 3 + ["warm"] * 3, windows, limits, np.ones(6, dtype=bool))
    assert v["rule_lap_to_lap_s"].values == pytest.approx([12e-3] * 3 + [10e-3] * 3)
    assert v["rule_fitted"].values.tolist() == [1, 1, 1, 1, 0, 1] and windows[4] > MAX_WINDOW


def test_the_command_states_the_machine_s_own_limit_and_where_the_lowest_of_the_grid_is(apesim, found):
    grid = ["--pressure", "0.6 MPa gauge, 1 MPa gauge", "--temperature", "287 K", "--duration", "60 deg, 75 deg"]
    endless = ["--set", 'engine.receiver.volume="inf"']
    code, out, _ = apesim("engine", "limit", *grid, *endless, "--json")
    data = json.loads(out)
    assert code == 0 and verify("engine_limit.h5") == []
    assert data["criterion"] == CRITERION
    assert data["limit_rpm"] == found.limit / RPM and data["limit_hz"] == pytest.approx(found.limit / RPM / 60.0)
    assert data["limit_at"] == {
        "supply_pressure_Pa": AMBIENT + 1e6,
        "supply_temperature_K": 287.0,
        "duration_deg": pytest.approx(75.0),
    }
    assert data["min_limit_rpm"] == min(point["limit_rpm"] for point in data["points"]) < data["limit_rpm"]
    assert (data["min_limit_at"]["supply_pressure_Pa"], data["min_limit_at"]["duration_deg"]) == (
        AMBIENT + 0.6e6,
        pytest.approx(60.0),
    )
    assert len(data["points"]) == 4 and data["points"][0]["fails"] == "full_lift"
    rule, paper = data["design_rule"], data["paper"]
    assert rule["lap_to_lap_s"] == pytest.approx(76.0 / 6.0 / data["limit_rpm"], rel=1e-3)
    assert rule["lap_to_lap_s_range"] == [rule["lap_to_lap_s"], data["points"][0]["rule_lap_to_lap_s"]]
    assert rule["fitted_windows_deg"] == pytest.approx([60.0, 75.0]) and rule["largest_misfit"] < 2e-3
    assert paper["speeds_rpm"] == PAPER_RPM and set(paper["reached_at_grid_points"].values()) == {0}
    assert paper["window_for_30_hz_deg"] == pytest.approx(6.0 * 1800.0 * rule["lap_to_lap_s"] - 1.0)


@pytest.mark.slow
def test_the_machine_s_own_point_is_computed_where_the_grid_does_not_hold_it(apesim):
    own = ["--set", 'supply.control_pressure="0.8 MPa gauge"', "--set", 'engine.receiver.volume="inf"']
    grid = ["--control-pressure", "1 MPa gauge", "--temperature", "287 K", "--duration", "75 deg", "--jobs", "1"]
    code, out, _ = apesim("engine", "limit", *grid, *own)
    assert code == 0 and "own" in out and "lowest of the grid" in out
    code, out, _ = apesim("engine", "limit", *grid, *own, "--json", "--overwrite", "--no-figures")
    data = json.loads(out)
    expected = engine_limit(machine(supply__control_pressure=AMBIENT + 0.8e6)).limit / RPM
    assert code == 0 and data["limit_rpm"] == expected < data["min_limit_rpm"]
    assert [point["control_pressure"] - AMBIENT for point in data["points"]] == pytest.approx([1e6, 0.8e6])
    assert data["paper"]["grid_points"] == 1


def test_a_limit_below_the_lowest_speed_is_told(apesim):
    stiff = ["--set", "valve.spring_rate=100 N/mm", "--set", "supply.pressure=0.05 MPa gauge"]
    grid = ["--pressure", "0.05 MPa gauge", "--temperature", "287 K", "--duration", "75 deg"]
    code, out, err = apesim("engine", "limit", *grid, *stiff, "--json", "--no-figures")
    data = json.loads(out)
    assert code == 3 and data["limit_rpm"] is None and data["min_limit_rpm"] is None
    assert data["design_rule"]["lap_to_lap_s_range"] is None
    assert "not even met at 300 r/min" in err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--duration", "75"], ["--duration", "no unit", "deg"]),
        (["--duration", "400 deg"], ["--duration", "out of range"]),
        (["--set", "engine.intake=ideal"], ["engine.intake", "ideal", "epv"]),
    ],
)
def test_bad_input_is_one_line_that_says_what_would_be_right(apesim, arguments, told):
    code, out, err = apesim("engine", "limit", *arguments)
    assert code == 2 and out == ""
    assert len(err.splitlines()) == 1 and all(word in err for word in told)
