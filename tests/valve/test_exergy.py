"""Exergy in the valve: what its springs hold."""

import numpy as np
import pytest

from apesim.air import GasState
from apesim.engine.machine import Machine
from apesim.valve.actuator import actuator_of
from apesim.valve.chamber import filled
from apesim.valve.exergy import valve_stored
from apesim.valve.piston import volume_a, volume_b
from apesim.valve.supply import ValveSupply


@pytest.mark.parametrize("lift", [0.0, 0.1, 0.5, 1.0], ids="lift {} of the stroke".format)
def test_chambers_of_ambient_air_leave_the_exergy_of_the_springs(lift):
    """Each rests at its own end of the stroke: k/2 (x² + (h - x)²) less k/2 h², which they hold at either stop."""
    machine = Machine()
    actuator, _ = actuator_of(machine, edges=[0.0], period=1.0)
    valve, ambient = machine.valve, GasState(machine.ambient.pressure, machine.ambient.temperature)
    position = (1.0 - lift) * valve.stroke
    contents = [filled(actuator.gas, volume(actuator.valve, position), ambient) for volume in (volume_a, volume_b)]
    y = np.array([position, 0.0, *contents[0], *contents[1]])
    stored = valve_stored(actuator, y, ValveSupply(ambient, ambient.pressure))
    at_stop = 0.5 * valve.spring_rate * valve.stroke**2
    springs = 0.5 * valve.spring_rate * (position**2 + (valve.stroke - position) ** 2)
    assert stored == pytest.approx(springs - at_stop, rel=1e-9, abs=1e-12)
