"""The best commands are what a brute-force grid of operating points cannot beat, and the front is one."""

import json
from math import nan

import numpy as np
import pytest

from apesim.archive.inspection import verify
from apesim.engine.angles import DEGREE
from apesim.engine.indicators import indicators
from apesim.engine.machine import Machine
from apesim.engine.steady import run_steady
from apesim.studies.optimise.figures import optimise_figures
from apesim.studies.optimise.landscape import DURATION, ENERGISE, RECORDED, Goal, Landscape, Point, judged
from apesim.studies.optimise.search import optimise, undominated
from apesim.studies.optimise.table import archive_of, bounds_of, faults_of, optima_over_speed
from tests.machines import RPM, machine
from tests.processes import without_stages

AMBIENT = Machine().ambient.pressure
SPEED = 1200.0 * RPM
BOTH = tuple(Goal)


@pytest.fixture(scope="module")
def found():
    return optimise(machine(), SPEED, BOTH)


def outcome(energise, duration, speed=SPEED, **other):
    """Brake torque [N m] and specific air [kg/kWh] by a run and a sum of their own; angles [deg]."""
    commanded = machine(energise=energise, release=energise + duration, **other)
    run = run_steady(commanded, speed, angle_step=5.0 * DEGREE)
    values = indicators(commanded, run)
    if not run.orbit.converged:
        return nan, nan
    torque = values["brake_torque_Nm"]
    air = values["engine_air_kg_per_cycle"] + values["control_air_kg_per_cycle"]
    return torque, air / (2.0 * np.pi * torque / 3.6e6) if torque > 0.0 else nan


@pytest.fixture(scope="module")
def grid():
    """Outcomes all over the range searched, every 15 degrees; shape (n, 2)."""
    energise = np.arange(ENERGISE[0] / DEGREE, ENERGISE[1] / DEGREE, 15.0)
    duration = np.arange(DURATION[0] / DEGREE, DURATION[1] / DEGREE, 15.0)
    return np.array([outcome(e, d) for e in energise for d in duration])


def angles_of(point):
    return point.energise / DEGREE, (point.release - point.energise) / DEGREE


def told(point):
    return point.values["brake_torque_Nm"], point.values["specific_air_kg_per_kWh"]


@pytest.mark.parametrize(("goal", "sign"), [(Goal.TORQUE, 1.0), (Goal.AIR, -1.0)])
@pytest.mark.slow
def test_no_point_of_a_grid_is_better_than_the_optimum(found, grid, goal, sign):
    best = found.best[goal]
    assert outcome(*angles_of(best)) == pytest.approx(told(best), rel=1e-6)
    reached = sign * told(best)[goal]
    everywhere = sign * grid[:, goal]
    assert np.nanmax(everywhere) <= reached
    # The grid is coarse, but its best is no farther off than a parabola over half its spacing makes it.
    assert np.nanmax(everywhere) >= reached - 0.03 * abs(reached)
    energise, duration = angles_of(best)
    nearby = [outcome(energise + i, duration + j)[goal] for i in (-1.0, 0.0, 1.0) for j in (-1.0, 0.0, 1.0)]
    assert np.argmax(sign * np.array(nearby)) == 4
    hardly_away = [outcome(energise + i, duration + j)[goal] for i, j in ((0.1, 0), (-0.1, 0), (0, 0.1), (0, -0.1))]
    assert max(sign * np.array(hardly_away)) <= reached + 2e-6 * abs(reached)


def test_no_point_of_the_front_is_dominated_and_its_ends_are_the_optima(found):
    torque, air = np.array([told(point) for point in found.front]).T
    assert len(found.front) > 30
    assert (np.diff(torque) > 0.0).all() and (np.diff(air) > 0.0).all()
    assert found.front[0] == found.best[Goal.AIR] and found.front[-1] == found.best[Goal.TORQUE]
    for goal in BOTH:
        alone = optimise(machine(), SPEED, (goal,))
        assert told(alone.best[goal])[goal] == pytest.approx(told(found.best[goal])[goal], rel=1e-6)
        assert alone.front == []
    assert np.hypot(np.diff(torque) / np.ptp(torque), np.diff(air) / np.ptp(air)).max() < 0.1


def test_no_point_of_a_grid_lies_beyond_the_front(found, grid):
    torque, air = np.array([told(point) for point in found.front]).T
    within = (grid[:, 0] > torque[0]) & (grid[:, 0] < torque[-1])
    on_the_front = np.interp(grid[within, 0], torque, air)
    assert within.sum() > 20
    assert (grid[within, 1] > on_the_front * (1.0 - 1e-3)).all()
    # Around points of the front, too, where a grid of 15 degrees says nothing.
    for point in found.front[3:-3:8]:
        energise, duration = angles_of(point)
        for step in np.array([(3, 0), (-3, 0), (0, 3), (0, -3), (3, -3), (-3, 3), (2, 2), (-2, -2)]) / 1.5:
            torque_there, air_there = outcome(energise + step[0], duration + step[1])
            if torque[0] < torque_there < torque[-1]:
                assert air_there > np.interp(torque_there, torque, air) * (1.0 - 1e-3)


def test_the_optimum_opens_early_and_beats_the_machines_own_commands(found):
    own = found.fixed.values
    for point in found.best.values():
        assert point.values["valve_open_deg"] < 0.0 < own["valve_open_deg"]
    assert told(found.fixed) == pytest.approx(outcome(-5.0, 75.0), rel=1e-6)
    assert told(found.best[Goal.TORQUE])[0] > told(found.fixed)[0]
    assert told(found.best[Goal.AIR])[1] < told(found.fixed)[1]
    assert bounds_of(found.best[Goal.TORQUE]) == {"energise": 0, "duration": 0}


def test_any_number_of_processes_finds_the_same():
    speeds = [900.0 * RPM, 1500.0 * RPM]
    reports = []
    one = optima_over_speed(machine(), speeds, (Goal.TORQUE,), jobs=1)
    two = optima_over_speed(machine(), speeds, (Goal.TORQUE,), jobs=2, report=lambda *done: reports.append(done))
    assert repr(one) == repr(two) and reports == [(1, 2), (2, 2)]
    assert [optimum.speed for optimum in two] == speeds


def test_a_free_pressure_is_an_optimum_too_and_told_where_it_runs_into_its_range():
    pressures = AMBIENT + 0.6e6, AMBIENT + 1.2e6
    (best,) = optimise(machine(), SPEED, (Goal.TORQUE,), pressures).best.values()
    assert best.pressure == pytest.approx(pressures[1], rel=1e-9)
    assert bounds_of(best) == {"energise": 0, "duration": 0, "supply_pressure": 1}
    fixed = optimise(machine(supply=1.2), SPEED, (Goal.TORQUE,)).best[Goal.TORQUE]
    assert told(best)[0] == pytest.approx(told(fixed)[0], rel=1e-5)
    assert outcome(*angles_of(best), supply=1.2) == pytest.approx(told(best), rel=1e-6)


def test_an_engine_that_nothing_turns_is_named():
    weak = machine(supply=0.05)
    optima = optima_over_speed(weak, [SPEED], BOTH, jobs=1)
    assert optima[0].best[Goal.AIR] is None and optima[0].front == []
    [line] = faults_of(optima)
    assert "1200 r/min" in line and "raise the pressure" in line
    archive = archive_of(weak, optima, BOTH)
    assert np.isnan(archive.variables["least_air_energise_deg"].values).all()
    assert np.isnan(archive.variables["front_brake_torque_Nm"].values).all()


def point(torque, work_over_air, place=(0.5, 0.5)):
    return Point(place, 0.0, 1.0, 1e6, dict.fromkeys(RECORDED, nan), (torque, work_over_air), False)


def test_a_state_that_was_not_seen_to_repeat_has_no_merit():
    few, all_ = (judged(machine(), run_steady(machine(), SPEED, max_cycles=max_cycles)) for max_cycles in (3, 600))
    assert few.merit == (-np.inf, -np.inf) and np.isnan(list(few.values.values())).all() and not few.full_lift
    assert told(all_) == pytest.approx(outcome(-5.0, 75.0), rel=1e-9) and all_.merit[Goal.TORQUE] == told(all_)[0]
    assert all_.merit[Goal.AIR] == pytest.approx(3.6e6 / told(all_)[1])


def test_points_that_do_not_repeat_or_give_no_work_do_not_count():
    landscape = Landscape(machine(), SPEED)
    landscape.settled = dict(enumerate([point(-np.inf, -np.inf), point(-3.0, 9e4)]))
    assert landscape.best(Goal.TORQUE).merit == (-3.0, 9e4) and landscape.best(Goal.AIR) is None
    landscape.settled[2] = point(2.0, 5e4)
    assert landscape.best(Goal.AIR).merit == (2.0, 5e4)
    assert landscape.best(Goal.AIR, min_torque=2.1) is None
    assert undominated(landscape.settled.values()) == [landscape.settled[2]]


def test_a_front_keeps_what_nothing_dominates():
    merits = [(1.0, 9.0), (2.0, 8.0), (2.0, 7.0), (1.5, 8.5), (1.4, 8.4), (3.0, 1.0), (2.999, 1.01), (-1.0, 20.0)]
    front = undominated([point(*merit) for merit in merits])
    assert [one.merit for one in front] == [(1.0, 9.0), (1.5, 8.5), (2.0, 8.0), (2.999, 1.01), (3.0, 1.0)]


def test_the_command_leaves_json_archive_and_figures(apesim, tmp_path):
    settings = ["--speed", "1200 rpm", "--jobs", "1", "--set", "engine.receiver.volume=inf"]
    code, out, err = apesim("engine", "optimise", *settings, "--json")
    data = json.loads(out)
    assert code == 0 and without_stages(err) == "" and verify("optimise.h5") == []
    (found,) = data["points"]
    assert (
        data["for"] == "both" and data["searched_duration"] == "5 to 300 deg" and found["most_torque"]["bounds"] == {}
    )
    assert found["front"][0]["specific_air_kg_per_kWh"] == found["least_air"]["specific_air_kg_per_kWh"]
    assert found["front"][-1]["brake_torque_Nm"] == found["most_torque"]["brake_torque_Nm"]
    assert found["most_torque"]["full_lift"] is True and found["runs"] > len(found["front"])
    names = {path.stem for path in tmp_path.glob("optimise.figures/*.png")}
    assert names == {"optimum_angles", "optimum_torque_and_air", "pareto_fronts"}


def test_without_brake_work_the_exit_code_says_so(apesim):
    weak = ["--set", "supply.pressure=0.05 MPa gauge", "--speed", "1200 rpm", "--no-figures"]
    code, out, err = apesim("engine", "optimise", "--for", "air", *weak, "--json")
    (found,) = json.loads(out)["points"]
    assert code == 3 and found["least_air"] is None and found["front"] == []
    assert "1200 r/min: no commands" in err


@pytest.mark.slow
def test_one_goal_and_a_free_pressure_are_drawn_and_shown(apesim, tmp_path):
    free = ["--free", "supply.pressure=0.8 MPa gauge:1 MPa gauge", "--speed", "1200 rpm"]
    code, out, _ = apesim("engine", "optimise", "--for", "air", *free)
    assert (
        code == 0
        and "least air" in out
        and "most torque" not in out
        and "at the highest supply pressure searched" in out
    )
    names = {path.stem for path in tmp_path.glob("optimise.figures/*.png")}
    assert names == {"optimum_angles", "optimum_torque_and_air", "optimum_pressure"}


def test_figures_are_drawn_of_a_single_speed(found, tmp_path):
    paths = optimise_figures(archive_of(machine(), [found], BOTH), AMBIENT, tmp_path)
    assert len(paths) == 6 and all(path.stat().st_size > 5000 for path in paths)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--for", "power"], ["--for", "torque", "air", "both"]),
        (["--speed", "1000"], ["--speed", "no unit", "rpm"]),
        (["--set", "engine.intake=cam"], ["engine.intake", "cam", "epv"]),
        (["--free", "supply.pressure"], ["--free", "bounds", "0.5 MPa gauge:1.5 MPa gauge"]),
        (["--free", "valve.stroke=5 mm:6 mm"], ["--free", "not the supply pressure", "supply.pressure="]),
        (["--free", "supply.pressure=2 MPa abs:1 MPa abs"], ["--free", "not below", "LOW:HIGH"]),
        (["--free", "supply.pressure=1:2"], ["--free", "no unit", "gauge"]),
    ],
)
def test_bad_input_is_one_line_that_says_what_would_be_right(apesim, arguments, words):
    code, out, err = apesim("engine", "optimise", *arguments)
    assert code == 2 and out == ""
    assert len(err.splitlines()) == 1 and all(word in err for word in words)
