"""`run_engine` of several cylinders, of two stages and of a free shaft, from Python and from the shell."""

import json

import matplotlib.pyplot as plt
import numpy as np
import pytest

from apesim import Machine, NotConverged, run_engine, run_many
from apesim.engine.drivetrain.indicators import SHAFT_INDICATORS, VALVE_INDICATORS
from apesim.studies.run.engine_run import PLOTS

THREE = {
    "engine.cylinders": 3,
    "ambient.temperature": "305 K",
    "supply.control_pressure": "0.8 MPa gauge",
    "cylinder": [{}, {"valve.stroke": "8 mm", "command.release": "60 deg"}, {}],
}
FAN = {"load.quadratic": "2.85e-3 N m s^2"}


@pytest.fixture(scope="module")
def three():
    return run_engine(Machine().with_(**THREE), "800 rpm")


def test_totals_are_sums_and_mean_effective_pressures_over_the_total_displacement(three):
    own = three.cylinders
    assert three["indicated_torque"] == pytest.approx(sum(each["indicated_torque_Nm"] for each in own), rel=1e-12)
    assert three["control_air_kg_per_cycle"] == pytest.approx(sum(each["control_air_kg_per_cycle"] for each in own))
    swept = 3.0 * np.pi / 4.0 * 0.085**2 * 0.088
    assert three["imep"] == pytest.approx(2.0 * np.pi * three["indicated_torque"] / swept, rel=1e-9)
    assert three["mass_closure"] < 1e-12 and three["energy_closure"] < 1e-12


def test_each_valve_is_told_of_its_own(three):
    first, second, third = three.cylinders
    assert first["valve_open_deg"] == pytest.approx(third["valve_open_deg"], abs=1e-4)
    assert second["valve_close_deg"] < first["valve_close_deg"] - 5.0
    assert second["peak_lift_m"] == pytest.approx(8e-3) and first["peak_lift_m"] == pytest.approx(9e-3)


def test_traces_have_an_axis_for_the_cylinders_and_are_drawn(three):
    lift = three.traces["lift"]
    assert lift.dims == ("crank_angle_deg", "cylinder") and lift.values.shape == (721, 3)
    summed = three.traces["torque"].values.sum(axis=1)
    assert np.allclose(summed, three.traces["gas_torque"].values, atol=1e-9)
    for what in PLOTS:
        ax = three.plot(what=what)
        assert len(ax.lines) == 3 and len({line.get_linestyle() for line in ax.lines}) == 3
    plt.close("all")


def test_the_command_prints_totals_and_each_valve(three, apesim, tmp_path):
    machine = tmp_path / "three.toml"
    machine.write_text(three.machine)
    run = "engine", "run", "--machine", machine, "--speed", "800 rpm"
    code, out, _ = apesim(*run, "--json", "--csv", tmp_path / "t.csv")
    data = json.loads(out)
    assert code == 0 and not {*VALVE_INDICATORS} & {*data} and {*SHAFT_INDICATORS} < {*data}
    assert len(data["cylinders"]) == 3 and data["cylinders"][1]["peak_lift_m"] == pytest.approx(8e-3)
    assert data["brake_torque_Nm"] == pytest.approx(three["brake_torque"], rel=1e-12)
    header = (tmp_path / "t.csv").read_text().splitlines()[0]
    assert header.startswith("crank_angle [deg],speed [rpm],gas_torque [N m]") and "lift_3 [m]" in header
    _, out, _ = apesim(*run)
    assert "each cylinder" in out and "nan" not in out


def test_a_free_shaft_turns_where_its_load_takes_up_its_torque(apesim):
    machine = Machine().with_(**FAN)
    free = run_engine(machine, "1200 rpm", free=True)
    mean = 2.85e-3 * (free["speed_rpm"] * np.pi / 30.0) ** 2
    assert free["brake_torque"] == pytest.approx(mean, rel=0.01)  # the square of the mean is not the mean square
    assert free["lowest_speed_rpm"] < free["speed_rpm"] < free["highest_speed_rpm"]
    code, out, _ = apesim(
        "engine", "run", "--speed", "1200 rpm", "--free", "--set", "load.quadratic=2.85e-3 N m s^2", "--json"
    )
    assert code == 0 and json.loads(out)["speed_rpm"] == pytest.approx(free["speed_rpm"], rel=1e-12)


def test_a_run_at_constant_speed_says_how_its_speed_would_swing():
    fixed = run_engine(Machine(), "1000 rpm")
    free = run_engine(Machine().with_(**FAN, shaft_inertia="0.5 kg m^2"), "1000 rpm", free=True)
    swing = (free["highest_speed_rpm"] - free["lowest_speed_rpm"]) / free["speed_rpm"]
    assert fixed["speed_swing"] / 5.0 == pytest.approx(swing, rel=0.1)  # a fifth of the inertia's share
    assert "speed_swing" not in free


def test_a_load_that_stops_the_shaft_is_named(apesim):
    with pytest.raises(NotConverged, match="lower the load"):
        run_engine(Machine().with_(load_constant="80 N m"), "600 rpm", free=True)
    code, _, err = apesim("engine", "run", "--speed", "600 rpm", "--free", "--set", "load.constant=80 N m")
    assert code == 3 and "lower the load" in err


def test_two_stages_run_and_the_air_is_that_of_the_first():
    two = run_engine(
        Machine().with_(**{"stage_2.bore": "120 mm", "stage_2.groove.effective_area": "300 mm^2"}), "600 rpm"
    )
    assert two.converged and len(two.cylinders) == 2
    assert two["engine_air_kg_per_cycle"] == two.cylinders[0]["engine_air_kg_per_cycle"]
    assert two.conditions["stages"] == "2"


def test_many_machines_of_several_cylinders_are_marched_as_each_alone(three):
    machine = Machine().with_(**THREE)
    many = run_many([Machine(), machine], speed="800 rpm")
    assert many.traces["brake_torque"].values[1] == three["brake_torque"]
