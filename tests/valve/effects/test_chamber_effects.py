"""Effects of the chambers: leaks, heat, dead volume."""

import numpy as np
import pytest

from apesim.restriction import NO_FLOW, Sides, flow_between
from apesim.valve.actuator import state_of
from apesim.valve.effects.chamber_wall_heat import ChamberWallHeat
from apesim.valve.effects.dead_volume import DeadVolume
from apesim.valve.effects.leakage_a import LeakageA
from apesim.valve.effects.leakage_b import LeakageB
from apesim.valve.effects.ring_leakage import RingLeakage
from apesim.valve.piston import STUCK
from tests.valve.effects.test_valve_effects import machine_with, rates_at, run_with
from tests.valve.test_bench import PRESSURE_B, TEMPERATURE_A

# --- leakage past the rings ---


def test_leakage_takes_from_a_what_it_gives_to_b():
    p, y, with_it = rates_at(STUCK, machine_with(ring_leakage=RingLeakage(0.2e-6)))
    _, _, without = rates_at(STUCK, machine_with())
    s = state_of(p.actuator, y, p.supply)
    mass, energy = flow_between(s.gas, 0.2e-6, Sides(s.chamber_a, s.chamber_b))
    assert mass > 0.0
    assert with_it.states.mass_b - without.states.mass_b == pytest.approx(mass, rel=1e-9)
    assert with_it.states.mass_a - without.states.mass_a == pytest.approx(-mass, rel=1e-9)
    assert with_it.states.energy_b - without.states.energy_b == pytest.approx(energy, rel=1e-9)
    assert with_it.states.energy_a - without.states.energy_a == pytest.approx(-energy, rel=1e-9)
    assert with_it.let_in == NO_FLOW


def test_chamber_b_rises_while_held_and_everything_closes():
    before_any_switch = slice(1, 15)
    leaking, tight = run_with(ring_leakage=RingLeakage(0.3e-6)), run_with()
    assert tight.trace[before_any_switch, PRESSURE_B] == pytest.approx(101325.0, rel=1e-12)
    rise = leaking.trace[before_any_switch, PRESSURE_B]
    assert (np.diff(rise) > 0.0).all()
    assert rise[0] > 101325.0
    assert leaking.closure["mass"] <= 1e-9
    assert leaking.closure["energy"] <= 1e-9
    assert leaking.closure["work"] <= 1e-6
    assert leaking.control_air > tight.control_air


# --- leaks to ambient ---


def test_a_leak_of_chamber_a_is_choked_flow_out_of_it():
    """0.2 mm2 at 1.101325 MPa and 287 K: 0.684731 S p/sqrt(R T), with cp T of its enthalpy."""
    _, _, leaking = rates_at(STUCK, machine_with(leakage_a=LeakageA(0.2e-6)))
    _, _, tight = rates_at(STUCK, machine_with())
    lost = 0.684731 * 0.2e-6 * 1.101325e6 / np.sqrt(287.05 * 287.0) * _pressure_share()
    assert leaking.states.mass_a - tight.states.mass_a == pytest.approx(-lost, rel=1e-6)
    assert leaking.states.energy_a - tight.states.energy_a == pytest.approx(-lost * 1004.675 * 287.0, rel=1e-6)
    assert leaking.states.mass_b == tight.states.mass_b
    assert leaking.let_in.mass == pytest.approx(-lost, rel=1e-6)


def _pressure_share():
    """The gas of a piston at 9 mm, at 4 mm: V(9 mm)/V(4 mm)."""
    return (11382e-9 + 1134.1e-6 * 9e-3) / (11382e-9 + 1134.1e-6 * 4e-3)


def test_a_leak_of_chamber_b_is_flow_in_where_it_stands_below_ambient():
    """At 4 mm, B has 101325 Pa x 11382/(11382 + 1134.1 x 5) = 67633 Pa, r = 0.66749, subsonic from 293.15 K."""
    _, _, leaking = rates_at(STUCK, machine_with(leakage_b=LeakageB(0.2e-6)))
    _, _, tight = rates_at(STUCK, machine_with())
    ratio = 11382.0 / (11382.0 + 1134.1 * 5.0)
    psi = np.sqrt(7.0 * (ratio ** (2.0 / 1.4) - ratio ** (2.4 / 1.4)))
    gained = psi * 0.2e-6 * 101325.0 / np.sqrt(287.05 * 293.15)
    assert leaking.states.mass_b - tight.states.mass_b == pytest.approx(gained, rel=1e-6)
    assert leaking.states.energy_b - tight.states.energy_b == pytest.approx(gained * 1004.675 * 293.15, rel=1e-6)
    assert leaking.states.mass_a == tight.states.mass_a


def test_a_leak_of_a_lets_the_valve_open_sooner_and_takes_control_air():
    tight, leaking = run_with(), run_with(leakage_a=LeakageA(0.3e-6))
    assert leaking.opening.delay < tight.opening.delay
    assert leaking.control_air > tight.control_air
    assert run_with(leakage_b=LeakageB(0.3e-6)).opening.delay > tight.opening.delay


# --- heat ---


def test_wall_heat_of_a_chamber_by_hand():
    """2 x 1134.1 mm2 + 4 V/D, D = 38.000 mm, V_A = 15918.4 mm3, V_B = 17052.5 mm3; 200 W/(m2 K), walls 20 K warmer."""
    effect = ChamberWallHeat(200.0, 307.0)
    _, _, heated = rates_at(STUCK, machine_with(chamber_wall_heat=effect))
    _, _, adiabatic = rates_at(STUCK, machine_with())
    for found, volume in (
        (heated.states.energy_a - adiabatic.states.energy_a, 15918.4e-9),
        (heated.states.energy_b - adiabatic.states.energy_b, 17052.5e-9),
    ):
        assert found == pytest.approx(200.0 * (2.0 * 1134.1e-6 + 4.0 * volume / 38.000e-3) * 20.0, rel=1e-5)
    assert heated.states.mass_a == adiabatic.states.mass_a
    assert heated.let_in.enthalpy == pytest.approx(
        heated.states.energy_a - adiabatic.states.energy_a + heated.states.energy_b - adiabatic.states.energy_b,
        rel=1e-9,
    )


def test_walls_warm_the_air_that_expands():
    """Chamber A expands through its vent from 287 K: the colder air takes heat from walls at 293.15 K."""
    adiabatic, heated = run_with(), run_with(chamber_wall_heat=ChamberWallHeat(400.0))
    coldest = np.argmin(adiabatic.trace[:, TEMPERATURE_A])
    assert adiabatic.trace[coldest, TEMPERATURE_A] < 280.0
    assert heated.trace[coldest, TEMPERATURE_A] > adiabatic.trace[coldest, TEMPERATURE_A]


# --- dead volume ---


def test_dead_volume_enlarges_both_chambers():
    p, y, _ = rates_at(STUCK, machine_with(dead_volume=DeadVolume(2000e-9)))
    state = state_of(p.actuator, y, p.supply)
    assert state.volume_a == pytest.approx((11382 + 2000 + 1134.1 * 4.0) * 1e-9, rel=1e-12)
    assert state.volume_b == pytest.approx((11382 + 2000 + 1134.1 * 5.0) * 1e-9, rel=1e-12)


def test_dead_volume_delays_the_opening_and_takes_control_air():
    runs = [run_with(dead_volume=DeadVolume(volume)) for volume in (0.0, 2500e-9, 5000e-9)]
    assert [r.opening.delay for r in runs] == sorted(r.opening.delay for r in runs)
    assert [r.control_air for r in runs] == sorted(r.control_air for r in runs)
    assert runs[0].opening.delay < runs[2].opening.delay
