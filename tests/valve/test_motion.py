from itertools import pairwise

import numpy as np
import pytest

from apesim.air import internal_energy
from apesim.flow_function import NEARLY_EQUAL
from apesim.march.adaptive import BREAKPOINT, EVENTS, LOG_HEAD, LOG_ROWS, NO_CARRY, ZERO_CROSSING, Status, march
from apesim.restriction import ROOM
from apesim.valve.actuator import (
    AREA,
    AREA_SLOPE,
    MODES,
    PHASE,
    PIECE,
    PIECE_HIGH,
    PIECE_LOW,
    START,
    STATES,
    X_A,
    X_A_SLOPE,
    X_B,
    X_B_SLOPE,
    closed_at_rest,
    state_of,
)
from apesim.valve.bench import SIZE, accuracy_of, bench_ledger, bench_of, closed_at_start
from apesim.valve.motion import (
    CORNER,
    CREEP,
    FLOW,
    LEFT,
    MET_CLOSED,
    MET_OPEN,
    NEAR_OPEN,
    ONE_PERCENT,
    SPEED_EXTREMUM,
    TURNED,
    actuator_events,
    actuator_zero_crossings,
    handle_actuator_event,
    start_actuator_segment,
)
from apesim.valve.piston import HELD_CLOSED, HELD_OPEN, STUCK, TO_CLOSED, TO_OPEN
from apesim.valve.solenoid import energised_fraction
from apesim.valve.solenoid_flow import FLOWS, solenoid_sides
from tests.valve.test_bench import BenchMachine

GROOVE_ROWS = np.array([[0.0, 0.0], [3e-3, 40e-6], [5e-3, 300e-6]])


def marched(machine, pulse, until, tolerance=1e-9):
    """A run of the bench with its log: log, state and mode at the end, start, status."""
    p, tables = bench_of(machine, [0.0, pulse])
    y, mode = closed_at_start(p)
    start = y.copy()
    log = np.empty((LOG_ROWS, LOG_HEAD + STATES))
    accuracy = accuracy_of(p, tolerance)
    breakpoints = tables.breakpoints(0.0, until)
    outcome = march(p, tables, 0.0, y, mode, breakpoints, accuracy, log, np.empty(0), np.empty((0, 6)), NO_CARRY)
    return log[: outcome.logged], y, mode, start, outcome.status


def instant(position, speed, p_a, p_b, phase, machine=None):
    """Bench, tables, state and mode at an instant."""
    p, tables = bench_of(machine or BenchMachine.with_(groove={"area_curve": GROOVE_ROWS}), [0.0, 1.0])
    gas = p.actuator.gas
    y, mode = np.zeros(SIZE), np.zeros(MODES)
    y[:2] = position, speed
    for i, (p_gas, volume) in enumerate(
        ((p_a, 11382e-9 + 1134.1e-6 * position), (p_b, 21588.9e-9 - 1134.1e-6 * position))
    ):
        mass = p_gas * volume / (gas.gas_constant * 290.0)
        y[2 + 2 * i : 4 + 2 * i] = mass, mass * internal_energy(gas, 290.0)
    mode[PHASE] = phase
    start_actuator_segment(p.actuator, tables, 0.0, 1e-3, y, mode, p.supply)
    return p, tables, y, mode


def values(*state):
    p, _, y, mode = instant(*state)
    g = np.full(EVENTS, np.nan)
    actuator_events(p.actuator, y, mode, p.supply, g)
    return g[:FLOW]


# --- events ---


def test_a_moving_piston_looks_out_for_stops_turning_and_corners():
    g = values(4e-3, 1.5, 5e5, 5e5, TO_CLOSED)
    # Closed at 9 mm; rows of the groove at 3 and 5 mm of lift, and the lift is 5 mm: on the row.
    assert g == pytest.approx([-5e-3, -4e-3, -1.0, -1.5 - CREEP, 0.0], abs=1e-15)
    g = values(4.5e-3, -0.5, 5e5, 5e5, TO_OPEN)
    assert g == pytest.approx([-4.5e-3, -4.5e-3, -1.0, -0.5 - CREEP, -0.5e-3], abs=1e-15)


def test_events_rise_above_zero_beyond_the_stops_and_past_the_turn():
    assert values(9.1e-3, 1.0, 5e5, 5e5, TO_CLOSED)[MET_CLOSED] == pytest.approx(0.1e-3)
    assert values(-0.1e-3, -1.0, 5e5, 5e5, TO_OPEN)[MET_OPEN] == pytest.approx(0.1e-3)
    assert values(4e-3, -0.1, 5e5, 5e5, TO_CLOSED)[TURNED] == pytest.approx(0.1 - CREEP)
    assert values(4e-3, 0.1, 5e5, 5e5, TO_OPEN)[TURNED] == pytest.approx(0.1 - CREEP)
    assert values(4e-3, -0.5 * CREEP, 5e5, 5e5, TO_CLOSED)[TURNED] < 0.0, "it creeps"


def test_a_piston_at_rest_looks_out_for_a_force_away_from_its_stop():
    spring = 1828.0 * 9e-3
    push = 1e5 * 1134.1e-6
    assert values(9e-3, 0.0, 5e5, 5e5, HELD_CLOSED) == pytest.approx([-1.0, -1.0, spring, -1.0, -1.0])
    assert values(9e-3, 0.0, 6e5, 5e5, HELD_CLOSED)[LEFT] == pytest.approx(spring - push)
    assert values(0.0, 0.0, 5e5, 6e5, HELD_OPEN)[LEFT] == pytest.approx(spring - push)
    assert values(4.5e-3, 0.0, 5e5, 6e5, STUCK)[LEFT] == pytest.approx(push)


# --- responses ---


def after(event, *state):
    p, tables, y, mode = instant(*state)
    handle_actuator_event(p.actuator, tables, event, y, mode, p.supply)
    return y[0], y[1], mode[PHASE]


def test_a_piston_that_is_pushed_against_a_stop_stays_there():
    assert after(MET_CLOSED, 9.0001e-3, 1.5, 8e5, 5e5, TO_CLOSED) == (9e-3, 0.0, HELD_CLOSED)
    assert after(MET_OPEN, -1e-7, -1.5, 5e5, 8e5, TO_OPEN) == (0.0, 0.0, HELD_OPEN)


def test_a_piston_that_is_pushed_away_from_a_stop_leaves_it_at_once():
    assert after(MET_CLOSED, 9e-3, 1.5, 5e5, 8e5, TO_CLOSED) == (9e-3, 0.0, TO_OPEN)
    assert after(MET_OPEN, 0.0, -1.5, 8e5, 5e5, TO_OPEN) == (0.0, 0.0, TO_CLOSED)


def test_a_piston_that_turns_goes_on_the_other_way():
    assert after(TURNED, 4e-3, 1e-9, 8e5, 5e5, TO_OPEN) == (4e-3, 0.0, TO_CLOSED)
    assert after(TURNED, 4e-3, -1e-9, 5e5, 8e5, TO_CLOSED) == (4e-3, 0.0, TO_OPEN)


def with_friction(force, breakaway=0.0, **sections):
    machine = BenchMachine.with_(**sections)
    friction = machine.effects.coulomb_friction._replace(force=force, breakaway=breakaway)
    return machine._replace(effects=machine.effects._replace(coulomb_friction=friction))


@pytest.mark.parametrize(("breakaway", "phase"), [(0.0, TO_OPEN), (9.0, TO_OPEN), (12.0, STUCK)])
def test_a_piston_that_turns_sticks_where_the_breakaway_force_holds_it(breakaway, phase):
    # 1e4 Pa push with 11.3 N to open; the springs are at rest in the middle.
    state = (4.5e-3, -1e-9, 5e5, 5.1e5, TO_CLOSED, with_friction(5.0, breakaway))
    assert after(TURNED, *state) == (4.5e-3, 0.0, phase)


def test_a_piston_that_is_set_free_goes_where_the_force_points():
    assert after(LEFT, 9e-3, 0.0, 5e5, 8e5, HELD_CLOSED)[2] == TO_OPEN
    assert after(LEFT, 0.0, 0.0, 8e5, 5e5, HELD_OPEN)[2] == TO_CLOSED
    assert after(LEFT, 4e-3, 0.0, 8e5, 5e5, STUCK)[2] == TO_CLOSED
    assert after(LEFT, 4e-3, 0.0, 5e5, 8e5, STUCK)[2] == TO_OPEN


@pytest.mark.parametrize("phase", [TO_OPEN, TO_CLOSED])
@pytest.mark.parametrize(("lift", "piece"), [(5e-3, 3.0), (3e-3, 1.0), (5e-3 - 1e-9, 3.0), (3e-3 + 1e-9, 1.0)])
def test_at_a_corner_the_piston_takes_the_next_piece_also_where_it_creeps_against_its_phase(phase, lift, piece):
    p, tables, y, mode = instant(5e-3, float(phase), 5e5, 5e5, phase)
    assert mode[PIECE] == 2.0
    y[0] = p.actuator.valve.stroke - lift
    handle_actuator_event(p.actuator, tables, CORNER, y, mode, p.supply)
    assert mode[PIECE] == piece
    ends = GROOVE_ROWS[int(piece) - 1, 0], (GROOVE_ROWS[int(piece), 0] if piece < 3 else np.inf)
    assert (mode[PIECE_LOW], mode[PIECE_HIGH]) == ends
    middle = 1e-3 if piece == 1 else 8e-3
    assert mode[AREA] + mode[AREA_SLOPE] * middle == pytest.approx(np.interp(middle, *GROOVE_ROWS.T), abs=1e-16)


@pytest.mark.parametrize(("lift", "outer", "inner"), [(5.1e-3, 3.0, 2.0), (-1e-4, 0.0, 1.0)])
def test_from_an_outer_piece_the_only_way_is_back(lift, outer, inner):
    for phase in (TO_OPEN, TO_CLOSED):
        p, tables, y, mode = instant(9e-3 - lift, 0.0, 5e5, 5e5, phase)
        assert mode[PIECE] == outer
        handle_actuator_event(p.actuator, tables, CORNER, y, mode, p.supply)
        assert mode[PIECE] == inner


# --- entering a stretch, zero crossings ---


def test_on_entering_a_stretch_the_solenoids_lines_run_from_end_to_end():
    own_a, own_b = [0.0, 20e-3], [0.0, 9e-3, 13.2e-3, 20e-3]
    p, tables = bench_of(BenchMachine(), own_a, edges_b=own_b)
    breakpoints = np.append(0.0, tables.breakpoints(0.0, 30e-3))
    for t, t_end in pairwise(breakpoints):
        mode = np.zeros(MODES)
        start_actuator_segment(
            p.actuator, tables, t, t_end, closed_at_rest(p.actuator, p.supply.control), mode, p.supply
        )
        assert mode[START] == t
        for x, slope, edges, curves in (
            (X_A, X_A_SLOPE, own_a, tables.curves_a),
            (X_B, X_B_SLOPE, own_b, tables.curves_b),
        ):
            for share in (0.0, 0.4, 1.0):
                expected = energised_fraction(np.array(edges), np.inf, curves, t + share * (t_end - t))
                assert mode[x] + mode[slope] * share * (t_end - t) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("phase", "before", "after"),
    [
        (HELD_CLOSED, (8.9e-3, 0.1), (9e-3, 0.0)),
        (HELD_OPEN, (-1e-4, -0.1), (0.0, 0.0)),
        (STUCK, (4e-3, 0.1), (4e-3, 0.0)),
        (STUCK, (-1e-4, 0.0), (0.0, 0.0)),
        (STUCK, (9.1e-3, 0.0), (9e-3, 0.0)),
        (TO_OPEN, (4e-3, -0.1), (4e-3, -0.1)),
        (TO_CLOSED, (9.1e-3, 0.1), (9.1e-3, 0.1)),
    ],
)
def test_on_entering_a_stretch_a_piston_at_rest_is_put_where_it_can_rest(phase, before, after):
    """A moving one beyond its stop is stopped by an event."""
    _, _, y, mode = instant(*before, 5e5, 5e5, phase)
    assert tuple(y[:2]) == after
    _, _, _, expected = instant(*after, 5e5, 5e5, phase)
    assert mode[[PIECE, AREA]].tolist() == expected[[PIECE, AREA]].tolist()


def test_zero_crossings_change_their_sign_at_1_percent_from_either_end_and_with_the_acceleration():
    p, _, y, mode = instant(9e-3 * 0.99, -1.0, 5e5, 5e5, TO_OPEN)
    w = np.zeros(3)
    for lift, signs in ((0.009, (-1, -1)), (0.011, (1, -1)), (0.989, (1, -1)), (0.991, (1, 1))):
        y[0] = 9e-3 * (1.0 - lift)
        actuator_zero_crossings(p.actuator, y, -2.5, mode, w)
        assert (np.sign(w[ONE_PERCENT]), np.sign(w[NEAR_OPEN])) == signs
        assert w[SPEED_EXTREMUM] == -2.5


# --- whole runs ---


def test_a_pulse_goes_through_all_phases_in_order():
    log, y, mode, _, status = marched(BenchMachine(), 50e-3, 100e-3)
    flows = range(FLOW, FLOW + FLOWS)
    codes = [int(c) for c in log[:, 1] if c not in (BREAKPOINT, ZERO_CROSSING + SPEED_EXTREMUM, *flows)]
    opening = [LEFT, ZERO_CROSSING + ONE_PERCENT, CORNER, ZERO_CROSSING + NEAR_OPEN, MET_OPEN]
    closing = [LEFT, ZERO_CROSSING + NEAR_OPEN, CORNER, ZERO_CROSSING + ONE_PERCENT, MET_CLOSED]
    # At full lift the piston stands on the groove's last row; nothing lies beyond.
    assert [c for c in codes if c != CORNER] == [c for c in opening + closing if c != CORNER]
    assert codes.count(CORNER) == 2
    assert (status, mode[PHASE], y[0], y[1]) == (Status.DONE, HELD_CLOSED, 9e-3, 0.0)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10])
def test_flows_change_their_regime_where_their_pressures_say_so(tolerance):
    """Choking, r = 0.999 and equal pressure are met within their room, and a pulse meets each flow's in both ways."""
    p, _ = bench_of(BenchMachine(), [0.0, 50e-3])
    log, *_ = marched(BenchMachine(), 50e-3, 100e-3, tolerance)
    gas, changes = p.actuator.gas, log[(log[:, 1] >= FLOW) & (log[:, 1] < FLOW + FLOWS)]
    ends = np.array([gas.critical_ratio, NEARLY_EQUAL, 1.0])
    met = {flow: [] for flow in range(FLOWS)}
    for row in changes:
        flow = int(row[1]) - FLOW
        (p_1, _), (p_2, _) = solenoid_sides(state_of(p.actuator, row[LOG_HEAD:], p.supply))[flow]
        away = np.abs(ends - min(p_1, p_2) / max(p_1, p_2))
        # The state at the event is that of the step, not of the interpolant that located it.
        assert away.min() < 1.1 * ROOM + 10.0 * tolerance
        met[flow].append(ends[away.argmin()])
    assert all({gas.critical_ratio, NEARLY_EQUAL} <= set(ends_met) for ends_met in met.values())
    assert sum(map(len, met.values())) < 30


def test_corners_of_the_groove_are_met_where_they_are():
    machine = BenchMachine.with_(groove={"area_curve": GROOVE_ROWS})
    log, *_ = marched(machine, 50e-3, 100e-3)
    lifts = 9e-3 - log[log[:, 1] == CORNER, LOG_HEAD]
    # A located time is good to 1e-12 s, the interpolant to some steps' tolerance. The first row is met on the stop.
    assert lifts[lifts > 1e-6] == pytest.approx([3e-3, 5e-3, 5e-3, 3e-3], abs=1e-9)


def test_lift_off_is_where_the_force_vanishes():
    log, *_ = marched(BenchMachine(), 50e-3, 20e-3, tolerance=1e-11)
    (row,) = log[log[:, 1] == LEFT]
    energy = row[LOG_HEAD + 3], row[LOG_HEAD + 5]
    p_a, p_b = 0.4 * energy[0] / (11382e-9 + 1134.1e-6 * 9e-3), 0.4 * energy[1] / 11382e-9
    # A step of 1e-11 relative in pressures of 1e6 Pa; the located time moves them by 1e8 Pa/s times 1e-12 s.
    assert (p_a - p_b) * 1134.1e-6 == pytest.approx(1828.0 * 9e-3, abs=1e-6)


LEVEL = {"supply": {"pressure": 101325.0}, "valve": {"viscous_friction": 0.0}}
"""Supply at ambient pressure: the springs alone drive the piston, with chambers that breathe on both sides."""


def test_without_dry_friction_the_springs_swing_the_piston_to_rest_in_the_middle():
    _, y, _, _, status = marched(BenchMachine.with_(supply={"pressure": 101325.0}), 5.0, 2.0)
    assert status == Status.DONE
    assert y[0] == pytest.approx(4.5e-3, abs=1e-6)
    assert abs(y[1]) < 1e-6


def test_dry_friction_holds_the_piston_where_the_springs_do_not_overcome_it():
    log, y, mode, _, status = marched(with_friction(5.0, **LEVEL), 5.0, 1.0)
    assert status == Status.DONE
    assert mode[PHASE] == STUCK
    assert y[1] == 0.0
    assert log[log[:, 1] != BREAKPOINT][-1, 1] == TURNED
    # The springs push it still, and the chambers breathe at equal pressure, so that nothing else does.
    assert 0.0 < abs(1828.0 * (9e-3 - 2.0 * y[0])) <= 5.0
    assert (log[:, 1] == TURNED).sum() < 20


def test_work_lost_to_dry_friction_is_force_times_distance():
    log, y, mode, start, _ = marched(with_friction(5.0, **LEVEL), 5.0, 1.0)
    assert mode[PHASE] == STUCK
    turns = np.concatenate([[9e-3], log[log[:, 1] == TURNED, LOG_HEAD], [y[0]]])
    distance = np.abs(np.diff(turns)).sum()
    springs = 1828.0 * (9e-3 * y[0] - y[0] ** 2) - 1828.0 * (9e-3 * 9e-3 - 9e-3**2)
    lost = bench_ledger(y - start).valve_work + springs
    assert lost == pytest.approx(5.0 * distance, rel=1e-6)


def test_a_breakaway_force_above_the_springs_holds_the_piston_on_its_stop():
    assert marched(with_friction(1.0, 16.0, **LEVEL), 5.0, 0.1)[1][0] < 9e-3
    log, y, mode, *_ = marched(with_friction(1.0, 17.0, **LEVEL), 5.0, 0.1)
    assert (y[0], mode[PHASE]) == (9e-3, HELD_CLOSED)
    assert not (log[:, 1] == LEFT).any()
