"""Controllers over a transient: what they are told, when their commands act, and what is refused."""

import json
from math import nan

import numpy as np
import pytest

import apesim
from apesim import EngineCommands, InputError
from apesim.engine.angles import DEGREE

RAMP = "0 s: 300 rpm, 1.5 s: 1800 rpm, 3 s: 300 rpm"
CONSTANT = "0 s: 600 rpm, 1 s: 600 rpm"
LEAD = "speed [rpm],energise [deg],release [deg]\n0,-5,70\n2500,-95,-65\n"
CLOSED = 1e-9
"""Closure of mass and energy that a march holds."""


def machine(**values):
    return apesim.Machine().with_(**values)


def run(own=None, **arguments):
    return apesim.run_transient(own or machine(), **arguments)


def errors_of(transient, first=0):
    """Errors of opening and closing [deg] from their targets, of the revolutions from one on, (r, 2)."""
    strokes = [transient.march.cylinders[name][first:, 0] / DEGREE for name in ("open", "close")]
    return np.stack(strokes, axis=1) - (-5.0, 70.0)


def rms(values):
    return np.sqrt(np.nanmean(np.square(values), axis=0))


def at_call(number, commands):
    """Controller that commands once, in its call of that number, counted from 0."""
    calls = iter(range(10**6))
    return lambda readings: commands if next(calls) == number else None


def test_feedback_meets_its_targets_through_a_ramp_where_fixed_commands_do_not():
    fixed, feedback = (run(speed=RAMP, timing=timing) for timing in ("fixed", "feedback"))
    assert (rms(errors_of(feedback, 8)) < 0.2 * rms(errors_of(fixed, 8))).all()
    assert (rms(errors_of(feedback, 8)) < 8.0).all()  # 4 and 7 deg: the speed changes by 5 % a revolution
    assert feedback["brake_work"] > 1.3 * fixed["brake_work"]
    assert max(feedback["mass_closure"], feedback["energy_closure"]) < CLOSED


def test_feedback_comes_to_its_targets_at_a_constant_speed():
    settled = errors_of(run(speed="0 s: 900 rpm, 2 s: 900 rpm", timing="feedback"))
    assert np.abs(settled[0]).max() > 15.0
    assert np.abs(settled[-3:]).max() < 0.02


def test_feedback_leads_each_cylinder_to_its_own_targets():
    late = [{}, {"valve.solenoid.dead_time": "2.5 ms", "command.close_target": "80 deg"}]
    own = machine(engine_cylinders=2, cylinder=late)
    march = run(own, speed="0 s: 900 rpm, 2 s: 900 rpm", timing="feedback").march
    assert march.cylinders["open"][-1] / DEGREE == pytest.approx([-5.0, -5.0], abs=0.1)
    assert march.cylinders["close"][-1] / DEGREE == pytest.approx([70.0, 80.0], abs=0.1)


def test_a_controller_that_keeps_what_holds_changes_nothing():
    without = run(speed=RAMP)
    kept, same = (run(speed=RAMP, controller=lambda _, c=c: c) for c in (None, EngineCommands(-5.0, 70.0)))
    np.testing.assert_array_equal(same.march.y, kept.march.y)
    # Not to the bit: the march stops at the end of each revolution, and begins there with a short step.
    for name in ("brake_work", "engine_air", "control_air"):
        assert kept[name] == pytest.approx(without[name], rel=1e-8)
    assert np.abs(errors_of(kept) - errors_of(without)).max() < 1e-5


def test_a_controller_reads_what_the_run_tells_of_each_revolution():
    seen = []
    transient = run(machine(engine_cylinders=2), speed=RAMP, controller=seen.append)
    rows = transient.to_dict()["revolutions"]
    assert len(seen) == len(rows) > 50
    for readings, row in zip(seen, rows, strict=True):
        assert readings.mean_speed_rpm == row["mean_speed_rpm"]
        assert readings.valve_close_deg == tuple(each["valve_close_deg"] for each in row["cylinders"])
        assert readings.engine_air_kg == row["engine_air_kg"]
        dip = readings.supply_pressure_Pa - readings.lowest_receiver_pressure_Pa
        assert dip == pytest.approx(row["receiver_dip_Pa"]) and 0.0 < dip < 0.2e6
        assert readings.lowest_receiver_pressure_Pa <= readings.receiver_pressure_Pa <= readings.supply_pressure_Pa
    assert [readings.turns for readings in seen] == list(range(1, len(seen) + 1))
    assert seen[5].energise_deg == pytest.approx((-5.0, -5.0))


def test_each_cylinder_takes_a_command_at_its_own_180_degrees():
    two = machine(engine_cylinders=2, engine_phases="0 deg, 90 deg")
    command = EngineCommands(release_deg=[60.0, 50.0])
    before, after = (
        run(two, speed=CONSTANT, controller=at_call(3, given)).march.cylinders["close"] / DEGREE
        for given in (None, command)
    )
    # Commanded after revolution 3, read in 4 at 180 and at 270 deg of the shaft, for the strokes that end in 5.
    moved = after - before
    assert np.abs(moved[:5]).max() < 0.01
    assert moved[5:, 0] == pytest.approx(-10.0, abs=1.0)
    assert moved[5:, 1] == pytest.approx(-20.0, abs=1.0)


def test_a_pressure_holds_until_the_next_one_that_is_imposed():
    lower, seen = EngineCommands(supply_pressure_Pa=0.6e6), []

    def controller(readings):
        seen.append(readings.supply_pressure_Pa)
        return lower if len(seen) == 3 else None

    transient = run(speed=CONSTANT, controller=controller, supply="0.65 s: 0.9 MPa abs")
    assert seen == pytest.approx([1101325.0] * 3 + [0.6e6] * 3 + [0.9e6] * 3)
    assert max(transient["mass_closure"], transient["energy_closure"]) < CLOSED
    # Control air follows as with --supply: unless the machine states its own.
    own = run(machine(**{"supply.control_pressure": "1 MPa gauge"}), speed=CONSTANT, controller=at_call(2, lower))
    both = run(speed=CONSTANT, controller=at_call(2, lower))
    assert (
        both.to_dict()["revolutions"][-1]["control_air_kg"] < 0.7 * own.to_dict()["revolutions"][-1]["control_air_kg"]
    )


def test_a_shaft_that_reverses_tells_its_controller_and_closes():
    hoist, speeds = machine(**{"load.constant": "60 N m", "load.kind": "hoist"}), []

    def controller(readings):
        speeds.append(readings.mean_speed_rpm)
        return feedback(readings)

    feedback = apesim.FeedbackTiming(hoist)
    transient = run(hoist, from_speed="500 rpm", duration="1.2 s", controller=controller)
    assert max(speeds) > 300.0 and min(speeds) < -1000.0
    assert max(transient[f"{name}_closure"] for name in ("mass", "energy", "shaft")) < CLOSED
    assert len(speeds) == transient["revolutions"]


def test_a_shaft_that_stays_at_rest_ends_as_it_would_without_a_controller():
    held = run(machine(**{"load.constant": "500 N m"}), duration="0.4 s", angle="30 deg", timing="feedback")
    assert held["duration"] == 0.4 and held["revolutions"] == 0 and held["energy_closure"] < CLOSED


def test_a_map_holds_until_the_controller_commands(tmp_path):
    (tmp_path / "lead.csv").write_text(LEAD)
    args = {"speed": CONSTANT, "timing": tmp_path / "lead.csv"}
    alone, kept = (run(**args, **more).march for more in ({}, {"controller": lambda _: None}))
    np.testing.assert_allclose(kept.cylinders["close"], alone.cylinders["close"], atol=1e-7)
    later = run(**args, controller=at_call(3, EngineCommands(release_deg=80.0))).march
    assert later.cylinders["open"][-1] == pytest.approx(alone.cylinders["open"][-1], abs=0.01)
    assert (later.cylinders["close"][-1] - alone.cylinders["close"][-1]) / DEGREE > 25.0


def test_a_floor_on_the_pulse_lies_over_what_a_controller_commands():
    short = EngineCommands(release_deg=45.0)
    fast = {"speed": "0 s: 1500 rpm, 0.6 s: 1500 rpm", "controller": lambda _: short}
    without, floor = run(**fast), run(**fast, min_pulse="10 ms")
    assert without["strokes_cut_short"] > 10 and floor["strokes_cut_short"] <= 2
    feedback = run(speed=RAMP, timing="feedback", min_pulse="10 ms")
    assert feedback["strokes_cut_short"] == 0


def test_a_controlled_run_is_kept_and_cannot_be_resumed(tmp_path):
    out = tmp_path / "run.h5"
    kept = run(speed=CONSTANT, timing="feedback", out=out)
    assert apesim.read_archive(out)["brake_work"] == kept["brake_work"]
    with pytest.raises(InputError, match="resume: does not go with a controller, of which nothing is kept"):
        run(speed=CONSTANT, timing="feedback", out=out, resume=True)
    with pytest.raises(apesim.ArchiveError):  # no controller, so that it is another run
        run(speed=CONSTANT, out=out, resume=True)


@pytest.mark.parametrize(
    ("returned", "wrong", "right"),
    [
        (7.0, "returned 7.0", "EngineCommands"),
        ((-5.0, 70.0), "returned (-5.0, 70.0)", "EngineCommands"),
        (EngineCommands(nan), "energise_deg = nan", "from -360 to 360"),
        (EngineCommands("-5 deg"), "energise_deg = '-5 deg'", "a number"),
        (EngineCommands([[0.0], [0.0, 1.0]]), "energise_deg = [[0.0], [0.0, 1.0]]", "a number"),
        (EngineCommands([-5.0, 0.0, 5.0]), "for 2 cylinders", "2 of them"),
        (EngineCommands(release_deg=[70.0, 800.0]), "800", "720"),
        (EngineCommands(20.0, 20.0), "release_deg at 20 deg is no later than", "more than 0"),
        (EngineCommands([-5.0, 80.0]), "cylinder 2: release_deg at 70 deg is 10 deg before", "more than 0"),
        (EngineCommands(-100.0, 300.0), "400 deg after", "less than 360"),
        (EngineCommands(supply_pressure_Pa=1.0), "supply_pressure_Pa = 1.0", "absolute"),
        (EngineCommands(supply_pressure_Pa=nan), "supply_pressure_Pa = nan", "absolute"),
    ],
)
def test_a_wrong_return_is_refused_with_one_error(returned, wrong, right):
    with pytest.raises(InputError) as raised:
        run(machine(engine_cylinders=2), speed=CONSTANT, controller=lambda _: returned)
    [fault] = raised.value.faults
    assert fault.key == "controller" and wrong in fault.wrong and right in fault.right, fault


def test_an_error_of_the_controller_itself_comes_through():
    with pytest.raises(ZeroDivisionError):
        run(speed=CONSTANT, controller=lambda readings: 1 / 0)


def test_what_does_not_go_together_is_refused():
    with pytest.raises(InputError, match=r"controller: does not go with the timing \"feedback\"; leave one"):
        run(speed=CONSTANT, timing="feedback", controller=lambda _: None)
    with pytest.raises(InputError, match=r"engine.intake: is cam, which has no commands"):
        run(machine(engine_intake="cam"), speed=CONSTANT, timing="feedback")
    with pytest.raises(InputError, match=r"controller: returned energise_deg, and the intake has no commands"):
        run(machine(engine_intake="cam"), speed=CONSTANT, controller=lambda _: EngineCommands(-5.0))
    with pytest.raises(InputError, match=r"controller: .* write a function"):
        run(speed=CONSTANT, controller="feedback")


def test_feedback_from_the_shell(apesim):
    code, out, _ = apesim(
        "engine", "transient", "--speed", "0 s: 900 rpm, 2 s: 900 rpm", "--timing", "feedback", "--json"
    )
    last = json.loads(out)["revolutions"][-1]["cylinders"][0]
    assert code == 0
    assert last["valve_open_deg"] == pytest.approx(-5.0, abs=0.1)
    assert last["valve_close_deg"] == pytest.approx(70.0, abs=0.1)
