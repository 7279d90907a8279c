"""The cylinder against a reactor network of Cantera: its own gas, its own balances, its own solver (CVODES).

The network is given our flows through groove and exhaust and our piston's motion, so that it judges what the cylinder
makes of them: mass and energy balance, thermally perfect air (air.yaml), volume. Stated error: 2e-5 of
pressure and temperature, 1e-4 of the work, which is a difference of larger ones.
"""

import cantera as ct
import numpy as np
import pytest

from apesim.air import CANTERA
from apesim.engine.angles import DEGREE
from apesim.engine.cycle.rates import TRACE
from apesim.engine.cycle.state import engine_ledger
from apesim.engine.kinematics import cylinder_volume
from tests.machines import machine, settled

ERROR, WORK_ERROR = 2e-5, 1e-4
STEP = 0.02
"""Step of the traces of flow [deg]."""


def column(run, name):
    return run.trace[:, [column.split(" [")[0] for column in TRACE].index(name)]


def network(run, supply_temperature):
    """Pressure [Pa] and temperature [K] of the reactor at the angles of the run's trace."""
    p, speed = run.cycle, run.cycle.speed
    times = (run.angles - p.start) / speed
    ambient = p.actuator.ambient
    pressure, temperature = column(run, "cylinder_pressure"), column(run, "cylinder_temperature")

    def air(kelvin, pascal):
        solution = ct.Solution("air.yaml")
        solution.TP = kelvin, pascal
        return solution

    cylinder = ct.IdealGasReactor(air(temperature[0], pressure[0]), clone=False, energy="on")
    cylinder.volume = cylinder_volume(p.crank, p.start)[0]
    cylinder.chemistry_enabled = False
    supply = ct.Reservoir(air(supply_temperature, p.supply.pressure), clone=False)
    outside = ct.Reservoir(air(ambient.temperature, ambient.pressure), clone=False)
    piston = ct.Wall(cylinder, ct.Reservoir(air(300.0, 1e5), clone=False), A=p.crank.face)
    piston.velocity = lambda t: cylinder_volume(p.crank, p.start + speed * t)[1] * speed / p.crank.face
    parts = [piston]
    for source, flow in ((supply, column(run, "groove_flow")), (outside, -column(run, "exhaust_flow"))):
        for upstream, downstream, share in ((source, cylinder, flow), (cylinder, source, -flow)):
            controller = ct.MassFlowController(upstream, downstream)
            controller.mass_flow_rate = ct.Tabulated1(times, np.maximum(share, 0.0))
            parts.append(controller)
    net = ct.ReactorNet([cylinder])
    net.rtol, net.atol = 1e-10, 1e-16
    net.max_time_step = STEP * DEGREE / speed * 10.0
    found = np.empty((len(times), 2))
    found[0] = pressure[0], temperature[0]
    for i, t in enumerate(times[1:], start=1):
        net.advance(t)
        found[i] = cylinder.phase.P, cylinder.T
    return found.T


OVEREXPANDED = {
    "supply": 0.3,
    "energise": -50.0,
    "release": 5.0,
    "engine__exhaust__closes": 300.0 * DEGREE,
}
"""Compresses what it kept beyond the supply, and expands what it took below ambient."""


@pytest.mark.parametrize("rpm, options", [(800.0, {}), (600.0, OVEREXPANDED)], ids=["default", "back-flow"])
def test_cylinder_agrees_with_a_reactor_network(rpm, options):
    a_machine = machine(air__model=CANTERA, **options)
    run = settled(a_machine, rpm, angle_step=STEP * DEGREE)
    if options:
        assert engine_ledger(run.end).groove_back > 0.02 * engine_ledger(run.end).flows.groove.mass
        assert engine_ledger(run.end).exhaust_back > 0.02 * engine_ledger(run.end).flows.groove.mass
    pressure, temperature = network(run, a_machine.supply.temperature)
    assert pressure == pytest.approx(column(run, "cylinder_pressure"), rel=ERROR)
    assert temperature == pytest.approx(column(run, "cylinder_temperature"), rel=ERROR)
    work = np.trapezoid(pressure, column(run, "cylinder_volume"))
    assert work == pytest.approx(engine_ledger(run.end).work, rel=WORK_ERROR)
