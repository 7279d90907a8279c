"""What sensors see, by the packages' reading and by the independent one."""

from math import nan, radians

import numpy as np
import pytest

from apesim.studies.measured.prediction import predict, run_of
from apesim.studies.measured.runs import ENGINE, FIT, MeasuredRun
from tests.machines import AMBIENT, RPM, machine
from tests.truth.simulator.periodic import periodic
from tests.truth.simulator.reading import rig_of
from tests.truth.simulator.sensors import bench_channels, engine_channels
from tests.truth.simulator.valve import simulate

CHAMBERS = ("lift", "pressure_a", "pressure_b")
CYLINDER = ("lift", "cylinder_pressure")
ERRORS = {"lift": 2e-6, "pressure_a": 100.0, "pressure_b": 100.0, "cylinder_pressure": 100.0}
"""Small against the noise of any sensor: 0.03 mm, 2 kPa."""
VALVE_EFFECTS = {
    "none": {},
    "lift lag": {"lift_sensor_lag__time": 0.3e-3},
    "pressure lag": {"pressure_sensor_lag__time": 0.4e-3},
    "gain": {"sensor_gain__lift": 0.02, "sensor_gain__pressure_b": -0.01},
    "offset": {"sensor_offset__lift": 0.1e-3, "sensor_offset__pressure_a": 3e3},
    "time zero": {"time_zero__time": 0.4e-3},
}
ENGINE_EFFECTS = {
    "lags": {"lift_sensor_lag__time": 0.3e-3, "pressure_sensor_lag__time": 0.4e-3},
    "dead centre": {"tdc_error__angle": radians(1.2)},
    "ripple": {"speed_ripple__share": 0.03},
}


def rigged(effects):
    return machine(supply=0.5, **{f"effects__{name}": value for name, value in effects.items()})


def assert_alike(found, true):
    for name, trace in true.items():
        assert found[name] == pytest.approx(trace, abs=ERRORS[name]), name


@pytest.mark.parametrize("effect", VALVE_EFFECTS)
def test_the_reading_of_a_bench_agrees_with_the_truth(effect):
    a_machine, times = rigged(VALVE_EFFECTS[effect]), np.arange(0.0, 0.09, 1e-4)
    channels = dict.fromkeys(CHAMBERS, times)
    run = MeasuredRun("", "", AMBIENT + 0.5e6, 287.0, 45e-3, FIT, times, channels)
    rig = rig_of(a_machine)
    true = bench_channels(rig.engine.valve, simulate(rig.engine.valve, 45e-3, 0.1), times, rig.sensors, CHAMBERS)
    assert_alike(predict(run_of(a_machine, run), run).channels, true)


@pytest.mark.parametrize("effect", ENGINE_EFFECTS)
def test_the_reading_of_an_engine_agrees_with_the_truth(effect):
    a_machine, angles, speed = rigged(ENGINE_EFFECTS[effect]), np.radians(np.arange(0.0, 360.0, 1.0)), 700.0 * RPM
    command = a_machine.command.energise, a_machine.command.release
    times = (angles - command[0]) / speed
    channels = dict.fromkeys(CYLINDER, angles)
    run = MeasuredRun(
        "", "", AMBIENT + 0.5e6, 287.0, nan, FIT, times, channels, ENGINE, speed, *command, angles, {"torque": 0.0}
    )
    rig = rig_of(a_machine)
    true = engine_channels(periodic(rig.engine, speed), angles, rig.sensors, (*CYLINDER, "torque"))
    found = predict(run_of(a_machine, run), run)
    assert found.means["torque"] == pytest.approx(true.pop("torque"), abs=1e-3)
    assert_alike(found.channels, true)
