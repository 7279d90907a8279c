"""Numbers of the machine file that are not the rig's are named before anything is fitted, and right ones never."""

import itertools

import pytest

from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.quantities.uncertainties import Uncertainty
from apesim.studies.measured import Measured
from apesim.studies.measured.plausibility import Kind, examine, refuse_faults
from apesim.studies.measured.prediction import with_value
from tests.studies.measured.test_plausibility import PHYSICS, USUAL, ends_of, engine, valve

MACHINE = Machine()
OF_THE_MACHINE = "stroke", "flight"


def folder(channels=("lift",), supplies=(0.16, 0.3, 0.6), changed=(), known_to=None):
    runs = tuple(valve(supply, channels=channels, changed=changed, seed=3) for supply in supplies)
    return Measured("measured", {}, runs, known_to=known_to or {})


def of_the_machine(machine, measured):
    return [one for one in examine(machine, measured).findings if one.check in OF_THE_MACHINE]


@pytest.mark.parametrize("channels", [("lift",), USUAL])
def test_a_stroke_that_is_a_tenth_too_long_is_named_and_refused_with_the_gain_beside_it(channels):
    [finding] = of_the_machine(with_value(MACHINE, "valve.stroke", 10e-3), folder(channels))
    assert finding.kind == Kind.FAULT
    assert "valve.stroke" in finding.seen and "10 mm" in finding.seen and "all 3 runs" in finding.seen
    assert "stroke 9.0" in finding.reason and "gain of the sensor 0.90" in finding.reason


@pytest.mark.parametrize(
    ("stroke", "kinds"), [(9.1e-3, []), (9.2e-3, []), (9.4e-3, ["warning"]), (8.65e-3, ["warning"])]
)
def test_a_stroke_that_a_calibration_can_follow_refuses_nothing(stroke, kinds):
    assert [str(one.kind) for one in of_the_machine(with_value(MACHINE, "valve.stroke", stroke), folder())] == kinds


def test_a_stroke_that_is_stated_as_uncertain_or_that_is_to_be_fitted_refuses_nothing():
    longer = with_value(MACHINE, "valve.stroke", 10e-3)
    stated = folder(known_to={"valve.stroke": Uncertainty(0.5e-3)})
    assert [str(one.kind) for one in of_the_machine(longer, stated)] == ["warning"]
    with pytest.raises(InputError, match=r"valve\.stroke"):
        refuse_faults(longer, folder())
    assert refuse_faults(longer, folder(), ["valve.stroke"])


def test_a_lift_that_ends_flat_too_low_in_one_run_of_three_is_not_the_stroke():
    measured = folder()
    lowered = measured.runs[0].channels["lift"] * 0.9
    runs = (measured.runs[0]._replace(channels={"lift": lowered}), *measured.runs[1:])
    assert of_the_machine(MACHINE, measured._replace(runs=runs)) == []


def test_a_stroke_that_is_too_long_is_named_on_the_bench_of_the_engine():
    runs = tuple(engine(rpm=rpm) for rpm in (400.0, 600.0))
    machine = with_value(MACHINE, "valve.stroke", 10e-3)
    [finding] = of_the_machine(machine, Measured("measured", {}, runs, "engine"))
    assert finding.kind == Kind.FAULT and "valve.stroke" in finding.seen


@pytest.mark.parametrize(
    ("key", "factor"),
    [
        ("valve.piston_area", 0.01),
        ("valve.moving_mass", 1000.0),
        ("valve.spring_rate", 100.0),
        ("valve.viscous_friction", 10.0),
        ("valve.solenoid.effective_area", 0.1),
    ],
)
@pytest.mark.parametrize("channels", [("lift",), USUAL])
def test_a_machine_whose_valve_flies_otherwise_in_all_runs_is_refused_and_the_key_named(key, factor, channels):
    own = MACHINE.valve.solenoid.effective_area if "solenoid" in key else getattr(MACHINE.valve, key.split(".")[-1])
    machine = with_value(MACHINE, key, own * factor)
    found = examine(machine, folder(channels)).findings
    [finding] = [one for one in found if one.check == "flight"]
    assert finding.kind == Kind.FAULT and key in finding.reason
    assert not [one for one in found if one.check in ("time zero", "pulse")]
    assert not [one for one in examine(machine, folder(channels)).findings if one.check == "stroke"]


def test_a_pulse_that_is_wrong_is_not_laid_at_the_door_of_the_machine():
    runs = tuple(run._replace(pulse=5e-3) for run in folder().runs)
    found = examine(MACHINE, Measured("measured", {}, runs)).findings
    assert {str(one.check) for one in found} == {"pulse"}


def test_right_numbers_are_silent_at_any_sampling_and_noise():
    for step, seed in itertools.product((1, 4, 12), range(4)):
        runs = [valve(supply, seed=seed) for supply in (0.16, 0.4)]
        coarse = [
            run._replace(times=run.times[::step], channels={name: each[::step] for name, each in run.channels.items()})
            for run in runs
        ]
        assert of_the_machine(MACHINE, Measured("measured", {}, tuple(coarse))) == [], (step, seed)


@pytest.mark.parametrize("effect", PHYSICS, ids=lambda effect: effect.name)
def test_no_effect_is_taken_for_a_number_of_the_machine(effect):
    for ends in ends_of(effect):
        changed = tuple((f"effects.{effect.name}.{key}", value) for key, value in ends)
        assert of_the_machine(MACHINE, folder(supplies=(0.14, 0.6), changed=changed)) == [], ends


@pytest.mark.parametrize("gain", [0.9, 0.93])
def test_a_gain_that_is_off_is_warned_of_and_left_to_the_search(gain):
    measured = folder()
    runs = tuple(run._replace(channels={"lift": gain * run.channels["lift"]}) for run in measured.runs)
    for number in (1, 3):
        found = of_the_machine(MACHINE, measured._replace(runs=runs[:number]))
        assert [str(one.kind) for one in found] == ["warning"]


@pytest.mark.parametrize("gain", [0.98, 1.02])
def test_an_error_of_the_gain_that_is_usual_refuses_nothing(gain):
    measured = folder()
    runs = [run._replace(channels={"lift": gain * run.channels["lift"]}) for run in measured.runs]
    assert of_the_machine(MACHINE, measured._replace(runs=tuple(runs))) == []
