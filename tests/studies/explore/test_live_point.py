"""Numbers at rest are those of a run, and those on the way are near them."""

from math import pi

import numpy as np
import pytest

import apesim
from apesim.engine.machine import Machine
from apesim.studies.explore.live_point import ANGLES, States, run_live
from tests.machines import RPM

MACHINES = {
    "default": {},
    "short stroke, own control air": {"valve_stroke": "6 mm", "supply_control_pressure": "0.7 MPa gauge"},
    "thin air": {"ambient_pressure": "80 kPa abs", "ambient_temperature": "260 K"},
    "cam": {"engine_intake": "cam"},
    "ideal": {"engine_intake": "ideal"},
    "two cylinders": {"engine_cylinders": 2},
}
OTHER = {"wall_time_s", "speed_swing", "mass_closure", "energy_closure", "exergy_closure", "periodic_change", "cycles"}
"""Numbers that say how the others were computed, and what a run alone estimates."""


def compared(run):
    """Numbers of a run by their names in files."""
    data = run.to_dict()
    return {
        name: value
        for name, value in data.items()
        if isinstance(value, float) and name not in {*OTHER, "wall_time_s", "speed_swing"}
    }


@pytest.mark.parametrize("name", MACHINES)
def test_numbers_at_rest_are_those_of_a_run(name):
    machine, states = Machine().with_(**MACHINES[name]), States()
    run_live(machine, 900.0 * RPM, states, is_exact=False)
    own, ideal = run_live(machine, 1000.0 * RPM, states, is_exact=True)
    expected = compared(apesim.run_engine(machine, speed="1000 rpm"))
    assert len(expected) > 25
    for key, value in expected.items():
        assert own.numbers[key] == pytest.approx(value, rel=1e-6, abs=1e-12, nan_ok=True), key
    by_ideal = apesim.run_engine(machine.with_(engine_intake="ideal"), speed="1000 rpm")
    assert ideal.numbers["brake_torque_Nm"] == pytest.approx(by_ideal["brake_torque"], rel=1e-6)


def test_a_state_that_is_shown_leads_to_the_next_in_fewer_cycles():
    machine, states, cycles = Machine(), States(), []
    run_live(machine, 1000.0 * RPM, states, is_exact=True)
    for number in range(1, 6):
        moved = machine.with_(engine_bore=f"{85 + number} mm", supply_pressure=f"{1.0 - 0.02 * number:.2f} MPa gauge")
        speed = (1000.0 + 20.0 * number) * RPM
        (quick, ideal), from_rest = (run_live(moved, speed, known, is_exact=False) for known in (states, States()))
        assert quick.numbers["converged"] == ideal.numbers["converged"] == 1
        cycles.append([sum(each.numbers["cycles"] for each in both) for both in ((quick, ideal), from_rest)])
    of_quick, of_rest = np.sum(cycles, axis=0)
    assert of_quick < 0.8 * of_rest
    exact, _ = run_live(moved, speed, States(), is_exact=True)
    assert quick.numbers["brake_torque_Nm"] == pytest.approx(exact.numbers["brake_torque_Nm"], rel=1e-5)
    assert quick.curves["cylinder_pressure"] == pytest.approx(exact.curves["cylinder_pressure"], rel=1e-4)


def test_curves_are_those_of_a_run_from_another_angle_on():
    own, _ = run_live(Machine(), 1000.0 * RPM, States(), is_exact=True)
    run = apesim.run_engine(Machine(), speed="1000 rpm")
    angles = run.traces["crank_angle_deg"].values
    for name in ("lift", "cylinder_pressure", "torque"):
        again = np.interp(ANGLES, angles, run.traces[name].values, period=360.0)
        assert own.curves[name] == pytest.approx(again, rel=1e-6, abs=1e-9)
    work = np.trapezoid(own.curves["torque"], ANGLES * pi / 180.0)
    assert work == pytest.approx(2.0 * pi * own.numbers["indicated_torque_Nm"], rel=1e-3)


def test_what_is_not_well_is_said():
    slow = Machine().with_(engine_receiver_volume="200 L", engine_receiver_feed_area="1 mm^2")
    quick, _ = run_live(slow, 1000.0 * RPM, States(), is_exact=False)
    assert quick.numbers["converged"] == 0 or quick.numbers["brake_torque_Nm"] <= 0.0
    assert quick.warnings
