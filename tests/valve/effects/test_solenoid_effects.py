"""Effects of the solenoids: delays, ramp, critical ratio, discharge coefficient, vents."""

from itertools import pairwise
from math import sqrt

import numpy as np
import pytest

from apesim.air import GasState
from apesim.restriction import NO_FLOW, flow_in, iso6358_flow, regime_between
from apesim.valve.actuator import MODES, PHASE, X_B, X_B_SLOPE, actuator_rates, closed_at_rest, state_of
from apesim.valve.bench import bench_of, run_bench
from apesim.valve.effects import ValveEffects
from apesim.valve.effects.critical_ratio import CriticalRatio
from apesim.valve.effects.discharge_coefficient_slope import DischargeCoefficientSlope
from apesim.valve.effects.pressure_dependent_delay import PressureDependentDelay
from apesim.valve.effects.release_delay import ReleaseDelay
from apesim.valve.effects.slow_ramp import SlowRamp
from apesim.valve.effects.solenoid_a_delay import SolenoidADelay
from apesim.valve.effects.solenoid_b_delay import SolenoidBDelay
from apesim.valve.effects.vent_back_pressure import VentBackPressure
from apesim.valve.motion import start_actuator_segment
from apesim.valve.piston import HELD_CLOSED
from apesim.valve.solenoid import Solenoid, energised_fraction
from apesim.valve.solenoid_flow import SUPPLY_A, VENT_A, solenoid_sides
from apesim.valve.supply import ValveSupply
from tests.valve.effects.test_valve_effects import PULSE, machine_with, run_with
from tests.valve.test_bench import LIFT, PRESSURE_A, PRESSURE_B, BenchMachine

# --- solenoid B, late or early ---


@pytest.mark.parametrize("rows", [5, -5])
def test_a_delay_of_solenoid_b_shifts_its_pressure_by_just_that(rows):
    sample = 1e-4
    plain = run_bench(BenchMachine(), PULSE, tolerance=1e-10)
    late = run_bench(machine_with(solenoid_b_delay=SolenoidBDelay(rows * sample)), PULSE, tolerance=1e-10)
    still = np.flatnonzero(plain.trace[:, LIFT] == 0.0)
    start = np.flatnonzero(np.diff(still) > 1)
    held = min(start[0] if len(start) else len(still), np.argmax(late.trace[:, LIFT] > 0.0)) - abs(rows)
    assert held > 25
    early_rows, late_rows = (
        (slice(0, held), slice(rows, held + rows))
        if rows > 0
        else (
            slice(-rows, held),
            slice(0, held + rows),
        )
    )
    assert plain.trace[held - 1, PRESSURE_B] > 1.5 * 101325.0
    # Rows lie between the steps, where the interpolant is of order 4 and the step of order 5: 1e-10 ** 0.8.
    assert late.trace[late_rows, PRESSURE_B] == pytest.approx(
        plain.trace[early_rows, PRESSURE_B], rel=10.0 * 1e-10**0.8
    )
    assert late.trace[:held, PRESSURE_A] == pytest.approx(plain.trace[:held, PRESSURE_A], rel=10.0 * 1e-10**0.8)


def test_a_solenoid_b_that_would_be_earlier_than_its_command_keeps_its_lines():
    machine = BenchMachine.with_(valve={"solenoid": Solenoid(dead_time=0.2e-3)})
    p, tables = bench_of(machine._replace(effects=ValveEffects(solenoid_b_delay=SolenoidBDelay(-1e-3))), [0.0, PULSE])
    for t, t_end in pairwise(tables.breakpoints(0.0, 2.0 * PULSE)):
        mode = np.zeros(MODES)
        start_actuator_segment(
            p.actuator, tables, t, t_end, closed_at_rest(p.actuator, p.supply.control), mode, p.supply
        )
        middle = 0.5 * (t + t_end)
        expected = energised_fraction(tables.edges_b, tables.period, tables.curves_b, middle)
        assert mode[X_B] + mode[X_B_SLOPE] * (middle - t) == pytest.approx(expected, abs=1e-9)


def test_a_late_solenoid_b_delays_the_opening():
    delays = [run_with(solenoid_b_delay=SolenoidBDelay(time)).opening.delay for time in (-0.5e-3, 0.0, 0.5e-3)]
    assert delays[0] < delays[1] < delays[2]


# --- solenoid A, ramp, pressure ---


def curves_of(supply_pressure=1.101325e6, solenoid=None, **effects):
    """Curves of solenoids A and B by edge, time in ms."""
    machine = machine_with(**effects)
    machine = machine._replace(supply=machine.supply._replace(pressure=supply_pressure))
    if solenoid:
        machine = machine._replace(valve=machine.valve._replace(solenoid=solenoid))
    _, tables = bench_of(machine, [0.0, PULSE])
    return [[(curve * [1e3, 1.0]).round(9).tolist() for curve in own] for own in (tables.curves_a, tables.curves_b)]


def test_a_delay_of_solenoid_a_leaves_b_alone():
    late, plain, early = [[1.9, 0.0], [3.4, 1.0]], [[1.5, 0.0], [3.0, 1.0]], [[1.1, 0.0], [2.6, 1.0]]
    assert curves_of(solenoid_a_delay=SolenoidADelay(0.4e-3)) == [[late] * 2, [plain] * 2]
    assert curves_of(solenoid_a_delay=SolenoidADelay(-0.4e-3))[0] == [early] * 2


# --- release ---


def test_a_release_delay_leaves_energising_alone():
    plain, late, early = [[1.5, 0.0], [3.0, 1.0]], [[2.3, 0.0], [3.8, 1.0]], [[0.5, 0.0], [2.0, 1.0]]
    assert curves_of(release_delay=ReleaseDelay(0.8e-3)) == [[plain, late]] * 2
    assert curves_of(release_delay=ReleaseDelay(-1e-3)) == [[plain, early]] * 2


def test_a_release_delay_is_the_dead_time_of_release_in_the_machine_file():
    machine = BenchMachine.with_(valve={"solenoid": Solenoid(release_dead_time=2.3e-3)})
    said, found = run_bench(machine, PULSE), run_with(release_delay=ReleaseDelay(0.8e-3))
    assert found.trace == pytest.approx(said.trace, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("rows", [8, -5])
def test_a_release_delay_shifts_the_closing_by_just_that_and_the_opening_not_at_all(rows):
    """All is at rest before the release, so a later one is the same closing, later."""
    sample = 1e-4
    plain, late = (
        run_bench(machine_with(release_delay=ReleaseDelay(time)), PULSE, tolerance=1e-10, sample=sample)
        for time in (0.0, rows * sample)
    )
    assert late.opening == plain.opening
    assert late.closing.delay - plain.closing.delay == pytest.approx(rows * sample, abs=1e-6)
    assert late.closing.seating_speed == pytest.approx(plain.closing.seating_speed, rel=1e-3)


def test_a_late_solenoid_a_delays_the_opening_and_an_early_one_advances_it():
    delays = [run_with(solenoid_a_delay=SolenoidADelay(time)).opening.delay for time in (-0.5e-3, 0.0, 0.5e-3)]
    assert delays[0] < delays[1] < delays[2]


@pytest.mark.parametrize(("time", "end"), [(0.9, 3.9), (-0.9, 2.1), (-1.5, 1.501)])
def test_a_slow_ramp_ends_later_from_the_same_dead_time_on(time, end):
    assert curves_of(slow_ramp=SlowRamp(time * 1e-3)) == [[[[1.5, 0.0], [end, 1.0]]] * 2] * 2


def test_a_slow_ramp_stretches_a_measured_curve_evenly():
    solenoid = Solenoid(opening_curve=np.array([[1e-3, 0.0], [1.5e-3, 0.2], [3e-3, 1.0]]))
    expected = [[1.0, 0.0], [1.75, 0.2], [4.0, 1.0]]
    assert curves_of(solenoid=solenoid, slow_ramp=SlowRamp(1e-3)) == [[expected] * 2] * 2


def test_a_slow_ramp_makes_the_piston_start_later_and_slower():
    runs = [run_with(slow_ramp=SlowRamp(time)).opening for time in (-1e-3, 0.0, 1e-3)]
    assert runs[0].delay < runs[1].delay < runs[2].delay
    assert runs[0].contact < runs[1].contact < runs[2].contact


@pytest.mark.parametrize(("pressure", "later"), [(0.4, 0.0), (0.9, 1.0), (0.2, -0.4)])
def test_delay_grows_with_control_pressure_from_the_reference_on(pressure, later):
    """2 ms/MPa above 0.4 MPa gauge."""
    found = curves_of(pressure * 1e6 + 101325.0, pressure_dependent_delay=PressureDependentDelay(2e-9))
    assert found == [[[[round(1.5 + later, 9), 0.0], [round(3.0 + later, 9), 1.0]]] * 2] * 2


def test_no_delay_comes_before_the_command():
    """-2.5 ms/MPa x 0.7 MPa would be 1.75 ms, more than the dead time of 1.5 ms."""
    found = curves_of(1.1e6 + 101325.0, pressure_dependent_delay=PressureDependentDelay(-2.5e-9))
    assert found == [[[[0.0, 0.0], [1.5, 1.0]]] * 2] * 2


# --- critical ratio ---

CHOKED = 0.684731 * 9e-6 * 8e5 / sqrt(287.05 * 300.0)
"""Eq. 8 at k = 1.4 and Eq. 7: 9 mm2, 8 bar, 300 K [kg/s]."""


def supply_flow(ratio, critical):
    """Flow through solenoid A's open supply side from 8 bar and 300 K [kg/s]."""
    p, _ = bench_of(machine_with(critical_ratio=CriticalRatio(critical)), [0.0, PULSE])
    y = closed_at_rest(p.actuator, GasState(ratio * 8e5, 300.0))
    state = state_of(p.actuator, y, ValveSupply(GasState(8e5, 300.0), 101325.0))
    sides = solenoid_sides(state)[SUPPLY_A]
    return flow_in(state.gas, regime_between(state.gas, sides), 9e-6, sides).mass


@pytest.mark.parametrize("critical", [0.2, 0.35, 0.5])
def test_flow_is_choked_up_to_b_and_falls_beyond(critical):
    assert supply_flow(critical - 0.001, critical) == pytest.approx(CHOKED, rel=1e-6)
    assert supply_flow(critical + 0.05, critical) < CHOKED * (1.0 - 1e-4)


@pytest.mark.parametrize("critical", [0.2, 0.35, 0.5])
@pytest.mark.parametrize("share", [0.1, 0.3, 0.5, 0.7, 0.9])
def test_flow_follows_the_quarter_ellipse_of_iso_6358(critical, share):
    """Eq. 8 itself lies within 0.7 % of the choked flow off the ellipse of b = 0.528."""
    ratio = critical + share * (1.0 - critical)
    ellipse = iso6358_flow(1.0, critical, 8e5, ratio * 8e5) / iso6358_flow(1.0, critical, 8e5, 0.0)
    assert supply_flow(ratio, critical) / CHOKED == pytest.approx(ellipse, abs=0.007)


def test_a_flow_from_chamber_to_vent_chokes_at_b_too():
    p, _ = bench_of(machine_with(critical_ratio=CriticalRatio(0.3)), [0.0, PULSE])
    for pressure, regime in ((101325.0 / 0.31, 2), (101325.0 / 0.29, 3)):
        y = closed_at_rest(p.actuator, GasState(pressure, 300.0))
        state = state_of(p.actuator, y, ValveSupply(GasState(8e5, 300.0), 101325.0))
        assert regime_between(state.gas, solenoid_sides(state)[VENT_A]) == regime


def test_a_lower_critical_ratio_slows_the_stroke():
    contacts = [run_with(critical_ratio=CriticalRatio(b)).opening.contact for b in (0.528, 0.4, 0.2)]
    assert contacts == sorted(contacts)
    assert contacts[0] < contacts[2]


# --- discharge coefficient ---


def test_discharge_coefficient_falls_with_the_pressure_ratio():
    """Chamber A vents from 0.5506625 MPa, r = 0.184006; chamber B fills from 1.101325 MPa, r = 0.0920028."""
    effect = {"discharge_coefficient_slope": DischargeCoefficientSlope(0.3)}
    falling, constant = (opened(machine_with(**values)) for values in (effect, {}))
    for kind, ratio in (("vented", 0.184006), ("supplied", 0.0920028)):
        for part, whole in zip(getattr(falling, kind), getattr(constant, kind), strict=True):
            assert whole > 0.0
            assert part == pytest.approx((1.0 - 0.3 * ratio) * whole, rel=1e-6)
    assert falling.states.mass_a == -falling.vented.mass
    assert falling.states.mass_b == falling.supplied.mass
    assert falling.let_in == NO_FLOW


def opened(machine):
    """Rates with both solenoids fully energised, and half of the air in chamber A."""
    machine = machine._replace(valve=machine.valve._replace(solenoid=Solenoid(dead_time=0.0, ramp_time=1e-9)))
    p, tables = bench_of(machine, [-1.0, PULSE])
    y = np.append(closed_at_rest(p.actuator, p.supply.control), np.zeros(7))
    y[2:4] *= 0.5
    mode = np.zeros(MODES)
    mode[PHASE] = HELD_CLOSED
    start_actuator_segment(p.actuator, tables, 0.0, 1e-6, y, mode, p.supply)
    return actuator_rates(p.actuator, 0.0, y, mode, p.supply)


def test_a_falling_discharge_coefficient_slows_the_stroke_and_a_rising_one_hastens_it():
    contacts = [
        run_with(discharge_coefficient_slope=DischargeCoefficientSlope(fall)).opening.contact
        for fall in (-0.3, 0.0, 0.3)
    ]
    assert contacts[0] < contacts[1] < contacts[2]


# --- vents ---


def test_back_pressure_is_where_vents_end_and_where_chamber_b_starts():
    run = run_with(vent_back_pressure=VentBackPressure(20e3))
    assert run.trace[0, PRESSURE_B] == pytest.approx(121325.0, rel=1e-12)
    held_open = np.searchsorted(run.times, PULSE) - 1
    assert run.trace[held_open, PRESSURE_A] == pytest.approx(121325.0, rel=1e-3)


def test_back_pressure_starts_both_strokes_sooner():
    """The chamber that empties is choked and does not feel it; the other one starts to fill from a higher pressure."""
    runs = [run_with(vent_back_pressure=VentBackPressure(pressure)) for pressure in (0.0, 15e3, 30e3)]
    for stroke in ("opening", "closing"):
        delays = [getattr(run, stroke).delay for run in runs]
        assert delays[0] > delays[1] > delays[2]
