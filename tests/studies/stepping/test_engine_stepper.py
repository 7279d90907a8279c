"""An engine in steps, beside runs of a periodic state and over time."""

from math import pi

import numpy as np
import pytest

import apesim
from apesim import EngineCommands, InputError, Stepper
from apesim.engine.angles import RPM

SAME = 1e-6
"""Relative difference that steps may make: tolerances of a march add up over some turns."""
CLOSED = 1e-9
OTHER = {
    "valve.stroke": "6 mm",
    "ambient.pressure": "95 kPa abs",
    "supply.control_pressure": "0.7 MPa gauge",
    "engine.receiver.volume": "0.4 L",
}
EFFECTS = {"effects.blow_by.area": "1 mm^2", "effects.coulomb_friction.force": "10 N"}
MACHINES = {
    "default": {},
    "other": OTHER,
    "two cylinders": OTHER | {"engine.cylinders": 2},
    "cam": {"engine.intake": "cam", "engine.receiver.volume": "inf"},
    "effects": EFFECTS,
}


def machine(**values):
    return apesim.Machine().with_(**values)


def stepped(stepper, times, inputs=()):
    """State at the end of steps; inputs are taken by the step that begins at their time."""
    inputs, before = dict(inputs), stepper.time
    for time in times:
        stepper.advance(time, **inputs.get(before, {}))
        before = time
    return stepper.state()


def split(end, count, seed, *among):
    return np.unique([*np.random.default_rng(seed).uniform(0.0, end, count), *among, end])


@pytest.mark.parametrize(
    "values", [{"engine.receiver.volume": "inf"}, {"engine.intake": "cam", "engine.receiver.volume": "inf"}]
)
def test_at_an_imposed_speed_it_comes_to_the_torque_of_a_periodic_state(values):
    own = machine(**values)
    run, turn = apesim.run_engine(own, speed="1200 rpm"), 60.0 / 1200.0
    stepper = Stepper(own, "engine", speed="1200 rpm")
    stepped(stepper, np.arange(1, 12) * turn)
    before, after = stepper.state(), stepped(stepper, 11.0 * turn + np.linspace(0.0, turn, 300)[1:])
    torques = [(after[name] - before[name]) / (2.0 * pi) for name in ("gas_work_J", "friction_work_J")]
    assert torques[0] == pytest.approx(run["indicated_torque"], rel=2e-6)
    assert torques[0] - torques[1] == pytest.approx(run["brake_torque"], rel=2e-6)
    air = after["engine_air_kg"] - before["engine_air_kg"]
    assert air == pytest.approx(run["engine_air_kg_per_cycle"], rel=2e-6)


@pytest.mark.parametrize("values", MACHINES.values(), ids=MACHINES)
def test_a_free_shaft_in_steps_is_one_that_is_marched_at_once(values):
    own, end = machine(**values), 0.16
    load, supply = "0.05 s: 6 N m", "0.09 s: 0.9 MPa abs"
    run = apesim.run_transient(own, duration=end, angle="30 deg", load=load, supply=supply, sample=end)
    stepper = Stepper(own, "engine", angle="30 deg")
    inputs = {0.05: {"load": 6.0}, 0.09: {"supply": 0.9e6}}
    state = stepped(stepper, split(end, 300, 3, 0.05, 0.09), inputs)
    assert state["angle_deg"] == pytest.approx(360.0 * run["turns"], rel=SAME)
    assert state["angle_deg"] > 360.0
    for name in ("gas_work_J", "load_work_J"):
        assert state[name] == pytest.approx(run[name], rel=SAME, abs=1e-6)
    assert state["engine_air_kg"] == pytest.approx(run["engine_air"], rel=SAME)
    closure = stepper.closure()
    assert sorted(closure) == ["energy", "mass", "shaft"]
    assert max(closure.values()) < CLOSED


def test_it_begins_in_the_periodic_state_of_a_speed_as_a_transient_does():
    run = apesim.run_transient(machine(), duration=0.1, from_speed="900 rpm", sample="1 ms")
    stepper = Stepper(machine(), "engine", from_speed="900 rpm")
    assert stepper.state()["speed_rad_s"] == pytest.approx(900.0 * RPM, rel=1e-9)
    speeds = []
    for time in run.traces["time"].values[1:]:
        stepper.advance(time)
        speeds.append(stepper.state()["speed_rpm"])
    assert speeds == pytest.approx(run.traces["speed_rpm"].values[1:], rel=SAME)


def test_commands_act_as_those_of_a_controller():
    commands = {2: EngineCommands(-20.0, 50.0), 4: EngineCommands(release_deg=[80.0, 60.0])}
    own, course = machine(engine_cylinders=2, engine_phases="0, 120 deg"), "0 s: 900 rpm, 0.6 s: 900 rpm"
    seen = []

    def controller(readings):
        seen.append(readings)
        return commands.get(readings.turns)

    apesim.run_transient(own, speed=course, controller=controller)
    stepper, told, command = Stepper(own, "engine", speed="900 rpm"), [], None
    for time in 0.5e-3 * np.arange(1, 1201):
        stepper.advance(time, command)
        readings, command = stepper.readings, None
        if readings and (not told or readings.turns > told[-1].turns):
            told.append(readings)
            command = commands.get(readings.turns)
    assert len(told) >= 8
    for ours, theirs in zip(told, seen, strict=False):
        assert ours.time_s == pytest.approx(theirs.time_s, abs=1e-9)
        assert ours.valve_open_deg == pytest.approx(theirs.valve_open_deg, abs=2e-3, nan_ok=True)
        assert ours.valve_close_deg == pytest.approx(theirs.valve_close_deg, abs=2e-3, nan_ok=True)
    assert told[-1].release_deg == pytest.approx((80.0, 60.0))


def test_a_pressure_among_the_commands_is_that_of_the_supply():
    times, states = split(0.1, 50, 7), []
    for inputs in ({"command": EngineCommands(supply_pressure_Pa=0.8e6)}, {"supply": 0.8e6}):
        stepper = Stepper(machine(), "engine", speed="900 rpm")
        states.append(stepped(stepper, times, {times[20]: inputs}))
        assert stepper.readings.supply_pressure_Pa == 0.8e6
    assert states[0] == states[1]


def test_a_supply_temperature_from_the_start_is_that_of_a_machine_with_it():
    own = machine(engine_receiver_volume="inf")
    other, times = machine(engine_receiver_volume="inf", supply_temperature="340 K"), split(0.36, 60, 2)
    states = []
    for each, inputs in ((own, {0.0: {"temperature": 340.0}}), (other, {})):
        stepper = Stepper(each, "engine", speed="1000 rpm")
        states.append(stepped(stepper, times, inputs))
    cold = stepped(Stepper(own, "engine", speed="1000 rpm"), times)
    # Chamber A began colder; its air has gone.
    assert states[0]["cylinder_temperature_K"] == pytest.approx(states[1]["cylinder_temperature_K"], rel=1e-3)
    assert states[0]["cylinder_temperature_K"] > 1.05 * cold["cylinder_temperature_K"]


def test_an_imposed_speed_holds_over_its_steps_and_may_turn_round():
    stepper = Stepper(machine(), "engine", speed="600 rpm")
    stepper.advance(0.05)
    stepper.advance(0.07, speed=100.0)
    angle = np.degrees(600.0 * RPM * 0.05 + 100.0 * 0.02)
    assert stepper.state()["angle_deg"] == pytest.approx(angle, rel=1e-9)
    stepper.advance(0.08, speed=0.0)
    stepper.advance(0.10, speed=-50.0)
    assert stepper.state()["angle_deg"] == pytest.approx(angle - np.degrees(50.0 * 0.02), rel=1e-9)
    assert sorted(stepper.closure()) == ["energy", "mass"]
    assert max(stepper.closure().values()) < CLOSED


@pytest.mark.parametrize("values", [OTHER | {"engine.cylinders": 2}, {"engine.intake": "cam"}])
def test_what_is_restored_goes_on_to_the_same_bits(values):
    own, times = machine(**values), split(0.2, 200, 4)
    has_commands = "engine.intake" not in values
    inputs = {times[20]: {"command": EngineCommands(-15.0, 50.0)}} if has_commands else {}
    later = {times[90]: {"supply": 0.95e6, "load": 4.0, "temperature": 300.0}}
    stepper, ends = Stepper(own, "engine", angle="40 deg"), []
    stepped(stepper, times[:60], inputs)
    kept = stepper.snapshot()
    for each in (stepper, Stepper(own, "engine"), stepper):
        each.restore(kept)
        parts = each.state(), stepped(each, times[60:], later), each.readings, each.closure()
        ends.append(list(map(repr, parts)))  # a cam has no pressures: NaN is not itself
        each.advance(0.3, supply=1.3e6, load=1.0)
    assert ends[0] == ends[1] == ends[2]
    assert ends[0][2] != "None"


def test_a_long_step_has_room_for_its_events():
    own = machine(engine_cylinders=2)
    stepper = Stepper(own, "engine", speed="2400 rpm")
    stepper.advance(1.5)
    assert stepper.readings.turns == 59
    assert stepper.state()["angle_deg"] == pytest.approx(60.0 * 360.0, rel=1e-9)


def test_a_snapshot_of_a_free_shaft_is_refused_where_the_speed_is_imposed():
    own = machine()
    with pytest.raises(InputError, match="snapshot: is of something else"):
        Stepper(own, "engine", speed="600 rpm").restore(Stepper(own, "engine").snapshot())


@pytest.mark.parametrize(
    ("own", "options", "inputs", "told"),
    [
        ({}, {"speed": "600 rpm"}, {"load": 5.0}, "load: is given, and the speed is imposed; leave it out"),
        ({}, {}, {"speed": 50.0}, "speed: is given, and the shaft is free; leave it out"),
        ({}, {"speed": "600 rpm"}, {"speed": 1e5}, "speed: 100000.0; give a speed from -3141.59 to 3141.59 rad/s"),
        ({}, {}, {"load": np.nan}, "load: nan; give a torque from"),
        ({}, {}, {"command": 1}, r"command: 1; give an apesim.EngineCommands"),
        ({}, {}, {"command": EngineCommands(400.0)}, r"command: energise_deg = 400.0; give a number from -360"),
        ({}, {}, {"command": EngineCommands(80.0)}, r"command: for cylinder 1: release_deg at 70 deg is 10 deg before"),
        ({}, {}, {"command": EngineCommands(supply_pressure_Pa=0.0)}, r"command: supply_pressure_Pa = 0.0"),
        ({"engine_intake": "cam"}, {}, {"command": EngineCommands(0.0)}, "energise_deg, and the intake has no command"),
        ({}, {}, {"supply": -1.0}, "supply: -1.0; give an absolute pressure"),
    ],
)
def test_a_wrong_input_is_refused_and_changes_nothing(own, options, inputs, told):
    stepper = Stepper(machine(**own), "engine", **options)
    stepper.advance(0.01)
    state = repr(stepper.state())
    with pytest.raises(InputError, match=told):
        stepper.advance(0.02, **inputs)
    assert repr(stepper.state()) == state
    stepper.advance(0.02)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"speed": "600 rpm", "from_speed": "600 rpm"}, r"speed: does not go with `from_speed`"),
        ({"angle": "10 deg", "from_speed": "600 rpm"}, r"angle: does not go with `from_speed`"),
        ({"speed": 600}, r"Stepper\(\): speed: .*unit|Stepper\(\): speed: 600"),
        ({"angle": "30"}, r"Stepper\(\): angle: "),
    ],
)
def test_arguments_that_do_not_go_together_are_refused(options, told):
    with pytest.raises(InputError, match=told):
        Stepper(machine(), "engine", **options)
