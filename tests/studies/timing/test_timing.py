"""Corrected commands do what they promise: in the coupled engine, between the points of the table, and in C."""

import csv
import json
import re
import shutil
import subprocess
from math import nan
from pathlib import Path

import numpy as np
import pytest

from apesim.archive import Archive, read
from apesim.archive.columns import column
from apesim.archive.inspection import verify
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.machine import Machine
from apesim.engine.steady import run_steady
from apesim.quantities.settings import dumps, load
from apesim.studies.run.operating_conditions import Supplies, with_supply
from apesim.studies.timing.export import as_json, export
from apesim.studies.timing.figures import timing_figures
from apesim.studies.timing.grid import REASONS, TimingMap, faults_of_timing, map_timing
from apesim.studies.timing.header import c_header
from apesim.studies.timing.law import Law, fitted
from apesim.studies.timing.open_loop import open_loop_delays
from apesim.studies.timing.solve import Look, Reason, corrected, reason_of
from apesim.studies.timing.summary import law_lines, shortcut_line, timing_tables
from apesim.studies.timing.table import Axes, InterpolationError, centres, interpolated
from apesim.valve.bench import run_bench
from tests.machines import RPM, changed, machine, settled

AMBIENT = Machine().ambient.pressure


def passages(a_machine, rpm, lap=1e-3):
    """Crank angles at which the lift in the trace rises and falls through the lap [deg]: not the indicators' way."""
    run = settled(a_machine, rpm, angle_step=0.05 * DEGREE)
    angle, above = np.degrees(run.angles), run.trace[:, 2] - lap
    found = np.flatnonzero(above[:-1] * above[1:] < 0.0)
    angles = angle[found] - above[found] * (angle[found + 1] - angle[found]) / (above[found + 1] - above[found])
    rising = above[found] < 0.0
    return angles[rising], angles[~rising]


def machine_at_targets(opens, closes):
    command = Machine().command._replace(open_target=opens * DEGREE, close_target=closes * DEGREE)
    return Machine()._replace(command=command)


@pytest.mark.parametrize("rpm", [300.0, 1000.0, 2400.0])
@pytest.mark.parametrize("control_air", ["regulator", "receiver"])
def test_the_lift_passes_the_lap_at_both_targets(rpm, control_air):
    given = machine(control_air=control_air, receiver=1.0)
    timing = corrected(given, rpm * RPM)
    assert timing.reachable
    opens, closes = passages(timing.machine, rpm)
    np.testing.assert_allclose([*opens, *closes], [-5.0, 70.0], atol=2e-3)
    command = timing.machine.command
    assert timing.advance == pytest.approx(given.command.open_target - command.energise)
    assert timing.release_advance == pytest.approx(given.command.close_target - command.release)


def test_a_start_from_elsewhere_leads_to_the_same_commands():
    found = corrected(machine(), 1500.0 * RPM)
    command = found.machine.command
    start = command.energise + 20.0 * DEGREE, command.release - command.energise - 10.0 * DEGREE
    other = corrected(machine(), 1500.0 * RPM, start)
    np.testing.assert_allclose(other[3:5], found[3:5], atol=1e-3 * DEGREE)


@pytest.mark.parametrize("rpm", [600.0, 1300.0])
def test_the_state_of_the_commands_before_leads_to_that_from_rest_in_half_the_cycles(rpm):
    timing = corrected(machine(receiver=1.0), rpm * RPM)
    from_rest = settled(timing.machine, rpm)
    assert timing.run.orbit.cycles < 0.6 * from_rest.orbit.cycles
    np.testing.assert_allclose(timing.run.start, from_rest.start, rtol=1e-6, atol=1e-9)


def test_targets_a_turn_later_need_the_same_commands_a_turn_later_and_stay_in_a_machine_files_range():
    found = [corrected(machine(targets=targets), 3000.0 * RPM) for targets in ((-300.0, -225.0), (60.0, 135.0))]
    assert all(timing.reachable for timing in found)
    assert found[0].advance == pytest.approx(found[1].advance, abs=1e-3 * DEGREE)
    for timing in found:
        assert not list(timing.machine.command.faults())
        command = timing.machine.command
        assignments = [f"command.{name}={getattr(command, name) / DEGREE!r} deg" for name in command._fields]
        assert load(Machine, None, assignments).command == pytest.approx(command)


def test_an_advance_of_more_than_a_turn_is_told_from_one_of_less():
    # 365 deg at 12000 r/min are 5.07 ms; 5 deg would be 0.07 ms, within the dead time of the solenoids.
    timing = corrected(machine(), 12000.0 * RPM)
    assert timing.reachable
    assert timing.advance / timing.run.cycle.speed > machine().valve.solenoid.dead_time
    assert TURN < timing.advance < 1.5 * TURN


@pytest.mark.parametrize(
    ("given", "rpm", "reason"),
    [
        (changed(machine(supply=2e-3), {"valve.spring_rate": 1e5}), 600.0, Reason.NEVER_CLOSES),
        (machine(targets=(-5.0, -4.5)), 2400.0, Reason.OPEN_TOO_LONG),
        (machine(), 20000.0, Reason.NO_PULSE),
        (
            changed(machine(supply=0.1), {"effects.coulomb_friction.force": 150.0}),
            600.0,
            Reason.NEVER_OPENS,
        ),
    ],
)
def test_what_is_out_of_reach_is_named_and_nothing_is_invented(given, rpm, reason):
    timing = corrected(given, rpm * RPM)
    assert timing.reason == reason
    assert not timing.reachable and timing.machine is given and timing.run is None
    assert np.isnan(timing[3:7]).all()
    assert ";" in reason.remedy


def test_a_cam_has_no_commands_to_correct():
    with pytest.raises(ValueError, match="electro-pneumatic"):
        corrected(machine("cam"), 1000.0 * RPM)


def test_every_reason_has_its_remedy():
    assert all(reason.remedy for reason in Reason)


def test_what_meets_the_targets_without_repeating_is_not_reached():
    timing = corrected(machine(), 1000.0 * RPM)
    early = run_steady(timing.machine, 1000.0 * RPM, max_cycles=2)
    assert reason_of(Look(timing.machine, early, {}, np.zeros(2))) == Reason.NOT_PERIODIC
    assert reason_of(Look(timing.machine, timing.run, {}, np.zeros(2))) == Reason.REACHED
    assert reason_of(Look(timing.machine, timing.run, {}, np.array([0.0, 0.06 * DEGREE]))) == Reason.MISSED
    assert reason_of(Look(timing.machine, timing.run, {}, np.array([nan, nan]))) == Reason.FAILED


def test_a_valve_that_bounces_back_through_the_lap_is_not_reached():
    given = load(Machine, None, ["effects.bounce.restitution=0.6", "groove.lap=0.05 mm"])
    assert corrected(given, 300.0 * RPM).reason == Reason.CROSSES_AGAIN


def test_delays_of_the_bench_are_where_a_finely_sampled_run_passes_the_lap():
    run = run_bench(machine(), 0.2, sample=2e-6)
    above = run.trace[:, 0] - 1e-3
    rise, fall = np.flatnonzero(above[:-1] * above[1:] < 0.0)
    passed = [run.times[i] - above[i] * 2e-6 / (above[i + 1] - above[i]) for i in (rise, fall)]
    np.testing.assert_allclose(open_loop_delays(machine()), [passed[0], passed[1] - 0.2], rtol=0, atol=1e-8)
    held = changed(machine(supply=2e-3), {"valve.spring_rate": 1e5})  # the springs hold it above the lap
    assert np.isnan(open_loop_delays(held).closing)


def test_interpolation_is_exact_for_what_is_linear_and_gives_nothing_beyond():
    axes = Axes(np.array([1.0, 2.0, 4.0]), np.array([5.0]), np.array([0.0, 10.0]))

    def law(x, y, z):
        return 3.0 + x - 2.0 * y + 0.5 * z + 0.1 * x * z

    values = law(*np.meshgrid(*axes, indexing="ij"))
    for point in ((1.0, 5.0, 0.0), (4.0, 5.0, 10.0), (1.5, 5.0, 2.5), (3.1, 5.0, 9.9)):
        assert interpolated(axes, values, point) == pytest.approx(law(*point))
    for point in ((0.9, 5.0, 0.0), (4.1, 5.0, 0.0), (2.0, 5.1, 0.0), (2.0, 5.0, -1.0)):
        assert np.isnan(interpolated(axes, values, point))
    values[2, 0, 1] = nan
    assert np.isnan(interpolated(axes, values, (3.0, 5.0, 5.0)))
    assert interpolated(axes, values, (2.0, 5.0, 5.0)) == pytest.approx(law(2.0, 5.0, 5.0))


def test_centres_are_all_or_a_choice_that_its_seed_repeats():
    axes = Axes(np.array([1.0, 2.0, 4.0]), np.array([5.0]), np.array([0.0, 10.0]))
    assert centres(axes, 10, 1) == ([(1.5, 5.0, 5.0), (3.0, 5.0, 5.0)], 2)
    many = Axes(np.arange(9.0), np.arange(9.0), np.arange(9.0))
    assert centres(many, 20, 1) == centres(many, 20, 1) != centres(many, 20, 2)
    assert len(set(centres(many, 20, 1)[0])) == 20 and centres(many, 20, 1)[1] == 512
    assert centres(Axes(*3 * (np.array([1.0]),)), 20, 1) == ([], 0)


def test_a_law_is_the_line_its_points_lie_on_and_says_how_far_they_do_not():
    temperatures = np.array([250.0, 287.0, 322.0])
    exact = fitted(1e6, 50.0, temperatures, 7e-3 - 5e-6 * (temperatures - 287.0), np.full(3, 50.0))
    assert (exact.at_reference, exact.slope) == (pytest.approx(7e-3), pytest.approx(-5e-6))
    assert exact.max_error < 1e-15 and exact.opposite_to_the_paper
    bent = fitted(1e6, 50.0, np.array([277.0, 287.0, 297.0]), np.array([7e-3, 7.3e-3, 7e-3]), np.full(3, 50.0))
    assert bent.slope == pytest.approx(0.0, abs=1e-15)
    assert bent.max_error == pytest.approx(0.2e-3) and bent.error_rms == pytest.approx(np.sqrt(0.02) * 1e-3)
    assert bent.max_angle_error == pytest.approx(50.0 * 0.2e-3)
    assert fitted(1e6, 50.0, temperatures, np.array([7e-3, nan, nan]), np.full(3, 50.0)) is None


SPEEDS = [600.0 * RPM, 1800.0 * RPM]
PRESSURES = [AMBIENT + 0.6e6, AMBIENT + 1.0e6]
TEMPERATURES = [270.0, 300.0]
SUPPLIES = Supplies(PRESSURES, TEMPERATURES, Machine())


@pytest.fixture(scope="module")
def mapped():
    return map_timing(SUPPLIES, SPEEDS, jobs=1)


def test_a_point_of_the_map_is_that_point_alone(mapped):
    v = {name: variable.values for name, variable in mapped.archive.variables.items()}
    alone = corrected(with_supply(Machine(), PRESSURES[0], TEMPERATURES[1]), SPEEDS[1])
    assert (v["speed_rpm"][5], v["supply_pressure"][5], v["supply_temperature"][5]) == (1800.0, PRESSURES[0], 300.0)
    assert v["reachable"].all() and (v["marches"] > 1).all()
    assert v["advance_deg"][5] * DEGREE == mapped.advance[1, 0, 1]
    np.testing.assert_allclose(
        [mapped.advance[1, 0, 1], mapped.release_advance[1, 0, 1]],
        [alone.advance, alone.release_advance],
        atol=2e-3 * DEGREE,
    )
    np.testing.assert_allclose(v["energise_deg"] + v["advance_deg"], -5.0)
    np.testing.assert_allclose(v["release_deg"] + v["release_advance_deg"], 70.0)
    np.testing.assert_allclose(v["pulse_s"], (v["release_deg"] - v["energise_deg"]) / 6.0 / v["speed_rpm"])


def test_correction_wins_torque_and_air_at_high_speed_and_gives_torque_away_at_low(mapped):
    v = {name: variable.values for name, variable in mapped.archive.variables.items()}
    won = v["brake_torque_Nm"] - v["fixed_brake_torque_Nm"]
    assert (won[v["speed_rpm"] == 1800.0] > 0.0).all() and (won[v["speed_rpm"] == 600.0] < 0.0).all()
    slow = v["speed_rpm"] == 600.0
    assert (v["specific_air_kg_per_kWh"][slow] < v["fixed_specific_air_kg_per_kWh"][slow]).all()


def test_the_shortcut_errs_little_where_strokes_are_complete_and_does_not_open_the_valve_at_high_speed(mapped):
    v = {name: variable.values for name, variable in mapped.archive.variables.items()}
    slow = v["speed_rpm"] == 600.0
    for name in ("open", "close"):
        error = v[f"shortcut_{name}_error_deg"]
        assert (np.abs(error[slow]) < 1.0).all() and (np.abs(error[slow]) > 1e-3).all()
        assert np.isnan(error[~slow]).all()
    commands = [f"command.{name}={v[f'shortcut_{name}_deg'][3].item()!r} deg" for name in ("energise", "release")]
    given = with_supply(load(Machine, None, commands), PRESSURES[1], TEMPERATURES[1])
    [opens], [closes] = passages(given, 600.0)
    errors = v["shortcut_open_error_deg"][3], v["shortcut_close_error_deg"][3]
    np.testing.assert_allclose(errors, [opens + 5.0, closes - 70.0], atol=2e-3)
    assert (v["shortcut_release_deg"] - v["shortcut_energise_deg"] < 60.0)[~slow].all()  # 75 are wanted of the valve


def test_the_error_of_interpolation_is_that_of_a_point_solved_in_the_middle(mapped):
    middle = 1200.0 * RPM, 0.5 * sum(PRESSURES), 285.0
    solved = corrected(with_supply(Machine(), *middle[1:]), middle[0])
    release = interpolated(mapped.axes, mapped.release_advance, middle)
    assert mapped.error.points == mapped.error.centres == 1
    assert mapped.error.max_release_error == pytest.approx(abs(release - solved.release_advance), abs=2e-3 * DEGREE)
    assert mapped.error.release_error_rms == pytest.approx(mapped.error.max_release_error)


def test_the_advance_falls_with_temperature_against_the_paper(mapped):
    for law in mapped.laws["advance"]:
        assert law.opposite_to_the_paper
        assert law.slope == pytest.approx(-6e-6, rel=0.1)
    assert sum(np.isnan(law.speed) for law in mapped.laws["advance"]) == len(PRESSURES)


def test_where_one_law_for_all_speeds_is_far_off_those_of_each_speed_are_told():
    def law(speed, at_reference, slope, angle):
        return Law(AMBIENT + 1e6, speed, at_reference, slope, 1e-5, 1e-5, angle * DEGREE, angle * DEGREE, 3)

    each = [law(50.0, 7e-3, -6e-6, 0.1), law(90.0, 7.5e-3, 1e-6, 0.3)]
    [near] = law_lines({"advance": [*each, law(nan, 7.2e-3, -2e-6, 0.9)]}, AMBIENT)
    assert near.startswith("advance at 1 MPa gauge: 7.200 ms -2.00 us/K") and "0.90 deg; it falls" in near
    [far] = law_lines({"advance": [*each, law(nan, 7.2e-3, -2e-6, 38.0)]}, AMBIENT)
    for told in (
        "each speed",
        "off by 38 deg",
        "7.000 to 7.500 ms -6.00 to +1.00 us/K",
        "0.10 to 0.30 deg",
        "1 of 2 sp",
    ):
        assert told in far
    [alone] = law_lines({"advance": each[:1]}, AMBIENT)
    assert alone == (
        "advance at 1 MPa gauge: 7.000 ms -6.00 us/K (supply temperature - 287 K), "
        "off by at most 0.010 ms or 0.10 deg; it falls with the temperature"
    )


def test_several_processes_give_the_same_bits(mapped):
    other = map_timing(SUPPLIES, SPEEDS, jobs=2)
    for name, variable in mapped.archive.variables.items():
        np.testing.assert_array_equal(variable.values, other.archive.variables[name].values, err_msg=name)
    assert other.error == mapped.error


def test_a_point_out_of_reach_is_named_and_the_others_are_kept():
    narrow = machine_at_targets(-5.0, -4.5)
    found = map_timing(Supplies(PRESSURES[1:], [287.0], narrow), [300.0 * RPM, 2400.0 * RPM], jobs=1)
    v = {name: variable.values for name, variable in found.archive.variables.items()}
    assert v["reachable"].tolist() == [1, 0] and v["reason"][1] == Reason.OPEN_TOO_LONG
    assert f"{int(Reason.OPEN_TOO_LONG)} open too long" in REASONS
    [fault] = faults_of_timing(found.archive)
    assert "2400 r/min" in fault and Reason.OPEN_TOO_LONG.remedy in fault
    assert np.isnan(v["advance_deg"][1]) and found.error.points == 0
    assert as_json(found)["points"][1]["remedy"] == Reason.OPEN_TOO_LONG.remedy
    assert as_json(found)["temperature_law"]["advance"] == []


C_MAIN = """
#include <stdio.h>
#include "timing.h"
int main(void)
{
    double speed, pressure, temperature, energise, release;
    while (scanf("%lf %lf %lf", &speed, &pressure, &temperature) == 3) {
        int known = apesim_timing(speed, pressure, temperature, &energise, &release);
        if (known) printf("%d %.17g %.17g\\n", known, energise, release); else printf("0 nan nan\\n");
    }
    return 0;
}
"""


def answers_of(header, points, folder):
    """What a C program with a header answers at points: code, energise and release [deg]."""
    (folder / "timing.h").write_text(header)
    (folder / "main.c").write_text(C_MAIN)
    strict = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(["gcc", *strict, "main.c", "-o", "main"], cwd=folder, check=True)
    lines = "".join(f"{s * 60.0 / TURN:.17g} {p:.17g} {t:.17g}\n" for s, p, t in points)
    done = subprocess.run([folder / "main"], input=lines, capture_output=True, text=True, check=True)
    return np.array([line.split() for line in done.stdout.splitlines()], dtype=float)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no C compiler here")
@pytest.mark.parametrize("hole", [False, True])
def test_the_c_header_gives_what_the_table_gives(mapped, tmp_path, hole):
    """Angles, and 0 beside a hole."""
    tables = [mapped.advance.copy(), mapped.release_advance.copy()]
    if hole:
        for table in tables:
            table[0, 1, 1] = nan
    header = c_header(mapped._replace(advance=tables[0], release_advance=tables[1]))
    lows, highs = np.array([axis[[0, -1]] for axis in mapped.axes]).T
    shares = np.random.default_rng(5).uniform(-0.1, 1.1, (300, 3))
    points = np.concatenate((lows + shares * (highs - lows), [lows, highs, 0.5 * (lows + highs)]))
    answers = answers_of(header, points, tmp_path)
    angles = [[interpolated(mapped.axes, table, point) / DEGREE for point in points] for table in tables]
    expected = np.column_stack((-5.0 - np.array(angles[0]), 70.0 - np.array(angles[1])))
    inside = ~np.isnan(expected[:, 0])
    assert 50 < inside.sum() < len(points) or hole
    np.testing.assert_array_equal(answers[:, 0] > 0.0, inside)
    np.testing.assert_allclose(answers[inside, 1:], expected[inside], rtol=0, atol=1e-8)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no C compiler here")
def test_the_c_header_says_where_the_piston_turns_back(tmp_path):
    """Beside a point without full lift; a neighbour that is unreachable comes first."""
    axes = Axes(np.array([600.0, 900.0, 1200.0, 1500.0]) * RPM, np.array([1.1e6]), np.array([287.0]))
    advance = np.array([0.5, 0.8, 1.1, nan]).reshape(axes.shape)
    columns = {"full_lift": column([1, 1, 0, 0], "1", "whether the piston meets its open stop")}
    command, error = Machine().command, InterpolationError(0, 0, 0, nan, nan, nan, nan)
    header = c_header(TimingMap(Archive("", {}, columns), command, axes, advance, advance, {}, error))
    assert "of the command angles, interpolated less solved" in header and "valve then misses its targets" in header
    points = [(speed * RPM, 1.1e6, 287.0) for speed in (610.0, 890.0, 910.0, 1190.0, 1210.0, 620.0)]
    assert answers_of(header, points, tmp_path)[:, 0].tolist() == [1.0, 1.0, 2.0, 2.0, 0.0, 1.0]


def test_the_tables_have_a_row_a_speed_and_say_in_words_what_the_valve_does(mapped):
    sentence, own, energise, release, legend = timing_tables(mapped, (PRESSURES[1], TEMPERATURES[1]), AMBIENT)
    turned = int((~mapped.full_lift).sum())
    assert f"all {mapped.full_lift.size} points" in sentence and f"{turned} of them" in sentence
    assert own.row_count == energise.row_count == release.row_count == len(mapped.axes.speeds)
    words = list(own.columns[-1].cells)
    assert [word == "opens fully" for word in words] == mapped.full_lift[:, 1, 1].tolist()
    assert all(re.fullmatch(r"opens fully|turns back at [0-9.]+ mm", word) for word in words)
    marks = [[cell.endswith("*") for cell in column.cells] for column in energise.columns[1:]]
    assert np.array_equal(np.transpose(marks), ~mapped.full_lift.reshape(len(mapped.axes.speeds), -1))
    assert legend.startswith("*") and len(energise.columns) == 1 + mapped.full_lift[0].size


def test_the_shortcut_is_told_in_a_sentence(mapped):
    told = shortcut_line(mapped)
    assert "delays of the bench" in told and "from 1800 r/min on not open everywhere" in told


def test_exports_say_the_same_and_state_their_error(mapped, tmp_path):
    table, text, header = export(mapped, tmp_path / "timing.h5")
    data = json.loads(text.read_text())
    with table.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert set(data) >= {"advance_deg", "release_advance_deg", "reachable", "interpolation_error", "temperature_law"}
    np.testing.assert_allclose(np.ravel(data["advance_deg"]), [float(row["advance_deg [deg]"]) for row in rows])
    np.testing.assert_allclose(data["advance_deg"], mapped.advance / DEGREE)
    assert [row["reason"] for row in rows] == ["reached"] * 8
    error = f"{np.degrees(mapped.error.max_release_error):.3g} (release)"
    for told in (header.read_text(), data["interpolation_error"]["measured"]):
        assert error in told and "at the centres of cells" in told and "at most" not in told
    assert data["interpolation_error"]["where"] == "centres of cells"
    assert all(path.stat().st_size > 5000 for path in timing_figures(mapped, AMBIENT, tmp_path))


def test_engine_run_opens_and_closes_where_engine_timing_promises(apesim):
    point = ["--speed", "1300 rpm", "--pressure", "0.8 MPa gauge", "--temperature", "300 K"]
    code, out, _ = apesim("engine", "timing", "--target", "-8 deg, 60 deg", *point, "--no-figures", "--json")
    data = json.loads(out)
    assert code == 0 and data["reachable"] == [[[True]]] and data["wall_time_s"] > 0.0
    assert data["advance_deg"] == [[[data["points"][0]["advance_deg"]]]]
    assert verify("timing.h5") == []
    assert "cell" not in data["interpolation_error"]["measured"] and "one point" in Path("timing.h").read_text()
    assert read("timing.h5").machine == dumps(machine_at_targets(-8.0, 60.0))
    settings = (
        f"command.energise={data['points'][0]['energise_deg']!r} deg",
        f"command.release={data['points'][0]['release_deg']!r} deg",
        "supply.pressure=0.8 MPa gauge",
        "supply.temperature=300 K",
    )
    assignments = [word for setting in settings for word in ("--set", setting)]
    code, out, _ = apesim("engine", "run", "--speed", "1300 rpm", *assignments, "--json")
    run = json.loads(out)
    assert code == 0
    assert (run["valve_open_deg"], run["valve_close_deg"]) == (
        pytest.approx(-8.0, abs=1e-3),
        pytest.approx(60.0, abs=1e-3),
    )
    assert run["brake_torque_Nm"] == pytest.approx(data["points"][0]["brake_torque_Nm"])


def test_even_the_quiet_table_says_why_a_point_is_out_of_reach(apesim):
    point = ["--speed", "2400 rpm", "--pressure", "1 MPa gauge", "--temperature", "287 K", "--no-figures", "--quiet"]
    code, out, _ = apesim("engine", "timing", "--target", "-5 deg, -4.5 deg", *point)
    assert code == 3 and "open too long" in " ".join(out.split())


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--target", "5 deg"], ["--target", "opening and a closing"]),
        (["--target", "70 deg, -5 deg"], ["--target", "less than a turn"]),
        (["--target", "-5 deg, 400 deg"], ["--target", "less than a turn"]),
        (["--target", "-5 deg, 70"], ["--target", "no unit", "deg"]),
        (["--set", "engine.intake=cam"], ["engine.intake", "cam", "epv"]),
        (["--out", "timing.csv"], ["timing.csv", "timing.h5"]),
    ],
)
def test_bad_input_is_one_line_that_says_what_would_be_right(apesim, arguments, told):
    code, out, err = apesim("engine", "timing", *arguments)
    assert code == 2 and out == ""
    assert len(err.splitlines()) == 1 and all(word in err for word in told)


def test_nothing_that_is_there_is_replaced_unasked(apesim):
    Path("timing.json").write_text("mine")
    code, _, err = apesim("engine", "timing", "--speed", "600 rpm")
    assert code == 2 and "timing.json" in err and "--overwrite" in err
    assert Path("timing.json").read_text() == "mine"
