"""Corrected commands and limits of engines with several cylinders."""

import numpy as np
import pytest

import apesim
from apesim import InputError, Machine

POINT = {"pressure": "0.8 MPa gauge", "temperature": "300 K"}
OWN = [{}, {"valve.solenoid.dead_time": "2.5 ms", "command.open_target": "0 deg"}]


def test_cylinders_that_are_alike_have_one_table_and_win_back_together():
    one, three = (
        apesim.correct_timing(Machine().with_(engine_cylinders=count), speed="700 rpm, 900 rpm", **POINT)
        for count in (1, 3)
    )
    for name in ("energise_deg", "release_deg", "fixed_valve_open_deg", "shortcut_open_error_deg"):
        assert np.allclose(three.traces[name].values, one.traces[name].values, atol=0.02), name
    assert np.allclose(three.traces["brake_torque"].values, 3.0 * one.traces["brake_torque"].values, rtol=0.01)


def test_cylinders_that_hang_on_one_anothers_air_are_corrected_together():
    shared = Machine().with_(engine_cylinders=3, supply_control_air="receiver", engine_receiver_volume="0.2 L")
    timing = apesim.correct_timing(shared, speed="900 rpm", **POINT)
    command = {f"command_{name}": (timing.traces[f"{name}_deg"].values[0], "deg") for name in ("energise", "release")}
    run = apesim.run_engine(
        shared.with_(supply_pressure=POINT["pressure"], supply_temperature="300 K", **command), "900 rpm"
    )
    for own in run.cylinders:
        assert own["valve_open_deg"] == pytest.approx(-5.0, abs=0.01)
        assert own["valve_close_deg"] == pytest.approx(70.0, abs=0.01)


def test_a_sweep_corrects_each_of_cylinders_that_differ():
    swept = apesim.sweep(Machine().with_(engine_cylinders=2, cylinder=OWN), "900 rpm", intake="epv", timing="corrected")
    assert np.allclose(swept.traces["cylinder_valve_open_deg"].values, [[-5.0, 0.0]], atol=0.01)
    assert np.allclose(swept.traces["cylinder_valve_close_deg"].values, [[70.0, 70.0]], atol=0.01)
    energise = swept.traces["cylinder_energise_deg"].values[0]
    assert energise[1] - energise[0] == pytest.approx(5.0 - 5.4, abs=0.05)


def test_the_limit_of_several_is_that_of_one():
    one, two = (
        apesim.find_engine_limit(Machine().with_(engine_cylinders=count), duration="75 deg", **POINT)
        for count in (1, 2)
    )
    assert two.traces["limit_rpm"].values[0] == pytest.approx(one.traces["limit_rpm"].values[0], abs=2.0)


@pytest.mark.parametrize("study", [apesim.correct_timing, apesim.find_engine_limit])
def test_one_table_is_not_for_cylinders_that_differ(study):
    with pytest.raises(
        InputError, match=r"cylinder\[2\]: has keys of its own, and one table of commands is for all; leave"
    ):
        study(Machine().with_(engine_cylinders=2, cylinder=OWN))
    with pytest.raises(InputError, match=r"stage_2.bore: switches a second stage on"):
        study(Machine().with_(**{"stage_2.bore": "120 mm"}))
