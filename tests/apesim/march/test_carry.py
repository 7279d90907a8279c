"""A march taken in calls that carry over what the next one needs, beside one that is never left."""

from typing import NamedTuple

import numpy as np
import pytest

from apesim.kernel import kernel
from apesim.march.adaptive import (
    IS_IMPLICIT,
    LAST_ERROR,
    LOG_HEAD,
    MIN_LAST_ERROR,
    NEXT_STEP,
    NO_CARRY,
    REACHED,
    STOP,
    STRETCH_END,
    Accuracy,
    Status,
    begin_carry,
    march,
)
from apesim.march.hybrid_system import events, handle_event, rates, start_segment
from tests.apesim.march.test_adaptive import NoTables

NO_TRACE = np.empty(0), np.empty((0, 0))
SWITCHES = np.array([0.3, 1.1, 2.0])
"""Times at which the force on the mass turns round [s]; the last one ends the march."""


class Pushed(NamedTuple):
    """A damped mass between two elastic stops that a force pushes, the other way in each stretch."""

    rate: float = 1.0
    """Rate of the damping [1/s]."""
    lost: float = 0.0
    """Above 0: the speed from which on the state has left its domain [m/s]."""


@rates.for_type(Pushed)
@kernel
def pushed_rates(p, t, y, mode, dy):
    dy[0] = y[1]
    dy[1] = mode[0] * (1.0 + t) - p.rate * y[1]
    return p.lost == 0.0 or abs(y[1]) < p.lost


@events.for_type(Pushed)
@kernel
def pushed_events(p, t, y, mode, g):
    g[0] = abs(y[0]) - 0.05 if mode[0] * y[0] > 0.0 else -1.0


@handle_event.for_type(Pushed)
@kernel
def handle_pushed_event(p, tables, event, t, y, mode):
    y[1] = -y[1]


@start_segment.for_type(Pushed)
@kernel
def start_pushed_segment(p, tables, t, t_end, y, mode):
    mode[0] = 1.0 if mode[1] % 2.0 == 0.0 else -1.0
    mode[1] += 1.0


def marched(p, ends, tolerance=1e-9, carries=True, until=SWITCHES, log_rows=0, max_step=0.1, state=None):
    """State, modes, what is carried, and the outcomes of the calls that end at `ends` [s]."""
    accuracy = Accuracy(tolerance, max_step, np.ones(2))
    carry = begin_carry(accuracy) if carries else NO_CARRY
    y, mode = np.zeros(2), np.zeros(2)
    outcomes, logs, t = [], [], 0.0
    for end in ends:
        log = np.empty((log_rows, LOG_HEAD + 2))
        if carries:
            carry[STOP] = end
            breakpoints = until
        else:
            breakpoints = np.append(until[(until > t) & (until < end)], end)
        outcomes.append(march(p, NoTables(), t, y, mode, breakpoints, accuracy, log, *NO_TRACE, carry))
        logs.append(log[: outcomes[-1].logged])
        t = end
    return y, mode, carry, outcomes, np.concatenate(logs)


@pytest.mark.parametrize("count", [1, 7, 150])
def test_however_a_march_is_split_it_is_the_same_motion(count):
    ends = np.append(np.sort(np.random.default_rng(count).uniform(0.0, 2.0, count - 1)), 2.0)
    whole, whole_mode, _, (alone,), _ = marched(Pushed(), [2.0], carries=False)
    y, mode, _, outcomes, _ = marched(Pushed(), ends)
    assert alone.events > 2
    assert sum(outcome.events for outcome in outcomes) == alone.events
    assert y == pytest.approx(whole, abs=1e-8)

    # A stretch begins at the breakpoints alone, and each call costs a step that its end cuts short.
    assert mode.tolist() == whole_mode.tolist()
    assert sum(outcome.steps for outcome in outcomes) <= alone.steps + 2 * count


def test_steps_that_the_ends_of_calls_cut_short_do_not_shorten_the_next_one():
    until = np.array([1e9])
    *_, carry, _, _ = marched(Pushed(rate=30.0), [0.2], 1e-11, until=until)
    grown, error = carry[NEXT_STEP], carry[LAST_ERROR]
    *_, carry, outcomes, _ = marched(Pushed(rate=30.0), [0.2, *(0.2 + 1e-4 * np.arange(1, 50))], 1e-11, until=until)
    assert carry[NEXT_STEP] >= grown
    assert carry[LAST_ERROR] == error > MIN_LAST_ERROR
    assert [outcome.steps for outcome in outcomes[1:]] == [1] * 49
    assert carry[STRETCH_END] == 1e9


def test_events_are_located_within_calls_and_noted_where_they_are():
    *_, log = marched(Pushed(), [2.0], carries=False, log_rows=100)
    *_, split = marched(Pushed(), np.linspace(0.0, 2.0, 60)[1:], log_rows=100)
    assert split[:, 1].tolist() == log[:-1, 1].tolist()  # the end of the march alone is missing
    assert split[:, 0] == pytest.approx(log[:-1, 0], abs=1e-8)


def test_copies_of_state_modes_and_what_is_carried_lead_on_to_the_same_bits():
    p, accuracy = Pushed(), Accuracy(1e-7, 0.1, np.ones(2))
    log = np.empty((0, LOG_HEAD + 2))
    y, mode, carry, *_ = marched(p, np.linspace(0.0, 1.0, 23)[1:])
    ends = []
    for _ in range(2):
        arrays = y.copy(), mode.copy()
        again = carry.copy()
        for t, end in ((1.0, 1.01), (1.01, 1.3), (1.3, 1.8)):
            again[STOP] = end
            march(p, NoTables(), t, *arrays, SWITCHES, accuracy, log, *NO_TRACE, again)
        ends.append([*arrays[0], *arrays[1], *again])
    assert ends[0] == ends[1]


def test_the_time_that_a_march_has_reached_is_known_where_it_fails():
    p = Pushed(rate=0.0, lost=0.2)
    _, _, carry, (_, outcome), _ = marched(p, [0.1, 0.28])
    assert outcome.status == Status.STEP_TOO_SMALL
    assert carry[REACHED] == pytest.approx(np.sqrt(1.4) - 1.0, rel=1e-6)
    assert carry[STRETCH_END] == -np.inf


def test_a_stretch_that_has_proved_stiff_stays_so_in_the_next_call():
    *_, carry, outcomes, _ = marched(Pushed(rate=1e5), [0.1, 0.2], tolerance=1e-6)
    assert carry[IS_IMPLICIT] == 1.0
    assert outcomes[0].steps > 10 * outcomes[1].steps
    assert outcomes[1].rejected == 0
