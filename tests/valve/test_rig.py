"""The force on the drive of a cylinder, by the balance of its piston worked by hand."""

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.valve.rig import drive_force
from tests.machines import AMBIENT, changed

BORE, GAUGE = 25.7e-3, 3e5
AREA = 0.25 * np.pi * BORE**2
STROKE = np.array([0.0, 10e-3, 20e-3, 40e-3, 30e-3, 15e-3])
VELOCITY = np.array([0.01, 0.012, 0.02, -0.01, -0.015, -0.02])
SIGN = np.sign(VELOCITY)
TERMS = {
    "rig.viscous_friction": (80.0, 80.0 * VELOCITY),
    "effects.coulomb_friction.force": (4.0, 4.0 * SIGN),
    "effects.seal_friction.coefficient": (6e-6, 6e-6 * GAUGE * SIGN),
    "effects.stribeck_friction.force": (3.0, 3.0 * np.exp(-((VELOCITY / 0.05) ** 2)) * SIGN),
    "effects.quadratic_drag.coefficient": (40.0, 40.0 * VELOCITY * abs(VELOCITY)),
    "effects.side_force.force": (2.0, 2.0),
    "effects.tabulated_force.force_at_50": (5.0, 5.0 * (STROKE == 20e-3)),
    "effects.leakage_a.area": (1e-7, 0.0),
    "effects.coulomb_friction.breakaway": (9.0, 0.0),
}
"""Value of each key, and the force that it adds: against the motion, along the axis, or none."""


def force(**values):
    machine = changed(Machine(), {"rig.bore": BORE} | values)
    return drive_force(machine, STROKE, np.full(len(STROKE), AMBIENT + GAUGE), VELOCITY)


def test_without_friction_the_drive_feels_the_pressure_alone():
    assert force() == pytest.approx(np.full(len(STROKE), AREA * GAUGE), rel=1e-12)


@pytest.mark.parametrize("key", TERMS)
def test_each_law_adds_its_force(key):
    value, expected = TERMS[key]
    added = force(**{key: value}) - force()
    if key == "effects.tabulated_force.force_at_50":  # cubic between its nodes, every tenth of the way
        at_nodes = np.isin(STROKE, (0.0, 20e-3, 40e-3))
        added, expected = added[at_nodes], expected[at_nodes]
    assert added == pytest.approx(np.broadcast_to(expected, added.shape), abs=1e-9)


def test_several_laws_add_up():
    keys = ("rig.viscous_friction", "effects.coulomb_friction.force", "effects.seal_friction.coefficient")
    added = force(**{key: TERMS[key][0] for key in keys}) - force()
    assert added == pytest.approx(sum(TERMS[key][1] for key in keys), abs=1e-9)


def test_the_default_bore_is_that_of_the_valves_piston():
    machine = Machine()
    assert machine.rig.piston_area == pytest.approx(machine.valve.piston_area, rel=1e-4)
