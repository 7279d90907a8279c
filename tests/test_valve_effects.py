from itertools import pairwise

import numpy as np
import pytest
from test_bench import LIFT, PRESSURE_A, PRESSURE_B, VELOCITY, BenchMachine, numbers
from test_motion import marched

from apesim.march import LOG_HEAD, Status
from apesim.restriction import flow_between
from valve.actuator import MODES, PHASE, X_B, X_B_SLOPE, actuator_rates, closed_at_rest, state_of
from valve.bench import bench_of, run_bench
from valve.effects import VALVE_EFFECTS, ValveEffects
from valve.effects.bounce import Bounce
from valve.effects.coulomb_friction import CoulombFriction
from valve.effects.ring_leakage import RingLeakage
from valve.effects.solenoid_b_delay import SolenoidBDelay
from valve.motion import LEFT, MET_CLOSED, MET_OPEN, actuator_enters
from valve.piston import HELD_CLOSED, HELD_OPEN, TO_CLOSED, TO_OPEN
from valve.solenoid import Solenoid, energised_fraction

ON = {
    "solenoid_b_delay": SolenoidBDelay(0.4e-3),
    "ring_leakage": RingLeakage(0.2e-6),
    "coulomb_friction": CoulombFriction(4.0, 6.0),
    "bounce": Bounce(0.4),
}
BREAKAWAY_ALONE = CoulombFriction(0.0, 6.0)
PULSE = 30e-3


def machine_with(**effects):
    return BenchMachine()._replace(effects=ValveEffects(**effects))


def run_with(**effects):
    return run_bench(machine_with(**effects), PULSE)


# --- strength zero ---


def test_every_effect_of_the_list_is_tested_here():
    assert ON.keys() == {effect.name for effect in VALVE_EFFECTS}


@pytest.mark.parametrize("name", ON)
def test_an_effect_that_is_on_changes_the_run(name):
    assert not np.array_equal(numbers(run_with(**{name: ON[name]})), numbers(run_with()))


def test_effects_at_strength_zero_that_are_looked_at_change_no_bit():
    # A restitution too small for any rebound has all laws compiled in, and does nothing itself.
    assert type(bench_of(machine_with(bounce=Bounce(1e-9)), [0.0, PULSE])[0].actuator.effects) is ValveEffects
    assert np.array_equal(numbers(run_with(bounce=Bounce(1e-9))), numbers(run_with()))


@pytest.mark.parametrize("other", ON)
@pytest.mark.parametrize(
    ("name", "off"),
    [
        ("solenoid_b_delay", SolenoidBDelay(-0.0)),
        ("ring_leakage", RingLeakage(-0.0)),
        ("coulomb_friction", CoulombFriction(-0.0, 0.0)),
        ("bounce", Bounce(-0.0)),
    ],
)
def test_strength_zero_changes_no_bit_with_another_effect_on(name, off, other):
    if name != other:
        assert np.array_equal(
            numbers(run_with(**{other: ON[other], name: off})), numbers(run_with(**{other: ON[other]}))
        )


def test_a_breakaway_force_alone_acts_whether_or_not_another_effect_is_on():
    def share_of(**effects):
        """What the breakaway force adds to the delay."""
        return run_with(coulomb_friction=BREAKAWAY_ALONE, **effects).opening.delay / run_with(**effects).opening.delay

    assert (share_of() > 1.0) == (share_of(bounce=ON["bounce"]) > 1.0)


# --- Coulomb friction ---


def test_friction_delays_the_start_and_slows_the_flight():
    strokes = [run_with(coulomb_friction=CoulombFriction(force)).opening for force in (0.0, 2.0, 4.0)]
    delays, contacts, speeds = ([getattr(s, name) for s in strokes] for name in ("delay", "contact", "seating_speed"))
    assert delays == sorted(delays)
    assert contacts == sorted(contacts)
    assert speeds == sorted(speeds, reverse=True)
    assert len(set(delays)) == 3


def force_at_start(effects):
    """Force to open at the instant at which the piston leaves its stop [N]."""
    log, *_ = marched(machine_with(**effects), PULSE, 8e-3, tolerance=1e-10)
    (row,) = log[log[:, 1] == LEFT]
    p, _ = bench_of(machine_with(**effects), [0.0, PULSE])
    state = state_of(p.actuator, row[LOG_HEAD:], p.supply)
    return (state.pressure_b - state.pressure_a) * 1134.1e-6 + 1828.0 * 9e-3


@pytest.mark.parametrize(("force", "breakaway", "holds"), [(3.0, 0.0, 3.0), (3.0, 2.0, 3.0), (3.0, 8.0, 8.0)])
def test_the_piston_starts_where_the_force_exceeds_the_larger_of_friction_and_breakaway(force, breakaway, holds):
    # The force rises by 1e5 N/s or so, its time is located to 1e-12 s; pressures of 1e6 Pa are held to 1e-10.
    assert force_at_start({"coulomb_friction": CoulombFriction(force, breakaway)}) == pytest.approx(holds, abs=1e-5)
    assert force_at_start({}) == pytest.approx(0.0, abs=1e-5)


def rates_at(phase, machine, position=4e-3):
    p, tables = bench_of(machine, [0.0, PULSE])
    y = np.append(closed_at_rest(p.actuator, p.supply), np.zeros(7))
    y[0], y[1] = position, 1.2 * np.sign(phase)
    mode = np.zeros(MODES)
    mode[PHASE] = phase
    actuator_enters(p.actuator, tables, 0.0, 1e-6, y, mode, p.supply)
    return p, y, actuator_rates(p.actuator, 0.0, y, mode, p.supply)


@pytest.mark.parametrize(("phase", "sign"), [(TO_CLOSED, -1.0), (TO_OPEN, 1.0), (HELD_OPEN, 0.0), (HELD_CLOSED, 0.0)])
def test_friction_decelerates_by_force_over_mass(phase, sign):
    _, _, with_it = rates_at(phase, machine_with(coulomb_friction=CoulombFriction(3.0, 9.0)))
    _, _, without = rates_at(phase, machine_with())
    # Accelerations of some 1e4 m/s2, rounded at 1e-16 of them.
    assert with_it.speed - without.speed == pytest.approx(sign * 3.0 / 0.1145, abs=1e-10)
    assert with_it._replace(speed=0.0) == without._replace(speed=0.0)


# --- leakage past the rings ---


def test_leakage_takes_from_a_what_it_gives_to_b():
    p, y, with_it = rates_at(HELD_CLOSED, machine_with(ring_leakage=RingLeakage(0.2e-6)))
    _, _, without = rates_at(HELD_CLOSED, machine_with())
    s = state_of(p.actuator, y, p.supply)
    mass, energy = flow_between(s.gas, 0.2e-6, s.pressure_a, s.temperature_a, s.pressure_b, s.temperature_b)
    assert mass > 0.0
    assert with_it.mass_b - without.mass_b == pytest.approx(mass, rel=1e-9)
    assert with_it.mass_a - without.mass_a == pytest.approx(-mass, rel=1e-9)
    assert with_it.energy_b - without.energy_b == pytest.approx(energy, rel=1e-9)
    assert with_it.energy_a - without.energy_a == pytest.approx(-energy, rel=1e-9)
    assert (with_it.other_mass, with_it.other_energy) == (0.0, 0.0)


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
    for t, t_end in pairwise(tables.kinks(0.0, 2.0 * PULSE)):
        mode = np.zeros(MODES)
        actuator_enters(p.actuator, tables, t, t_end, closed_at_rest(p.actuator, p.supply), mode, p.supply)
        middle = 0.5 * (t + t_end)
        expected = energised_fraction(tables.edges, tables.period, tables.curve_b, middle)
        assert mode[X_B] + mode[X_B_SLOPE] * (middle - t) == pytest.approx(expected, abs=1e-9)


def test_a_late_solenoid_b_delays_the_opening():
    delays = [run_with(solenoid_b_delay=SolenoidBDelay(time)).opening.delay for time in (-0.5e-3, 0.0, 0.5e-3)]
    assert delays[0] < delays[1] < delays[2]


# --- bounce ---


def contacts_of(restitution, stop, until=2.0 * PULSE):
    log, y, mode, _, status = marched(machine_with(bounce=Bounce(restitution)), PULSE, until)
    assert status == Status.DONE
    return log[log[:, 1] == stop], y, mode


@pytest.mark.parametrize("restitution", [0.2, 0.4, 0.6])
@pytest.mark.parametrize(
    ("stop", "sign", "until", "held"),
    [
        (MET_OPEN, -1.0, PULSE, HELD_OPEN),
        (MET_CLOSED, 1.0, 2.0 * PULSE, HELD_CLOSED),
    ],
)
def test_a_piston_bounces_with_falling_speeds_and_is_held_in_the_end(restitution, stop, sign, until, held):
    contacts, y, mode = contacts_of(restitution, stop, until)
    speeds = sign * contacts[:, LOG_HEAD + 1]
    assert len(speeds) >= 3
    assert (np.diff(np.abs(speeds)) < 0.0).all()
    # Each rebound keeps its share or less of the speed, and below 1e-3 m/s it ends.
    assert len(speeds) <= 2 + np.log(1e-3 / speeds[0]) / np.log(restitution)
    assert (mode[PHASE], y[1]) == (held, 0.0)


@pytest.mark.parametrize("restitution", [0.2, 0.6])
def test_every_contact_is_met_on_the_way_to_the_stop(restitution):
    contacts, *_ = contacts_of(restitution, MET_OPEN, PULSE)
    assert (contacts[:, LOG_HEAD + 1] < 0.0).all()


def test_the_first_rebound_has_its_share_of_the_seating_speed():
    sample = 1e-6
    run = run_bench(machine_with(bounce=Bounce(0.4)), PULSE, until=15e-3, sample=sample)
    after = np.searchsorted(run.times, run.opening.contact)
    # Within a sample the speed changes by at most 1.1e6 Pa * 1134 mm2 / 0.1145 kg times 1e-6 s.
    assert run.trace[after, VELOCITY] == pytest.approx(0.4 * run.opening.seating_speed, abs=0.011)
    assert run.opening.seating_speed == pytest.approx(run_with().opening.seating_speed, rel=1e-6)
    assert run.trace[:, LIFT].max() <= 9e-3 + 1e-12


def test_without_bounce_there_is_one_contact():
    contacts, y, mode = contacts_of(0.0, MET_OPEN, PULSE)
    assert len(contacts) == 1
    assert (y[0], y[1], mode[PHASE]) == (0.0, 0.0, HELD_OPEN)
