"""Supply line and intake pipe: their balances, their limits, and their equations marched by somebody else."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from apesim.engine.cycle.cylinder_laws import FLOW
from apesim.engine.cycle.operating_point import accuracy_at, charged_at_rest, cycle_of
from apesim.engine.cycle.rates import cycle_rates
from apesim.engine.cycle.state import (
    CYLINDER,
    LINE,
    PIPE,
    PIPE_FEED,
    RECEIVER,
    STATES,
    control_ledger,
    engine_ledger,
)
from apesim.engine.effects.intake_pipe_loss import IntakePipeLoss
from apesim.engine.indicators import indicators
from apesim.engine.machine import Machine
from apesim.march.periodic import distance, periodic_orbit
from apesim.quantities import InputError
from apesim.quantities.settings import load
from apesim.valve import bench
from apesim.valve.bench import TRACE, accuracy_of, bench_of, run_bench
from apesim.valve.effects import ValveEffects
from apesim.valve.effects.supply_droop import SupplyDroop
from apesim.valve.line import LINE_FLOW
from tests.machines import RPM, machine, settled
from tests.valve.test_bench import BenchMachine, naive_flow

PULSE = 30e-3
PRESSURE_A, PRESSURE_B = (TRACE.index(f"pressure_{chamber} [Pa abs]") for chamber in "ab")


def with_line(feed_area, volume=0.1e-3):
    return BenchMachine()._replace(effects=ValveEffects(supply_droop=SupplyDroop(feed_area, volume)))


def breathing_through(line=(0.0, 0.1e-3), pipe=(0.0, 0.1e-3), **options):
    """A machine with a supply line and an intake pipe: feed area [m2] and volume [m3] of each."""
    a_machine = machine(**options)
    effects = a_machine.effects._replace(supply_droop=SupplyDroop(*line), intake_pipe_loss=IntakePipeLoss(*pipe))
    return a_machine._replace(effects=effects)


# --- limits ---


def measures(run):
    return np.array([*run.opening[:3], *run.closing[:3], run.control_air])


def test_a_line_that_is_fed_through_a_huge_area_is_none():
    """The feed's drop is mdot sqrt(R T)/(44.7 S) next to equal pressures: 24 g/s through 1000 cm2 lose 0.15 Pa/bar."""
    plain, run = (run_bench(with_line(area, 1e-3), PULSE) for area in (0.0, 0.1))
    assert measures(run) == pytest.approx(measures(plain), rel=1e-5)


def test_a_line_of_huge_volume_is_none_however_it_is_fed():
    plain, run = (run_bench(with_line(area, 1e3), PULSE, tolerance=1e-9) for area in (0.0, 2e-6))
    assert measures(run) == pytest.approx(measures(plain), rel=1e-6)


def test_the_narrower_the_feed_the_later_the_valve_and_the_slower_the_chamber():
    runs = [run_bench(with_line(area), PULSE) for area in (0.0, 50e-6, 10e-6, 2e-6)]
    delays = [run.opening.delay for run in runs]
    pressures = [run.trace[np.searchsorted(run.times, 6e-3), PRESSURE_B] for run in runs]
    assert delays == sorted(delays)
    assert pressures == sorted(pressures, reverse=True)
    assert len(set(delays)) == len(set(pressures)) == 4


def test_a_pipe_of_huge_area_is_its_volume_added_to_the_receiver():
    """What is left is the drop over the area, 17 Pa/bar at 0.3 kg/s through 100 cm2: half as much as through 50."""
    more = 0.5e-3
    larger = engine_ledger(settled(breathing_through(receiver=1.0 + more * 1e3), 1000.0).end).groove.mass
    plain = engine_ledger(settled(breathing_through(receiver=1.0), 1000.0).end).groove.mass
    gaps = [
        engine_ledger(run.end).groove.mass / larger - 1.0
        for run in (settled(breathing_through(pipe=(area, more), receiver=1.0), 1000.0) for area in (0.005, 0.01))
    ]
    assert gaps[0] / gaps[1] == pytest.approx(2.0, rel=0.05)
    assert abs(gaps[1]) < 2e-4 < 0.1 * abs(plain / larger - 1.0)


def test_a_pipe_takes_air_and_torque():
    found = []
    for area in (0.0, 500e-6, 100e-6, 30e-6):
        a_machine = breathing_through(pipe=(area, 0.1e-3), receiver=1.0)
        found.append(indicators(a_machine, settled(a_machine, 1000.0)))
    for name in ("indicated_torque_Nm", "engine_air_kg_per_cycle"):
        values = [one[name] for one in found]
        assert values == sorted(values, reverse=True), name
        assert len(set(values)) == 4


# --- balances ---


@pytest.mark.parametrize("period", [np.inf, 0.1])
@pytest.mark.parametrize("line", [(2e-6, 0.1e-3), (10e-6, 1e-3), (50e-6, 0.02e-3)])
def test_a_bench_with_a_line_closes(line, period):
    run = run_bench(with_line(*line), 50e-3, period=period)
    assert run.status == 0
    assert run.closure["mass"] < 1e-13
    assert run.closure["energy"] < 1e-13
    assert run.closure["work"] < 1e-6


@pytest.mark.parametrize("control_air", ["regulator", "receiver"])
@pytest.mark.parametrize("receiver", [1.0, np.inf])
@pytest.mark.parametrize(("line", "pipe"), [(5e-6, 0.0), (0.0, 50e-6), (5e-6, 100e-6)])
def test_an_engine_with_line_and_pipe_closes_and_gives_on_what_it_is_fed(line, pipe, receiver, control_air):
    a_machine = breathing_through((line, 0.1e-3), (pipe, 0.1e-3), receiver=receiver, control_air=control_air)
    run = settled(a_machine, 800.0)
    found = indicators(a_machine, run)
    assert found["mass_closure"] < 1e-13
    assert found["energy_closure"] < 1e-13
    assert control_ledger(run.end).line_fed.mass == pytest.approx(control_ledger(run.end).supplied.mass, rel=1e-5)
    given_on = engine_ledger(run.end).groove.mass if pipe else 0.0
    assert engine_ledger(run.end).pipe.mass == pytest.approx(given_on, rel=1e-5)
    for states, area in (((LINE, LINE + 1), line), ((PIPE, PIPE + 1), pipe)):
        moved = np.ptp([run.start[i] for i in states]) if area else 0.0
        assert (moved > 0.0) == (area > 0.0)


def rates_at(a_machine, receiver, line, pipe):
    """Rates with the valve under way, both solenoids half open; pressure [Pa] and temperature [K] of each volume."""
    p, tables, _ = cycle_of(a_machine, 1000.0 * RPM)
    y, mode = charged_at_rest(p)
    gas = p.actuator.gas
    for mass, (pressure, temperature), volume in (
        (RECEIVER, receiver, p.receiver_volume),
        (LINE, line, p.actuator.line.volume),
        (PIPE, pipe, p.pipe.volume),
    ):
        y[mass] = pressure * volume / (gas.gas_constant * temperature)
        y[mass + 1] = pressure * volume / (gas.heat_capacity_ratio - 1.0)
    bench.start_segment(p, tables, 2e-3, 2.5e-3, y, mode)
    dy = np.full_like(y, np.nan)
    assert cycle_rates(p, 2.2e-3, y, mode, dy)
    return dy


@pytest.mark.parametrize("pipe", [(0.6e6, 250.0), (1.05e6, 280.0), (0.9995e6, 270.0)])
@pytest.mark.parametrize("control_air", ["regulator", "receiver"])
def test_line_and_pipe_are_fed_from_what_is_before_them(pipe, control_air):
    """From the receiver or the regulator to the line, from the receiver to the pipe, or back, and that from nothing."""
    a_machine = breathing_through((8e-6, 0.2e-3), (70e-6, 0.3e-3), receiver=1.0, control_air=control_air)
    receiver, line = (1.0e6, 260.0), (0.8e6, 240.0)
    dy = rates_at(a_machine, receiver, line, pipe)
    source = receiver if control_air == "receiver" else (1.101325e6, 287.0)
    into_line, into_pipe = naive_flow(8e-6, *line, *source), naive_flow(70e-6, *pipe, *receiver)
    control, flows = control_ledger(dy), engine_ledger(dy)
    assert control.line_fed == pytest.approx(into_line, rel=1e-10)
    assert flows.pipe == pytest.approx(into_pipe, rel=1e-10)
    assert dy[LINE] == control.line_fed.mass - control.supplied.mass != control.line_fed.mass
    assert dy[PIPE] == flows.pipe.mass - flows.groove.mass
    drawn = into_pipe[0] + (into_line[0] if control_air == "receiver" else 0.0)
    assert dy[RECEIVER] == pytest.approx(flows.feed.mass - drawn, rel=1e-10)
    assert np.isfinite(dy).all()


# --- the equations, marched by somebody else ---

VOLUME, FEED = 0.05e-3, 8e-6


def naive_rates(t, y, moving):
    """Eqs. 1-8 at the defaults with a line before the solenoids, pulse on since t = 0; pressures and temperatures."""
    position, speed, p_a, t_a, p_b, t_b, p_l, t_l = y
    x = min(1.0, max(0.0, (t - 1.5e-3) / 1.5e-3))
    force = (p_a - p_b) * 1134.1e-6 + 1828.0 * (9e-3 - 2.0 * position) - 111.08 * speed
    dy = [speed, force / 0.1145 if moving else 0.0]
    drawn = np.zeros(2)

    def gas(p, t_gas, volume, swell, mass_in, heat_in):
        dp = 0.4 / volume * heat_in - 1.4 * p / volume * swell
        return [dp, t_gas * (dp / p + swell / volume - mass_in / (p * volume / (287.05 * t_gas)))]

    for p, t_gas, depth, swell, supply in (
        (p_a, t_a, position, 1134.1e-6 * speed, 9e-6 * (1.0 - x)),
        (p_b, t_b, 9e-3 - position, -1134.1e-6 * speed, 9e-6 * x),
    ):
        into = np.array(naive_flow(supply, p, t_gas, p_l, t_l))
        out = np.array(naive_flow(9e-6 - supply, p, t_gas, 101325.0, 293.15))
        dy += gas(p, t_gas, 11382e-9 + 1134.1e-6 * depth, swell, *(into + out))
        drawn += into
    return dy + gas(p_l, t_l, VOLUME, 0.0, *(np.array(naive_flow(FEED, p_l, t_l, 1.101325e6, 287.0)) - drawn))


def test_scipy_finds_the_same_flight_with_a_line():
    def lift_off(t, y, moving):
        return (y[2] - y[4]) * 1134.1e-6 - 1828.0 * 9e-3

    def contact(t, y, moving):
        return y[0]

    y, t, marks = np.array([9e-3, 0.0, 1.101325e6, 287.0, 101325.0, 287.0, 1.101325e6, 287.0]), 0.0, []
    for end, moving, event in ((1.5e-3, 0, None), (3e-3, 0, lift_off), (20e-3, 0, lift_off), (20e-3, 1, contact)):
        if event is lift_off and marks:
            continue
        if event:
            event.terminal = True
        found = solve_ivp(
            naive_rates, (t, end), y, "LSODA", args=(moving,), rtol=1e-11, atol=1e-13, max_step=1e-4, events=event
        )
        t, y = found.t[-1], found.y[:, -1]
        marks += list(found.t_events[0]) if event else []
    run = run_bench(with_line(FEED, VOLUME), 20e-3, tolerance=1e-10)
    assert run.opening.contact == pytest.approx(marks[-1], rel=1e-7)
    assert run.opening.seating_speed == pytest.approx(-y[1], rel=1e-6)
    p, _ = bench_of(with_line(FEED, VOLUME), [0.0, 20e-3])
    assert y[6] < 0.9 * p.supply.control.pressure


# --- steps ---


def test_the_measures_converge_with_the_tolerance_and_the_line_changes_over_at_an_event():
    default, fine = (run_bench(with_line(10e-6, 0.1e-3), PULSE, tolerance=tolerance) for tolerance in (1e-7, 1e-11))
    assert measures(default) == pytest.approx(measures(fine), rel=1e-6)
    assert (default.log[:, 1] == LINE_FLOW).sum() >= 2


def test_the_pipe_changes_over_at_an_event():
    run = settled(breathing_through(pipe=(100e-6, 0.1e-3), receiver=1.0), 1000.0)
    assert (run.log[:, 1] == FLOW + PIPE_FEED).sum() >= 2
    assert run.work_change < 1e-5


def test_volumes_are_states_only_where_there_are_any():
    assert len(accuracy_of(bench_of(BenchMachine(), [0.0, PULSE])[0]).scale) == 6
    assert len(accuracy_of(bench_of(with_line(10e-6), [0.0, PULSE])[0]).scale) == 8
    counts = {}
    for line in (0.0, 5e-6):
        for pipe in (0.0, 50e-6):
            p, _, _ = cycle_of(breathing_through((line, 0.1e-3), (pipe, 0.1e-3)), 100.0)
            counts[line > 0.0, pipe > 0.0] = len(accuracy_at(p).scale)
    assert counts == {(False, False): STATES, (True, False): STATES + 2, (False, True): 14, (True, True): 14}


def test_the_periodic_state_does_not_depend_on_how_full_line_and_pipe_start():
    a_machine = breathing_through((5e-6, 0.1e-3), (100e-6, 0.1e-3), receiver=1.0)
    p, tables, breakpoints = cycle_of(a_machine, 1000.0 * RPM)
    accuracy, orbits = accuracy_at(p), []
    for share in (1.0, 0.4):
        y, mode = charged_at_rest(p)
        y[[LINE, LINE + 1, PIPE, PIPE + 1, RECEIVER, RECEIVER + 1, CYLINDER]] *= share
        orbits.append(periodic_orbit(p, tables, y, mode, breakpoints, accuracy))
    assert all(orbit.converged for orbit in orbits)
    assert distance(orbits[0].y, orbits[1].y, accuracy.scale) < 1e-6


# --- ranges ---


@pytest.mark.parametrize(
    ("table", "right"),
    [
        ('supply_droop]\nfeed_area = "1 mm^2"', "2 to 50 mm^2"),
        ('intake_pipe_loss]\narea = "20 mm^2"', "30 to 500 mm^2"),
    ],
)
def test_a_feed_that_starves_is_refused(table, right, tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(f"[effects.{table}\n")
    with pytest.raises(InputError, match=right.replace("^", r"\^")):
        load(Machine, path)
