from math import exp, log
from typing import NamedTuple

import numba
import numpy as np
import pytest

from apesim.kernel import kernel
from apesim.march import periodic
from apesim.march.adaptive import LOG_HEAD, Accuracy, Status
from apesim.march.hybrid_system import rates, start_segment
from apesim.march.periodic import (
    BURST,
    ENOUGH,
    FINE,
    MAX_PERIOD,
    NOISE,
    PATIENCE,
    SAME,
    Drive,
    Linear,
    Record,
    Settling,
    _foretold,
    _only_errors_move,
    distance,
    known_orbit,
    periodic_orbit,
)
from tests.apesim.march.test_adaptive import NoTables, cached_apart

TOLERANCE = 1e-7


@pytest.fixture(scope="module", autouse=True)
def own_cache():
    yield from cached_apart(__file__)


# --- two machines whose cycle is known ---


class Contraction(NamedTuple):
    """Two states that relax to a fixed point, by a factor a cycle each."""

    first: float = 0.5
    second: float = 0.99
    target: float = 3.0


@rates.for_type(Contraction)
@kernel
def contraction_rates(p, t, y, mode, dy):
    dy[0] = np.log(p.first) * (y[0] - p.target)
    dy[1] = np.log(p.second) * (y[1] + y[0] - 2.0 * p.target) - dy[0]
    if y.shape[0] > 2:
        dy[2] = 1.0
    return True


class Map(NamedTuple):
    """y -> fixed + slope (y - fixed) + bend (y - fixed)^2 + rise at the start of a cycle; then nothing happens."""

    slope: float
    bend: float = 0.0
    fixed: float = 2.0
    phase: int = 0
    """2: what is free is held from cycle to cycle, and free again."""
    rise: float = 0.0
    walls: float = 1e9
    """Distance from the fixed point beyond which there is no domain."""


@start_segment.for_type(Map)
@kernel
def start_map_segment(p, tables, t, t_end, y, mode):
    x = y[0] - p.fixed
    y[0] = p.fixed + p.slope * x + p.bend * x * x + p.rise
    if p.phase:
        mode[0] = p.phase - mode[0]


@rates.for_type(Map)
@kernel
def map_rates(p, t, y, mode, dy):
    dy[0] = 0.0
    return abs(y[0] - p.fixed) < p.walls


def settle(machine, y, states=None, max_cycles=600, tolerance=TOLERANCE):
    n = states or len(y)
    accuracy = Accuracy(tolerance, 10.0, np.ones(n))
    return periodic_orbit(
        machine, NoTables(), np.array(y, dtype=float), np.zeros(1), np.array([1.0]), accuracy, max_cycles=max_cycles
    )


# --- fixed points ---


def test_a_fast_contraction_is_found_by_plain_cycles():
    orbit = settle(Contraction(0.1, 0.2), [5.0, 5.0])
    assert orbit.converged
    assert (orbit.period, orbit.status) == (1, Status.DONE)
    assert orbit.cycles <= BURST
    # A cycle changes by 1e-8, relative to 1 + 3, and by 0.2 of that and so on for ever after.
    assert orbit.y == pytest.approx([3.0, 3.0], abs=4e-8 * 0.2 / 0.8 + NOISE * 1e-9)


def test_a_slow_contraction_is_found_in_far_fewer_cycles_than_plain_ones_would_take():
    orbit = settle(Contraction(), [5.0, 5.0])
    assert orbit.converged
    assert orbit.period == 1
    plain = log(1e-8 * 4.0 / (2.0 * 0.01)) / log(0.99)
    assert plain > 1000
    assert orbit.cycles < 100
    # A cycle's own error is a few tolerances of a step; a fixed point multiplies it by 1/(1 - 0.99).
    assert orbit.y == pytest.approx([3.0, 3.0], abs=4.0 * TOLERANCE / 0.01)


def test_a_small_change_is_not_enough_where_there_is_far_to_go():
    """A cycle changes by 1e-4 of what is to go: by 1e-9 at first, though the fixed point is 1e-5 away."""
    orbit = settle(Contraction(0.1, 0.9999), [3.0, 3.0 + 4e-5], tolerance=1e-13)
    assert (orbit.converged, orbit.period) == (True, 1)
    assert orbit.y == pytest.approx([3.0, 3.0], abs=1e-7)
    assert orbit.cycles < 60


def test_the_ledger_of_the_orbit_is_zero_and_plays_no_part():
    with_ledger = settle(Contraction(), [5.0, 5.0, 7.0], states=2)
    assert with_ledger.y[2] == 0.0
    assert with_ledger.y[:2].tolist() == settle(Contraction(), [5.0, 5.0]).y.tolist()


def test_an_orbit_that_starts_at_its_fixed_point_is_seen_at_once():
    orbit = settle(Contraction(), [3.0, 3.0])
    assert (orbit.converged, orbit.cycles, orbit.change) == (True, 2, 0.0)


def test_the_start_is_left_as_it_was():
    y = np.array([5.0, 5.0])
    periodic_orbit(Contraction(), NoTables(), y, np.zeros(1), np.array([1.0]), Accuracy(1e-7, 10.0, np.ones(2)))
    assert y.tolist() == [5.0, 5.0]


def test_slow_alternating_convergence_is_of_period_1():
    orbit = settle(Map(-0.99), [3.0])
    assert (orbit.converged, orbit.period) == (True, 1)
    assert orbit.y[0] == pytest.approx(2.0, abs=1e-5)


# --- from a machine near by ---


def known(machine, y):
    accuracy = Accuracy(TOLERANCE, 10.0, np.ones(len(y)))
    return known_orbit(machine, NoTables(), settle(machine, y), np.array([1.0]), accuracy)


def settle_from(start, machine, y):
    accuracy = Accuracy(TOLERANCE, 10.0, np.ones(len(y)))
    given = np.array(y, dtype=float), np.zeros(1), np.array([1.0]), accuracy
    return periodic_orbit(machine, NoTables(), *given, known=start)


def test_a_slow_contraction_near_by_takes_a_few_cycles():
    start = known(Contraction(), [5.0, 5.0])
    orbit = settle_from(start, Contraction(target=3.01), [5.0, 5.0])
    assert (orbit.converged, orbit.period, orbit.status) == (True, 1, Status.DONE)
    assert orbit.cycles <= 4
    assert orbit.y == pytest.approx([3.01, 3.01], abs=4.0 * TOLERANCE / 0.01)


def test_other_slopes_are_learnt_on_the_way():
    start = known(Contraction(0.5, 0.9), [5.0, 5.0])
    orbit = settle_from(start, Contraction(0.4, 0.95, 3.1), [5.0, 5.0])
    assert orbit.cycles <= 8
    assert orbit.y == pytest.approx([3.1, 3.1], abs=4.0 * TOLERANCE / 0.05)


def test_a_rough_correction_learns_from_a_first_step_that_is_too_short():
    """A state that moves by 0.01 of its distance a cycle, corrected as if that were 0.1, is far from where it lands."""
    start, other = known(Contraction(0.5, 0.9), [5.0, 5.0]), Contraction(0.5, 0.99, 3.1)
    given_up, learnt = (settle_from(start._replace(rough=rough), other, [5.0, 5.0]) for rough in (False, True))
    assert learnt.cycles <= 6 < given_up.cycles
    for orbit in (given_up, learnt):
        assert orbit.y == pytest.approx([3.1, 3.1], abs=10.0 * TOLERANCE / 0.01)
    assert not learnt.known.rough


def test_what_was_found_is_the_start_for_the_next():
    first = settle_from(known(Contraction(0.5, 0.9), [5.0, 5.0]), Contraction(0.4, 0.95, 3.1), [5.0, 5.0])
    orbit = settle_from(first.known, Contraction(0.4, 0.95, 3.101), [5.0, 5.0])
    assert orbit.cycles < first.cycles
    assert orbit.y == pytest.approx([3.101, 3.101], abs=4.0 * TOLERANCE / 0.05)


def test_accelerated_cycles_show_the_way_from_where_they_end():
    first = settle(Contraction(0.5, 0.9), [5.0, 5.0])
    orbit = settle_from(first.known, Contraction(0.5, 0.9, 3.01), [5.0, 5.0])
    assert orbit.cycles <= 3 < first.cycles
    assert orbit.y == pytest.approx([3.01, 3.01], abs=4.0 * TOLERANCE / 0.1)


def test_the_last_cycle_on_the_way_is_the_one_that_is_recorded():
    start, machine = known(Contraction(), [5.0, 5.0]), Contraction(target=3.01)
    accuracy = Accuracy(TOLERANCE, 10.0, np.ones(2))
    record = Record(np.empty((20, LOG_HEAD + 2)), np.empty(0), np.empty((0, 0)))
    given = machine, NoTables(), np.full(2, 5.0), np.zeros(1), np.array([1.0]), accuracy
    found = periodic_orbit(*given, 1e-5, known=start, record=record)
    assert found.recorded.outcome.logged > 0
    end, _, _ = Drive(machine, NoTables(), np.array([1.0]), accuracy).march(found.y, found.mode)
    assert found.recorded.end.tolist() == end.tolist()
    assert found.y == pytest.approx([3.01, 3.01], abs=1e-4)
    assert periodic_orbit(*given, 1e-5, record=record).recorded is None  # not from a state that is near


def test_a_start_too_far_away_is_replaced():
    far = Map(0.5, walls=0.7, fixed=4.0)
    orbit = settle_from(known(Map(0.5), [2.3]), far, [4.5])
    assert orbit.known.y == pytest.approx(orbit.y)
    assert settle_from(orbit.known, far, [4.5]).cycles <= 2


def test_where_the_known_state_does_not_help_the_march_is_the_one_from_rest():
    far, rest = Map(0.5, walls=0.7, fixed=4.0), [4.5]
    orbit = settle_from(known(Map(0.5), [2.3]), far, rest)
    assert (orbit.converged, orbit.y.tolist()) == (True, settle(far, rest).y.tolist())


def test_a_state_is_known_only_where_one_near_by_settles_in_the_same_way():
    """From a slope of -0.99 to one of -1.2 it is not far, and then the state swings for ever."""
    assert known(Map(-0.3), [2.3]) is not None
    assert known(Map(-0.99), [2.3]) is None
    assert known(FLIP, [2.3]) is None


# --- period 2 ---


FLIP = Map(slope=-1.2, bend=0.4)
"""A map whose fixed point is unstable and whose orbit of period 2 is not: it draws nearer by 0.16 every two cycles. Of
x -> -a x + b x^2 the two points add up to (a - 1)/b, with the product (1 - a)/b^2."""
SWINGS = 2.0 + np.roots([1.0, -0.5, -1.25])


@pytest.mark.parametrize("start", [3.39, 2.3])
def test_a_stable_orbit_of_period_2_is_called_2(start):
    orbit = settle(FLIP, [start])
    assert orbit.converged
    assert orbit.period == 2
    assert np.abs(SWINGS - orbit.y[0]).min() < 1e-6
    assert orbit.change == pytest.approx(abs(SWINGS[0] - SWINGS[1]) / (1.0 + SWINGS.max()), rel=1e-6)
    assert orbit.change_of_two <= 1e-8


def test_a_slow_orbit_of_period_2_is_helped_as_one_of_period_1_is():
    """Just beyond the flip it draws nearer by 2 % a cycle: 900 plain ones."""
    orbit = settle(Map(slope=-1.01, bend=0.4), [2.3])
    assert (orbit.converged, orbit.period) == (True, 2)
    assert orbit.cycles < 150
    swings = 2.0 + np.roots([1.0, -0.01 / 0.4, -0.01 / 0.16])
    assert np.abs(swings - orbit.y[0]).min() < 1e-5


class Ringing(NamedTuple):
    """A state that rings far faster than the cycle, undamped, so that no method may step over it."""

    rate: float = 1e4


@rates.for_type(Ringing)
@kernel
def ringing_rates(p, t, y, mode, dy):
    dy[0] = -p.rate * y[1]
    dy[1] = p.rate * y[0]
    return True


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="millions of steps")
@pytest.mark.compiled
def test_an_orbit_that_takes_too_many_evaluations_is_given_up():
    orbit = settle(Ringing(), [1.0, 0.0])
    assert orbit.status == Status.TOO_MANY_EVALUATIONS
    assert not orbit.converged
    assert 1 < orbit.cycles < 60


# --- what is not steady ---


@pytest.mark.parametrize(
    ("slope", "start"),
    [
        (-1.5, 0.5),
        (1.5, 0.5),
        (-1.5, 1e-3),
        (1.5, 1e-3),
        (-1.02, 0.5),
        (1.02, 0.5),
    ],
)
def test_an_unstable_fixed_point_is_not_called_steady(slope, start):
    orbit = settle(Map(slope), [2.0 + start], max_cycles=200)
    assert not orbit.converged
    assert orbit.period == 0


def test_chaos_is_not_called_steady():
    # The logistic map of 3.9, its unstable fixed point moved to 2.
    orbit = settle(Map(slope=2.0 - 3.9, bend=-3.9, fixed=2.0), [2.1 - (1.0 - 1.0 / 3.9) + 0.5], max_cycles=300)
    assert not orbit.converged
    assert orbit.period == 0


def test_a_state_that_drifts_off_does_not_converge_within_the_most_cycles():
    orbit = settle(Map(slope=1.0, rise=0.5), [3.0], max_cycles=100)
    assert not orbit.converged
    assert orbit.period == 0
    # What Newton's method tries may lead past the most cycles: 1 + 1 of a slope, 1 of what was found.
    assert 100 <= orbit.cycles <= 103


@pytest.mark.parametrize(("parameter", "period"), [(3.5, 4), (3.8318740552833155, 3), (3.7389149, 5)])
def test_the_logistic_map_repeats_after_as_many_cycles_as_its_parameter_has_it(parameter, period):
    orbit = settle(Map(slope=2.0 - parameter, bend=-parameter, fixed=2.0), [1.9])
    assert (orbit.converged, orbit.period) == (True, period)


class Turning(NamedTuple):
    """A state that turns round through some values, and one beside it that drifts."""

    values: float
    drift: float = 0.0


@start_segment.for_type(Turning)
@kernel
def start_turning_segment(p, tables, t, t_end, y, mode):
    y[0] = (y[0] + 1.0) % p.values
    y[1] += p.drift


@pytest.mark.parametrize(
    ("values", "period"), [(2, 2), (3, 3), (4, 4), (7, 7), (MAX_PERIOD, MAX_PERIOD), (MAX_PERIOD + 1, 0)]
)
def test_a_state_that_turns_round_repeats_after_all_its_values_up_to_the_longest_period(values, period):
    orbit = settle(Turning(values), [0.0, 1.0])
    assert (orbit.converged, orbit.period) == (period > 0, period)


def test_a_drift_is_no_period_of_some_cycles():
    """It is below the solver's error over a period, and adds up."""
    orbit = settle(Turning(5, drift=0.2 * SAME * TOLERANCE), [0.0, 1.0])
    assert (orbit.converged, orbit.period) == (False, 0)


def test_a_phase_that_changes_every_cycle_is_of_period_2():
    orbit = settle(Map(0.5, phase=2), [2.5])
    assert (orbit.converged, orbit.period) == (True, 2)
    assert orbit.change == np.inf


def test_a_direction_that_changes_every_cycle_is_no_other_phase():
    orbit = settle(Map(0.5, phase=1), [2.5])
    assert (orbit.converged, orbit.period) == (True, 1)


class Receivers(NamedTuple):
    """A store that fills over thousands of cycles, and shares what another one lacks, which follows it within one."""

    gain: float = 1e-5
    share: float = 0.5


class Receiver(NamedTuple):
    """A store that fills over thousands of cycles behind a state that follows it at once; both are far from the end."""

    gain: float = 1e-3
    flow: float = 3.0


@start_segment.for_type(Receiver)
@kernel
def start_receiver_segment(p, tables, t, t_end, y, mode):
    y[0] += p.gain * (p.flow - y[0] * y[0]) / (1.0 + y[0] * y[0])
    y[1] = 0.2 * y[1] + y[0]


@pytest.mark.parametrize(("gain", "start"), [(1e-3, 0.1), (1e-4, 0.1), (1e-4, 50.0), (1e-5, 5.0)])
def test_a_store_far_from_its_end_is_led_there_by_steps_of_many_cycles(gain, start):
    orbit = settle(Receiver(gain), [start, 0.0])
    assert (orbit.converged, orbit.period) == (True, 1)
    assert orbit.y == pytest.approx([3.0**0.5, 3.0**0.5 / 0.8], rel=1e-3)
    assert orbit.cycles < 180 + ENOUGH, "plain cycles would need ten thousand, slopes taken anew for each step 208"


@start_segment.for_type(Receivers)
@kernel
def start_receivers_segment(p, tables, t, t_end, y, mode):
    lacking = y[1] - y[0] * y[0]
    y[0] += p.gain * (3.0 - y[0] * y[0]) / (1.0 + y[0] * y[0]) + p.share * lacking
    y[1] = y[0] * y[0]


@pytest.mark.parametrize("share", [0.1, 0.5])
def test_what_a_long_step_leaves_of_a_fast_state_does_not_lead_the_slow_one_astray(share):
    orbit = settle(Receivers(share=share), [5.0, 25.0])
    assert (orbit.converged, orbit.period) == (True, 1)
    assert orbit.y == pytest.approx([3.0**0.5, 3.0], rel=1e-6)
    assert orbit.cycles < 300 + ENOUGH


class Vessel(NamedTuple):
    """A vessel whose temperature takes a hundred thousand cycles to settle, beside a pressure that takes some ten.

    The pressure is led to where it balances by the root of what it lacks, and takes the temperature with it.
    """

    flow: float
    share: float
    power: float


@start_segment.for_type(Vessel)
@kernel
def start_vessel_segment(p, tables, t, t_end, y, mode):
    lacking = y[0] ** p.power - y[1]
    flow = p.flow * lacking / np.sqrt(abs(lacking) + 1e-6)
    y[0] += 1e-5 * (3.0 - y[0] * y[0]) / (1.0 + y[0] * y[0]) + p.share * flow
    y[1] += flow


@rates.for_type(Vessel)
@kernel
def vessel_rates(p, t, y, mode, dy):
    dy[:] = 0.0
    return True


@pytest.mark.parametrize(
    ("flow", "share", "power"), [(1e-3, 0.7, -0.1), (1e-3, 0.2, -0.1), (1e-3, -0.5, -0.1), (3e-4, -0.5, -0.1)]
)
def test_a_pressure_that_a_long_step_leaves_out_of_balance_does_not_hide_what_a_temperature_gains(flow, share, power):
    orbit = settle(Vessel(flow, share, power), [10.0, 10.0**power + 0.1], max_cycles=1000)
    assert (orbit.converged, orbit.period) == (True, 1)
    assert orbit.y == pytest.approx([3.0**0.5, 3.0 ** (0.5 * power)], abs=1e-7)


class Slow(NamedTuple):
    """A store that comes to 1 by a hundred thousandth of the way in a cycle."""

    share: float = 1e-5


@start_segment.for_type(Slow)
@kernel
def start_slow_segment(p, tables, t, t_end, y, mode):
    y[0] += p.share * (1.0 - y[0])


@rates.for_type(Slow)
@kernel
def slow_rates(p, t, y, mode, dy):
    dy[:] = 0.0
    return True


def test_a_state_that_is_near_is_not_led_away_by_a_step_of_many_cycles(monkeypatch):
    """Such a step leaves a hundredth of the store, Newton's method a fourth of the way."""
    monkeypatch.setattr(periodic, "_many_cycles", lambda *_: (np.array([1.01]), False))
    monkeypatch.setattr(periodic, "_newton", lambda drive, y, *_: 1.0 + (y - 1.0) / 4.0)
    orbit = settle(Slow(), [1e5])
    assert orbit.converged
    assert orbit.cycles < 200


@pytest.mark.parametrize(("repelled", "arrived"), [(1e-7, True), (1e-5, False)])
def test_no_store_is_waited_for_that_a_million_cycles_hardly_move(repelled, arrived, monkeypatch):
    """One settles in 50 million cycles; how far a step leads is limited by another, which repels by an error."""
    slopes, still = np.diag([1.0 + repelled, 1.0 - 2e-8, 0.9]), np.array([0.0, 1e-16, 0.0])
    monkeypatch.setattr(periodic, "_linear", lambda drive, y, *_: Linear(y, np.ones(3), slopes, still))
    drive = Drive(None, NoTables(), np.array([1.0]), Accuracy(TOLERANCE, 10.0, np.ones(3)))
    _, has_arrived = periodic._many_cycles(drive, np.ones(3), np.zeros(1), 1e-7, 600)
    assert has_arrived == arrived


class Jittery(NamedTuple):
    """A state that the solver's error moves about, by a sine of the cycle's number, and that drifts or not."""

    jitter: float
    drift: float = 0.0


@start_segment.for_type(Jittery)
@kernel
def start_jittery_segment(p, tables, t, t_end, y, mode):
    mode[1] += 1.0
    y[0] += p.drift + p.jitter * (np.sin(1e4 * mode[1]) - np.sin(1e4 * (mode[1] - 1.0)))


@rates.for_type(Jittery)
@kernel
def jittery_rates(p, t, y, mode, dy):
    dy[0] = 0.0
    return True


@pytest.mark.parametrize(
    ("machine", "converged"),
    [
        (Jittery(3e-7), True),
        (Jittery(3e-7, drift=2e-7), False),
        (Jittery(1e-7, drift=1e-7), False),
        (Jittery(3e-6), False),
    ],
)
def test_what_only_the_error_of_a_step_moves_is_steady_and_what_drifts_as_little_is_not(machine, converged):
    accuracy = Accuracy(TOLERANCE, 10.0, np.ones(1))
    for shift in range(5):
        mode = np.array([0.0, float(shift)])
        orbit = periodic_orbit(machine, NoTables(), np.array([1.0]), mode, np.array([1.0]), accuracy, max_cycles=100)
        assert orbit.change < SAME * TOLERANCE or not converged
        assert orbit.converged == converged


def test_what_a_cycle_forgets_is_no_drift_where_it_begins_with_the_error_of_other_steps(monkeypatch):
    """The second state is left by each cycle as its own steps have it."""
    left = {TOLERANCE: 5e-7, FINE * TOLERANCE: 5e-8}
    monkeypatch.setattr(periodic, "_image", lambda drive, y, *_: np.array([y[0], 1.0 + left[drive.accuracy.tolerance]]))
    drive = Drive(None, NoTables(), np.array([1.0]), Accuracy(TOLERANCE, 10.0, np.ones(2)))
    found = Settling(np.array([1.0, 1.0 - 5e-7]), np.zeros(1), Status.DONE, 5e-7, 5e-7, 0)
    assert _only_errors_move(drive, found, 1e-8)


class Closed(NamedTuple):
    """A volume that is filled and emptied in a cycle, and keeps what it holds but for the solver's error or a leak."""

    drift: float = 0.0


@rates.for_type(Closed)
@kernel
def closed_rates(p, t, y, mode, dy):
    mean = 4.880792585865024  # I0(3)
    dy[0] = 2.0 * (np.exp(3.0 * np.cos(2.0 * np.pi * t)) - mean) + p.drift
    return True


@pytest.mark.parametrize(("drift", "is_error"), [(0.0, True), (1e-7, False), (-1e-7, False)])
def test_what_falls_with_the_tolerance_of_a_step_is_its_error_and_what_stays_is_a_drift(drift, is_error):
    tolerance = 1e-6
    drive = Drive(Closed(drift=drift), NoTables(), np.array([1.0]), Accuracy(tolerance, 10.0, np.ones(1)))
    start, mode = np.array([1.0]), np.zeros(1)
    end, _, _ = drive.march(start, mode)
    change = distance(end, start, np.ones(1))
    assert 5e-8 < change < SAME * tolerance, "more than counts as periodic, whether it is error or drift"
    found = Settling(end, mode, Status.DONE, change, 2.0 * change, 0)
    assert _only_errors_move(drive, found, 2e-8) == is_error
    assert drive.accuracy.tolerance == tolerance


class Balanced(NamedTuple):
    """A store between nearly equal pressures: its flow is the root of their difference, whose slope has no bound."""

    gain: float


@start_segment.for_type(Balanced)
@kernel
def start_balanced_segment(p, tables, t, t_end, y, mode):
    apart = 1.0 - y[0]
    y[0] += p.gain * np.sign(apart) * np.sqrt(abs(apart))
    y[1] = 0.2 * y[1]


class Snapping(NamedTuple):
    """A store that fills slowly beside a state that stands on an edge: below it, it is thrown far beyond."""

    gain: float


@start_segment.for_type(Snapping)
@kernel
def start_snapping_segment(p, tables, t, t_end, y, mode):
    y[0] += p.gain * (1.0 - y[0])
    y[1] = 1.0 if y[1] >= 1.0 else 1.02


@rates.for_type(Receivers)
@rates.for_type(Receiver)
@rates.for_type(Balanced)
@rates.for_type(Snapping)
@rates.for_type(Turning)
@kernel
def none_of_two_rates(p, t, y, mode, dy):
    dy[0] = dy[1] = 0.0
    return True


def test_steps_that_lead_past_a_balance_from_both_sides_become_shorter():
    orbit = settle(Balanced(1e-4), [0.5, 0.0])
    assert (orbit.converged, orbit.period) == (True, 1)
    assert orbit.y[0] == pytest.approx(1.0, abs=1e-6)


def test_slopes_are_taken_to_the_side_on_which_a_state_on_an_edge_has_them():
    orbit = settle(Snapping(1e-4), [0.5, 1.0])
    assert (orbit.converged, orbit.period) == (True, 1)
    assert orbit.y == pytest.approx([1.0, 1.0], abs=1e-3)


@pytest.mark.parametrize("max_cycles", [PATIENCE + extra for extra in range(16)])
def test_a_drift_is_seen_wherever_the_most_cycles_end_the_search(max_cycles):
    accuracy, y, mode = Accuracy(TOLERANCE, 10.0, np.ones(1)), np.array([1.0]), np.zeros(2)
    machine = Jittery(1e-9, drift=4e-7)
    orbit = periodic_orbit(machine, NoTables(), y, mode, np.array([1.0]), accuracy, max_cycles=max_cycles)
    assert orbit.change == pytest.approx(2e-7, rel=0.1)
    assert not orbit.converged


def test_a_step_that_is_short_because_it_spans_few_cycles_has_not_arrived():
    orbit = settle(Receivers(share=-0.3), [50.0, 2500.0])
    assert orbit.y[0] > 30.0, "it drifts on by some ten millionths a cycle"
    assert not orbit.converged


def test_a_map_that_is_asked_for_where_it_was_taken_is_the_same():
    known = Linear(np.array([3.0, 2.0]), np.ones(2), 0.5 * np.eye(2), np.array([0.1, 0.0]))
    assert _foretold(known, np.array([3.0, 2.0]), np.array([3.1, 2.0]), np.ones(2), 0.3) is known


def test_states_that_are_held_do_not_count_among_those_that_settle():
    def settles_in(*multipliers):
        return Linear(np.ones(1), np.ones(1), np.diag(multipliers), np.ones(1)).settles_in

    slow, held = 1.0 - 1.0 / 50.0, 1.0
    assert settles_in(0.5, slow, held, held + 1e-12) == pytest.approx(50.0)
    assert settles_in(held) == 0.0


def test_a_march_that_fails_is_told():
    orbit = settle(Map(1.5, walls=5.0), [2.5])
    assert orbit.status == Status.STEP_TOO_SMALL
    assert not orbit.converged
    assert orbit.period == 0


def test_distance_is_the_largest_change_relative_to_scale_and_size():
    a, b = np.array([1.0, 100.0, 7.0]), np.array([1.5, 101.0, 9.0])
    assert distance(a, b, np.array([1.0, 1.0])) == pytest.approx(0.5 / 2.5)


def test_the_contraction_is_what_it_says():
    # One cycle, by hand: x_1 falls by its factor, x_1 + x_2 - 2 target by the other.
    orbit = settle(Contraction(0.25, 0.5), [5.0, 5.0], max_cycles=1)
    assert orbit.cycles == 1
    first = 3.0 + 2.0 * exp(log(0.25))
    assert orbit.y == pytest.approx([first, 6.0 + 4.0 * 0.5 - first], rel=1e-6)
    assert not orbit.converged
