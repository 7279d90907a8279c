"""The engine's limit is where its targets, full strokes or repetition stop being had, and what fails first is named."""

import json

import numpy as np
import pytest

from apesim.archive.inspection import verify
from engine.breathing import DEGREE
from engine.machine import Machine
from studies.engine_limit import (
    CRITERION,
    PAPER_RPM,
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
from studies.figures.engine_limit import engine_limit_figures
from studies.timing.solve import Reason, corrected
from studies.valve_map import with_supply
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
    archive = map_engine_limit(machine(), [AMBIENT + 1.0e6], [287.0], [60.0 * DEGREE, 75.0 * DEGREE], jobs=1)
    v = {name: variable.values for name, variable in archive.variables.items()}
    assert v["limit_rpm"][1] == found.limit / RPM and v["limit_hz"][1] == pytest.approx(found.limit / RPM / 60.0)
    assert v["duration_deg"].tolist() == pytest.approx([60.0, 75.0]) and v["fails"][1] == Failure.FULL_LIFT
    assert v["open_time_s"][1] == pytest.approx(75.0 / 6.0 / v["limit_rpm"][1])
    assert np.isnan(v["works_again_rpm"]).all() and v["peak_lift_m"][1] == pytest.approx(9e-3)
    assert archive.provenance["criterion"] == CRITERION
    assert all(path.stat().st_size > 5000 for path in engine_limit_figures(archive, AMBIENT, tmp_path))


def test_the_command_puts_limit_and_criterion_into_its_json(apesim):
    grid = ["--pressure", "0.6 MPa gauge, 1 MPa gauge", "--temperature", "287 K", "--duration", "75 deg"]
    code, out, _ = apesim("engine", "limit", *grid, "--json")
    data = json.loads(out)
    assert code == 0 and verify("engine_limit.h5") == []
    assert data["criterion"] == CRITERION and data["paper_rpm"] == PAPER_RPM
    assert data["limit_rpm"] == min(point["limit_rpm"] for point in data["points"])
    assert 900.0 < data["limit_rpm"] < 1200.0 and data["points"][0]["fails"] == "full_lift"


def test_a_limit_below_the_lowest_speed_is_told(apesim):
    stiff = ["--set", "valve.spring_rate=100 N/mm"]
    grid = ["--pressure", "0.05 MPa gauge", "--temperature", "287 K", "--duration", "75 deg"]
    code, out, err = apesim("engine", "limit", *grid, *stiff, "--json", "--no-figures")
    assert code == 3 and json.loads(out)["limit_rpm"] is None
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
