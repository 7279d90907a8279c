"""Plausibility: each check fires on its fault, and is silent on the nearest honest data.

Honest data are those of the machine with the noise of usual sensors. That no effect of the library is called a fault is
tried at the ends of its range, and that the checks say the likely reason, in its words.
"""

import itertools
import typing
from functools import cache

import numpy as np
import pytest

from apesim.engine.effects import ALL_EFFECTS
from apesim.engine.machine import Machine
from apesim.quantities import Choice, InputError
from apesim.studies.measured import Measured, MeasuredRun, read_measured
from apesim.studies.measured.plausibility import examine, refuse_faults
from apesim.studies.measured.prediction import predict, run_of, with_value
from apesim.valve.effects import VALVE_EFFECTS
from tests.folders import ROOT
from tests.machines import AMBIENT

MACHINE = Machine()
NOISE = {
    "lift": 3e-5,
    "velocity": 0.02,
    "pressure_a": 2e3,
    "pressure_b": 2e3,
    "temperature_a": 1.0,
    "cylinder_pressure": 5e3,
}
USUAL = "lift", "pressure_a", "pressure_b"


@cache
def valve(supply=0.4, start=-5e-3, pulse=50e-3, late=0.0, channels=USUAL, seed=0, changed=()):
    """A run of the valve's bench, its trigger late by some time [s], of a machine with changed keys."""
    machine = MACHINE
    for key, value in changed:
        machine = with_value(machine, key, value)
    times = np.arange(start, 0.12, 0.25e-3)
    name = f"p{supply}_{seed}"
    placeholder = dict.fromkeys(channels, times)
    run = MeasuredRun(name, f"{name}.csv", supply * 1e6 + AMBIENT, 290.0, pulse, "fit", times + late, placeholder)
    shown = predict(run_of(machine, run), run)
    assert not shown.failed
    return with_noise(run._replace(times=times), shown.channels, seed)


@cache
def engine(supply=1.0, rpm=600.0, turned=0.0, channels=("lift", "cylinder_pressure"), seed=0, changed=()):
    """A run of the engine's bench, its top dead centre off by some angle [deg]."""
    machine = MACHINE
    for key, value in changed:
        machine = with_value(machine, key, value)
    angles, speed = np.radians(np.arange(360.0)), rpm * np.pi / 30.0
    energise, release = machine.command.energise, machine.command.release
    run = MeasuredRun(
        f"n{rpm:g}_{seed}",
        f"n{rpm:g}_{seed}.csv",
        supply * 1e6 + AMBIENT,
        287.0,
        np.nan,
        "fit",
        (angles + np.radians(turned) - energise) / speed,
        dict.fromkeys(channels, angles),
        bench="engine",
        speed=speed,
        energise=energise,
        release=release,
        angles=angles,
        means={"torque": 0.0, "air_flow": 0.0},
    )
    shown = predict(run_of(machine, run), run)
    assert not shown.failed
    return with_noise(run._replace(times=(angles - energise) / speed, means=shown.means), shown.channels, seed)


def with_noise(run, channels, seed):
    rng = np.random.default_rng(seed)
    return run._replace(
        channels={name: values + NOISE[name] * rng.standard_normal(len(values)) for name, values in channels.items()}
    )


def with_channels(run, **channels):
    return run._replace(channels=run.channels | channels)


def findings(*runs, noise=None):
    return examine(MACHINE, Measured("measured", noise or {}, runs, runs[0].bench)).findings


def said(*runs, noise=None):
    """Kind, check and reason of each finding."""
    return [(str(one.kind), str(one.check), one.reason) for one in findings(*runs, noise=noise)]


# --- honest data ---


@pytest.mark.parametrize("supply", [0.16, 0.4, 1.0])
@pytest.mark.parametrize("start", [-5e-3, 0.0])
def test_honest_data_of_the_valve_are_silent(supply, start):
    for channels in (USUAL, ("lift",), ("velocity", "temperature_a")):
        assert said(valve(supply, start, channels=channels)) == []


def test_honest_repeats_are_silent():
    assert said(valve(seed=0), valve(seed=1)) == []


@pytest.mark.parametrize("rpm", [600.0, 1200.0])
def test_honest_data_of_the_engine_are_silent(rpm):
    assert said(engine(rpm=rpm)) == []


@pytest.mark.parametrize("folder", ["laboratory", "missing_effect/solenoid", "missing_effect/coulomb_lift_alone"])
def test_the_data_of_the_examples_are_silent(folder):
    measured = read_measured(ROOT / "docs" / "examples" / "data" / folder, AMBIENT)
    assert examine(MACHINE, measured).findings == []


def ends_of(effect):
    """Parameters of an effect at the ends of their ranges, all combinations; of many, one at a time.

    A reference that a slope is counted from has no size of its own: at its ends the slope would be that of no rig.
    """
    hints = typing.get_type_hints(effect.parameters, include_extras=True)
    ends = {name: ends_in(hint) for name, hint in hints.items() if name != "reference"}
    if len(ends) > 4:
        return [((name, value),) for name, values in ends.items() for value in values]
    return [tuple(zip(ends, values, strict=True)) for values in itertools.product(*ends.values())]


def ends_in(hint):
    """Ends of the range of a parameter; all of its choices."""
    [declared] = hint.__metadata__
    return range(len(declared.options)) if isinstance(declared, Choice) else sorted(set(declared.ends))


PHYSICS = [effect for effect in VALVE_EFFECTS if not effect.tabulated and effect.sensor is None]


@pytest.mark.slow
@pytest.mark.parametrize("effect", PHYSICS, ids=lambda effect: effect.name)
def test_no_effect_of_the_valve_is_called_a_fault(effect):
    for ends in ends_of(effect):
        changed = tuple((f"effects.{effect.name}.{key}", value) for key, value in ends)
        for channels in (("lift",), USUAL):
            runs = [valve(supply, channels=channels, changed=changed) for supply in (0.14, 0.6)]
            faults = [one for one in findings(*runs) if one.kind == "fault"]
            assert not faults, (ends, faults)


@pytest.mark.slow
@pytest.mark.parametrize(
    "effect",
    [effect for effect in ALL_EFFECTS if effect not in VALVE_EFFECTS and not effect.tabulated],
    ids=lambda effect: effect.name,
)
def test_no_effect_of_the_engine_is_called_a_fault(effect):
    for ends in ends_of(effect):
        changed = tuple((f"effects.{effect.name}.{key}", value) for key, value in ends)
        faults = [one for one in findings(engine(0.8, 800.0, changed=changed)) if one.kind == "fault"]
        assert not faults, (ends, faults)


# --- pressures ---


@pytest.mark.parametrize("channel", ["pressure_a", "pressure_b"])
@pytest.mark.parametrize(
    ("factor", "added", "reason"),
    [
        (1.0, -AMBIENT, "gauge called abs?"),
        (1.0, AMBIENT, "abs called gauge?"),
        (10.0, 0.0, "bar called MPa, or 10 times too large?"),
        (10.0, -9.0 * AMBIENT, "bar called MPa, or 10 times too large?"),
    ],
)
def test_a_pressure_in_another_unit_is_a_fault(channel, factor, added, reason):
    run = valve()
    [(kind, check, why)] = said(with_channels(run, **{channel: factor * run.channels[channel] + added}))
    assert (kind, why) == ("fault", reason)
    assert check in ("level", "pressure below zero")


def test_a_back_pressure_is_no_fault_of_the_gauge():
    run = valve()
    raised = np.maximum(
        run.channels["pressure_a"], AMBIENT + 30e3 + 2e3 * np.random.default_rng(1).standard_normal(500)
    )
    assert said(with_channels(run, pressure_a=raised)) == []


@pytest.mark.parametrize(("added", "reason"), [(-AMBIENT, "gauge called abs"), (AMBIENT, "abs called gauge")])
@pytest.mark.parametrize("supply", [0.16, 0.4, 1.0])
def test_a_supply_of_another_kind_is_a_fault(supply, added, reason):
    run = valve(supply)
    [(kind, check, why)] = said(run._replace(supply=run.supply + added))
    assert (kind, check) == ("fault", "supply")
    assert why.startswith(reason)


def test_a_regulator_that_is_off_by_a_few_per_cent_is_silent_and_by_a_tenth_a_warning():
    run = valve()
    assert said(run._replace(supply=run.supply + 15e3)) == []
    assert [(kind, check) for kind, check, _ in said(run._replace(supply=run.supply + 55e3))] == [("warning", "supply")]


def test_swapped_chambers_are_said_once():
    run = valve()
    a, b = run.channels["pressure_a"], run.channels["pressure_b"]
    assert said(with_channels(run, pressure_a=b, pressure_b=a)) == [("fault", "swapped chambers", "a and b swapped?")]
    assert said(run._replace(channels={"pressure_a": b})) == [("fault", "swapped chambers", "a and b swapped?")]


@pytest.mark.parametrize("lift_unit", [1e-6, 1e-8])  # bar and kPa under the lift's mm
def test_lift_and_pressure_swapped_are_said_once(lift_unit):
    run = valve()
    lift, a, b = (run.channels[name] for name in USUAL)
    swapped = with_channels(run, lift=lift_unit * a, pressure_a=1e8 * lift)
    why = "lift and pressure_a swapped?"
    assert said(swapped) == [("fault", "lift and pressure swapped", why)]
    assert said(swapped._replace(channels={k: v for k, v in swapped.channels.items() if k != "pressure_b"})) == said(
        swapped
    )
    turned = with_channels(run, lift=MACHINE.valve.stroke - lift, pressure_a=b, pressure_b=a)
    assert why not in {each for _, _, each in said(turned)}


# --- lift, velocity, temperature ---


@pytest.mark.parametrize(
    ("factor", "added", "reason"),
    [
        (1e3, 0.0, "µm called mm, or mm called m?"),
        (1e-3, 0.0, "mm called µm, or m called mm?"),
        (10.0, 0.0, "mm called cm?"),
        (-1.0, 0.0, "inverted?"),
        (-1.0, 9e-3, "inverted, measured from the open stop?"),
        (1.0, 1e-3, "zero not set, or the sensor slipped?"),
        (1.0, -1e-3, "zero not set, or the sensor slipped?"),
        (1.1, 0.0, "is valve.stroke of the machine the rig's, or the gain of the sensor?"),
    ],
)
@pytest.mark.parametrize("channels", [("lift",), USUAL])
def test_a_lift_that_cannot_be_one_is_a_fault(channels, factor, added, reason):
    run = valve(channels=channels)
    [(kind, _, why)] = said(with_channels(run, lift=factor * run.channels["lift"] + added))
    assert (kind, why) == ("fault", reason)


def test_a_lift_within_five_per_cent_is_silent():
    run = valve()
    assert said(with_channels(run, lift=1.02 * run.channels["lift"] - 0.1e-3)) == []


@pytest.mark.parametrize("zero", [0.23e-3, -0.2e-3])
def test_a_lift_that_rests_beside_zero_is_a_hint(zero):
    for run in (valve(), engine()):
        [one] = findings(with_channels(run, lift=run.channels["lift"] + zero))
        assert (one.kind, one.channel) == ("hint", "lift")
        assert f"rests at {1e3 * zero:.2g}"[:11] in one.seen and "times its noise" in one.seen


@pytest.mark.parametrize(("turns", "drift"), [(1, 100e3), (1, -100e3), (2, 100e3)])
@pytest.mark.parametrize("channel", ["cylinder_pressure", "pressure_a"])
def test_a_pressure_that_does_not_come_back_after_a_turn_is_a_warning(channel, turns, drift):
    for rpm in (600.0, 1200.0):
        run = engine(rpm=rpm, channels=(channel,))
        angles = np.radians(np.arange(360.0 * turns))
        rng = np.random.default_rng(2)
        values = np.tile(run.channels[channel], turns) + 1e3 * rng.standard_normal(len(angles))
        run = run._replace(angles=angles, times=(angles - run.energise) / run.speed, channels={channel: values})
        assert said(run) == []
        [one] = findings(with_channels(run, **{channel: values + drift * angles / angles[359]}))
        assert (one.kind, one.check, one.channel) == ("warning", "open turn", channel)
        assert ("higher" if drift > 0.0 else "lower") in one.seen


def test_a_velocity_that_is_turned_round_or_in_another_unit_is_a_fault():
    run = valve(channels=("velocity", "temperature_a"))
    velocity = run.channels["velocity"]
    assert said(with_channels(run, velocity=-velocity)) == [("fault", "inverted", "inverted?")]
    assert said(with_channels(run, velocity=1e3 * velocity)) == [("fault", "level", "mm/s called m/s?")]
    assert said(with_channels(run, velocity=1.8 * velocity)) == []


def test_temperatures_in_another_unit_are_told():
    run = valve(channels=("lift", "temperature_a"))
    temperature = run.channels["temperature_a"]
    assert said(with_channels(run, temperature_a=temperature - 273.15)) == [("fault", "temperature", "degC called K?")]
    assert said(with_channels(run, temperature_a=temperature + 273.15)) == [("fault", "temperature", "K called degC?")]
    slow = 290.0 + 0.05 * (temperature - 290.0)  # a thermocouple hardly follows
    assert said(with_channels(run, temperature_a=slow)) == []
    assert ("warning", "temperature", "K called degC?") in said(run._replace(temperature=563.15))


# --- times ---


@pytest.mark.parametrize("channels", [("lift",), USUAL])
@pytest.mark.parametrize("start", [-5e-3, 0.0])
@pytest.mark.parametrize("late", [10e-3, -10e-3])
def test_a_trigger_that_is_ten_milliseconds_off_is_a_fault_that_says_so(channels, start, late):
    [one] = findings(valve(start=start, late=late, channels=channels))
    assert (one.kind, one.reason) == ("fault", f"trigger 10.0 ms {'late' if late > 0.0 else 'early'}?")
    assert one.right.startswith(f"{'add' if late > 0.0 else 'take'} 10.0 ms")


@pytest.mark.parametrize("channels", [("lift",), USUAL])
@pytest.mark.parametrize(
    ("factor", "reason"), [(1e3, "ms called s, or µs called ms?"), (1e-3, "s called ms, or ms called µs?")]
)
@pytest.mark.parametrize("supply", [0.16, 0.8])
def test_times_in_another_unit_are_a_fault_and_nothing_else(supply, factor, reason, channels):
    run = valve(supply, channels=channels)
    assert said(run._replace(times=factor * run.times)) == [("fault", "unit of time", reason)]


@pytest.mark.parametrize("late", [2e-3, -2e-3])
def test_a_trigger_that_is_two_milliseconds_off_is_a_warning(late):
    [(kind, check, reason)] = said(valve(late=late))
    assert (kind, check, reason) == ("warning", "time zero", f"trigger 2.0 ms {'late' if late > 0.0 else 'early'}?")


def test_a_trigger_that_is_a_millisecond_off_is_left_to_the_fit():
    assert said(valve(late=1e-3)) == []


@pytest.mark.parametrize("channels", [("lift",), USUAL])
@pytest.mark.parametrize(("true", "stated"), [(50e-3, 5e-3), (5e-3, 50e-3), (50e-3, 500e-3)])
def test_a_pulse_that_was_ten_times_another_is_a_fault(channels, true, stated):
    run = valve(pulse=true, channels=channels)._replace(pulse=stated)
    [(kind, check, reason)] = said(run)
    assert (kind, check) == ("fault", "pulse")
    assert reason == f"{1e3 * true:g} ms called {1e3 * stated:g} ms?"


def test_a_pulse_that_was_a_fifth_longer_is_told_by_pressures_and_doubted_by_lift():
    assert said(valve()._replace(pulse=38e-3))[0][:2] == ("fault", "pulse")
    assert said(valve(channels=("lift",))._replace(pulse=38e-3))[0][:2] == ("warning", "pulse")
    assert said(valve()._replace(pulse=48e-3)) == []


# --- records ---


def test_a_channel_that_never_moves_is_a_fault():
    run = valve()
    rng = np.random.default_rng(1)
    assert [one[:2] for one in said(with_channels(run, pressure_a=np.full(500, 5e5)))] == [("fault", "never moves")]
    still = with_channels(run, pressure_a=5e5 + 2e3 * rng.standard_normal(500))
    assert [one[:2] for one in said(still)] == [("fault", "never moves")]


def test_a_lift_that_does_not_move_in_one_run_may_be_real():
    still = 3e-5 * np.random.default_rng(1).standard_normal(500)
    assert [one[:2] for one in said(with_channels(valve(), lift=still), valve(seed=1))] == [("warning", "never moves")]
    assert [one[:2] for one in said(with_channels(valve(), lift=still))] == [("fault", "never moves")]


@pytest.mark.parametrize(("channel", "end"), [("pressure_a", 4e5), ("pressure_b", 3e5), ("lift", 8e-3)])
def test_a_flat_top_that_noise_cannot_make_is_a_fault(channel, end):
    run = valve()
    cut = with_channels(run, **{channel: np.minimum(run.channels[channel], end)})
    assert [one[:2] for one in said(cut)] == [("fault", "clipped")]


def test_a_flat_top_without_any_noise_is_a_simulators():
    run = valve()
    smooth = predict(run_of(MACHINE, run), run).channels
    assert said(run._replace(channels=smooth)) == []


def test_a_lift_whose_negative_values_were_cut_off_is_a_warning():
    run = valve()
    cut = with_channels(run, lift=np.maximum(run.channels["lift"], 0.0))
    assert [one[:2] for one in said(cut)] == [("warning", "often at its end")]


def test_steps_above_the_noise_are_told():
    run = valve()

    def stepped(step):
        return with_channels(run, lift=np.round(run.channels["lift"] / step) * step)

    assert [one[:2] for one in said(stepped(0.5e-3))] == [("fault", "quantised")]
    assert [one[:2] for one in said(stepped(0.2e-3))] == [("warning", "quantised")]
    assert [one[:2] for one in said(stepped(0.2e-3), noise={"lift": 3e-5})] == [("fault", "quantised")]
    assert said(stepped(0.05e-3)) == []


def test_spikes_are_a_warning_and_move_no_level():
    run = valve()
    lift, pressure = run.channels["lift"].copy(), run.channels["pressure_a"].copy()
    lift[[60, 61]], pressure[[300, 400]] = 30e-3, 2e6
    told = findings(with_channels(run, lift=lift, pressure_a=pressure))
    assert [(one.kind, one.check, one.channel) for one in told] == [
        ("warning", "spikes", "lift"),
        ("warning", "spikes", "pressure_a"),
    ]


def test_a_gap_in_time_is_a_warning():
    run = valve()
    kept = (run.times < 59.9e-3) | (run.times > 70.1e-3)  # between samples, so that rounding decides about none
    cut = run._replace(times=run.times[kept], channels={name: each[kept] for name, each in run.channels.items()})
    [one] = findings(cut)
    assert (one.kind, one.check) == ("warning", "gaps in time")
    assert "from 59.75 to 70.25 ms" in one.seen


@pytest.mark.parametrize(("jitter", "kind"), [(0.05, "hint"), (0.5, "warning")])
def test_uneven_samples_are_a_hint_and_a_warning_where_they_are_very_uneven(jitter, kind):
    run = valve()
    moved = run.times + jitter * 0.25e-3 * np.random.default_rng(1).uniform(-1.0, 1.0, len(run.times))
    assert [one[:2] for one in said(run._replace(times=moved))] == [(kind, "uneven samples")]


@pytest.mark.parametrize("channels", [("lift",), USUAL])
def test_a_record_of_rest_alone_is_no_fault_and_is_told(channels):
    run = valve(channels=channels)
    later = run.times + 0.2
    rest = {
        name: values[-1] + NOISE[name] * np.random.default_rng(1).standard_normal(500)
        for name, values in run.channels.items()
    }
    assert [one[:2] for one in said(run._replace(times=later, channels=rest))] == [("warning", "motion not recorded")]
    [fault] = [
        one
        for one in findings(run._replace(times=later, channels=rest | {"lift": rest["lift"] + 30e-3}))
        if one.kind == "fault"
    ]
    assert fault.reason == "zero not set, or the sensor slipped?"


def test_missing_cells_cost_themselves_alone():
    run = valve()
    lift = run.channels["lift"].copy()
    lift[[3, 200]] = np.nan
    assert [one[:2] for one in said(with_channels(run, lift=lift))] == [("hint", "missing cells")]
    lift[100:200] = np.nan
    assert [one[:2] for one in said(with_channels(run, lift=lift))] == [("warning", "missing cells")]
    assert [one[:2] for one in said(with_channels(run, lift=np.full(500, np.nan)))] == [("warning", "missing cells")]
    assert [one[:2] for one in said(valve(), valve(channels=("lift",), seed=1))] == [("hint", "missing cells")]


STRETCHES = {
    "before the command": (-5e-3, 3e-3),
    "the opening": (3e-3, 30e-3),
    "the dwell": (25e-3, 50e-3),
    "the closing": (50e-3, 85e-3),
    "all that moves": (2e-3, 90e-3),
    "the end": (70e-3, 1.0),
}
"""Times from and to which cells are missing [s]."""


def without(run, start, end, channels):
    """A run whose cells are missing from one time to another, and every tenth anywhere."""
    lost = (run.times >= start) & (run.times < end)
    lost[::10] = True
    return with_channels(run, **{name: np.where(lost, np.nan, run.channels[name]) for name in channels})


@pytest.mark.parametrize(("start", "end"), STRETCHES.values(), ids=STRETCHES)
@pytest.mark.parametrize("lacking", [("lift",), USUAL, ("velocity", "temperature_a")])
@pytest.mark.parametrize("supply", [0.16, 0.6])
def test_honest_data_with_missing_cells_are_silent_about_all_else(supply, lacking, start, end):
    run = valve(supply, channels=USUAL if "lift" in lacking else lacking)
    assert {check for _, check, _ in said(without(run, start, end, lacking))} == {"missing cells"}


@pytest.mark.parametrize(("start", "end"), [(0.0, 90.0), (80.0, 200.0), (180.0, 360.0)])
def test_honest_data_of_the_engine_with_missing_cells_are_silent_about_all_else(start, end):
    run = engine()
    lost = (np.degrees(run.angles) >= start) & (np.degrees(run.angles) < end)
    lost[::10] = True
    holed = with_channels(run, **{name: np.where(lost, np.nan, values) for name, values in run.channels.items()})
    assert {check for _, check, _ in said(holed)} == {"missing cells"}


def test_faults_are_found_among_missing_cells():
    run, late = (without(each, 25e-3, 40e-3, USUAL) for each in (valve(), valve(late=10e-3)))
    lift, a, b = (run.channels[name] for name in USUAL)
    broken = {
        "µm called mm, or mm called m?": with_channels(run, lift=1e3 * lift),
        "inverted, measured from the open stop?": with_channels(run, lift=MACHINE.valve.stroke - lift),
        "gauge called abs?": with_channels(run, pressure_a=a - AMBIENT),
        "a and b swapped?": with_channels(run, pressure_a=b, pressure_b=a),
        "trigger 10.0 ms late?": late,
        "50 ms called 5 ms?": run._replace(pulse=5e-3),
        "clipped at the end of its range?": with_channels(run, pressure_a=np.minimum(a, 4e5)),
    }
    for reason, each in broken.items():
        assert {why for kind, _, why in said(each) if kind == "fault"} == {reason}


def test_two_runs_with_the_same_data_are_a_fault():
    run = valve()
    [one] = findings(run, run._replace(data="copy.csv"))
    assert (one.kind, one.check, one.file) == ("fault", "same data", "copy.csv")
    assert one.channel == "lift, pressure_a, pressure_b"
    [one] = findings(with_channels(run, pressure_b=run.channels["pressure_b"]), valve(seed=1))[:1] or [None]
    assert one is None


# --- the engine's bench ---


@pytest.mark.parametrize("added", [-AMBIENT, AMBIENT])
def test_a_cylinder_pressure_of_another_kind_is_a_fault(added):
    run = engine()
    [(kind, _, reason)] = said(with_channels(run, cylinder_pressure=run.channels["cylinder_pressure"] + added))
    assert (kind, reason) == ("fault", "gauge called abs?" if added < 0.0 else "abs called gauge?")


@pytest.mark.parametrize(("turned", "kind"), [(180.0, "fault"), (-30.0, "fault"), (20.0, "fault"), (10.0, "warning")])
@pytest.mark.parametrize("channels", [("cylinder_pressure",), ("lift", "cylinder_pressure")])
def test_a_top_dead_centre_that_is_off_is_told(turned, kind, channels):
    [one] = findings(engine(turned=turned, channels=channels))
    assert (one.kind, one.check) == (kind, "crank angle")
    assert f"{abs(turned):.0f} deg" in one.right


def test_a_crank_angle_from_bottom_dead_centre_is_a_fault_that_says_so():
    [one] = [one for one in findings(engine(turned=180.0)) if one.check == "crank angle"]
    assert (one.kind, one.reason) == ("fault", "0 deg at bottom dead centre?")
    assert abs(np.degrees(one.size)) == pytest.approx(180.0, abs=2.0)


@pytest.mark.parametrize(
    ("angles", "kinds"),
    [
        ((20.0, 20.0, 18.0), ["fault"] * 3),
        ((20.0, 0.0, 18.0), ["warning"] * 2),  # what is late at some speeds, and not at others, is no sensor's zero
        ((20.0, 31.0, 20.0), ["warning"] * 3),
        ((10.0, 10.0), ["warning"] * 2),
        ((20.0, 180.0), ["fault", "warning"]),
    ],
)
def test_the_crank_angle_is_off_by_as_much_in_all_runs(angles, kinds):
    runs = [engine(rpm=600.0 + 60.0 * i, turned=turned, seed=i) for i, turned in enumerate(angles)]
    assert [str(one.kind) for one in findings(*runs) if one.check == "crank angle"] == kinds


def test_a_whole_turn_is_no_error():
    run = engine()
    assert said(run._replace(angles=run.angles + 2.0 * np.pi)) == []


@pytest.mark.parametrize(
    ("mean", "factor", "reason"),
    [
        ("torque", -1.0, "sign turned round?"),
        ("torque", 100.0, "N cm called N m?"),
        ("air_flow", 60.0, "per minute called per second?"),
        ("air_flow", 1.0 / 60.0, "per second called per minute?"),
        ("air_flow", 49.8, "L/min (ANR) called g/s?"),
        ("air_flow", -1.0, "sign turned round?"),
    ],
)
def test_a_mean_in_another_unit_is_a_fault(mean, factor, reason):
    run = engine()
    [(kind, _, why)] = said(run._replace(means=run.means | {mean: factor * run.means[mean]}))
    assert (kind, why) == ("fault", reason)


@pytest.mark.parametrize("factor", [0.7, 1.5])
def test_means_that_a_leak_could_make_are_silent(factor):
    run = engine()
    assert said(run._replace(means={name: factor * value for name, value in run.means.items()})) == []


# --- what is refused ---


def test_faults_refuse_with_a_line_for_each_and_warnings_are_passed_on():
    run = valve()
    bad = with_channels(run, lift=1e3 * run.channels["lift"], pressure_b=run.channels["pressure_b"] - AMBIENT)
    with pytest.raises(InputError) as caught:
        refuse_faults(MACHINE, Measured("measured", {}, (bad,)))
    lines = str(caught.value).splitlines()
    assert [line.split(": ")[:2] for line in lines] == [
        ["measured/p0.4_0.csv", "pressure_b"],
        ["measured/p0.4_0.csv", "lift"],
    ]
    [warning] = refuse_faults(MACHINE, Measured("measured", {}, (valve(late=2e-3),)))
    assert "trigger 2.0 ms late?" in warning


def test_what_a_free_key_would_explain_refuses_nothing():
    run = valve()
    longer = with_channels(run, lift=1.2 * run.channels["lift"])
    with pytest.raises(InputError, match=r"valve\.stroke"):
        refuse_faults(MACHINE, Measured("measured", {}, (longer,)))
    assert len(refuse_faults(MACHINE, Measured("measured", {}, (longer,)), free=["valve.stroke"])) == 1


def test_records_are_checked_without_a_machine():
    run = valve()
    stuck = with_channels(run, lift=np.zeros(500), pressure_b=run.channels["pressure_b"] - AMBIENT)
    told = examine(None, Measured("measured", {}, (stuck,))).findings
    assert [one.check for one in told] == ["never moves"]
