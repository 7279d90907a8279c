from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from apesim.air import Air, Ambient
from apesim.effect import NoEffects
from apesim.march.adaptive import Status
from apesim.valve.actuator import STATES, actuator_of, closed_at_rest
from apesim.valve.bench import TRACE, bench_of, run_bench
from apesim.valve.effects import ValveEffects
from apesim.valve.groove import Groove
from apesim.valve.motion import MET_CLOSED, MET_OPEN
from apesim.valve.piston import Valve
from apesim.valve.solenoid import Solenoid
from apesim.valve.supply import Supply

LIFT, VELOCITY, PRESSURE_A, PRESSURE_B, TEMPERATURE_A, TEMPERATURE_B = range(len(TRACE))


class BenchMachine(NamedTuple):
    """The sections of a machine that the bench looks at."""

    air: Air = Air()
    ambient: Ambient = Ambient()
    supply: Supply = Supply()
    valve: Valve = Valve()
    groove: Groove = Groove()
    effects: ValveEffects = ValveEffects()

    @classmethod
    def with_(cls, **sections):
        """Defaults, but for the keys given by section."""
        machine = cls()
        return machine._replace(**{name: getattr(machine, name)._replace(**keys) for name, keys in sections.items()})


DEFAULT = BenchMachine()


def numbers(run):
    """All numbers of a run, for comparison bit by bit."""
    return np.concatenate([run.trace.ravel(), run.opening, run.closing, [run.control_air, run.steps]])


# --- start ---


def test_the_bench_starts_closed_at_rest_with_a_full_and_b_empty():
    row = run_bench(DEFAULT, 5e-3).trace[0]
    expected = [0.0, 0.0, DEFAULT.supply.pressure, DEFAULT.ambient.pressure, 287.0, 287.0]
    # Lift is a difference of two equal numbers; the others are a product and a quotient away from the state.
    assert row == pytest.approx(expected, rel=1e-14, abs=0.0)


def test_control_air_may_have_a_pressure_of_its_own():
    run = run_bench(BenchMachine.with_(supply={"control_pressure": 0.7e6}), 5e-3)
    assert run.trace[0, PRESSURE_A] == pytest.approx(0.7e6, rel=1e-14)


# --- the equations, marched by somebody else ---


def naive_psi(r, k=1.4):
    if r > 0.999:
        return naive_psi(0.999) * (1.0 - r) / 0.001
    r = max(r, (2.0 / (k + 1.0)) ** (k / (k - 1.0)))
    return np.sqrt(2.0 * k / (k - 1.0) * (r ** (2.0 / k) - r ** ((k + 1.0) / k)))


def naive_flow(area, p, t, p_other, t_other):
    """Mass and enthalpy into a volume at p, t from another (Eqs. 7, 8)."""
    sign, (high, warm), low = (1.0, (p_other, t_other), p) if p_other > p else (-1.0, (p, t), p_other)
    mass = sign * area * naive_psi(low / high) * high / np.sqrt(287.05 * warm)
    return mass, mass * 3.5 * 287.05 * warm


def naive_rates(t, y, moving):
    """Eqs. 1-8 at the defaults, pulse on since t = 0; pressures and temperatures instead of masses and energies."""
    position, speed, p_a, t_a, p_b, t_b = y
    x = min(1.0, max(0.0, (t - 1.5e-3) / 1.5e-3))
    dy = [speed, 0.0]
    if moving:
        force = (p_a - p_b) * 1134.1e-6 + 1828.0 * (9e-3 - 2.0 * position) - 111.08 * speed
        dy[1] = force / 0.1145
    for p, t_gas, volume, swell, supply in (
        (p_a, t_a, 11382e-9 + 1134.1e-6 * position, 1134.1e-6 * speed, 9e-6 * (1.0 - x)),
        (p_b, t_b, 11382e-9 + 1134.1e-6 * (9e-3 - position), -1134.1e-6 * speed, 9e-6 * x),
    ):
        m_in, h_in = naive_flow(supply, p, t_gas, 1.101325e6, 287.0)
        m_out, h_out = naive_flow(9e-6 - supply, p, t_gas, 101325.0, 293.15)
        dp = 0.4 / volume * (h_in + h_out) - 1.4 * p / volume * swell
        mass = p * volume / (287.05 * t_gas)
        dy += [dp, t_gas * (dp / p + swell / volume - (m_in + m_out) / mass)]
    return dy


def test_scipy_finds_the_same_start_flight_and_contact():
    def march_on(start, end, y, moving, event=None):
        if event:
            event.terminal = True
        return solve_ivp(
            naive_rates, (start, end), y, args=(moving,), method="DOP853", rtol=1e-11, atol=1e-14, events=event
        )

    def lift_off(t, y, moving):
        return (y[2] - y[4]) * 1134.1e-6 - 1828.0 * 9e-3

    def one_percent(t, y, moving):
        return y[0] - 0.99 * 9e-3

    def contact(t, y, moving):
        return y[0]

    rest = [9e-3, 0.0, 1.101325e6, 287.0, 101325.0, 287.0]
    parts = [march_on(0.0, 1.5e-3, rest, False)]
    parts.append(march_on(1.5e-3, 3e-3, parts[-1].y[:, -1], False, lift_off))
    if not parts[-1].t_events[0].size:
        parts.append(march_on(3e-3, 20e-3, parts[-1].y[:, -1], False, lift_off))
    parts.append(march_on(parts[-1].t[-1], 20e-3, parts[-1].y[:, -1], True, one_percent))
    delay = parts[-1].t[-1]
    parts.append(march_on(delay, 20e-3, parts[-1].y[:, -1], True, contact))
    run = run_bench(DEFAULT, 20e-3, tolerance=1e-10)
    # Some 100 steps, each held to 1e-10 or better.
    assert run.opening.delay == pytest.approx(delay, rel=1e-7)
    assert run.opening.contact == pytest.approx(parts[-1].t[-1], rel=1e-7)
    assert run.opening.seating_speed == pytest.approx(-parts[-1].y[1, -1], rel=1e-7)
    at_rest = run.trace[np.searchsorted(run.times, 1.5e-3 - 1e-9)]
    assert at_rest[2:] == pytest.approx(parts[0].y[[2, 4, 3, 5], -1], rel=1e-9)


@pytest.mark.compiled
def test_the_measures_converge_with_the_tolerance():
    runs = {tolerance: run_bench(DEFAULT, 50e-3, tolerance=tolerance) for tolerance in (1e-5, 1e-7, 1e-11)}
    for stroke in ("opening", "closing"):
        coarse, default, fine = (np.array(getattr(run, stroke)[:3]) for run in runs.values())
        # A stroke takes some 100 steps, each held to its tolerance.
        assert np.abs(default / fine - 1.0).max() < 100 * 1e-7
        assert np.abs(default / fine - 1.0).max() < np.abs(coarse / fine - 1.0).max()


# --- closure ---


@pytest.mark.parametrize("period", [np.inf, 0.1])
@pytest.mark.parametrize("model", [0, 1])
def test_mass_energy_and_work_close(period, model):
    run = run_bench(BenchMachine.with_(air={"model": model}), 50e-3, period=period)
    assert run.status == Status.DONE
    assert run.closure["mass"] <= 1e-9
    assert run.closure["energy"] <= 1e-9
    assert run.closure["work"] <= 1e-6


def test_control_air_of_a_cycle_fills_each_chamber_once():
    run = run_bench(DEFAULT, 50e-3, period=0.1)
    # A chamber's swept volume and clearance from ambient to supply pressure, colder than supply or not: within a half.
    filled = 2.0 * (11382e-9 + 1134.1e-6 * 9e-3) * (1.101325e6 - 101325.0) / (287.05 * 287.0)
    assert 0.5 * filled < run.control_air < 1.5 * filled


# --- symmetry ---


def test_in_periodic_full_strokes_opening_and_closing_coincide():
    run = run_bench(DEFAULT, 50e-3, period=100e-3)
    assert run.orbit.converged
    assert run.orbit.period == 1
    for measure in ("delay", "stroke_time", "seating_speed"):
        assert getattr(run.opening, measure) == pytest.approx(getattr(run.closing, measure), rel=1e-6)


def test_after_a_rest_opening_and_closing_differ_through_the_chambers_initial_states():
    run = run_bench(DEFAULT, 50e-3)
    for measure in ("delay", "stroke_time", "seating_speed"):
        assert 0.01 < abs(getattr(run.opening, measure) / getattr(run.closing, measure) - 1.0) < 0.07


# --- parameters that must, or must not, matter ---


def test_a_table_of_the_default_ramp_is_the_default_ramp():
    table = np.array([[1.5e-3, 0.0], [3.0e-3, 1.0]])
    by_table = run_bench(BenchMachine()._replace(valve=Valve(solenoid=Solenoid(opening_curve=table))), 50e-3)
    assert np.array_equal(numbers(by_table), numbers(run_bench(DEFAULT, 50e-3)))


def test_a_table_overrides_dead_time_and_ramp():
    table = np.array([[0.5e-3, 0.0], [3.0e-3, 1.0]])
    runs = [
        run_bench(BenchMachine()._replace(valve=Valve(solenoid=Solenoid(dead_time=dead, opening_curve=table))), 50e-3)
        for dead in (1.5e-3, 9e-3)
    ]
    assert np.array_equal(numbers(runs[0]), numbers(runs[1]))
    assert runs[0].opening.delay < run_bench(DEFAULT, 50e-3).opening.delay


def test_the_groove_does_not_act_on_the_bench():
    # Its corners end steps, so that the runs differ by the error of the steps, and by nothing else.
    curve = np.array([[0.0, 0.0], [3.1e-3, 40e-6], [5e-3, 300e-6]])
    for measure in ("opening", "closing"):
        plain = getattr(run_bench(DEFAULT, 50e-3, tolerance=1e-10), measure)
        other = getattr(run_bench(BenchMachine.with_(groove={"area_curve": curve}), 50e-3, tolerance=1e-10), measure)
        assert other[:3] == pytest.approx(plain[:3], rel=1e-7)
        assert getattr(run_bench(BenchMachine.with_(groove={"effective_area": 1e-3}), 50e-3), measure) == getattr(
            run_bench(DEFAULT, 50e-3), measure
        )


def test_pressure_and_piston_mass_act_in_the_right_direction():
    default = run_bench(DEFAULT, 50e-3).opening
    assert run_bench(BenchMachine.with_(supply={"pressure": 0.6e6}), 50e-3).opening.stroke_time > default.stroke_time
    assert run_bench(BenchMachine.with_(valve={"moving_mass": 0.3}), 50e-3).opening.delay > default.delay
    assert run_bench(BenchMachine.with_(supply={"temperature": 322.0}), 50e-3).opening.delay < default.delay


# --- incomplete strokes ---


def test_a_pulse_too_short_for_a_full_stroke_has_no_contact():
    run = run_bench(DEFAULT, 5.5e-3, until=60e-3)
    assert 0.01 * 9e-3 < run.trace[:, LIFT].max() < 9e-3
    assert np.isfinite(run.opening.delay)
    assert np.isnan([run.opening.stroke_time, run.opening.seating_speed, run.opening.contact]).all()
    assert np.isnan([run.closing.delay, run.closing.stroke_time]).all()
    assert run.closing.contact > 5.5e-3
    assert run.trace[-1, LIFT] == 0.0


def test_a_pulse_shorter_than_the_ramp_moves_air_but_not_the_piston():
    pulse = 0.6e-3
    run = run_bench(DEFAULT, pulse, until=30e-3, sample=1e-5)
    assert run.trace[:, LIFT].max() == 0.0
    assert np.isnan(run.opening[:4]).all()
    dead, over = run.times < 1.5e-3, run.times > pulse + 3.0e-3
    assert run.trace[dead, PRESSURE_B] == pytest.approx(101325.0)
    assert run.trace[:, PRESSURE_B].max() > 1.5 * 101325.0
    assert run.trace[over, PRESSURE_B].argmax() == 0
    assert run.trace[-1, PRESSURE_A] == pytest.approx(DEFAULT.supply.pressure, rel=1e-6)
    assert run.closure["mass"] <= 1e-9


# --- brakes ---


def test_brakes_change_nothing_before_they_act_and_delay_contact():
    plain, braked = (run_bench(DEFAULT, 50e-3, brakes=brakes) for brakes in ((), (9e-3, 10e-3)))
    early = plain.times <= 9e-3 + 1.5e-3
    assert braked.trace[early] == pytest.approx(plain.trace[early], rel=1e-6)
    assert braked.opening.contact > plain.opening.contact
    assert braked.opening.seating_speed < plain.opening.seating_speed
    assert braked.closing.contact > 50e-3


def test_a_brake_of_one_solenoid_fills_or_empties_its_chamber_alone():
    # Braked in flight: A sees supply again and fills, B is vented and empties; the other keeps its own way.
    plain = run_bench(DEFAULT, 50e-3)
    of_a = run_bench(DEFAULT, 50e-3, brakes=(9e-3, 14e-3), brakes_b=())
    of_b = run_bench(DEFAULT, 50e-3, brakes_b=(9e-3, 14e-3))
    now = plain.times.searchsorted(11.5e-3)
    a, b = 2, 3
    assert of_a.trace[now, a] > plain.trace[now, a] + 2e4 and of_b.trace[now, b] < plain.trace[now, b] - 2e4
    both = run_bench(DEFAULT, 50e-3, brakes=(9e-3, 14e-3))
    own = run_bench(DEFAULT, 50e-3, brakes=(9e-3, 14e-3), brakes_b=(9e-3, 14e-3))
    np.testing.assert_array_equal(own.trace, both.trace)
    for run in (of_a, of_b):
        assert max(run.closure.values()) < 1e-7


def test_the_log_tells_each_contact():
    run = run_bench(DEFAULT, 50e-3)
    for event, stroke in ((MET_OPEN, run.opening), (MET_CLOSED, run.closing)):
        [row] = run.log[run.log[:, 1] == event]
        assert (row[0], abs(row[4])) == (stroke.contact, stroke.seating_speed)


# --- the trace ---


def test_the_trace_ends_at_the_end_and_its_velocity_is_the_slope_of_the_lift():
    run = run_bench(DEFAULT, 20e-3, until=20e-3, sample=1e-5)
    assert run.times[-1] == 20e-3
    flight = (run.times > 6e-3) & (run.times < 11e-3)
    lift, velocity = run.trace[flight, LIFT], run.trace[flight, VELOCITY]
    # Central differences over 2e-5 s: off by h^2/6 times the third derivative, below 1e7 m/s^3.
    assert np.gradient(lift, 1e-5)[1:-1] == pytest.approx(velocity[1:-1], abs=1e-10 / 6.0 * 1e7)
    held = run.times > run.opening.contact
    assert (run.trace[held, LIFT] == 9e-3).all()
    assert (run.trace[held, VELOCITY] == 0.0).all() and not np.signbit(run.trace[held, VELOCITY]).any()


def test_the_kernels_view_holds_the_state_at_rest():
    p, tables = bench_of(DEFAULT, [0.0, 1e-3])
    y = closed_at_rest(p.actuator, p.supply.control)
    assert len(y) == STATES
    assert tables.breakpoints(0.0, 10e-3) == pytest.approx([1e-3, 1.5e-3, 2.5e-3, 3e-3, 4e-3, 10e-3])
    assert actuator_of(DEFAULT, [0.0, 1e-3], np.inf)[0].effects == NoEffects()
