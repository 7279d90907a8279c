import hashlib
from math import acosh, cosh, exp, sqrt, tanh
from math import log as ln
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from apesim.kernel import cache_folder, kernel
from apesim.march import adaptive as module
from apesim.march.adaptive import (
    BREAKPOINT,
    LOG_HEAD,
    MAX_EVENTS,
    NO_CARRY,
    REMEDIES,
    ZERO_CROSSING,
    Accuracy,
    Status,
    march,
)
from apesim.march.hybrid_system import events, handle_event, observe, power, rates, start_segment, zero_crossings

compiled_only = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="plain Python takes minutes over this")


def cached_apart(file):
    """Keep what the march's kernels compile for the machines of a test file in a folder of that file's own.

    The common folder is named by the sources of the layers, not of the tests; and a process that cannot import a
    test's machine would drop all that is kept there.
    """
    if numba.config.DISABLE_JIT:
        yield
        return
    kernels = [k for k in vars(module).values() if isinstance(k, numba.core.dispatcher.Dispatcher)]
    caches = [k._cache for k in kernels]
    before = numba.config.CACHE_DIR
    digest = hashlib.sha256(Path(file).read_bytes()).hexdigest()[:16]
    numba.config.CACHE_DIR = str(cache_folder() / f"{Path(file).stem}-{digest}")
    for k in kernels:
        k.enable_caching()
    numba.config.CACHE_DIR = before
    yield
    for k, cache in zip(kernels, caches, strict=True):
        k._cache = cache


@pytest.fixture(scope="module", autouse=True)
def own_cache():
    yield from cached_apart(__file__)


class NoTables(NamedTuple):
    none: np.ndarray = np.zeros(1)


def run(
    machine, y, breakpoints, tolerance=1e-10, max_step=0.1, states=None, log_rows=500, times=(), start=0.0, scale=1.0
):
    """March a machine; its outcome, state and mode at the end, log and trace."""
    y, mode = np.array(y, dtype=float), np.zeros(2)
    n = states or len(y)
    log, trace = np.full((log_rows, LOG_HEAD + n), np.nan), np.full((len(times), 3), np.nan)
    accuracy = Accuracy(tolerance, max_step, np.full(n, scale))
    outcome = march(
        machine,
        NoTables(),
        start,
        y,
        mode,
        np.array(breakpoints, dtype=float),
        accuracy,
        log,
        np.array(times),
        trace,
        NO_CARRY,
    )
    return outcome, y, mode, log[: outcome.logged], trace


def rows(log, code):
    return log[log[:, 1] == code]


# --- a mass that falls through air onto a floor ---


class Fall(NamedTuple):
    gravity: float = 9.81
    limit: float = 5.0
    """Speed at which drag and weight are equal [m/s]."""
    restitution: float = 0.0


@rates.for_type(Fall)
@kernel
def fall_rates(p, t, y, mode, dy):
    dy[0] = y[1]
    dy[1] = 0.0 if mode[0] > 0.0 else -p.gravity * (1.0 + y[1] * abs(y[1]) / p.limit**2)
    return True


@events.for_type(Fall)
@kernel
def fall_events(p, t, y, mode, g):
    g[0] = -y[0] if mode[0] == 0.0 else -1.0


@handle_event.for_type(Fall)
@kernel
def handle_fall_event(p, tables, event, t, y, mode):
    y[0] = 0.0
    y[1] = p.restitution * abs(y[1])
    if p.restitution == 0.0:
        mode[0] = 1.0


@power.for_type(Fall)
@kernel
def fall_power(p, t, y):
    return -p.gravity * y[1]


HEIGHT = 2.0
FALL = Fall()
FALL_TIME = FALL.limit / FALL.gravity * acosh(exp(HEIGHT * FALL.gravity / FALL.limit**2))
FALL_SPEED = FALL.limit * tanh(FALL.gravity * FALL_TIME / FALL.limit)


@pytest.mark.parametrize("max_step", [0.1, 0.013])
def test_a_contact_is_located_at_its_analytic_time(max_step):
    outcome, y, mode, log, _ = run(FALL, [HEIGHT, 0.0], [1.5], tolerance=1e-11, max_step=max_step)
    ((time, _, _, height, speed),) = rows(log, 0)
    assert time == pytest.approx(FALL_TIME, abs=1e-9)
    assert speed == pytest.approx(-FALL_SPEED, abs=1e-9)
    # Located to 1e-12 s at 5 m/s, on the far side: the interpolant of the step that ends there differs by its error.
    assert abs(height) < 1e-10
    assert (outcome.status, outcome.events) == (Status.DONE, 1)
    assert y.tolist() == [0.0, 0.0]
    assert mode[0] == 1.0


def test_work_by_quadrature_is_the_fall_of_potential_energy():
    outcome, *_ = run(FALL, [HEIGHT, 0.0], [1.5], tolerance=1e-11)
    assert outcome.work == pytest.approx(FALL.gravity * HEIGHT, rel=1e-9)


def test_no_work_is_taken_and_nothing_noted_where_the_log_has_no_rows():
    outcome, y, *_ = run(FALL, [HEIGHT, 0.0], [1.5], log_rows=0)
    assert (outcome.work, outcome.logged, outcome.events) == (0.0, 0, 1)
    assert y.tolist() == run(FALL, [HEIGHT, 0.0], [1.5])[1].tolist()


def test_a_ball_that_bounces_for_ever_is_given_up_with_a_remedy():
    outcome, *_ = run(Fall(restitution=0.5), [HEIGHT, 0.0], [60.0], log_rows=5000)
    assert outcome.status == Status.TOO_MANY_EVENTS
    assert outcome.events == MAX_EVENTS + 1
    assert "restitution" in Status(outcome.status).remedy


def test_rebounds_follow_one_another_as_the_law_of_restitution_says():
    _, _, _, log, _ = run(Fall(limit=1e9, restitution=0.8), [HEIGHT, 0.0], [5.0], tolerance=1e-11)
    contacts = rows(log, 0)
    first = sqrt(2.0 * HEIGHT / 9.81)
    flights = 2.0 * first * 0.8 ** np.arange(1, 6)
    assert contacts[:6, 0] == pytest.approx(first + np.append(0.0, np.cumsum(flights)), abs=1e-9)
    assert -contacts[:6, 4] == pytest.approx(9.81 * first * 0.8 ** np.arange(6), abs=1e-8)


# --- a harmonic oscillator, with its two turning points located ---


class Oscillator(NamedTuple):
    omega: float = 3.0
    speed: float = 0.0
    """Speed of a belt that is dragged over the domain; beyond position 10 there is none."""


@rates.for_type(Oscillator)
@kernel
def oscillator_rates(p, t, y, mode, dy):
    dy[0] = y[1]
    dy[1] = -p.omega * p.omega * y[0]
    if y.shape[0] > 2:
        dy[2] = y[1] * y[1]
    return y[0] < 10.0


@zero_crossings.for_type(Oscillator)
@kernel
def oscillator_zero_crossings(p, t, y, dy, mode, w):
    w[0] = y[0]
    w[1] = dy[0]


@power.for_type(Oscillator)
@kernel
def oscillator_power(p, t, y):
    return y[1] * y[1]


@observe.for_type(Oscillator)
@kernel
def oscillator_observes(p, t, y, mode, row):
    row[0], row[1], row[2] = t, y[0], y[1]


OSCILLATOR = Oscillator()
START = [1.0, 0.0]


def exact(t, omega=3.0):
    return np.array([np.cos(omega * t), -omega * np.sin(omega * t)])


def test_the_global_error_falls_in_proportion_to_the_tolerance():
    tolerances = 10.0 ** np.arange(-4, -11, -1.0)
    # Held by the tolerance alone: a longest step of 10 s is never reached.
    errors = [
        np.abs(run(OSCILLATOR, START, [20.0], tolerance, 10.0)[1] - exact(20.0)).max() for tolerance in tolerances
    ]
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    # A step's error is of order 5 in h and that of the result, which takes the better formula, of order 5 too.
    assert slope == pytest.approx(1.0, abs=0.1)
    assert errors[-1] < 1e-7


def test_the_step_grows_with_the_fifth_root_of_the_tolerance():
    steps = [run(OSCILLATOR, START, [100.0], 10.0**-n, 10.0, log_rows=0)[0].steps for n in (5, 10)]
    assert steps[1] / steps[0] == pytest.approx(10.0, rel=0.1)


def test_the_state_agrees_with_scipy():
    def field(t, y):
        return [y[1], -9.0 * y[0]]

    other = solve_ivp(field, (0.0, 7.0), START, method="DOP853", rtol=1e-12, atol=1e-12)
    assert run(OSCILLATOR, START, [7.0], 1e-12)[1] == pytest.approx(other.y[:, -1], abs=1e-9)


def test_zero_crossings_are_located_and_noted_with_the_sign_of_their_change():
    outcome, _, _, log, _ = run(OSCILLATOR, START, [7.0], 1e-11)
    crossings, turns = rows(log, ZERO_CROSSING), rows(log, ZERO_CROSSING + 1)
    expected = np.pi / 3.0 * (np.arange(7) + 0.5)
    expected = expected[expected < 7.0]
    assert crossings[:, 0] == pytest.approx(expected, abs=1e-8)
    assert crossings[:, 2].tolist() == [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0][: len(expected)]
    assert crossings[:, 3:] == pytest.approx(exact(expected).T, abs=1e-7)
    # The first turning point is the start, where the speed is zero: no change of sign.
    assert turns[:, 0] == pytest.approx(np.pi / 3.0 * np.arange(1, 7), abs=1e-8)
    assert turns[:, 2].tolist() == [1.0, -1.0] * 3
    assert outcome.events == 0


def test_locating_zero_crossings_changes_no_bit_of_the_state():
    assert run(OSCILLATOR, START, [7.0])[1].tolist() == run(OSCILLATOR, START, [7.0], log_rows=0)[1].tolist()


def test_a_full_log_is_no_fault():
    outcome, _, _, log, _ = run(OSCILLATOR, START, [7.0], log_rows=3)
    assert (outcome.status, outcome.logged) == (Status.DONE, 3)
    assert log.tolist() == run(OSCILLATOR, START, [7.0])[3][:3].tolist()


def test_the_log_holds_the_ends_of_the_smooth_stretches():
    _, y, _, log, _ = run(OSCILLATOR, START, [0.5, 0.9, 1.3], 1e-11)
    breakpoints = rows(log, BREAKPOINT)
    assert breakpoints[:, 0].tolist() == [0.0, 0.5, 0.9, 1.3]
    assert breakpoints[:, 3:] == pytest.approx(exact(breakpoints[:, 0]).T, abs=1e-9)
    assert breakpoints[-1, 3:].tolist() == y.tolist()
    assert (np.diff(log[:, 0]) >= 0.0).all()


def test_breakpoints_in_the_past_are_passed_over():
    _, _, _, log, _ = run(OSCILLATOR, START, [0.5, 0.9, 1.3], start=0.9)
    assert rows(log, BREAKPOINT)[:, 0].tolist() == [0.9, 1.3]


def test_a_trace_is_the_solution_at_its_times():
    times = np.append(np.linspace(0.0, 2.0, 41), [2.0])
    *_, trace = run(OSCILLATOR, START, [1.0, 2.0], 1e-9, 1.0, times=times)
    assert trace[:, 0].tolist() == times.tolist()
    # The interpolant is of order 4 within a step of order 5: between the steps the fourth root of the error's
    # fifth power, 1e-9 ** 0.8.
    assert trace[:, 1:] == pytest.approx(exact(times).T, abs=10.0 * 1e-9**0.8)


def test_a_trace_changes_no_step():
    plain = run(OSCILLATOR, START, [2.0])
    traced = run(OSCILLATOR, START, [2.0], times=np.linspace(0.0, 2.0, 77))
    assert traced[1].tolist() == plain[1].tolist()
    assert traced[0] == plain[0]


def test_the_ledger_is_integrated_and_not_controlled():
    outcome, y, *_ = run(OSCILLATOR, [*START, 0.0], [2.0], 1e-9, 10.0, states=2)
    expected = 9.0 * (1.0 - np.sin(12.0) / 12.0)
    assert y[2] == pytest.approx(expected, rel=1e-7)
    assert outcome.work == pytest.approx(expected, rel=1e-7)
    assert outcome.steps == run(OSCILLATOR, START, [2.0], 1e-9, 10.0)[0].steps


@pytest.mark.parametrize("breakpoints", [[0.0], []])
def test_a_march_of_no_length_leaves_the_state_as_it_was(breakpoints):
    outcome, y, _, log, _ = run(OSCILLATOR, START, breakpoints)
    assert (outcome.status, outcome.steps, outcome.work) == (Status.DONE, 0, 0.0)
    assert y.tolist() == START
    assert log.tolist() == [[0.0, BREAKPOINT, 0.0, *START]]


def test_a_state_that_leaves_its_domain_ends_the_march_with_a_remedy():
    outcome, y, *_ = run(OSCILLATOR, [0.0, 60.0], [7.0])
    assert outcome.status == Status.STEP_TOO_SMALL
    assert y[0] == pytest.approx(10.0, abs=1e-9)
    assert "domain" in Status(outcome.status).remedy


@compiled_only
@pytest.mark.compiled
def test_a_march_that_is_too_long_ends_with_a_remedy():
    outcome, *_ = run(OSCILLATOR, START, [1e6], max_step=0.01, log_rows=0)
    assert outcome.status == Status.TOO_MANY_EVALUATIONS
    assert module.MAX_EVALUATIONS < outcome.evaluations <= module.MAX_EVALUATIONS + 6
    assert outcome.evaluations == 6 * (outcome.steps + outcome.rejected + outcome.events)
    assert f"{module.MAX_EVALUATIONS // 10**6} million times, or" in Status(outcome.status).remedy
    assert f"or {module.MAX_EVALUATIONS_TO_PERIODIC // 10**6} million" in Status(outcome.status).remedy


def test_every_status_has_its_text():
    assert REMEDIES.keys() == set(Status)
    assert len({status.remedy for status in Status}) == len(Status)


# --- relaxation towards a force that is switched; two events ---


class Relaxation(NamedTuple):
    time: float = 0.2
    switched: float = 1.0 / 3.0
    hidden: int = 0
    """1: the switch is found out by the clock in `rates`; 0: it is set on entering a stretch."""
    marks: int = 0
    """1: events where the state passes 0.5 and 0.3."""


@rates.for_type(Relaxation)
@kernel
def relaxation_rates(p, t, y, mode, dy):
    force = mode[0]
    if p.hidden:
        force = 1.0 if t > p.switched else 0.0
    dy[0] = (force - y[0]) / p.time
    return True


@start_segment.for_type(Relaxation)
@kernel
def start_relaxation_segment(p, tables, t, t_end, y, mode):
    mode[0] = 1.0 if 0.5 * (t + t_end) > p.switched else 0.0


@events.for_type(Relaxation)
@kernel
def relaxation_events(p, t, y, mode, g):
    g[0] = y[0] - 0.5 if p.marks and mode[1] < 2.0 else -1.0
    g[1] = y[0] - 0.3 if p.marks and mode[1] < 1.0 else -1.0


@handle_event.for_type(Relaxation)
@kernel
def handle_relaxation_event(p, tables, event, t, y, mode):
    mode[1] += 1.0


def relaxed(t):
    return 1.0 - exp(-(t - 1.0 / 3.0) / 0.2)


def test_a_breakpoint_that_is_listed_costs_nothing():
    alone, *_ = run(Relaxation(switched=-1.0), [0.0], [1.0 - 1.0 / 3.0], 1e-8, 10.0)
    outcome, y, *_ = run(Relaxation(), [0.0], [1.0 / 3.0, 1.0], 1e-8, 10.0)
    assert y[0] == pytest.approx(relaxed(1.0), abs=1e-8)
    # The stretch before it, where nothing moves, takes a step of 0.5, then as long as may be.
    assert outcome.rejected <= alone.rejected + 3
    assert outcome.steps <= alone.steps + 6


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_a_breakpoint_that_is_not_listed_is_paid_for_in_steps_and_in_error(tolerance):
    listed, y, *_ = run(Relaxation(), [0.0], [1.0 / 3.0, 1.0], tolerance, 10.0)
    hidden, y_hidden, *_ = run(Relaxation(hidden=1), [0.0], [1.0], tolerance, 10.0)
    # The step shrinks to where the jump of the slope, 1/0.2, does not show: by fifths at best.
    assert hidden.rejected - listed.rejected >= np.log(1.0 / tolerance) / np.log(5.0) / 2.0
    assert abs(y_hidden[0] - relaxed(1.0)) > 2.0 * abs(y[0] - relaxed(1.0))


def test_of_two_events_in_one_step_the_first_one_wins():
    outcome, _, _, log, _ = run(Relaxation(switched=-1.0, marks=1), [0.0], [1.0], 1e-3, 10.0)
    happened = log[(log[:, 1] >= 0) & (log[:, 1] < ZERO_CROSSING)]
    assert happened[:, 1].tolist() == [1.0, 0.0]
    # Times are as good as the tolerance, the states as good as the location.
    assert happened[:, 0] == pytest.approx([-0.2 * ln(0.7), -0.2 * ln(0.5)], abs=1e-3)
    assert happened[:, 3] == pytest.approx([0.3, 0.5], abs=1e-3)
    assert outcome.events == 2


def test_both_marks_lie_within_one_step():
    outcome, *_ = run(Relaxation(switched=-1.0), [0.0], [1.0], 1e-3, 10.0)
    assert outcome.steps < 10


def test_free_fall_from_the_formula():
    assert FALL.limit**2 / FALL.gravity * ln(cosh(FALL.gravity * FALL_TIME / FALL.limit)) == pytest.approx(HEIGHT)
