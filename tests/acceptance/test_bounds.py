"""No machine beats what thermodynamics allows, whatever its parameters; and limits that are known exactly.

Flow exergy that enters and the exergy of the walls' heat bound every run, and nothing destroys less than none;
isentropic work bounds adiabatic runs into which nothing flows back. Full admission is a reference, which the engine
without expansion comes up to.
"""

from math import inf, pi

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from apesim.engine.angles import DEGREE
from apesim.engine.cycle.state import control_ledger, engine_ledger
from apesim.engine.exergy import ENTERS, LEAVES, exergy_closure, exergy_ledger
from apesim.engine.friction import Friction
from apesim.engine.ideal_work import full_admission_work, isentropic_work
from apesim.engine.indicators import closure, indicators
from apesim.engine.kinematics import crank_of, cylinder_volume
from apesim.engine.steady import run_steady
from apesim.valve.supply import REGULATOR
from tests.acceptance.random_engines import random_engine
from tests.machines import AMBIENT, RPM, machine, settled

CLOSURE = 1e-9
EXERGY_CLOSURE = 1e-6


def reals(low, high):
    return st.floats(low, high, allow_nan=False)


@st.composite
def machines(draw):
    """A machine and its speed [r/min]."""
    return random_engine(lambda low, high: draw(reals(low, high)), lambda options: draw(st.sampled_from(options)))


def ideal_work(law, a_machine, run):
    """Work by a law of `apesim.engine.ideal_work`, of all the air that the engine takes from the supply [J]."""
    air = engine_ledger(run.end).groove.mass
    if run.cycle.control_from_receiver:
        air += control_ledger(run.end).supplied.mass
    supply = a_machine.supply
    return air * law(run.cycle.actuator.gas, supply.temperature, supply.pressure / a_machine.ambient.pressure)


@settings(max_examples=150, derandomize=True, deadline=None, database=None, suppress_health_check=[*HealthCheck])
@given(machines())
def test_no_machine_beats_exergy_and_every_one_closes(drawn):
    a_machine, rpm = drawn
    run = run_steady(a_machine, rpm * RPM, angle_step=10.0 * DEGREE, max_cycles=120)
    assert run.status == 0
    assume(run.orbit.converged)
    mass, energy = closure(run)
    assert mass < CLOSURE
    assert energy < CLOSURE
    terms = exergy_ledger(run, 0.0)
    enters = sum(terms[name] for name in ENTERS)
    assert exergy_closure(run, terms) < EXERGY_CLOSURE
    assert {name for name in LEAVES if terms[name] < -EXERGY_CLOSURE * abs(enters)} == set()
    ledger, heat = engine_ledger(run.end), a_machine.effects.cylinder_wall_heat
    heated, leaky = heat.h or heat.factor, a_machine.effects.blow_by.area > 0.0
    work = ledger.work
    assert work <= enters - terms["control_air"] * (a_machine.supply.control_air == REGULATOR)
    if work > 0.0 and not (heated or leaky) and ledger.groove_back == ledger.exhaust_back == 0.0:
        assert work <= ideal_work(isentropic_work, a_machine, run)


SLOW_AND_WIDE = {
    "intake": "ideal",
    "groove__effective_area": 5e-4,
    "engine__exhaust__effective_area": 5e-4,
    "engine__exhaust__flank": 0.1 * DEGREE,
}
LOSSES = 3e-3
"""Next to none in groove and exhaust valve."""


@pytest.mark.parametrize("supply", [0.4, 1.0])
def test_full_expansion_and_recompression_come_close_to_isentropic_and_not_above(supply):
    """Cut-off from where the isentrope comes to ambient pressure at BDC; the exhaust valve closes from where what stays
    is recompressed to the supply's pressure at TDC, and there the groove opens."""
    ratio = ((supply * 1e6 + AMBIENT) / AMBIENT) ** (1.0 / 1.4)
    crank = crank_of(machine(engine__compression_ratio=50.0).engine)
    full = cylinder_volume(crank, pi)[0]
    assert crank.clearance * ratio < full / ratio
    angle = {
        volume: brentq(lambda a, volume=volume: cylinder_volume(crank, a)[0] - volume, 0.0, pi) / DEGREE
        for volume in (full / ratio, crank.clearance * ratio)
    }
    cut_off, close = angle[full / ratio], 360.0 - angle[crank.clearance * ratio]
    a_machine = machine(
        supply=supply,
        targets=(0.0, cut_off),
        engine__compression_ratio=50.0,
        engine__exhaust__opens=180.0 * DEGREE,
        engine__exhaust__closes=close * DEGREE,
        **SLOW_AND_WIDE,
    )
    run = settled(a_machine, 100.0, angle_step=10.0 * DEGREE)
    share = engine_ledger(run.end).work / ideal_work(isentropic_work, a_machine, run)
    assert 1.0 - LOSSES < share < 1.0


def test_admission_over_the_whole_stroke_tends_to_the_full_admission_efficiency_from_below():
    """What is missing is the filling of the clearance: (1 - p0/p) V_c/k over the volume swept, 1.3 %."""
    a_machine = machine(
        targets=(0.0, 180.0),
        engine__compression_ratio=50.0,
        engine__exhaust__opens=180.0 * DEGREE,
        engine__exhaust__closes=360.0 * DEGREE,
        **SLOW_AND_WIDE,
    )
    run = settled(a_machine, 100.0, angle_step=10.0 * DEGREE)
    share = engine_ledger(run.end).work / ideal_work(full_admission_work, a_machine, run)
    filling = (1.0 - AMBIENT / a_machine.supply.pressure) / 1.4 / 49.0
    assert share < 1.0
    assert share == pytest.approx(1.0 / (1.0 + filling), abs=LOSSES)


def test_an_infinite_receiver_is_the_limit_of_a_very_large_one():
    infinite, large = (
        indicators(a_machine, settled(a_machine, 800.0, angle_step=10.0 * DEGREE))
        for a_machine in (machine(receiver=volume, engine__receiver__feed_area=10000e-6) for volume in (inf, 1e4))
    )
    for name in ("indicated_torque_Nm", "engine_air_kg_per_cycle", "peak_cylinder_pressure_Pa"):
        assert large[name] == pytest.approx(infinite[name], rel=1e-4)


def test_without_friction_brake_is_indicated():
    a_machine = machine(engine__friction=Friction(0.0, 0.0, 0.0, 0.0))
    found = indicators(a_machine, settled(a_machine, 800.0))
    assert found["brake_torque_Nm"] == found["indicated_torque_Nm"]
    assert found["brake_power_W"] == found["indicated_power_W"]
    assert found["fmep_Pa"] == 0.0
