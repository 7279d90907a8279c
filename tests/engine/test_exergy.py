"""Exergy: its laws against Lemmon's air and textbooks; the ledger of a cycle against its trace and its own closure."""

from math import inf, log

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apesim.air import THERMALLY_PERFECT, Air, GasContent, GasState, enthalpy, gas_of
from apesim.engine.angles import DEGREE
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cycle.operating_point import charged_at_rest, cycle_of
from apesim.engine.cycle.rates import cycle_rates, start_cycle_segment
from apesim.engine.cycle.state import SIZE, STATES, cylinder_state, engine_ledger, instant_at
from apesim.engine.effects import ALL_EFFECTS
from apesim.engine.exergy import ENTERS, LEAVES, RATES, TERMS, exergy_closure, exergy_ledger, stored_exergy
from apesim.engine.indicators import indicators
from apesim.engine.steady import run_steady
from apesim.exergy import Stream, exergy_brought, exergy_stored, flow_exergy, mixing_loss, throttling_loss
from apesim.valve.actuator import PHASE
from apesim.valve.chamber import chamber_state, filled
from apesim.valve.piston import TO_OPEN
from tests import lemmon_air
from tests.machines import AMBIENT, RPM, changed, machine, settled, turned_on

R, CP = 287.05, 3.5 * 287.05
IDEAL_GAS, PERFECT_GAS = gas_of(Air()), gas_of(Air(model=THERMALLY_PERFECT))
GASES = pytest.mark.parametrize("gas", [IDEAL_GAS, PERFECT_GAS], ids=["ideal", "thermally perfect"])
ROOM = GasState(100e3, 310.0)
CLOSURE = 1e-6


@given(st.floats(150.0, 600.0), st.floats(0.5, 30.0))
def test_flow_exergy_with_cp_of_t_is_lemmons(temperature, ratio):
    def availability(pressure, temperature):
        return lemmon_air.enthalpy(temperature) - ROOM.temperature * lemmon_air.entropy(temperature, pressure)

    expected = availability(ratio * ROOM.pressure, temperature) - availability(*ROOM)
    found = flow_exergy(PERFECT_GAS, ROOM, GasState(ratio * ROOM.pressure, temperature))
    # The polynomial keeps to 2e-5 of cp: at most 0.3 J/kg for each 10 K, the most where the exergy is small.
    assert found == pytest.approx(expected, rel=1e-5, abs=3e-5 * 1050.0 * abs(temperature - ROOM.temperature) + 1e-6)


def test_flow_exergy_with_constant_cp_is_the_textbook_formula():
    expected = CP * (287.0 - 310.0) - 310.0 * (CP * log(287.0 / 310.0) - R * log(8.0))
    assert flow_exergy(IDEAL_GAS, ROOM, GasState(8.0 * ROOM.pressure, 287.0)) == pytest.approx(expected, rel=1e-12)
    assert flow_exergy(IDEAL_GAS, ROOM, ROOM) == 0.0


@GASES
def test_a_stream_that_is_throttled_and_mixed_brings_what_is_left_of_its_exergy(gas):
    """From 8 bar and 250 K through a restriction into 3 bar and 400 K."""
    stream, volume = Stream(0.1, 250.0), GasState(3e5, 400.0)
    brought = exergy_brought(gas, ROOM, 0.1, 0.1 * enthalpy(gas, 250.0), volume)
    lost = throttling_loss(gas, ROOM, stream, 8e5, 3e5) + mixing_loss(gas, ROOM, stream, 400.0)
    assert brought == pytest.approx(0.1 * flow_exergy(gas, ROOM, GasState(8e5, 250.0)) - lost, rel=1e-12)
    assert mixing_loss(gas, ROOM, stream, 400.0) > 0.0
    assert mixing_loss(gas, ROOM, stream, 250.0) == 0.0


@GASES
def test_what_is_brought_is_how_the_exergy_of_a_volume_rises(gas):
    volume, state, mass_more, energy_more = 1e-3, GasState(3e5, 400.0), 1e-9, 5e-4
    content = filled(gas, volume, state)
    more = GasContent(content.mass + mass_more, content.energy + energy_more)
    before, after = (
        exergy_stored(gas, ROOM, held, chamber_state(gas, held, volume), volume) for held in (content, more)
    )
    assert after - before == pytest.approx(exergy_brought(gas, ROOM, mass_more, energy_more, state), rel=1e-4)


# --- the ledger of a cycle ---

EFFECTS = {effect.name: effect for effect in ALL_EFFECTS}


def with_effects(*names, **options):
    a_machine = machine(**options)
    return changed(a_machine, {f"effects.{name}": turned_on(EFFECTS[name], 0.3) for name in names})


VALVE_LEAKS = "ring_leakage", "leakage_a", "leakage_b"
CASES = {
    "receiver": (machine(receiver=1.0), 1000.0),
    "infinite receiver, back-flow into it": (machine(supply=0.3, energise=-60.0, release=20.0), 1000.0),
    "control air from the receiver": (machine(receiver=0.3, control_air="receiver"), 1500.0),
    "control air of its own pressure": (machine(receiver=1.0, supply__control_pressure=0.6e6), 600.0),
    "cp(T)": (machine(receiver=1.0, air__model=THERMALLY_PERFECT), 1000.0),
    "cam": (machine(receiver=1.0, intake="cam"), 1000.0),
    "ideal valve, stiff receiver": (machine(receiver=0.3, intake="ideal"), 400.0),
    "ideal valve, cylinder filled by choked flow in one step of the states": (
        machine(
            intake="ideal",
            supply=2.3622651005941298,
            temperature=244.3500984436233,
            energise=-25.9,
            release=177.4,
            engine__bore=0.04636283303942838,
            engine__compression_ratio=9.823723351551319,
        ),
        859.026586173326,
    ),
    "cold ambient": (machine(receiver=1.0, ambient__temperature=250.0), 1000.0),
    "warm ambient of high pressure": (machine(receiver=1.0, ambient__temperature=330.0, ambient__pressure=2e5), 900.0),
    "exhaust and vents below ambient": (machine(supply=0.1, intake="cam"), 700.0),
    "leaks and heat of the valve": (with_effects(*VALVE_LEAKS, "chamber_wall_heat", receiver=1.0), 1000.0),
    "leaks and heat of the cylinder": (
        with_effects("seat_leak", "blow_by", "cylinder_wall_heat", receiver=1.0),
        1000.0,
    ),
    "forces and bounce": (with_effects("coulomb_friction", "intake_flow_force", "bounce", "end_cushion"), 800.0),
    "line and pipe": (
        with_effects("supply_droop", "intake_pipe_loss", "seat_leak", receiver=0.5, control_air="receiver"),
        1000.0,
    ),
    "pipe behind an infinite receiver": (with_effects("intake_pipe_loss", "blow_by"), 1000.0),
    "changed vents and solenoids": (
        with_effects("vent_back_pressure", "critical_ratio", "discharge_coefficient_slope", "dead_volume"),
        1000.0,
    ),
    "back pressure behind the exhaust": (with_effects("exhaust_back_pressure", receiver=1.0), 1000.0),
    "tables": (with_effects("tabulated_leak", "tabulated_heat", "tabulated_cylinder_heat", receiver=1.0), 1000.0),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.compiled
def test_the_ledger_closes(case):
    a_machine, rpm = CASES[case]
    found = indicators(a_machine, settled(a_machine, rpm))
    terms = {name: found[f"exergy_{name}_J"] for name in TERMS}
    enters = terms["engine_air"] + terms["control_air"] + terms["wall_heat"]
    assert found["exergy_closure"] < CLOSURE
    assert terms["engine_friction"] + terms["brake_work"] == pytest.approx(terms["indicated_work"], rel=1e-12)
    # That of the march with the ledger, which takes other steps.
    assert terms["indicated_work"] == pytest.approx(found["indicated_torque_Nm"] * 2.0 * np.pi, rel=1e-6)
    if case != "forces and bounce":  # the force of the intake's air works on the piston without being paid for
        assert {name for name in LEAVES if terms[name] < -CLOSURE * enters} == set()
    assert abs(terms["stored"]) < CLOSURE * enters


@pytest.mark.skipif(not numba.config.DISABLE_JIT, reason="compiles as long as the marches of all cases")
@pytest.mark.parametrize("case", CASES)
def test_what_enters_leaves_is_stored_or_becomes_work_at_every_moment(case):
    """In states at random, with the valve on its way; what is stored by central differences.

    The piston also works on the ambient, which gives all of it back within a cycle.
    """
    a_machine, rpm = CASES[case]
    p, tables, breakpoints = cycle_of(a_machine, rpm * RPM)
    rng, h = np.random.default_rng(3), 2e-8
    for _ in range(8):
        y, mode = charged_at_rest(p)
        y[2:STATES] *= rng.uniform(0.7, 1.4, STATES - 2)
        y[0], y[1] = rng.uniform(0.1, 0.9) * a_machine.valve.stroke, rng.uniform(-1.0, 1.0)
        mode[PHASE] = TO_OPEN
        t = rng.uniform(0.0, 0.99 * breakpoints[-1])
        start_cycle_segment(p, tables, t, t + 1e-4, y, mode)
        dy = np.empty(SIZE + RATES)
        assert cycle_rates(p, t, np.append(y, np.zeros(RATES)), mode, dy)
        earlier, later = (stored_exergy(p, t + step, y + step * dy[:SIZE]) for step in (-h, h))
        enters = [dy[SIZE + number] for number, _ in ENTERS.values()]
        leaves = [dy[SIZE + number] for number, _ in LEAVES.values()]
        on_ambient = a_machine.ambient.pressure * cylinder_state(p, instant_at(p, t, y), y)[1] * p.speed
        stored, work = (later - earlier) / (2.0 * h), engine_ledger(dy).work - on_ambient
        turnover = sum(map(abs, (*enters, *leaves, stored, work)))
        assert abs(sum(enters) - sum(leaves) - stored - work) < 1e-7 * turnover


@pytest.mark.parametrize(("intake", "stores"), [("epv", True), ("cam", False), ("ideal", False)])
def test_only_an_engine_with_an_electro_pneumatic_valve_stores_exergy_in_one(intake, stores):
    p, _, _ = cycle_of(machine(intake=intake), 1000.0 * RPM)
    y, _ = charged_at_rest(p)
    moving = y.copy()
    moving[1] = 1.0
    assert (stored_exergy(p, 0.0, moving) - stored_exergy(p, 0.0, y) > 0.05) == stores


@pytest.mark.compiled
def test_the_ledger_closes_over_a_cycle_that_is_not_periodic_and_better_at_a_smaller_tolerance():
    closures = []
    for tolerance in (1e-5, 1e-7, 1e-9):
        run = run_steady(machine(receiver=1.0), 1000.0 * RPM, max_cycles=1, tolerance=tolerance)
        terms = exergy_ledger(run, 0.0)
        assert abs(terms["stored"]) > 1.0
        closures.append(exergy_closure(run, terms))
    assert closures[0] > 5.0 * closures[1] > 25.0 * closures[2]


def test_terms_are_those_of_the_trace():
    """Trapezia of 0.05 degrees; a receiver without end, so that the air before the groove has the supply's state."""
    a_machine = machine(receiver=inf)
    run = settled(a_machine, 1000.0, angle_step=0.05 * DEGREE)
    found = indicators(a_machine, run)
    column = {name.split(" [")[0]: run.trace[:, i] for i, name in enumerate(TRACE)}
    time = (run.angles - run.cycle.start) / run.cycle.speed
    pressure, temperature = column["cylinder_pressure"], column["cylinder_temperature"]
    into, out = column["groove_flow"], column["exhaust_flow"]
    supply, ambient = a_machine.supply, 293.15

    def mixed(one, other):
        return CP * (one - other) / other - CP * np.log(one / other)

    rates = {
        "engine_air": into * flow_exergy(IDEAL_GAS, a_machine.ambient, supply.engine_air()),
        "groove": into * ambient * R * np.log(supply.pressure / pressure),
        "cylinder_mixing": ambient * into * mixed(supply.temperature, temperature),
        "exhaust_valve": out * ambient * R * np.log(pressure / AMBIENT),
        "exhaust_air": out * (CP * (temperature - ambient) - ambient * CP * np.log(temperature / ambient)),
        "valve_friction": 111.08 * column["velocity"] ** 2,
    }
    for name, rate in rates.items():
        assert found[f"exergy_{name}_J"] == pytest.approx(np.trapezoid(rate, time), rel=2e-4), name
    speeds = found["opening_seating_speed_m_s"], found["closing_seating_speed_m_s"]
    assert found["exergy_valve_impacts_J"] == pytest.approx(sum(0.5 * 0.1145 * v**2 for v in speeds), rel=1e-9)
    assert found["exergy_vented_air_J"] > 0.0 and found["exergy_receiver_mixing_J"] == found["exergy_feed_J"] == 0.0
