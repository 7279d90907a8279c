"""What the effects of the measurement do to a record, by cases worked by hand."""

import numpy as np
import pytest
from scipy.integrate import quad

from apesim.engine.angles import DEGREE
from apesim.engine.effects import ALL_EFFECTS
from apesim.engine.effects.speed_ripple import SpeedRipple, true_angle
from apesim.engine.effects.tdc_error import TdcError
from apesim.reading import LAG_STEP, Reading, followed, stepped
from apesim.studies.measured.prediction import predict, run_of
from apesim.valve.effects.channel_swap import ChannelSwap
from apesim.valve.effects.clock_error import ClockError
from apesim.valve.effects.lift_sensor_lag import LiftSensorLag
from apesim.valve.effects.pressure_sensor_lag import PressureSensorLag
from apesim.valve.effects.sensor_gain import SensorGain
from apesim.valve.effects.sensor_offset import SensorOffset
from apesim.valve.effects.time_zero import TimeZero
from tests.machines import changed, machine, turned_on
from tests.studies.measured.test_prediction import ENERGISE, TIMES, engine_run, valve_run

LIBRARY = {effect.parameters: effect for effect in ALL_EFFECTS if effect.sensor}
SOME = np.array([-2e-3, 0.0, 3.3e-3, 3.31e-3, 20e-3])
LIFTS, TORQUE = {("valve", "lift"), ("engine", "lift")}, {("engine", "torque")}
PRESSURES = {("valve", "pressure_b"), ("engine", "cylinder_pressure")}
OVER_ANGLE = {("engine", "cylinder_pressure"), ("engine", "lift")}
CHANGED = {
    "lift_sensor_lag": LIFTS,
    "pressure_sensor_lag": PRESSURES,
    "sensor_gain": LIFTS | PRESSURES | TORQUE,
    "sensor_offset": LIFTS | PRESSURES | TORQUE,
    "time_zero": {("valve", "lift"), ("valve", "pressure_b")},
    "clock_error": {("valve", "lift"), ("valve", "pressure_b")},
    "channel_swap": {("valve", "pressure_b")},
    "tdc_error": OVER_ANGLE,
    "speed_ripple": OVER_ANGLE,
}
"""What each effect changes, of lift, a pressure and the torque on both benches."""
every = pytest.mark.parametrize("effect", LIBRARY.values(), ids=[effect.name for effect in LIBRARY.values()])


def after(parameters, reading):
    return LIBRARY[type(parameters)].sensor(parameters, reading)


def ramps(times):
    """Channels that rise from time 0 on."""
    up = np.maximum(times, 0.0)
    return {"lift": 2.0 * up, "pressure_a": 1e5 + 3.0 * up, "cylinder_pressure": 4.0 * up, "torque": 5.0}


def on_engine(channels, rpm=1000.0):
    return Reading(channels, rpm * np.pi / 30.0, ENERGISE)


# --- lags ---


@pytest.mark.parametrize("lag", [2e-5, 0.5e-3])
def test_a_lagging_ramp_is_late_by_the_lag_once_it_has_begun(lag):
    lift = after(LiftSensorLag(lag), Reading(ramps)).at(SOME)
    expected = 2.0 * (np.maximum(SOME, 0.0) - lag * (1.0 - np.exp(-np.maximum(SOME, 0.0) / lag)))
    assert lift["lift"] == pytest.approx(expected, abs=1e-12)
    assert lift["lift"][-1] == pytest.approx(2.0 * (20e-3 - lag), abs=1e-12)


def test_a_lag_holds_for_the_channels_of_its_kind_alone():
    true = ramps(SOME)
    lift = after(LiftSensorLag(1e-4), Reading(ramps)).at(SOME)
    pressures = after(PressureSensorLag(1e-4), Reading(ramps)).at(SOME)
    assert {name for name in true if not np.array_equal(lift[name], true[name])} == {"lift"}
    assert {name for name in true if not np.array_equal(pressures[name], true[name])} == {
        "pressure_a",
        "cylinder_pressure",
    }
    assert pressures["pressure_a"][0] == 1e5


def test_a_lagging_sine_is_weaker_and_late_as_first_order_has_it():
    lag, omega, times = 0.3e-3, 2.0 * np.pi * 200.0, np.linspace(0.0, 0.02, 101)
    found = after(LiftSensorLag(lag), Reading(lambda t: {"lift": np.sin(omega * t)})).at(times)["lift"]
    # 25 time constants of history begin within 1e-9 of the settled response.
    expected = np.sin(omega * times - np.arctan(omega * lag)) / np.sqrt(1.0 + (omega * lag) ** 2)
    assert found == pytest.approx(expected, abs=5e-5)


def test_a_lag_follows_a_straight_signal_exactly():
    lag, times = 3e-5, LAG_STEP * np.arange(7)
    found = followed(1.0 + 2e4 * times, lag)
    assert found == pytest.approx(1.0 + 2e4 * (times - lag * (1.0 - np.exp(-times / lag))), rel=1e-14)
    after = np.array([4.5e-6, 0.0])
    between = stepped(found[:2], 1.0 + 2e4 * times[:2], 1.0 + 2e4 * (times[:2] + after), after, lag)
    assert between[0] == pytest.approx(1.0 + 2e4 * (4.5e-6 - lag * (1.0 - np.exp(-0.15))), rel=1e-14)
    assert between[1] == found[1]


# --- gain and offset ---


def test_gain_and_offset_act_on_their_channel_alone():
    true = ramps(SOME)
    scaled = after(SensorGain(lift=0.1, torque=-0.2), Reading(ramps)).at(SOME)
    shifted = after(SensorOffset(pressure_a=7.0, torque=1.0), Reading(ramps)).at(SOME)
    assert scaled["lift"] == pytest.approx(1.1 * true["lift"], rel=1e-15)
    assert shifted["pressure_a"].tolist() == (true["pressure_a"] + 7.0).tolist()
    assert (scaled["torque"], shifted["torque"]) == (4.0, 6.0)
    assert np.array_equal(scaled["pressure_a"], true["pressure_a"])
    assert np.array_equal(shifted["lift"], true["lift"])


# --- time and angle ---


def test_a_late_record_shows_what_was_before_on_a_valves_bench_alone():
    late = after(TimeZero(1e-3), Reading(ramps)).at(SOME)
    assert late["lift"] == pytest.approx(2.0 * np.maximum(SOME - 1e-3, 0.0))
    assert np.array_equal(after(TimeZero(1e-3), on_engine(ramps)).at(SOME)["lift"], ramps(SOME)["lift"])


def test_a_fast_clock_shows_what_was_before_the_more_the_later_on_a_valves_bench_alone():
    fast = after(ClockError(0.02), Reading(ramps)).at(SOME)
    assert fast["lift"] == pytest.approx(2.0 * np.maximum(SOME, 0.0) / 1.02)
    assert np.array_equal(after(ClockError(0.02), on_engine(ramps)).at(SOME)["lift"], ramps(SOME)["lift"])


def test_swapped_chambers_stand_under_each_others_name_and_crosstalk_between():
    def both(times):
        return {"pressure_a": 5e5 + times, "pressure_b": 1e5 - times, "lift": times}

    swapped, mixed = (after(ChannelSwap(share), Reading(both)).at(SOME) for share in (1.0, 0.25))
    assert swapped["pressure_a"] == pytest.approx(both(SOME)["pressure_b"], rel=1e-12)
    assert swapped["pressure_b"] == pytest.approx(both(SOME)["pressure_a"], rel=1e-12)
    assert mixed["pressure_a"] == pytest.approx(4e5 + 0.5 * SOME, rel=1e-12)
    assert np.array_equal(swapped["lift"], both(SOME)["lift"])
    assert np.array_equal(after(ChannelSwap(1.0), Reading(ramps)).at(SOME)["pressure_a"], ramps(SOME)["pressure_a"])


def test_an_error_of_the_dead_centre_is_one_of_angle_on_an_engine_alone():
    late = after(TdcError(1.5 * DEGREE), on_engine(ramps)).at(SOME)  # 1.5 degrees of 6000 a second: 0.25 ms
    assert late["lift"] == pytest.approx(2.0 * np.maximum(SOME - 0.25e-3, 0.0))
    assert np.array_equal(after(TdcError(1.5 * DEGREE), Reading(ramps)).at(SOME)["lift"], ramps(SOME)["lift"])


@pytest.mark.parametrize("degrees", [-170.0, -90.0, 30.0, 90.0, 180.0, 359.0, 800.0])
def test_a_crank_that_turns_unevenly_takes_the_time_that_its_speed_says(degrees):
    share, true = 0.04, degrees * DEGREE
    mean = 1.0 / np.sqrt(1.0 - share**2)  # so that a turn takes as long as an even one
    recorded, _ = quad(lambda angle: 1.0 / (mean * (1.0 + share * np.sin(angle))), 0.0, true)
    assert true_angle(share, np.array([recorded]))[0] == pytest.approx(true, abs=1e-9)


def test_an_uneven_crank_agrees_with_the_recorder_at_every_top_dead_centre():
    turns = 2.0 * np.pi * np.arange(-2, 3)
    assert true_angle(0.04, turns) == pytest.approx(turns, abs=1e-12)
    assert np.degrees(true_angle(0.04, np.array([np.pi])))[0] - 180.0 == pytest.approx(4.58, abs=0.01)


def test_the_record_of_an_uneven_crank_is_that_of_its_true_angles():
    run = engine_run()

    def angles(times):
        return {"lift": run.speed * times + ENERGISE}

    found = after(SpeedRipple(0.03), on_engine(angles)).at(run.times)["lift"]
    assert found == pytest.approx(true_angle(0.03, run.angles), abs=1e-12)
    assert after(SpeedRipple(0.03), Reading(ramps)).at(SOME)["lift"].tolist() == ramps(SOME)["lift"].tolist()


# --- through the whole prediction ---


def predicted(run, names, *parameters):
    """A prediction with an effect's parameters."""
    at = run_of(machine(), run)
    own = {LIBRARY[type(values)].name: values for values in parameters}
    found = predict(at._replace(effects=at.effects._replace(**own)), run, names)
    return found.channels | found.means, found.marks


@every
@pytest.mark.compiled
def test_an_effect_of_the_measurement_changes_what_is_predicted_and_off_no_bit(effect):
    strengths = effect.strengths or effect.parameters._fields[:1]
    off, changed_channels = effect.parameters(**dict.fromkeys(strengths, -0.0)), set()
    valve_names = ["lift", "pressure_b", "pressure_a"]  # the last for effects that mix both
    for run, names in ((valve_run(), valve_names), (engine_run(), ["cylinder_pressure", "lift", "torque"])):
        (plain, marks), (idle, _), (on, marks_on) = (
            predicted(run, names, *parameters) for parameters in ((), (off,), (turned_on(effect),))
        )
        assert all(np.array_equal(idle[name], plain[name]) for name in names)
        assert marks_on.keys() == marks.keys()
        changed_names = [name for name in names if not np.array_equal(on[name], plain[name])]
        changed_channels |= {(run.bench, name) for name in changed_names if name != "pressure_a"}
    assert changed_channels == CHANGED[effect.name]


def test_a_lagging_lift_sensor_is_late_by_its_lag_in_mid_flight():
    """The lag of a ramp is its time, and the flight is nearly one."""
    run = valve_run(times=np.arange(0.0, 0.03, 1e-5))
    at = run_of(machine(), run)
    true, late = (
        predict(one, run, ["lift"]).channels["lift"]
        for one in (at, changed(at, {"effects.lift_sensor_lag.time": 1e-4}))
    )
    crossing = [np.interp(4.5e-3, lift[: np.argmax(lift)], run.times[: np.argmax(lift)]) for lift in (true, late)]
    assert crossing[1] - crossing[0] == pytest.approx(1e-4, rel=0.05)
    assert true[-1] == 9e-3
    assert late[-1] == pytest.approx(9e-3, rel=1e-12)


def test_lag_gain_and_offset_are_passed_in_the_order_of_the_signal():
    """Before the pulse, a lag shows what stands; gain, then offset, are applied to that."""
    run = valve_run()
    effects = {"lift_sensor_lag.time": 3e-4, "sensor_gain.lift": 0.1, "sensor_offset.lift": 1e-3}
    at = changed(run_of(machine(), run), {f"effects.{name}": value for name, value in effects.items()})
    lift = predict(at, run, ["lift"]).channels["lift"]
    assert lift[TIMES < 0.0] == pytest.approx(1e-3)
    assert lift.max() == pytest.approx(1.1 * 9e-3 + 1e-3)
