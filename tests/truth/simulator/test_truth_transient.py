"""The independent transient: it repeats independent solutions by a program in C, and keeps its own ledger."""

from math import degrees, inf, pi, radians

import numpy as np
import pytest
from scipy.integrate import quad

from tests.machines import AMBIENT, RPM
from tests.truth.simulator.assembly import ANGLE, PRESSURE, SPEED, Assembly, Kind
from tests.truth.simulator.crank import TURN
from tests.truth.simulator.engine import Engine
from tests.truth.simulator.periodic import periodic, results
from tests.truth.simulator.shaft import Load, Shaft, friction_torque, load_torque, pull_and_hold
from tests.truth.simulator.transient import impose, march, start
from tests.truth.simulator.turning import begins, sector_of, turn_of

ERROR = 1e-6
"""Relative; the solutions are printed with seven digits."""
LAP_PASSED = 6.734427e-3
"""Command edge to the lap, of a valve after a rest: where the crank of P07c, without friction, begins to move [s]."""
QUADRATIC = Load(quadratic=20.0 / (800.0 * RPM) ** 2)
ENGINE = Engine()
TWO = Assembly((ENGINE, ENGINE), (0.0, pi), loads=((0.0, QUADRATIC),))
THREE = Assembly((ENGINE,) * 3, (0.0, TURN / 3.0, 2.0 * TURN / 3.0))
ALONE = Assembly(loads=((0.0, QUADRATIC),))
STARTS = {
    "P07, 30 deg to 900 r/min": (ALONE, 30.0, 900.0, (7.53408, 0.1259079, 1.18503, 7.729857, 0.767811)),
    "P07b, friction of Chen and Flynn at every speed": (
        ALONE._replace(shaft=Shaft(breakaway_factor=1.0)),
        30.0,
        900.0,
        (7.305948, 0.1258192, 1.185028, 7.729797, 0.7678091),
    ),
    "P07c, no friction": (
        ALONE._replace(engines=(ENGINE._replace(friction=(0.0, 0.0, 0.0, 0.0)),)),
        30.0,
        900.0,
        (None, 0.1222154, 1.167252, 7.383306, 0.7384126),
    ),
    "P08, against 20 N m, 1 kg m2": (
        Assembly(shaft=Shaft(1.0), loads=((0.0, Load(20.0)),)),
        30.0,
        600.0,
        (8.324615, 1.259175, 7.282224, 31.07385, 3.713094),
    ),
    "P10, two cylinders": (TWO, 200.0, 900.0, (7.83873, 0.08873008, 0.6835779, 7.213336, 0.7194383)),
    "P11, three cylinders, 0.2 kg m2, against 30 N m": (
        THREE._replace(shaft=Shaft(0.2), loads=((0.0, Load(30.0)),)),
        160.0,
        900.0,
        (9.049931, 0.1454361, 1.125423, 14.82251, 1.634736),
    ),
}
"""First motion [ms], time [s], turns, engine air [g], control air [g]."""
RAMP = (0.0, 300.0 * RPM), (1.5, 1800.0 * RPM), (3.0, 300.0 * RPM)
REVOLUTIONS = {
    4: (792.8229, 51.83591, 4.188347),
    15: (1396.259, 10.94112, 2.164345),
    26: (1789.507, -0.5908982, 0.8759827),
    40: (1236.694, 17.16915, 2.719841),
    48: (753.9341, 50.18551, 4.102107),
}
"""P14: mean speed [r/min], torque [N m], engine air [g]."""


def first_motion(run):
    return run.of_kind(Kind.FIRST_MOTION)[0]


def assert_closes(run):
    """Kinetic energy is what gas, friction and load have left of it."""
    totals = run.totals(run.ending.states)
    kinetic = 0.5 * run.assembly.shaft.inertia * totals.speed**2
    assert totals.work - totals.friction_work - totals.load_work == pytest.approx(kinetic, rel=1e-7, abs=1e-7)


@pytest.mark.parametrize("name", STARTS)
def test_starts_repeat_the_independent_solutions_by_a_program_in_c(name):
    assembly, angle, target, (motion, *wanted) = STARTS[name]
    run = start(assembly, radians(angle), target * RPM)
    totals = run.totals(run.ending.states)
    turns = (totals.angle - radians(angle)) / TURN
    found = [run.ending.time, turns, totals.engine_air * 1e3, totals.control_air * 1e3]
    assert run.ending.kind == Kind.TARGET
    assert found == pytest.approx(wanted, rel=ERROR)
    if motion:
        assert first_motion(run).time * 1e3 == pytest.approx(motion, rel=ERROR)
    assert_closes(run)


def test_without_friction_the_crank_moves_when_the_lift_passes_the_lap():
    """P07c, of whose first motion the program in C itself is sure to 1e-6."""
    assembly, angle, *_ = STARTS["P07c, no friction"]
    run = march(assembly, radians(angle), 7e-3)
    assert first_motion(run).time == pytest.approx(run.of_kind(Kind.OPENS)[0].time, rel=1e-6)
    assert first_motion(run).time == pytest.approx(LAP_PASSED, rel=ERROR)


def test_a_kick_back_repeats_the_independent_solution_by_a_program_in_c():
    """P09: it breaks away forwards, is thrown back over its dead centre, and comes to rest at the second stop."""
    run = start(Assembly(), radians(-4.0))
    motion, *stops = run.of_kind(Kind.FIRST_MOTION, Kind.MOTION, Kind.SPEED_ZERO)
    (rest,) = run.of_kind(Kind.AT_REST)
    assert (motion.time, degrees(motion.angle)) == pytest.approx((0.008079361, -4.0), rel=ERROR)
    assert [one.time for one in stops] == pytest.approx([0.3874993, 0.6306734], rel=ERROR)
    assert [degrees(one.angle) for one in stops] == pytest.approx([-253.1529, -216.6961], rel=ERROR)
    assert (rest.time, rest.angle) == (stops[-1].time, stops[-1].angle)
    assert (run.ending.kind, run.ending.time) == (Kind.HELD, pytest.approx(rest.time + 0.25))
    assert run.totals(run.ending.states).engine_air * 1e3 == pytest.approx(0.2873413, rel=ERROR)
    assert_closes(run)


@pytest.mark.parametrize(
    "assembly, below, above",
    [
        (Assembly(), 1.1415, 1.1435),
        (Assembly(), 70.0, 69.99),
        (Assembly(loads=((0.0, Load(20.0)),)), 4.699, 4.7005),
        (Assembly(shaft=Shaft(breakaway_factor=1.0)), 0.5705, 0.572),
    ],
    ids=["low 1.142523 deg", "high 70 deg", "low 4.699579 deg against 20 N m", "low 0.5712158 deg, no break-away"],
)
def test_edges_of_angles_from_which_it_starts_lie_where_the_program_in_c_has_them(assembly, below, above):
    """P12, P12b."""
    held, moving = (start(assembly, radians(angle), 1.0 * RPM) for angle in (below, above))
    assert (held.ending.kind, held.ending.time) == (Kind.HELD, 0.25)
    assert not held.of_kind(Kind.FIRST_MOTION)
    assert moving.of_kind(Kind.FIRST_MOTION)


def assert_repeats(revolution, wanted):
    totals = revolution.totals
    found = 60.0 / revolution.duration, totals.work / TURN, totals.engine_air * 1e3
    assert found == pytest.approx(wanted, rel=ERROR)


def test_a_ramp_repeats_its_fourth_revolution_by_a_program_in_c():
    run = impose(Assembly(), 0.0, (RAMP[0], (0.54, 840.0 * RPM)))
    assert run.ending.kind == Kind.TIME
    assert_repeats(list(run.revolutions())[3], REVOLUTIONS[4])


@pytest.mark.slow
def test_a_ramp_repeats_the_independent_solution_by_a_program_in_c():
    """P14."""
    run = impose(Assembly(), 0.0, RAMP)
    revolutions, totals = list(run.revolutions()), run.totals(run.ending.states)
    for number, wanted in REVOLUTIONS.items():
        assert_repeats(revolutions[number - 1], wanted)
    assert totals.angle / TURN == pytest.approx(52.5, rel=1e-8)
    assert (totals.work, totals.friction_work) == pytest.approx((7674.031, 1912.236), rel=ERROR)
    assert (totals.engine_air * 1e3, totals.control_air * 1e3) == pytest.approx((138.5602, 19.71622), rel=ERROR)


@pytest.mark.slow
@pytest.mark.parametrize(
    "assembly, rpm, turns, wanted",
    [
        (Assembly(), -1000.0, 60, (19.82017, 25.74554, -121.3254, 257.1715, 1.259484, 0.4324817, 1032.241)),
        (TWO, 800.0, 24, (98.80318, 88.65376, -5.364638, 211.6876, 8.232107, 0.9058736, 1038.32)),
        (THREE, 800.0, 24, (148.2048, 132.9806, 54.32505, 204.1327, 12.34816, 1.35881, 1038.32)),
    ],
    ids=["P01, backwards", "P02, two cylinders", "P03, three cylinders"],
)
def test_a_constant_speed_repeats_the_independent_solutions_by_a_program_in_c(assembly, rpm, turns, wanted):
    until = turns * 60.0 / abs(rpm) + 1e-3
    run = impose(assembly, 0.0, ((0.0, rpm * RPM), (until, rpm * RPM)))
    *_, last = run.revolutions()
    totals, sign = last.totals, np.sign(rpm)
    states = run.states(np.linspace(last.begins, last.begins + last.duration, 20001))
    torque = run.gas_torque(states)
    mean = [sign * work / TURN for work in (totals.work, totals.work - totals.friction_work)]
    air = totals.engine_air * 1e3, totals.control_air * 1e3
    found = *mean, torque.min(), torque.max(), *air, states[PRESSURE].min() * 1e-3
    assert found == pytest.approx(wanted, rel=1e-5)


@pytest.mark.slow
def test_a_free_shaft_repeats_the_independent_solution_by_a_program_in_c():
    """P05."""
    *_, last = march(ALONE, radians(30.0), 3.0).revolutions()
    totals = last.totals
    torques = [work / TURN for work in (totals.work, totals.friction_work, totals.load_work)]
    assert 60.0 / last.duration == pytest.approx(1015.391, rel=ERROR)
    assert torques == pytest.approx([37.89354, 5.465715, 32.42782], rel=ERROR)
    assert (totals.engine_air * 1e3, totals.control_air * 1e3) == pytest.approx((3.919778, 0.4393016), rel=ERROR)


@pytest.mark.slow
def test_a_step_of_the_load_repeats_the_independent_solution_by_a_program_in_c():
    """P13, of which the first three revolutions after the step."""
    assembly = ALONE._replace(loads=((0.0, QUADRATIC), (5.0, QUADRATIC._replace(constant=10.0))))
    run = march(assembly, radians(30.0), 5.4)
    step = run.states([5.0])[:, 0]
    assert step[SPEED] / RPM == pytest.approx(1050.402, rel=ERROR)
    assert step[ANGLE] / TURN == pytest.approx(83.61329, rel=ERROR)
    revolutions = list(run.revolutions())
    before = [one for one in revolutions if one.begins + one.duration < 5.0][-1]
    means = [60.0 / one.duration for one in revolutions if one.begins > 5.0][:3]
    assert 60.0 / before.duration == pytest.approx(1015.391, rel=ERROR)
    assert means == pytest.approx([979.8726, 960.7243, 953.4987], rel=ERROR)


@pytest.mark.parametrize("intake", [pytest.param("epv", marks=pytest.mark.slow), "cam", "ideal"])
def test_a_constant_speed_leads_to_the_periodic_state_over_crank_angle(intake):
    engine = ENGINE._replace(intake=intake, receiver_volume=inf, energise=radians(-20.0), release=radians(50.0))
    run = impose(Assembly((engine,)), 0.0, ((0.0, 600.0 * RPM), (0.71, 600.0 * RPM)))
    *_, last = run.revolutions()
    wanted = results(periodic(engine, 600.0 * RPM))
    assert last.totals.work / TURN == pytest.approx(wanted["indicated_torque"], rel=ERROR)
    assert last.totals.engine_air == pytest.approx(wanted["engine_air"], rel=ERROR)
    assert (last.totals.work - last.totals.friction_work) / TURN == pytest.approx(wanted["brake_torque"], rel=ERROR)


def test_twins_on_an_infinite_receiver_start_as_one_cylinder_does():
    """All that happens to them happens at the same instants."""
    engine = ENGINE._replace(receiver_volume=inf)
    one = start(Assembly((engine,)), radians(30.0), 600.0 * RPM)
    two = start(Assembly((engine, engine), (0.0, 0.0), Shaft(0.2)), radians(30.0), 600.0 * RPM)
    assert two.ending.time == pytest.approx(one.ending.time, rel=1e-8)
    single, both = (run.totals(run.ending.states) for run in (one, two))
    assert both.angle == pytest.approx(single.angle, rel=1e-8)
    assert both[2:] == pytest.approx([2.0 * value for value in single[2:]], rel=1e-7)
    assert_closes(two)


def test_a_start_ends_after_three_turns():
    run = start(Assembly(), radians(30.0))
    assert run.ending.kind == Kind.TURNED
    assert run.ending.angle == pytest.approx(radians(30.0) + 3.0 * TURN, rel=1e-12)
    assert [one.angle for one in run.of_kind(Kind.PASSAGE)] == [TURN, 2.0 * TURN, 3.0 * TURN]


def test_a_hoist_pulls_the_crank_backwards_at_once_and_gets_back_what_it_gives():
    """70 deg is where the command ends: it begins as the crank leaves it backwards."""
    run = march(Assembly(loads=((0.0, Load(10.0, hoist=True)),)), radians(70.0), 0.05)
    assert first_motion(run).time == 0.0
    opening, turning = run.of_kind(Kind.OPENS, Kind.SPEED_ZERO)
    assert opening.time == pytest.approx(LAP_PASSED, rel=ERROR)
    assert turning.angle < opening.angle < radians(70.0) < run.ending.angle
    begins_at = [at for at, _ in run.pieces]
    assert len(set(begins_at)) == len(begins_at)  # no stretch ends where it begins
    totals = run.totals(run.ending.states)
    assert totals.load_work == pytest.approx(10.0 * (totals.angle - radians(70.0)), rel=1e-7)
    assert_closes(run)


def test_a_brake_that_is_let_go_lets_the_crank_go_at_that_instant():
    run = march(Assembly(loads=((0.0, Load(1e3)), (20e-3, Load()))), radians(30.0), 30e-3)
    assert first_motion(run).time == 20e-3
    assert run.totals(run.ending.states).load_work == 0.0
    assert_closes(run)


def test_an_imposed_speed_that_changes_its_sign_takes_the_command_back():
    """It swings from -15 deg to -1 deg and back, and so passes the energising angle, -5 deg, twice."""
    top = radians(7.0) / 0.05
    run = impose(Assembly(), radians(-15.0), ((0.0, 0.0), (0.1, top), (0.3, -top), (0.4, 0.0)))
    opening, closing = run.of_kind(Kind.OPENS, Kind.CLOSES)
    assert run.ending.angle == pytest.approx(radians(-15.0), abs=1e-9)
    # It slows down evenly from -8 deg on, at 0.1 s, to -1 deg, at 0.2 s, and is as fast at each angle on its way back.
    energised, released = (0.2 + way * 0.1 * np.sqrt(4.0 / 7.0) for way in (-1.0, 1.0))
    assert opening.kind == Kind.OPENS
    assert opening.time - energised == pytest.approx(LAP_PASSED, rel=ERROR)  # the start of a start, at rest
    assert closing.time > released
    lost, _ = quad(lambda speed: friction_torque(Shaft(), [ENGINE], [AMBIENT], speed) * speed * 0.1 / top, 0.0, top)
    assert run.totals(run.ending.states).friction_work == pytest.approx(4.0 * lost, rel=ERROR)


def test_friction_is_that_of_chen_and_flynn_and_doubled_at_rest():
    volume = 0.25 * pi * 85e-3**2 * 88e-3
    piston_speed = 88e-3 * 600.0 * RPM / pi
    pressure = 0.4e5 + 0.005 * 1e6 + 0.08e5 * piston_speed + 0.0008e5 * piston_speed**2
    assert friction_torque(Shaft(), [ENGINE], [1e6], 600.0 * RPM) == pytest.approx(pressure * volume / TURN)
    resting = (0.4e5 + 0.005 * 2e6 + 0.4e5 + 0.005 * 1e6) * volume / TURN
    assert friction_torque(Shaft(), [ENGINE, ENGINE], [2e6, 1e6], 0.0) == pytest.approx(2.0 * resting)
    slow = friction_torque(Shaft(), [ENGINE], [1e6], 30.0 * RPM)
    as_fast = friction_torque(Shaft(breakaway_factor=1.0), [ENGINE], [1e6], 30.0 * RPM)
    assert slow == pytest.approx((1.0 + 0.75**2) * as_fast)


def test_a_brake_opposes_motion_and_a_hoist_does_not():
    brake = Load(3.0, 0.5, 0.25, ((2.0, 1.0), (4.0, 2.0)))
    assert load_torque(brake, 1, 3.0) == pytest.approx(3.0 + 1.5 + 2.25 + 1.5)
    assert load_torque(brake, -1, 8.0) == pytest.approx(-(3.0 + 4.0 + 16.0 + 2.0))
    assert load_torque(brake, 0, 0.0) == 0.0
    hoist = Load(3.0, hoist=True)
    assert [load_torque(hoist, direction, 5.0) for direction in (-1, 0, 1)] == [3.0, 3.0, 3.0]
    own = friction_torque(Shaft(), [ENGINE], [1e5], 0.0)
    assert pull_and_hold(Shaft(), brake, [ENGINE], [1e5], 7.0) == pytest.approx((7.0, own + 4.0))
    assert pull_and_hold(Shaft(), hoist, [ENGINE], [1e5], 7.0) == pytest.approx((4.0, own))


def test_a_crank_on_a_corner_is_in_the_sector_that_begins_there():
    turn = turn_of((ENGINE, ENGINE), (0.0, pi))
    for angle in (radians(70.0), -TURN, radians(355.0) - 3.0 * TURN, TURN * (1.0 - 1e-16)):
        sector, exact = sector_of(turn, angle)
        assert begins(turn, sector) == exact == pytest.approx(angle, abs=1e-12)
    sector, exact = sector_of(turn, radians(-8.0))
    assert exact == radians(-8.0)
    assert begins(turn, sector) < exact < begins(turn, sector + 1)


def test_states_in_between_are_those_at_the_events():
    run = start(Assembly(), radians(30.0), 300.0 * RPM)
    for one in (*run.of_kind(Kind.OPENS, Kind.FIRST_MOTION), run.ending):
        assert run.states([one.time])[:, 0] == pytest.approx(one.states, rel=1e-7, abs=1e-9)
