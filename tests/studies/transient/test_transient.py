"""Engines over time, from Python and from the shell."""

import json

import matplotlib.pyplot as plt
import numpy as np
import pytest

import apesim
from apesim import InputError
from apesim.studies.transient.transient import PLOTS

RAMP = "0 s: 600 rpm, 0.5 s: 1200 rpm"
LEAD = "speed [rpm],energise [deg],release [deg]\n0,-5,70\n2500,-95,-65\n"


def machine(**values):
    return apesim.Machine().with_(**values)


@pytest.fixture(scope="module")
def ramp():
    return apesim.run_transient(machine(), speed=RAMP)


def test_an_imposed_speed_is_kept_and_everything_closes(ramp):
    data = ramp.to_dict()
    assert data["turns"] == pytest.approx(7.5, rel=1e-9)
    assert max(data["closure"]["mass"], data["closure"]["energy"]) < 1e-9
    speeds = [row["mean_speed_rpm"] for row in data["revolutions"]]
    assert len(speeds) == 7 and speeds == sorted(speeds)
    assert sum(row["gas_torque_Nm"] for row in data["revolutions"]) * 2.0 * np.pi < data["gas_work_J"]


def test_a_row_has_each_cylinder(ramp):
    two = apesim.run_transient(machine(engine_cylinders=2), speed=RAMP).to_dict()["revolutions"][3]
    one = ramp.to_dict()["revolutions"][3]
    assert len(two["cylinders"]) == 2 and len(one["cylinders"]) == 1
    assert two["cylinders"][0]["valve_open_deg"] == pytest.approx(one["cylinders"][0]["valve_open_deg"], abs=0.5)
    assert two["receiver_dip_Pa"] > 0.0


def test_air_that_both_stages_use_counts_once():
    two = apesim.run_transient(machine(stage_2_bore="120 mm"), speed="0 s: 600 rpm, 1 s: 600 rpm")
    drawn, row = two.march.cylinders["engine_air"], two.to_dict()["revolutions"][-1]
    assert drawn[-1, 1] > 0.5 * drawn[-1, 0] > 0.0
    assert row["engine_air_kg"] == pytest.approx(drawn[-1, 0], rel=1e-12)
    assert drawn[:, 0].sum() < two["engine_air"] < drawn.sum()  # the last revolution is not whole
    assert row["receiver_dip_Pa"] < 0.1e6  # that of the receiver, not of the inter-receiver


def test_an_endless_receiver_dips_with_the_supply_alone():
    endless = machine(engine_receiver_volume="inf", engine_cylinders=2)
    run = apesim.run_transient(endless, speed="0 s: 600 rpm, 0.6 s: 600 rpm", supply="0.35 s: 0.8 MPa gauge")
    dips = [row["receiver_dip_Pa"] for row in run.to_dict()["revolutions"]]
    assert dips[0] == 0.0 and dips[-1] == pytest.approx(0.2e6, rel=1e-9)


def test_cylinders_with_keys_of_their_own_have_angles_of_their_own():
    late = machine(engine_cylinders=2, cylinder=[{}, {"valve.solenoid.dead_time": "2.5 ms"}])
    row = apesim.run_transient(late, speed="0 s: 600 rpm, 0.5 s: 600 rpm").to_dict()["revolutions"][-1]
    first, second = (own["valve_open_deg"] for own in row["cylinders"])
    assert second - first == pytest.approx(6.0 * 600.0 * 1e-3, abs=0.05)  # 1 ms later


def test_a_shaft_that_is_let_free_at_a_speed_goes_on_from_its_periodic_state():
    heavy = machine(shaft_inertia="1e5 kg m^2")
    row = apesim.run_transient(heavy, from_speed="1000 rpm", duration="0.3 s").to_dict()["revolutions"][-1]
    steady = apesim.run_engine(machine(), speed="1000 rpm")
    assert row["gas_torque_Nm"] == pytest.approx(steady["indicated_torque"], rel=1e-4)
    assert row["brake_torque_Nm"] == pytest.approx(steady["brake_torque"], rel=1e-4)
    assert row["cylinders"][0]["valve_open_deg"] == pytest.approx(steady["valve_open_deg"], abs=0.01)


def test_a_load_replaces_the_constant_part_and_leaves_the_rest():
    fan = {"load.quadratic": "2.85e-3 N m s^2", "load.constant": "3 N m"}
    run = apesim.run_transient(machine(**fan), from_speed="1000 rpm", duration="1 s", load="0.5 s: 13 N m")
    rows = run.to_dict()["revolutions"]
    before, after = rows[0], rows[-1]
    for row, constant in ((before, 3.0), (after, 13.0)):
        speed = row["mean_speed_rpm"] * np.pi / 30.0
        assert row["load_torque_Nm"] == pytest.approx(
            constant + 2.85e-3 * speed**2, rel=2e-2
        )  # the mean of the square is not the square of the mean
    assert run["shaft_closure"] < 1e-9


def test_the_supply_changes_with_the_control_air_that_is_not_stated():
    step = "0.25 s: 0.6 MPa gauge"
    speed = "0 s: 800 rpm, 0.5 s: 800 rpm"
    both = apesim.run_transient(machine(), speed=speed, supply=step)
    own = apesim.run_transient(machine(**{"supply.control_pressure": "1 MPa gauge"}), speed=speed, supply=step)
    last = [run.to_dict()["revolutions"][-1] for run in (both, own)]
    assert last[0]["control_air_kg"] < 0.7 * last[1]["control_air_kg"]
    assert both.to_dict()["revolutions"][0]["gas_torque_Nm"] > 1.5 * last[0]["gas_torque_Nm"]


def test_a_timing_is_read_from_a_csv_by_the_speed(tmp_path):
    (tmp_path / "lead.csv").write_text(LEAD)
    rows = apesim.run_transient(machine(), speed=RAMP, timing=tmp_path / "lead.csv").to_dict()["revolutions"]
    assert all(abs(row["cylinders"][0]["valve_open_deg"] + 5.0) < 12.0 for row in rows[1:])
    assert rows[-1]["cylinders"][0]["valve_close_deg"] < 100.0


def test_a_map_of_timings_is_interpolated_at_the_supply(tmp_path):
    speeds = "500:1300:200 rpm"
    apesim.correct_timing(machine(), target="-5 deg, 70 deg", speed=speeds, out=tmp_path / "map.h5")
    run = apesim.run_transient(machine(), speed="0 s: 900 rpm, 0.5 s: 900 rpm", timing=tmp_path / "map.csv")
    own = run.to_dict()["revolutions"][-1]["cylinders"][0]
    assert own["valve_open_deg"] == pytest.approx(-5.0, abs=0.3)
    assert own["valve_close_deg"] == pytest.approx(70.0, abs=1.0)


def test_a_floor_on_the_pulse_is_kept(tmp_path):
    (tmp_path / "lead.csv").write_text(LEAD)
    speed = "0 s: 1500 rpm, 0.4 s: 1500 rpm"
    short = apesim.run_transient(machine(), speed=speed, timing=tmp_path / "lead.csv")
    longer = apesim.run_transient(machine(), speed=speed, timing=tmp_path / "lead.csv", min_pulse="10 ms")
    # Until the first passage of 180 degrees the machine's own command holds, with its shorter pulse.
    assert short["strokes_cut_short"] == short["revolutions"] > 1 == longer["strokes_cut_short"]
    assert "full lift" in short.warnings[0]


def test_a_floor_on_the_pulse_is_laid_over_each_cylinders_own_command():
    own = [{}, {"command.release": "50 deg"}]
    args = {"speed": "0 s: 1200 rpm, 0.6 s: 1200 rpm"}
    with_floor, without = (
        apesim.run_transient(machine(engine_cylinders=2, cylinder=own), **args, min_pulse=floor)
        for floor in ("10 ms", None)
    )
    closes, closed = (
        [each["valve_close_deg"] for each in run.to_dict()["revolutions"][-1]["cylinders"]]
        for run in (with_floor, without)
    )
    # 75 deg are longer than 10 ms, and stay; 55 deg become 72 deg.
    assert closes[0] == pytest.approx(closed[0], abs=1.0)
    assert closes[1] - closed[1] > 12.0


def test_a_timing_leaves_the_command_of_a_second_stage_alone(tmp_path):
    (tmp_path / "lead.csv").write_text(LEAD)
    two = machine(**{"stage_2.bore": "120 mm", "stage_2.command.energise": "3 deg"})
    args = {"speed": "0 s: 900 rpm, 0.8 s: 900 rpm"}
    with_map = apesim.run_transient(two, timing=tmp_path / "lead.csv", **args).to_dict()["revolutions"][-1]
    without = apesim.run_transient(two, **args).to_dict()["revolutions"][-1]
    first, second = ([row["cylinders"][i]["valve_open_deg"] for row in (with_map, without)] for i in range(2))
    assert first[0] == pytest.approx(first[1] - 0.036 * 900.0, abs=1.0)
    assert second[0] == pytest.approx(second[1], abs=1.0)


@pytest.mark.parametrize(
    ("arguments", "key", "right"),
    [
        ({}, "duration", "3 s"),
        ({"speed": "600 rpm"}, "speed", "0 s: 300 rpm"),
        ({"speed": "0 s: 600, 1 s: 900 rpm"}, "speed", "rpm"),
        ({"speed": "1 s: 600 rpm, 0.5 s: 900 rpm"}, "speed", "0 s: 300 rpm"),
        ({"speed": RAMP, "from_speed": "1000 rpm"}, "from_speed", "leave one"),
        ({"duration": "1 s", "load": "0.5 s: 10"}, "load", "N m"),
        ({"duration": "1 s", "supply": "0.5 s: 1 MPa"}, "supply", "gauge"),
        ({"duration": "1 s", "timing": "no.csv"}, "timing", "speed [rpm]"),
    ],
)
def test_wrong_arguments_are_named_with_the_right_form(arguments, key, right):
    with pytest.raises(InputError) as raised:
        apesim.run_transient(machine(), **arguments)
    assert any(fault.key == key and right in str(fault) for fault in raised.value.faults), raised.value


def test_a_timing_does_not_silently_replace_a_cylinders_own_command(tmp_path):
    (tmp_path / "lead.csv").write_text(LEAD)
    own = machine(engine_cylinders=2, cylinder=[{}, {"command.release": "60 deg"}])
    with pytest.raises(InputError, match=r"timing: would replace the command that cylinder\[2\] has of its own; leave"):
        apesim.run_transient(own, speed=RAMP, timing=tmp_path / "lead.csv")
    with pytest.raises(InputError, match=r"cranking_release: would replace"):
        apesim.start_engine(own, cranking_release="130 deg")


def test_every_plot_has_axes_with_units(ramp):
    for what in PLOTS:
        ax = ramp.plot(what=what)
        assert "[" in ax.get_ylabel() and ax.get_xlabel() == "time [s]"
        plt.close("all")


def test_the_command_prints_what_the_function_returns(apesim, ramp, tmp_path):
    code, out, _ = apesim("engine", "transient", "--speed", RAMP, "--json", "--csv", str(tmp_path / "ramp.csv"))
    data = json.loads(out)
    assert code == 0
    assert {**data, "wall_time_s": 0.0} == json.loads(
        json.dumps({**ramp.to_dict(), "wall_time_s": 0.0}).replace("NaN", "null")
    )
    assert len((tmp_path / "ramp.csv").read_text().splitlines()) == 5002


def test_a_fault_is_named_as_an_option(apesim):
    code, out, err = apesim("engine", "transient", "--from", "1000")
    assert code == 2 and out == "" and "--from" in err and "rpm" in err
