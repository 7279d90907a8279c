"""The one adaptive march in time, with dense output and located events.

Dormand and Prince's 5(4) pair (J. Comp. Appl. Math. 6, 1980, 19) with the interpolant of Hairer, Norsett and
Wanner, Solving Ordinary Differential Equations I, II.6. A machine is a NamedTuple of parameters; for its type it
registers the kernels below, and the march of that machine is chosen when it is compiled.

The state ``y`` holds the integrated states first, and behind them the ledger: quantities that are integrated
beside the states and act on nothing. ``mode`` holds what jumps between smooth stretches and is constant within one:
the phase of a contact, the piece of a table in use. A machine's parameters ``p`` are numbers only; its arrays travel
apart, as ``tables``, and are looked at on entering a stretch: a reference counted array in a tuple that is handed
from law to law costs more than the laws.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from apesim.kernel import by_type, kernel


@by_type
def rates(p, t, y, mode, dy):
    """Write dy/dt into dy; False where the state has left its domain."""
    return False


@by_type
def events(p, t, y, mode, g):
    """Write into g what ends a step where it rises above zero: contacts, lift-offs, corners of a table."""


@by_type
def respond(p, tables, event, t, y, mode):
    """Change y and mode at an event."""


@by_type
def watch(p, t, y, dy, mode, w):
    """Write into w what is located where it changes its sign, and noted, without ending a step."""


@by_type
def enter(p, tables, t, t_end, y, mode):
    """Set mode on entering the smooth stretch from t to t_end."""


@by_type
def power(p, t, y):
    """The power whose integral is also taken by quadrature of the dense output [W]."""
    return 0.0


@by_type
def observe(p, t, y, mode, row):
    """Write one row of a trace."""


class Status(IntEnum):
    """How a march ended."""

    DONE = 0
    STEP_TOO_SMALL = 1
    TOO_MANY_EVENTS = 2
    TOO_MANY_STEPS = 3

    @property
    def remedy(self):
        """What happened, and what to change."""
        return REMEDIES[self]


REMEDIES = {
    Status.DONE: "done",
    Status.STEP_TOO_SMALL: "the step fell below 1e-14 s: a state left its domain; look for an area too large for its "
    "volume",
    Status.TOO_MANY_EVENTS: "more than 2000 events: a contact or a dry friction chatters; lower the restitution",
    Status.TOO_MANY_STEPS: "more than 2 million steps: the volumes are too small for their areas, or the time too long",
}

TOLERANCE = 1e-7
"""Default tolerance of a step."""
EVENTS = 6
"""Room for the values of events and of watches."""
KINK, WATCH = -1, 100
"""Codes in the log: the end of a smooth stretch; watch number n is WATCH + n."""
STEPS_MOST = 2_000_000
EVENTS_MOST = 2000
STEP_LEAST = 1e-14
ROOT_TOLERANCE = 1e-12
LOG_ROWS, LOG_HEAD = 4000, 3
"""Room in a log; columns before the state: time [s], code, sign of the change."""


class Accuracy(NamedTuple):
    """What the march holds to."""

    tolerance: float
    """Error of a step, relative to scale + abs(y)."""
    step_most: float
    """Longest step [s]."""
    scale: np.ndarray
    """One for each integrated state; the ledger behind them is not controlled."""


class Outcome(NamedTuple):
    """How a march went."""

    status: int
    steps: int
    rejected: int
    events: int
    logged: int
    work: float
    """Quadrature of `power` over the dense output [J]."""


_NODES = np.array([0.046910077030668, 0.230765344947158, 0.5, 0.769234655052842, 0.953089922969332])
_WEIGHTS = np.array([0.118463442528095, 0.239314335249683, 0.284444444444444, 0.239314335249683, 0.118463442528095])


@kernel(inline=False)
def _slope(p, t, y, mode, dy):
    """`rates`, laid down once for all callers but the stages."""
    return rates(p, t, y, mode, dy)


@kernel(inline=False)
def _stages(p, t, h, y, mode, n, k, trial):
    """Stages 2 to 7 of a step from (t, y), k[0] given; trial ends as the new state. False outside the domain.

    A loop, so that `rates` is laid down once.
    """
    for s in range(1, 7):
        if s == 1:
            c = 0.2
            for i in range(n):
                trial[i] = y[i] + h * (k[0, i] / 5.0)
        elif s == 2:
            c = 0.3
            for i in range(n):
                trial[i] = y[i] + h * (3.0 / 40.0 * k[0, i] + 9.0 / 40.0 * k[1, i])
        elif s == 3:
            c = 0.8
            for i in range(n):
                trial[i] = y[i] + h * (44.0 / 45.0 * k[0, i] - 56.0 / 15.0 * k[1, i] + 32.0 / 9.0 * k[2, i])
        elif s == 4:
            c = 8.0 / 9.0
            for i in range(n):
                trial[i] = y[i] + h * (
                    19372.0 / 6561.0 * k[0, i]
                    - 25360.0 / 2187.0 * k[1, i]
                    + 64448.0 / 6561.0 * k[2, i]
                    - 212.0 / 729.0 * k[3, i]
                )
        elif s == 5:
            c = 1.0
            for i in range(n):
                trial[i] = y[i] + h * (
                    9017.0 / 3168.0 * k[0, i]
                    - 355.0 / 33.0 * k[1, i]
                    + 46732.0 / 5247.0 * k[2, i]
                    + 49.0 / 176.0 * k[3, i]
                    - 5103.0 / 18656.0 * k[4, i]
                )
        else:
            for i in range(y.shape[0]):
                trial[i] = y[i] + h * (
                    35.0 / 384.0 * k[0, i]
                    + 500.0 / 1113.0 * k[2, i]
                    + 125.0 / 192.0 * k[3, i]
                    - 2187.0 / 6784.0 * k[4, i]
                    + 11.0 / 84.0 * k[5, i]
                )
        if not rates(p, t + c * h, trial, mode, k[s]):
            return False
    return True


@kernel(inline=False)
def _error(h, y, trial, k, tolerance, scale):
    """Root mean square of the error estimate over its tolerance."""
    total = 0.0
    for i in range(scale.shape[0]):
        e = h * (
            71.0 / 57600.0 * k[0, i]
            - 71.0 / 16695.0 * k[2, i]
            + 71.0 / 1920.0 * k[3, i]
            - 17253.0 / 339200.0 * k[4, i]
            + 22.0 / 525.0 * k[5, i]
            - 1.0 / 40.0 * k[6, i]
        )
        ratio = e / (tolerance * (scale[i] + max(abs(y[i]), abs(trial[i]))))
        total += ratio * ratio
    return np.sqrt(total / scale.shape[0])


@kernel(inline=False)
def _interpolant(h, y, trial, k, c):
    """Coefficients of the dense output of a step into c, (5, n)."""
    for i in range(c.shape[1]):
        rise = trial[i] - y[i]
        bend = h * k[0, i] - rise
        c[0, i] = y[i]
        c[1, i] = rise
        c[2, i] = bend
        c[3, i] = rise - h * k[6, i] - bend
        c[4, i] = h * (
            -12715105075.0 / 11282082432.0 * k[0, i]
            + 87487479700.0 / 32700410799.0 * k[2, i]
            - 10690763975.0 / 1880347072.0 * k[3, i]
            + 701980252875.0 / 199316789632.0 * k[4, i]
            - 1453857185.0 / 822651844.0 * k[5, i]
            + 69997945.0 / 29380423.0 * k[6, i]
        )


@kernel(inline=False)
def _dense(c, x, out):
    """The interpolant at the share x of the step."""
    u = 1.0 - x
    for i in range(c.shape[1]):
        out[i] = c[0, i] + x * (c[1, i] + u * (c[2, i] + x * (c[3, i] + u * c[4, i])))


@kernel(inline=False)
def _value(p, which, t, h, x, c, mode, y, dy, g):
    """Event (which < WATCH) or watch number at the share x of the step."""
    _dense(c, x, y)
    if which < WATCH:
        events(p, t + x * h, y, mode, g)
        return g[which]
    _slope(p, t + x * h, y, mode, dy)
    watch(p, t + x * h, y, dy, mode, g)
    return g[which - WATCH]


@kernel(inline=False)
def _root(p, which, t, h, low, f_low, high, f_high, c, mode, y, dy, g):
    """Root between the shares low and high by the Illinois method, bisecting where it stalls."""
    side = 0
    for i in range(100):
        if (high - low) * h < ROOT_TOLERANCE:
            break
        if i % 4 == 3:
            x = 0.5 * (low + high)
        else:
            x = (low * f_high - high * f_low) / (f_high - f_low)
            if not low < x < high:
                x = 0.5 * (low + high)
        f = _value(p, which, t, h, x, c, mode, y, dy, g)
        if f == 0.0:
            return x
        if (f > 0.0) == (f_high > 0.0):
            high, f_high = x, f
            if side == 1:
                f_low *= 0.5
            side = 1
        else:
            low, f_low = x, f
            if side == -1:
                f_high *= 0.5
            side = -1
    return high


@kernel(inline=False)
def _first_event(p, t, h, c, mode, y, dy, g, g_end):
    """The first event in a step and its share of the step; (-1, 1) if there is none."""
    found, share = -1, 1.0
    for event in range(EVENTS):
        if g_end[event] <= 0.0:
            continue
        low = 0.0
        f_low = _value(p, event, t, h, low, c, mode, y, dy, g)
        if f_low >= 0.0:
            x = 1.0
            for _ in range(40):
                x *= 0.5
                f = _value(p, event, t, h, x, c, mode, y, dy, g)
                if f < 0.0:
                    low, f_low = x, f
                    break
        x = 0.0
        if f_low < 0.0:
            x = _root(p, event, t, h, low, f_low, 1.0, g_end[event], c, mode, y, dy, g)
        if found < 0 or x < share:
            found, share = event, x
    return found, share


@kernel
def _copy(source, target):
    """Element by element: a slice would add seconds to the compiling."""
    for i in range(source.shape[0]):
        target[i] = source[i]


@kernel(inline=False)
def _note(log, logged, t, code, sign, y):
    """One row of the log; nothing where it is full (or of no rows: not wanted)."""
    if logged < log.shape[0]:
        log[logged, 0] = t
        log[logged, 1] = code
        log[logged, 2] = sign
        for i in range(LOG_HEAD, log.shape[1]):
            log[logged, i] = y[i - LOG_HEAD]
        return logged + 1
    return logged


@kernel(inline=False)
def march(p, tables, t, y, mode, kinks, accuracy, log, times, trace):
    """March a machine through its smooth stretches.

    Parameters
    ----------
    p : NamedTuple
        The machine.
    tables : NamedTuple
        Its arrays.
    t : float
        Start [s].
    y : (n,) float array
        State at the start; the state at the end on return.
    mode : (m,) float array
        Likewise.
    kinks : (j,) float array
        Times at which a smooth stretch ends, ascending; the last one is the end of the march [s].
    accuracy : Accuracy
    log : (l, 3 + i) float array
        Filled with a row for each kink, event and watch: time, code, sign of the change, the i integrated states. No
        rows: nothing is noted, and no work taken by quadrature.
    times : (r,) float array
        When to take rows of the trace, ascending [s].
    trace : (r, q) float array
        Filled by `observe`; rows that the march does not reach are left as they are.

    Returns
    -------
    Outcome
    """
    scale = accuracy.scale
    n = scale.shape[0]
    noting = log.shape[0] > 0
    k, c = np.zeros((7, y.shape[0])), np.zeros((5, n))
    trial, at, slope = y.copy(), np.empty(n), np.empty(y.shape[0])
    g, g_end = np.full(EVENTS, -1.0), np.full(EVENTS, -1.0)
    w, w_end = np.zeros(EVENTS), np.zeros(EVENTS)
    steps = rejected = happened = logged = sampled = 0
    work = 0.0
    last_error = 1e-4
    h_next = 0.05 * accuracy.step_most
    for kink in kinks:
        if kink <= t:
            continue
        enter(p, tables, t, kink, y, mode)
        _slope(p, t, y, mode, k[0])
        watch(p, t, y, k[0], mode, w)
        logged = _note(log, logged, t, KINK, 0.0, y)
        while t < kink:
            if steps + rejected > STEPS_MOST:
                return Outcome(Status.TOO_MANY_STEPS, steps, rejected, happened, logged, work)
            h = min(h_next, accuracy.step_most)
            whole = kink - t
            if h >= whole:
                h = whole
            elif h > 0.5 * whole:
                h = 0.5 * whole
            if h < STEP_LEAST and h < whole:
                return Outcome(Status.STEP_TOO_SMALL, steps, rejected, happened, logged, work)
            if not _stages(p, t, h, y, mode, n, k, trial):
                rejected += 1
                h_next = 0.25 * h
                continue
            error = _error(h, y, trial, k, accuracy.tolerance, scale)
            if not error <= 1.0:
                rejected += 1
                h_next = h * max(0.2, 0.9 * error**-0.2) if error < 1e300 else 0.1 * h
                continue
            grown = h * min(5.0, max(0.2, 0.9 * max(error, 1e-10) ** -0.17 * last_error**0.04))
            h_next = max(grown, h_next) if h == whole else grown
            last_error = max(error, 1e-4)
            events(p, t + h, trial, mode, g_end)
            event, share = -1, 1.0
            hit = False
            for i in range(EVENTS):
                hit = hit or g_end[i] > 0.0
            if hit:
                _interpolant(h, y, trial, k, c)
                event, share = _first_event(p, t, h, c, mode, at, slope, g, g_end)
                h *= share
                if not _stages(p, t, h, y, mode, n, k, trial):
                    return Outcome(Status.STEP_TOO_SMALL, steps, rejected, happened, logged, work)
            steps += 1
            end = kink if event < 0 and h == whole else t + h
            sampling = sampled < times.shape[0] and times[sampled] <= end
            if noting or sampling:
                _interpolant(h, y, trial, k, c)
            if noting:
                watch(p, t + h, trial, k[6], mode, w_end)
                for i in range(EVENTS):
                    if w[i] * w_end[i] < 0.0:
                        x = _root(p, WATCH + i, t, h, 0.0, w[i], 1.0, w_end[i], c, mode, at, slope, g)
                        _dense(c, x, at)
                        logged = _note(log, logged, t + x * h, WATCH + i, np.sign(w_end[i]), at)
                _copy(w_end, w)
                for i in range(5):
                    _dense(c, _NODES[i], at)
                    work += _WEIGHTS[i] * h * power(p, t + _NODES[i] * h, at)
            while sampled < times.shape[0] and times[sampled] <= end:
                _dense(c, min(1.0, max(0.0, (times[sampled] - t) / max(h, STEP_LEAST))), at)
                observe(p, times[sampled], at, mode, trace[sampled])
                sampled += 1
            t = end
            _copy(trial, y)
            if event < 0:
                _copy(k[6], k[0])
                continue
            happened += 1
            if happened > EVENTS_MOST:
                return Outcome(Status.TOO_MANY_EVENTS, steps, rejected, happened, logged, work)
            logged = _note(log, logged, t, event, 0.0, y)
            respond(p, tables, event, t, y, mode)
            _slope(p, t, y, mode, k[0])
            watch(p, t, y, k[0], mode, w)
    logged = _note(log, logged, t, KINK, 0.0, y)
    return Outcome(Status.DONE, steps, rejected, happened, logged, work)
