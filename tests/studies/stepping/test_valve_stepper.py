"""The valve in steps, beside runs that are never left and a filling that is computed by other means."""

from math import pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import apesim
from apesim import EngineCommands, InputError, NotConverged, Stepper
from apesim.march.adaptive import REMEDIES, Status
from apesim.valve.bench import run_bench, trace_bench

SAME_LIFT, SAME_WITH_EFFECTS = 1e-9, 6e-9
"""Lift that a stepped valve may differ by from one that is never left [m]; with dry friction and a leak the latter is
off by 2e-9 itself, and the former by 3e-9, from a march at a tolerance of 1e-12."""
CLOSED = 1e-12
"""Closure of mass and energy that a march holds."""
OTHER = {
    "valve.stroke": "6 mm",
    "ambient.pressure": "90 kPa abs",
    "ambient.temperature": "305 K",
    "supply.control_pressure": "0.6 MPa gauge",
    "valve.solenoid.release_dead_time": "0.2 ms",
    "valve.solenoid.release_ramp_time": "2.4 ms",
}
LINE = {"effects.supply_droop.volume": "20 cm^3", "effects.supply_droop.feed_area": "8 mm^2"}
EFFECTS = {"effects.coulomb_friction.force": "10 N", "effects.ring_leakage.area": "0.2 mm^2"}
MACHINES = {"default": {}, "other": OTHER, "other with a supply line": OTHER | LINE, "effects": EFFECTS}


def machine(**values):
    return apesim.Machine().with_(**values)


def lifts_of(stepper, times, commands):
    """Lifts of a valve at the ends of steps, commanded by a function of the time at which each begins."""
    lifts, before = [], stepper.time
    for time in times:
        stepper.advance(time, command=commands(before))
        lifts.append(stepper.state()["lift_m"])
        before = time
    return np.array(lifts)


def pulse_of(seconds):
    return lambda t: int(t < seconds)


def test_a_thousand_steps_are_the_run_that_is_never_left():
    stepper, run = Stepper(machine(), "valve"), apesim.run_valve(machine())
    lifts = lifts_of(stepper, 1e-4 * np.arange(1, 1001), pulse_of(50e-3 - 1e-9))
    assert np.abs(lifts - run.traces["lift"].values[1:]).max() < SAME_LIFT
    assert stepper.state()["control_air_kg"] == pytest.approx(run["control_air"], rel=1e-7)
    assert max(stepper.closure().values()) < CLOSED


@pytest.mark.parametrize("values", MACHINES.values(), ids=MACHINES)
def test_however_it_is_split_it_is_the_same_motion(values):
    own, pulse = machine(**values), 10.0371e-3
    for seed in range(6):
        rng = np.random.default_rng(seed)
        ends = np.sort(rng.uniform(0.0, 40e-3, int(10 ** rng.uniform(0.5, 3.0))))
        times = np.unique([*ends, pulse, 16e-3, 40e-3])
        stepper = Stepper(own, "valve")
        lifts = lifts_of(stepper, times, pulse_of(pulse))
        trace, _ = trace_bench(own, pulse, times)
        assert trace[:, 0].max() > 0.5 * own.valve.stroke
        assert np.abs(lifts - trace[:, 0]).max() < (SAME_WITH_EFFECTS if values is EFFECTS else SAME_LIFT)
        assert max(stepper.closure().values()) < CLOSED


def test_edges_that_come_while_it_is_marched_are_those_of_a_run_that_knows_them():
    brakes = (8.72e-3, 9.46e-3, 22e-3, 24.5e-3)
    run = run_bench(machine(), 12e-3, 50e-3, brakes=brakes, sample=1e-4)
    edges = np.sort([0.0, 12e-3, *brakes])
    times = np.unique([*run.times[1:], *edges[1:]])
    lifts = lifts_of(Stepper(machine(), "valve"), times, lambda t: int(np.searchsorted(edges, t, "right") % 2))
    of_run = np.isin(times, run.times)
    assert np.abs(lifts[of_run] - run.trace[1:, 0]).max() < SAME_LIFT


def test_it_goes_on_for_longer_than_edges_are_remembered():
    period, count = 30e-3, 60
    stepper = Stepper(machine(), "valve")
    lifts = lifts_of(stepper, 0.5e-3 * np.arange(1, 60 * count + 1), lambda t: int((t + 1e-9) % period < 12e-3))
    periods = lifts.reshape(count, -1)
    assert np.abs(periods[-1] - periods[-2]).max() < 1e-7
    assert periods[-1].max() == pytest.approx(9e-3, rel=1e-6)


def psi(r, k=1.4):
    """Flow function, Eq. 8 of the EPV paper (doi 10.1631/jzus.A0820373)."""
    critical = (2.0 / (k + 1.0)) ** (k / (k - 1.0))
    r = max(r, critical)
    return np.sqrt(2.0 * k / (k - 1.0) * (r ** (2.0 / k) - r ** ((k + 1.0) / k)))


@pytest.mark.parametrize(("pressure", "temperature"), [(1.6e6, 287.0), (2.4e6, 330.0)])
def test_a_step_of_the_supply_fills_chamber_a_as_a_volume_is_filled_through_an_orifice(pressure, temperature):
    own = machine()
    valve, gas, cv = own.valve, 287.05, 287.05 / 0.4
    volume = valve.clearance_volume + valve.piston_area * valve.stroke

    def filling(t, y):
        mass, kelvin = y[0], y[1] / y[0] / cv
        flow = valve.solenoid.effective_area * psi(mass * gas * kelvin / volume / pressure)
        flow *= pressure / np.sqrt(gas * temperature)
        return [flow, flow * 1.4 * cv * temperature]

    before = own.supply.pressure
    start = [before * volume / gas / own.supply.temperature, before * volume * cv / gas]
    stepper = Stepper(own, "valve")
    stepper.advance(3.3e-3)
    ends = np.array([0.2e-3, 0.3e-3, 0.5e-3])
    true = solve_ivp(filling, (0.0, ends[-1]), start, "LSODA", ends, rtol=1e-10, atol=1e-14).y
    for end, (_, energy) in zip(ends, true.T, strict=True):
        stepper.advance(3.3e-3 + end, supply=pressure, temperature=temperature)
        assert stepper.state()["pressure_a_Pa"] == pytest.approx(0.4 * energy / volume, rel=1e-6)
    assert before < stepper.state()["pressure_a_Pa"] < pressure


def test_a_supply_from_the_start_is_that_of_a_machine_with_it():
    times = 1e-4 * np.arange(1, 200)
    other = Stepper(machine(supply_pressure="0.7 MPa abs"), "valve")
    expected = lifts_of(other, times, pulse_of(10e-3))
    stepper = Stepper(machine(), "valve")
    stepper.advance(0.3, supply=0.7e6)
    found = lifts_of(stepper, 0.3 + times, lambda t: int(t - 0.3 < 10e-3 - 1e-9))
    # Chamber A was emptied to the lower pressure from the higher one, and is colder.
    assert np.abs(found - expected).max() < 0.2 * 9e-3
    assert stepper.state()["pressure_a_Pa"] < 0.75e6


@pytest.mark.parametrize("values", [MACHINES["default"], MACHINES["other with a supply line"]])
def test_what_is_restored_goes_on_to_the_same_bits(values):
    stepper = Stepper(own := machine(**values), "valve")
    times = np.sort(np.random.default_rng(1).uniform(0.0, 40e-3, 300))
    lifts_of(stepper, times[:70], pulse_of(9e-3))
    kept, ends = stepper.snapshot(), []
    for each in (stepper, Stepper(stepper.machine, "valve"), stepper):
        if each is not stepper:
            stepper.advance(1.0, command=1, supply=0.4e6)
            each = Stepper(own, "valve")
        each.restore(kept)
        state = each.state()
        for time in times[70:]:
            each.advance(time, command=int(time < 12e-3), supply=0.9e6 if time > 20e-3 else None)
        ends.append((state, each.state(), each.closure()))
    assert ends[0] == ends[1] == ends[2]


@pytest.mark.parametrize(
    ("t", "inputs", "told"),
    [
        (0.01, {}, r"t: 0.01; give a time above 0.01 s"),
        (np.nan, {}, r"t: nan; give a time"),
        (np.inf, {}, r"t: inf; give a time"),
        ("0.02", {}, r"t: '0.02'; give a time|t: 0.02; give a time"),
        (None, {}, r"t: None; give a time"),
        (0.02, {"command": 0.5}, r"command: 0.5; give 1 to energise"),
        (0.02, {"command": "1"}, r"command: .?1.?; give 1 to energise"),
        (0.02, {"command": EngineCommands()}, r"command: .*give 1 to energise"),
        (0.02, {"supply": 0.0}, r"supply: 0.0; give an absolute pressure from 20000 to 3e\+07 Pa"),
        (0.02, {"supply": -1e5}, r"supply: -100000.0; give an absolute pressure"),
        (0.02, {"supply": "1 MPa abs"}, r"supply: .*give an absolute pressure"),
        (0.02, {"temperature": np.nan}, r"temperature: nan; give a temperature from 150 to 600 K"),
        (0.02, {"speed": 10.0}, r"speed: is given, and a valve on its bench has no shaft; leave it out"),
        (0.02, {"load": 10.0}, r"load: is given, and a valve on its bench has no shaft; leave it out"),
    ],
)
def test_a_wrong_step_is_refused_and_changes_nothing(t, inputs, told):
    stepper = Stepper(machine(), "valve")
    stepper.advance(0.01, command=1)
    state = stepper.state()
    with pytest.raises(InputError, match=rf"Stepper.advance\(\): {told}"):
        stepper.advance(t, **inputs)
    assert stepper.state() == state


@pytest.mark.parametrize(
    ("what", "options", "told"),
    [
        ("pump", {}, r"Stepper\(\): what: is .?pump.?; write \"valve\" or \"engine\""),
        (7, {}, r"Stepper\(\): what: 7 is of the type int; write a text"),
        ("valve", {"speed": "600 rpm"}, r"Stepper\(\): speed: is given, and a valve on its bench has no shaft"),
    ],
)
def test_a_wrong_stepper_is_refused(what, options, told):
    with pytest.raises(InputError, match=told):
        Stepper(machine(), what, **options)


def test_a_snapshot_of_something_else_is_refused():
    one, other = (Stepper(machine(), "valve") for _ in range(2))
    with pytest.raises(InputError, match="snapshot: is of something else; give what snapshot"):
        one.restore(other.snapshot())
    with pytest.raises(InputError, match="snapshot: is of something else"):
        one.restore(None)


def test_a_march_that_fails_tells_its_remedy_and_where_it_ended():
    stepper = Stepper(machine(), "valve")
    with pytest.raises(NotConverged) as error:
        stepper.advance(1e5)
    assert REMEDIES[Status.TOO_MANY_EVALUATIONS] in str(error.value)
    assert f"the march ended at {stepper.time:.9g} s" in str(error.value)
    assert 1.0 < stepper.time < 1e5
    assert stepper.state()["time_s"] == stepper.time
    stepper.advance(stepper.time + 8e-3, command=1)
    assert stepper.state()["lift_m"] == pytest.approx(2.05e-3, abs=3e-3)


def test_the_speed_of_the_lift_is_its_slope():
    stepper = Stepper(machine(), "valve")
    stepper.advance(8e-3, command=1)
    before = stepper.state()
    stepper.advance(8e-3 + 1e-7)
    slope = (stepper.state()["lift_m"] - before["lift_m"]) / 1e-7
    assert slope == pytest.approx(before["velocity_m_s"], rel=1e-3)
    assert before["velocity_m_s"] > 0.1 / pi
