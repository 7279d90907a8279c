"""The cylinder as a reactor network of Cantera: its own gas, its own balances, its own solver (CVODES).

The network is given our flows through groove and exhaust and our piston's motion, so that it judges what the cylinder
makes of them: mass and energy balance, thermally perfect air, volume. Its air is Lemmon's as it is printed, in pieces
of Cantera's own form (NASA's of nine coefficients).
"""

from collections.abc import Mapping
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

import cantera as ct
import numpy as np
from numpy.polynomial import Chebyshev, Polynomial

from apesim.air import THERMALLY_PERFECT
from apesim.engine.angles import DEGREE
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cycle.state import engine_ledger
from apesim.engine.kinematics import cylinder_volume
from apesim.engine.steady import SteadyRun
from tests import lemmon_air
from tests.machines import machine, settled

STEP = 0.02
"""Step of the traces of flow [deg]."""
OVEREXPANDED: dict[str, Any] = {
    "supply": 0.3,
    "energise": -50.0,
    "release": 5.0,
    "engine__exhaust__closes": 300.0 * DEGREE,
}
"""Compresses what it kept beyond the supply, and expands what it took below ambient."""
EDGES = 60.0, 100.0, 160.0, 240.0, 340.0, 460.0, 620.0, 800.0, 1000.0
"""Ends of the pieces of the network's cp [K]: within 4e-7 of Lemmon's."""
CASES: dict[str, tuple[float, dict[str, Any]]] = {"default": (800.0, {}), "back-flow": (600.0, OVEREXPANDED)}
"""Speeds [r/min] and what is changed of the default machine."""


class Comparison(NamedTuple):
    """What the network and the cylinder make of the same flows in a cycle."""

    run: SteadyRun
    pressure: float
    """Largest relative deviation of the pressure."""
    temperature: float
    """Largest relative deviation of the temperature."""
    work: float
    """Relative deviation of the work."""


def column(run: SteadyRun, name: str) -> np.ndarray:
    """A column of the run's trace."""
    return run.trace[:, [column.split(" [")[0] for column in TRACE].index(name)]


@cache
def air_yaml() -> str:
    """Lemmon's air for Cantera: one species of one element, whose weight gives the gas constant."""
    pieces = []
    for cold, hot in pairwise(EDGES):
        cp = Chebyshev.interpolate(np.vectorize(lemmon_air.heat_capacity), 4, domain=[cold, hot])
        a = cp.convert(kind=Polynomial).coef / lemmon_air.R
        # The two constants of integration, so that neither enthalpy nor entropy jumps from piece to piece.
        h = lemmon_air.enthalpy(cold) / lemmon_air.R - sum(a[i] * cold ** (i + 1) / (i + 1) for i in range(5))
        s = lemmon_air.entropy(cold) / lemmon_air.R - a[0] * np.log(cold) - sum(a[i] * cold**i / i for i in range(1, 5))
        pieces.append([0.0, 0.0, *map(float, a), float(h), float(s)])
    return f"""
elements: [{{symbol: Lm, atomic-weight: {ct.gas_constant / lemmon_air.R!r}}}]
phases: [{{name: air, thermo: ideal-gas, elements: [Lm], species: [air]}}]
species:
- name: air
  composition: {{Lm: 1}}
  thermo: {{model: NASA9, reference-pressure: 1.0e5, temperature-ranges: {list(EDGES)}, data: {pieces}}}
"""


def lemmons_air(kelvin: float, pascal: float) -> ct.Solution:
    """Lemmon's air in Cantera, at a temperature [K] and pressure [Pa]."""
    solution = ct.Solution(yaml=air_yaml())
    solution.TP = kelvin, pascal
    return solution


def network(run: SteadyRun, supply_temperature: float) -> np.ndarray:
    """Pressure [Pa] and temperature [K] of the reactor at the angles of the run's trace."""
    p, speed = run.cycle, run.cycle.speed
    times = (run.angles - p.start) / speed
    ambient = p.actuator.ambient
    pressure, temperature = column(run, "cylinder_pressure"), column(run, "cylinder_temperature")

    air = lemmons_air
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
    # With 1e-10 the deviations of the network vary by 3e-6 from processor to processor.
    net.rtol, net.atol = 1e-12, 1e-20
    net.max_time_step = STEP * DEGREE / speed * 10.0
    found = np.empty((len(times), 2))
    found[0] = pressure[0], temperature[0]
    for i, t in enumerate(times[1:], start=1):
        net.advance(t)
        found[i] = cylinder.phase.P, cylinder.T
    return found.T


def compared(rpm: float, options: Mapping[str, Any]) -> Comparison:
    """The cylinder of a machine, over a cycle of its periodic state, beside the network."""
    a_machine = machine(air__model=THERMALLY_PERFECT, **options)
    run = settled(a_machine, rpm, angle_step=STEP * DEGREE)
    pressure, temperature = network(run, a_machine.supply.temperature)
    work = np.trapezoid(pressure, column(run, "cylinder_volume"))
    return Comparison(
        run,
        float(np.abs(pressure / column(run, "cylinder_pressure") - 1.0).max()),
        float(np.abs(temperature / column(run, "cylinder_temperature") - 1.0).max()),
        abs(work / engine_ledger(run.end).work - 1.0),
    )
