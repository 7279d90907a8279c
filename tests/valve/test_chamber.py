from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from apesim.air import THERMALLY_PERFECT, Air, GasContent, GasState, enthalpy, gas_of, internal_energy
from apesim.effect import NoEffects
from apesim.restriction import SHUT, Sides, flow_between, flow_in, regime_between
from apesim.valve.actuator import (
    MODES,
    PHASE,
    REGIME,
    START,
    X_A,
    X_A_SLOPE,
    X_B,
    actuator_of,
    actuator_rates,
    state_of,
)
from apesim.valve.bench import bench_of
from apesim.valve.chamber import chamber_state
from apesim.valve.piston import HELD_CLOSED, TO_CLOSED, TO_OPEN
from apesim.valve.solenoid_flow import SUPPLY_A, VENT_A, solenoid_sides, start_solenoid_segment
from apesim.valve.supply import ValveSupply
from apesim.valve.terms import ValveState
from tests import lemmon_air
from tests.valve.test_bench import BenchMachine

GASES = pytest.mark.parametrize("air", [Air(), Air(model=THERMALLY_PERFECT)], ids=["ideal", "thermally perfect"])
VOLUME = 2e-5
SUPPLY, AMBIENT = GasState(1.1e6, 290.0), GasState(1.0e5, 300.0)


def flow(gas, which, area, pressure, temperature, regime=None):
    """A flow through solenoid A, its chamber at a pressure and temperature."""
    own, supply = (GasState(pressure, temperature), VOLUME), ValveSupply(SUPPLY, AMBIENT.pressure)
    state = ValveState(gas, AMBIENT, None, 4e-3, 0.0, *own, *own, supply, AMBIENT.pressure, 1.0)
    sides = solenoid_sides(state)[which]
    return flow_in(gas, regime_between(gas, sides) if regime is None else regime, area, sides)


@GASES
@given(pressure=st.floats(1e4, 3e6), temperature=st.floats(120.0, 700.0))
def test_pressure_and_temperature_follow_from_mass_and_energy(air, pressure, temperature):
    gas = gas_of(air)
    mass = pressure * VOLUME / (gas.gas_constant * temperature)
    state = chamber_state(gas, GasContent(mass, mass * internal_energy(gas, temperature)), VOLUME)
    assert state == pytest.approx((pressure, temperature), rel=1e-12)


@GASES
def test_a_closed_chamber_follows_the_isentrope(air):
    gas = gas_of(air)
    mass = 1e6 * VOLUME / (gas.gas_constant * 400.0)
    energy = mass * internal_energy(gas, 400.0)
    steps = 20000
    volumes = np.linspace(VOLUME, 4.0 * VOLUME, steps + 1)
    for low, high in pairwise(volumes):
        middle = energy - 0.5 * (high - low) * chamber_state(gas, GasContent(mass, energy), low).pressure
        energy -= (high - low) * chamber_state(gas, GasContent(mass, middle), 0.5 * (low + high)).pressure
    pressure, temperature = chamber_state(gas, GasContent(mass, energy), volumes[-1])
    # The midpoint rule: off by about (dV/V)^2 = (3/20000)^2, some times over.
    near = 10.0 * (3.0 / steps) ** 2
    if air.model == THERMALLY_PERFECT:
        rise = lemmon_air.entropy(temperature, pressure) - lemmon_air.entropy(400.0, 1e6)
        # The polynomial keeps to 2e-5 of cp, and the temperature falls by a factor of 1.7.
        assert rise == pytest.approx(0.0, abs=(near + 2e-5) * 1010.0)
    else:
        assert pressure == pytest.approx(1e6 * 4.0**-1.4, rel=near)
        assert temperature == pytest.approx(400.0 * 4.0**-0.4, rel=near)


@GASES
def test_air_comes_in_as_warm_as_the_supply_and_leaves_as_warm_as_the_chamber(air):
    gas = gas_of(air)
    supplied, supplied_enthalpy = flow(gas, SUPPLY_A, 9e-6, 5e5, 250.0)
    vented, vented_enthalpy = flow(gas, VENT_A, 4e-6, 5e5, 250.0)
    assert supplied > 0.0
    assert vented > 0.0
    assert supplied_enthalpy == supplied * enthalpy(gas, 290.0)
    assert vented_enthalpy == vented * enthalpy(gas, 250.0)


@GASES
def test_back_flow_changes_sign_and_temperature(air):
    gas = gas_of(air)
    supplied, supplied_enthalpy = flow(gas, SUPPLY_A, 9e-6, 1.2e6, 350.0)
    assert supplied < 0.0
    assert supplied_enthalpy == supplied * enthalpy(gas, 350.0)
    vented, vented_enthalpy = flow(gas, VENT_A, 9e-6, 0.9e5, 250.0)
    assert vented < 0.0
    assert vented_enthalpy == vented * enthalpy(gas, 300.0)


def test_a_side_that_is_shut_passes_nothing():
    gas = gas_of(Air())
    assert flow(gas, SUPPLY_A, 0.0, 5e5, 250.0) == (0.0, 0.0)
    assert flow(gas, SUPPLY_A, 9e-6, 5e5, 250.0, regime=SHUT) == (0.0, 0.0)


# --- the first law in both chambers ---


@GASES
@pytest.mark.parametrize("phase", [TO_CLOSED, TO_OPEN, HELD_CLOSED])
@pytest.mark.parametrize("x", [0.0, 0.3, 1.0])
def test_energy_of_a_chamber_changes_by_enthalpy_and_work_alone(air, phase, x):
    bench, _ = bench_of(BenchMachine(air=air), [0.0, 1.0])
    actuator, gas = bench.actuator, bench.actuator.gas
    position, speed = 4e-3, 1.5 * phase
    volumes = 11382e-9 + 1134.1e-6 * position, 11382e-9 + 1134.1e-6 * (9e-3 - position)
    states = GasState(7e5, 310.0), GasState(3e5, 260.0)
    y = np.zeros(13)
    y[:2] = position, speed
    for i, ((p, t), volume) in enumerate(zip(states, volumes, strict=True)):
        mass = p * volume / (gas.gas_constant * t)
        y[2 + 2 * i : 4 + 2 * i] = mass, mass * internal_energy(gas, t)
    mode = np.zeros(MODES)
    mode[PHASE], mode[START] = phase, 0.25
    # A line in time: the fraction is x at 0.5 s.
    mode[X_A], mode[X_A_SLOPE], mode[X_B] = x - 0.1, 0.4, x
    start_solenoid_segment(state_of(actuator, y, bench.supply), (1.0,) * 4, (1.0,) * 4, REGIME, mode)
    r = actuator_rates(actuator, 0.5, y, mode, bench.supply)
    moving = 0.0 if phase == HELD_CLOSED else speed
    into, out = (9e-6 * (1.0 - x), 9e-6 * x), (9e-6 * x, 9e-6 * (1.0 - x))
    flows_a, flows_b = (
        flow_between(gas, supply, Sides(bench.supply.control, own))
        + flow_between(gas, vent, Sides(own, actuator.ambient))
        for own, supply, vent in zip(states, into, out, strict=True)
    )
    for mass, energy, (m_in, h_in, m_out, h_out), (p, _), growth in (
        (r.states.mass_a, r.states.energy_a, flows_a, states[0], 1134.1e-6 * moving),
        (r.states.mass_b, r.states.energy_b, flows_b, states[1], -1134.1e-6 * moving),
    ):
        assert mass == pytest.approx(m_in - m_out, rel=1e-9)
        assert energy == pytest.approx(h_in - h_out - p * growth, rel=1e-9)
    assert r.states.position == moving
    assert r.work == pytest.approx((7e5 - 3e5) * 1134.1e-6 * moving, rel=1e-12)
    if phase != HELD_CLOSED:
        force = 4e5 * 1134.1e-6 + 1828.0 * (9e-3 - 2.0 * position) - 111.08 * speed
        assert r.states.speed == pytest.approx(force / 0.1145, rel=1e-12)
    else:
        assert r.states.speed == 0.0


def test_an_effect_at_strength_zero_is_not_even_looked_at():
    assert actuator_of(BenchMachine(), [0.0, 1.0], np.inf)[0].effects == NoEffects()
