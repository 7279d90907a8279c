"""How far apesim and the independent simulator of `tests.truth` differ: bench, engine and corrected commands."""

from math import degrees, inf, radians
from typing import NamedTuple

import numpy as np

from apesim.engine.angles import DEGREE
from apesim.engine.indicators import indicators
from apesim.engine.machine import Machine
from apesim.studies.timing import corrected
from apesim.valve.bench import run_bench
from apesim.valve.effects import VALVE_EFFECTS
from tests.machines import AMBIENT, RPM, machine, settled, turned_on
from tests.truth.simulator.periodic import Periodic, opening_and_closing, periodic, results
from tests.truth.simulator.reading import engine_of, rig_of
from tests.truth.simulator.valve import POSITION, PRESSURE_A, TEMPERATURE_B, Bench, simulate

MARCHED = [effect for effect in VALVE_EFFECTS if effect.slots != ("sensor",) and not effect.tabulated]
"""Effects of the valve that both know."""
ERROR = 2e-5
"""Relative error of our numbers at the default tolerance and of printed ones; of torques, to that of full pressure."""
ANGLE_ERROR = 1e-3
"""Error of an angle [deg]."""
NEAREST = 1e-8
"""Distance to its periodic state that the simulator is brought to where its usual one leaves numbers in doubt."""
TARGETS = (-5.0, 70.0)
"""Intended opening and closing of the default machine [deg]."""
ANGLES = {
    "opens": "valve_open_deg",
    "closes": "valve_close_deg",
    "full_open": "full_open_deg",
    "closed": "closed_deg",
}
"""Angles of the simulator, and names of our indicators."""


class BenchDeviations(NamedTuple):
    """Largest deviations over an opening and a closing of 50 ms each."""

    lift: float
    """[m]"""
    pressure: float
    """Chamber A, relative."""
    temperature: float
    """Chamber B, relative."""


def bench_deviations(tested: Machine, bench: Bench | None = None) -> BenchDeviations:
    """Deviations of a machine's valve on its bench, from the simulator's own bench where one is given."""
    run = run_bench(tested, 50e-3, 100e-3, sample=5e-5)
    states = simulate(bench or rig_of(tested).engine.valve, 50e-3, 100e-3).states(run.times)
    return BenchDeviations(
        float(np.abs(run.trace[:, 0] - (tested.valve.stroke - states[POSITION])).max()),
        float(np.abs(run.trace[:, 2] / states[PRESSURE_A] - 1.0).max()),
        float(np.abs(run.trace[:, 5] / states[TEMPERATURE_B] - 1.0).max()),
    )


def with_effect(name: str) -> Machine:
    """The default valve at 0.4 MPa gauge, with one effect half of the way to the farther end of its range."""
    (effect,) = (effect for effect in MARCHED if effect.name == name)
    tested = machine(supply=0.4)
    return tested._replace(effects=tested.effects._replace(**{name: turned_on(effect)}))


def random_machine(seed):
    """A machine with anything at random, and a speed [r/min]."""
    rng = np.random.default_rng(seed)

    def real(low, high):
        return float(rng.uniform(low, high))

    opens, stroke, effects = real(-40.0, 0.0), real(60e-3, 110e-3), bool(rng.integers(2))
    closes = opens + real(55.0, 100.0)
    values = {
        "valve__moving_mass": real(0.08, 0.15),
        "valve__piston_area": real(900e-6, 1300e-6),
        "valve__clearance_volume": real(8e-6, 14e-6),
        "valve__spring_rate": real(1000.0, 3000.0),
        "valve__viscous_friction": real(60.0, 160.0),
        "valve__stroke": real(7e-3, 10e-3),
        "valve__solenoid__effective_area": real(7e-6, 12e-6),
        "valve__solenoid__dead_time": real(1e-3, 2e-3),
        "valve__solenoid__ramp_time": real(1e-3, 2e-3),
        "groove__effective_area": real(80e-6, 250e-6),
        "groove__lap": real(0.5e-3, 2e-3),
        "engine__bore": real(60e-3, 110e-3),
        "engine__stroke": stroke,
        "engine__rod_length": stroke * real(1.5, 2.2),
        "engine__pin_offset": stroke * real(-0.1, 0.1),
        "engine__compression_ratio": real(8.0, 20.0),
        "engine__cam__opens": radians(opens),
        "engine__cam__closes": radians(closes),
        "engine__cam__flank": radians(real(10.0, 27.0)),
        "engine__cam__lift": real(5e-3, 11e-3),
        "engine__exhaust__effective_area": real(300e-6, 800e-6),
        "engine__exhaust__opens": radians(real(150.0, 175.0)),
        "engine__exhaust__closes": radians(real(300.0, 345.0)),
        "engine__exhaust__flank": radians(real(15.0, 30.0)),
        "engine__receiver__feed_area": real(80e-6, 300e-6),
        "supply__control_pressure": AMBIENT + real(0.6e6, 1.5e6),
    }
    if effects:
        values |= {
            "effects__coulomb_friction__force": real(0.0, 8.0),
            "effects__coulomb_friction__breakaway": real(0.0, 16.0),
            "effects__solenoid_b_delay__time": real(0.0, 0.8e-3),
            "effects__bounce__restitution": real(0.0, 0.4),
            "effects__ring_leakage__area": real(0.0, 0.2e-6),
            "effects__blow_by__area": real(0.0, 0.8e-6),
            "effects__cylinder_wall_heat__h": real(0.0, 300.0),
            "effects__cylinder_wall_heat__wall_temperature": 310.0,
        }
    a_machine = machine(
        intake=str(rng.choice(["epv", "epv", "epv", "cam", "ideal"])),
        supply=real(0.4, 2.0),
        temperature=real(260.0, 320.0),
        energise=opens,
        release=closes,
        targets=(opens, closes),
        receiver=float(rng.choice([inf, real(0.3, 1.5)])),
        control_air=str(rng.choice(["regulator", "receiver"])),
        **values,
    )
    return a_machine, real(300.0, 1300.0)


class EngineDeviations(NamedTuple):
    """Deviations of an operating point in its periodic state; 0 where both say that there is none."""

    shares: dict[str, float]
    """Relative, of torques to that of the full pressure."""
    angles: dict[str, float]
    """[deg]"""

    def beyond(self) -> dict[str, float]:
        """Those beyond `ERROR` and `ANGLE_ERROR`."""
        beyond = {name: off for name, off in self.shares.items() if not off <= ERROR}
        return beyond | {name: off for name, off in self.angles.items() if not off <= ANGLE_ERROR}


def engine_deviations(a_machine: Machine, rpm: float) -> EngineDeviations:
    """Deviations of a machine at a speed [r/min]."""
    ours, found = engine_of(a_machine), indicators(a_machine, settled(a_machine, rpm))
    deviations = _deviations(periodic(ours, rpm * RPM), found)
    return _deviations(periodic(ours, rpm * RPM, near=NEAREST), found) if deviations.beyond() else deviations


def _deviations(run: Periodic, found: dict[str, float]) -> EngineDeviations:
    """Deviations of indicators from those of a run of the simulator."""
    assert run.converged
    ours, true = run.engine, results(run)
    full = (ours.intake_pressure - AMBIENT) * 0.25 * np.pi * ours.bore**2 * ours.stroke / (2.0 * np.pi)
    shares, angles = {}, {}
    for name in ("indicated_torque", "brake_torque"):
        shares[name] = abs(found[f"{name}_Nm"] - true[name]) / full
    units = {"engine_air": "kg_per_cycle", "control_air": "kg_per_cycle", "peak_cylinder_pressure": "Pa"}
    if ours.intake == "epv":
        units |= {"opening_seating_speed": "m_s", "closing_seating_speed": "m_s", "peak_lift": "m"}
        angles = {name: _difference(found[key], degrees(true[name])) for name, key in ANGLES.items()}
    for name, unit in units.items():
        scale = abs(true[name]) or 1.0
        shares[name] = _difference(found[f"{name}_{unit}"] / scale, true[name] / scale)
    return EngineDeviations(shares, angles)


def _difference(found: float, true: float) -> float:
    """Difference of two numbers; 0 where neither is one, NaN where only one is none."""
    return 0.0 if np.isnan(found) and np.isnan(true) else float(abs(found - true))


def timing_misses(rpm: float, **options: float | str) -> tuple[float, float]:
    """How far the simulator's valve opens and closes from the targets, with apesim's corrected commands [deg]."""
    a_machine = machine(**options)
    found = corrected(a_machine, rpm * RPM)
    assert found.reachable
    command = found.machine.command
    opened = opening_and_closing(engine_of(a_machine), rpm * RPM, command.energise, command.release)
    opening, closing = (angle / DEGREE - target for angle, target in zip(opened, TARGETS, strict=True))
    return opening, closing
