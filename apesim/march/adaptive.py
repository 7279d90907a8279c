"""Adaptive march in time, with located events.

A machine is a NamedTuple of parameters; for its type it registers the kernels of `apesim.march.hybrid_system`, and the
march of that machine is chosen when it is compiled. Its steps are those of `apesim.march.dormand_prince`; in a stretch
that proves stiff, and to the end of that march, those of `apesim.march.rosenbrock`.
"""

from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from apesim.kernel import entry, kernel
from apesim.march.dormand_prince import dense, interpolant, slopes, stages, step_error, stiffness
from apesim.march.hybrid_system import (
    event_count,
    events,
    finish_step,
    handle_event,
    is_final,
    is_followed,
    max_short_steps,
    observe,
    power,
    segment_end,
    start_segment,
    step_share,
    zero_crossings,
)
from apesim.march.rosenbrock import STAGES, implicit_error, implicit_interpolant, implicit_stages, slopes_of_rates


class Status(IntEnum):
    """How a march ended."""

    DONE = 0
    STEP_TOO_SMALL = 1
    TOO_MANY_EVENTS = 2
    TOO_MANY_EVALUATIONS = 3
    STOPPED = 4

    @property
    def remedy(self) -> str:
        """What happened, and what to change."""
        return REMEDIES[self]


TOLERANCE = 1e-7
"""Default tolerance of a step."""
EVENTS = 17
"""Room for the values of events, of a machine that says no other number, and of zero crossings."""
BREAKPOINT, ZERO_CROSSING = -1, 1000
"""Codes in the log: the end of a smooth stretch; zero crossing number n is ZERO_CROSSING + n."""
EVALUATIONS_IN_A_STEP = 6
"""Evaluations of the rates in a step of either method, those at its start being known."""
MAX_EVALUATIONS = 5_000_000
"""Largest number of evaluations of the rates in a march; chosen, as a march that needs more takes some 5 s."""
MAX_EVALUATIONS_TO_PERIODIC = 12_000_000
"""Largest number of evaluations in all cycles to a periodic state; chosen, as they take some 10 to 20 s."""
MAX_EVENTS = 2000
"""Largest number of events of a march; more are chatter."""
SHORT = 0.1
"""Share of the longest step below which a step counts as short."""
STIFF = 2.0
"""Length of a step times the largest slope of the rates above which stability holds it, not accuracy; chosen below 3.3,
about which it swings."""
MIN_STEP = 1e-14
"""Shortest step [s], far below the time in which anything of a machine changes."""
FIRST_STEP = 0.05
"""Length of the first step, over the longest: the error of that step sets the next."""
SAFETY, MIN_FACTOR, MAX_FACTOR = 0.9, 0.2, 5.0
"""Factors of the length from one step to the next: on what the error would allow, and the least and the largest at
once; those of Hairer, Nørsett and Wanner's code DOPRI5 but for the largest, which is 10 there."""
BY_ERROR, BY_LAST_ERROR, BY_IMPLICIT_ERROR = -0.17, 0.04, -0.25
"""Exponents of the error over its tolerance: PI control of the explicit steps, as in DOPRI5 (0.2 less 0.75 * 0.04, and
0.04), and control by the error alone of the implicit ones, which falls with their fourth power."""
BY_REFUSED_ERROR = -0.2
"""Exponent of the error of a step that is rejected, which falls with the fifth power of its length."""
MIN_ERROR, MIN_LAST_ERROR = 1e-10, 1e-4
"""Errors over the tolerance that count at least: of a step, so that no power of 0 is taken, and of the one before it,
so that one very small error does not lengthen two steps."""
OUTSIDE, HOPELESS, MAX_FINITE_ERROR = 0.25, 0.1, 1e300
"""Factors of a step that left the domain of a law, and of one whose error is above the last, or no number."""
MAX_ERROR_TO_EVENT = 10.0
"""Error of a step made again up to an event, over its tolerance, above which it is rejected; the whole step held."""
ROOT_TOLERANCE = 1e-12
"""Error in the time of an event or zero crossing [s]."""
LOG_ROWS, LOG_HEAD = 24_000, 3
"""Room in a log, for an extremum in many a step, too: where a stretch is stiff, the slope of a pressure may change its
sign at every step. Columns before the state: time [s], code, sign of the change."""
REMEDIES = {
    Status.DONE: "done",
    Status.STEP_TOO_SMALL: f"the step fell below {MIN_STEP:g} s: a state left its domain; look for an area too large "
    "for its volume",
    Status.TOO_MANY_EVENTS: f"more than {MAX_EVENTS} events: a contact, dry friction or a flow chatters; lower the "
    "restitution",
    Status.TOO_MANY_EVALUATIONS: f"the rates were evaluated more than {MAX_EVALUATIONS / 1e6:g} million times, or "
    f"{MAX_EVALUATIONS_TO_PERIODIC / 1e6:g} million times to the periodic state: the volumes are too small for their "
    "areas, or the time too long",
    Status.STOPPED: "an event has ended it",
}
"""Text of each status: what happened, and what to change."""


class Accuracy(NamedTuple):
    """Tolerances that the march holds to."""

    tolerance: float
    """Error of a step, relative to scale + abs(y)."""
    max_step: float
    """Longest step [s]; a machine may ask for a shorter one, see `apesim.march.hybrid_system.step_share`."""
    scale: np.ndarray
    """Scale of the error of each integrated state; the ledger behind them is not controlled."""

    def tenfold(self) -> "Accuracy":
        """Return ten times the tolerance, and the longest step as far up as order 5 has it, to see the error change.

        >>> coarse = Accuracy(1e-7, 1e-3, np.ones(1)).tenfold()
        >>> round(coarse.tolerance * 1e6, 6), round(coarse.max_step * 1e3, 3)
        (1.0, 1.585)
        """
        return self._replace(tolerance=10.0 * self.tolerance, max_step=10.0**0.2 * self.max_step)


class Outcome(NamedTuple):
    """How a march went."""

    status: int
    """How it ended, `Status`."""
    steps: int
    """Number of accepted steps."""
    rejected: int
    """Number of rejected steps."""
    evaluations: int
    """Number of evaluations of the rates in all steps, and in those made again up to an event."""
    events: int
    """Number of events."""
    logged: int
    """Number of rows in the log."""
    work: float
    """Quadrature of the power over the dense output [J]."""


STOP, NEXT_STEP, LAST_ERROR, IS_IMPLICIT, SHORT_STEPS, STRETCH_END, REACHED, CARRIED = range(8)
"""Slots of what a march carries from one call to the next: where the call ends [s], given; length of the next step [s];
error of the last one over its tolerance; whether steps are implicit; short steps of the stretch; where the stretch ends
that the call left open [s]; the time reached [s], at a failure too; how many slots there are."""
NO_CARRY = np.empty(0)
"""Nothing is carried: the march ends with its breakpoints."""


def begin_carry(accuracy: Accuracy) -> np.ndarray:
    """Return what a march carries before its first call, (CARRIED,).

    >>> carry = begin_carry(Accuracy(1e-7, 0.1, np.ones(1)))
    >>> round(float(carry[NEXT_STEP]), 6), float(carry[STRETCH_END])
    (0.005, -inf)
    """
    carry = np.zeros(CARRIED)
    carry[NEXT_STEP], carry[LAST_ERROR] = FIRST_STEP * accuracy.max_step, MIN_LAST_ERROR
    carry[STRETCH_END] = -np.inf
    return carry


_NODES = np.array([0.046910077030668, 0.230765344947158, 0.5, 0.769234655052842, 0.953089922969332])
_WEIGHTS = np.array([0.118463442528095, 0.239314335249683, 0.284444444444444, 0.239314335249683, 0.118463442528095])


@kernel(inline=False)
def _value(
    p: Any,
    which: int,
    t: float,
    h: float,
    x: float,
    c: np.ndarray,
    mode: np.ndarray,
    y: np.ndarray,
    dy: np.ndarray,
    g: np.ndarray,
) -> float:
    """Event (which < ZERO_CROSSING) or zero crossing number at the share x of the step."""
    dense(c, x, y)
    if which < ZERO_CROSSING:
        events(p, t + x * h, y, mode, g)
        return g[which]
    slopes(p, t + x * h, y, mode, dy)
    zero_crossings(p, t + x * h, y, dy, mode, g)
    return g[which - ZERO_CROSSING]


@kernel(inline=False)
def _root(
    p: Any,
    which: int,
    t: float,
    h: float,
    low: float,
    f_low: float,
    high: float,
    f_high: float,
    c: np.ndarray,
    mode: np.ndarray,
    y: np.ndarray,
    dy: np.ndarray,
    g: np.ndarray,
) -> float:
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
def _first_event(
    p: Any,
    t: float,
    h: float,
    c: np.ndarray,
    mode: np.ndarray,
    y: np.ndarray,
    dy: np.ndarray,
    g: np.ndarray,
    g_end: np.ndarray,
) -> tuple[int, float]:
    """The first event in a step and its share of the step; (-1, 1) if there is none."""
    found, share = -1, 1.0
    for event in range(g.shape[0]):
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
def _copy(source: np.ndarray, target: np.ndarray) -> None:
    """Element by element: a slice would add seconds to the compiling."""
    for i in range(source.shape[0]):
        target[i] = source[i]


@kernel(inline=False)
def _note(log: np.ndarray, logged: int, t: float, code: float, sign: float, y: np.ndarray) -> int:
    """One row of the log; nothing where it is full (or of no rows: not wanted)."""
    if logged < log.shape[0]:
        log[logged, 0] = t
        log[logged, 1] = code
        log[logged, 2] = sign
        known = min(log.shape[1], LOG_HEAD + y.shape[0])
        for i in range(LOG_HEAD, known):
            log[logged, i] = y[i - LOG_HEAD]
        for i in range(known, log.shape[1]):  # within a step the integrated states alone are known
            log[logged, i] = np.nan
        return logged + 1
    return logged


@kernel(inline=False)
def _locate_zero_crossings(
    p: Any,
    t: float,
    h: float,
    c: np.ndarray,
    mode: np.ndarray,
    y: np.ndarray,
    dy: np.ndarray,
    g: np.ndarray,
    w: np.ndarray,
    w_end: np.ndarray,
    log: np.ndarray,
    logged: int,
) -> int:
    """Note the zero crossings in a step, and take over the values at its end."""
    for i in range(w.shape[0]):
        if w[i] * w_end[i] < 0.0:
            x = _root(p, ZERO_CROSSING + i, t, h, 0.0, w[i], 1.0, w_end[i], c, mode, y, dy, g)
            dense(c, x, y)
            logged = _note(log, logged, t + x * h, ZERO_CROSSING + i, np.sign(w_end[i]), y)
    _copy(w_end, w)
    return logged


@kernel(inline=False)
def _quadrature(p: Any, t: float, h: float, c: np.ndarray, y: np.ndarray) -> float:
    """Integral of the power over a step by Gauss and Legendre's five nodes."""
    work = 0.0
    for i in range(5):
        dense(c, _NODES[i], y)
        work += _WEIGHTS[i] * h * power(p, t + _NODES[i] * h, y)
    return work


@kernel(inline=False)
def _sample(
    p: Any,
    t: float,
    h: float,
    end: float,
    c: np.ndarray,
    mode: np.ndarray,
    y: np.ndarray,
    times: np.ndarray,
    trace: np.ndarray,
    sampled: int,
) -> int:
    """Take the rows of the trace that fall into a step."""
    while sampled < times.shape[0] and times[sampled] <= end:
        dense(c, min(1.0, max(0.0, (times[sampled] - t) / max(h, MIN_STEP))), y)
        observe(p, times[sampled], y, mode, trace[sampled])
        sampled += 1
    return sampled


@kernel
def _step(
    p: Any,
    t: float,
    h: float,
    y: np.ndarray,
    mode: np.ndarray,
    implicit: bool,
    scale: np.ndarray,
    jacobian: np.ndarray,
    k: np.ndarray,
    u: np.ndarray,
    room: np.ndarray,
    trial: np.ndarray,
) -> bool:
    """A step from (t, y), k[0] given; trial ends as the new state, k[6] as its rates. False outside the domain."""
    if implicit:
        return implicit_stages(p, t, h, y, mode, scale, jacobian, k, trial, u, room)
    return stages(p, t, h, y, mode, scale.shape[0], k, trial)


@kernel
def _error(
    h: float, y: np.ndarray, trial: np.ndarray, implicit: bool, k: np.ndarray, u: np.ndarray, accuracy: Accuracy
) -> float:
    """Error of a step over its tolerance."""
    if implicit:
        return implicit_error(y, trial, u, accuracy.tolerance, accuracy.scale)
    return step_error(h, y, trial, k, accuracy.tolerance, accuracy.scale)


@kernel
def _interpolant(
    h: float, y: np.ndarray, trial: np.ndarray, implicit: bool, k: np.ndarray, u: np.ndarray, c: np.ndarray
) -> None:
    """Coefficients of the dense output of a step into c, (5, n)."""
    if implicit:
        implicit_interpolant(y, trial, u, c)
    else:
        interpolant(h, y, trial, k, c)


@entry
def march(
    p: Any,
    tables: Any,
    t: float,
    y: np.ndarray,
    mode: np.ndarray,
    breakpoints: np.ndarray,
    accuracy: Accuracy,
    log: np.ndarray,
    times: np.ndarray,
    trace: np.ndarray,
    carry: np.ndarray,
) -> Outcome:
    """March a machine through its smooth stretches.

    Steps are those of Dormand and Prince's pair of order 5(4) [1]_; in a stretch where stability needs more short ones
    than the machine allows, those of RODAS [2]_. The length of explicit steps is controlled by the errors of a step and
    of the one before (PI control) [3]_, that of implicit ones by the error of a step alone.

    Events end a step where they are located on its dense output [4]_, by the Illinois method [5]_ with a bisection in
    every fourth iteration. The power is integrated over the dense output by Gauss and Legendre's five nodes [6]_.

    A march can be taken in calls that each end at a time of their own, and carry over what the next one needs. Such an
    end is no breakpoint: the smooth stretch goes on behind it, and a step that it cuts short does not shorten the next.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.
    tables : NamedTuple
        Arrays of the machine.
    t : float
        Start [s].
    y : (n,) float array
        State at the start; the state at the end on return.
    mode : (m,) float array
        Modes at the start; the modes at the end on return.
    breakpoints : (j,) float array
        Times at which a smooth stretch ends, ascending; the last one is the end of the march [s].
    accuracy : Accuracy
        Tolerance, longest step and scales.
    log : (l, 3 + i) float array
        Filled with a row for each breakpoint, event and zero crossing: time, code, sign of the change, the i integrated
        states. No rows: nothing is noted, and no work taken by quadrature.
    times : (r,) float array
        When to take rows of the trace, ascending [s].
    trace : (r, q) float array
        Filled by `apesim.march.hybrid_system.observe`; rows that the march does not reach are left as they are.
    carry : (CARRIED,) or (0,) float array
        What is carried from one call to the next, from `begin_carry` on; the call ends at `carry[STOP]`, which is not
        after the last breakpoint. Whoever changes parameters, tables or breakpoints in between sets
        `carry[STRETCH_END]` to -inf: a new stretch begins. Empty: nothing is carried.

    Returns
    -------
    Outcome
        Status and counts.

    References
    ----------
    .. [1] J. R. Dormand and P. J. Prince, "A family of embedded Runge-Kutta formulae", J. Comput. Appl. Math. 6, 1980,
       pp. 19-26, doi 10.1016/0771-050X(80)90013-3.
    .. [2] E. Hairer and G. Wanner, "Solving Ordinary Differential Equations II: Stiff and Differential-Algebraic
       Problems", 2nd ed., Springer, 1996, doi 10.1007/978-3-642-05221-7, IV.7; IV.2 on PI control of the step.
    .. [3] K. Gustafsson, "Control theoretic techniques for stepsize selection in explicit Runge-Kutta methods", ACM
       Trans. Math. Softw. 17, 1991, pp. 533-554, doi 10.1145/210232.210242.
    .. [4] L. F. Shampine and S. Thompson, "Event location for ordinary differential equations", Comput. Math. Appl. 39,
       2000, pp. 43-54, doi 10.1016/S0898-1221(00)00045-6.
    .. [5] M. Dowell and P. Jarratt, "A modified regula falsi method for computing the root of an equation", BIT 11,
       1971, pp. 168-174, doi 10.1007/BF01934364.
    .. [6] M. Abramowitz and I. A. Stegun (eds.), "Handbook of Mathematical Functions", National Bureau of Standards,
       1964, Table 25.4.

    Examples
    --------
    A decay at 2 per second over 1 s, exp(-2) = 0.1353353:

    >>> from typing import NamedTuple
    >>> import numpy as np
    >>> from apesim.kernel import kernel
    >>> from apesim.march.hybrid_system import rates
    >>> class Decay(NamedTuple):
    ...     rate: float
    >>> @rates.for_type(Decay)
    ... @kernel
    ... def decay_rates(p, t, y, mode, dy):
    ...     dy[0] = -p.rate * y[0]
    ...     return True
    >>> p, y, mode = Decay(rate=2.0), np.array([1.0]), np.zeros(1)
    >>> class NoTables(NamedTuple):
    ...     nothing: float = 0.0
    >>> accuracy, log, times = Accuracy(1e-9, 0.1, np.ones(1)), np.empty((0, 4)), np.empty(0)
    >>> outcome = march(p, NoTables(), 0.0, y, mode, np.array([1.0]), accuracy, log, times, np.empty((0, 0)), NO_CARRY)
    >>> Status(outcome.status).name, round(float(y[0]), 7)
    ('DONE', 0.1353353)
    """
    scale = accuracy.scale
    n = scale.shape[0]
    noting = log.shape[0] > 0
    following = noting and is_followed(p)
    carrying = carry.shape[0] > 0

    # Room for stages, dense output, implicit steps and events, once for the whole march: compiled code makes no arrays.
    k, c = np.zeros((7, y.shape[0])), np.zeros((5, n))
    trial, at, slope = y.copy(), np.empty(n), np.empty(y.shape[0])
    u, implicit = np.zeros((STAGES, y.shape[0])), False
    jacobian, room, has_jacobian = np.empty((y.shape[0], n + 1)), np.empty((n, n + 2)), False
    count = event_count(p)
    g, g_end = np.full(count, -1.0), np.full(count, -1.0)
    w, w_end = np.zeros(count), np.zeros(count)
    most_short = max_short_steps(p)
    steps = rejected = evaluations = happened = logged = sampled = 0
    work = 0.0
    last_error, was_rejected = MIN_LAST_ERROR, False
    h_next = FIRST_STEP * accuracy.max_step
    short, stop, breakpoint = 0, np.inf, -np.inf

    # A march that goes on takes up what its last call left; the end of this one is no breakpoint.
    if carrying:
        stop, h_next, last_error = carry[STOP], carry[NEXT_STEP], carry[LAST_ERROR]
        implicit, short, breakpoint = carry[IS_IMPLICIT] > 0.0, int(carry[SHORT_STEPS]), carry[STRETCH_END]
        carry[STRETCH_END], carry[REACHED] = -np.inf, t
    number = 0
    while number < breakpoints.shape[0] and t < stop:
        if breakpoints[number] <= t:
            number += 1
            continue

        # A smooth stretch begins: the rates jump at a breakpoint, so the slopes of the last step are of no use. It may
        # end before the next breakpoint, where the machine has found out on the way.
        if breakpoint <= t:
            breakpoint = segment_end(p, tables, t, breakpoints[number], mode)
            start_segment(p, tables, t, breakpoint, y, mode)
            logged = _note(log, logged, t, BREAKPOINT, 0.0, y)
            short = 0
        slopes(p, t, y, mode, k[0])
        zero_crossings(p, t, y, k[0], mode, w)
        while t < breakpoint and t < stop:
            if evaluations > MAX_EVALUATIONS:
                return Outcome(Status.TOO_MANY_EVALUATIONS, steps, rejected, evaluations, happened, logged, work)

            # The length of the step. The last two to a breakpoint are alike: a tiny last one would cost as much as any.
            max_step = accuracy.max_step * step_share(p, y, mode)
            h = min(h_next, max_step)
            limit = min(breakpoint, stop)
            whole = limit - t
            if h >= whole:
                h = whole
            elif h > 0.5 * whole:
                h = 0.5 * whole
            if h < MIN_STEP and h < whole:
                return Outcome(Status.STEP_TOO_SMALL, steps, rejected, evaluations, happened, logged, work)

            # The step itself. Outside of the domain of a law there is no error to go by: a quarter of the length.
            if implicit and not has_jacobian:
                taken = slopes_of_rates(p, t, h, y, mode, scale, k, trial, jacobian, room)
                evaluations += taken
                has_jacobian = taken > 0
            evaluations += EVALUATIONS_IN_A_STEP
            in_domain = has_jacobian or not implicit
            if not (in_domain and _step(p, t, h, y, mode, implicit, scale, jacobian, k, u, room, trial)):
                rejected += 1
                h_next = OUTSIDE * h
                was_rejected = True
                continue

            # Its error rejects it, or says how long the next may be. After a rejection an implicit one does not grow.
            error = _error(h, y, trial, implicit, k, u, accuracy)
            if not error <= 1.0:
                rejected += 1
                has_size = error < MAX_FINITE_ERROR
                h_next = h * max(MIN_FACTOR, SAFETY * error**BY_REFUSED_ERROR) if has_size else HOPELESS * h
                was_rejected = True
                continue
            least = max(error, MIN_ERROR)
            allowed = max(MIN_FACTOR, SAFETY * least**BY_ERROR * last_error**BY_LAST_ERROR)
            grown = h * min(MAX_FACTOR, allowed)
            if implicit:
                allowed = max(MIN_FACTOR, SAFETY * least**BY_IMPLICIT_ERROR)
                grown = h * min(1.0 if was_rejected else MAX_FACTOR, allowed)
            was_rejected = False
            h_next = max(grown, h_next) if h == whole else grown
            if not (h == whole and stop < breakpoint):  # the end of a call says nothing of the errors of whole steps
                last_error = max(error, MIN_LAST_ERROR)

            # An event within it: the step is made again up to there, as dense output is of a lower order than a step.
            events(p, t + h, trial, mode, g_end)
            event, share = -1, 1.0
            hit = False
            for i in range(count):
                hit = hit or g_end[i] > 0.0
            if hit:
                _interpolant(h, y, trial, implicit, k, u, c)
                event, share = _first_event(p, t, h, c, mode, at, slope, g, g_end)
                h *= share
                again = implicit and h > MIN_STEP  # none of the length 0 can be implicit
                evaluations += EVALUATIONS_IN_A_STEP
                inside = _step(p, t, h, y, mode, again, scale, jacobian, k, u, room, trial)
                if not (inside and _error(h, y, trial, again, k, u, accuracy) <= MAX_ERROR_TO_EVENT):
                    if h < MIN_STEP:
                        return Outcome(Status.STEP_TOO_SMALL, steps, rejected, evaluations, happened, logged, work)
                    rejected += 1
                    h_next = 0.5 * h
                    continue

            # What is read off the step, before its state takes the place of the one before.
            steps += 1
            end = limit if event < 0 and h == whole else t + h
            sampling = sampled < times.shape[0] and times[sampled] <= end
            if following or sampling:
                _interpolant(h, y, trial, implicit, k, u, c)
            if following:
                zero_crossings(p, t + h, trial, k[6], mode, w_end)
                logged = _locate_zero_crossings(p, t, h, c, mode, at, slope, g, w, w_end, log, logged)
                work += _quadrature(p, t, h, c, at)
            if sampling:
                sampled = _sample(p, t, h, end, c, mode, at, times, trace, sampled)

            finish_step(p, t, h, y, k[0], trial, k[6], mode)

            # Whether it was stability that held it short. A stretch that proves stiff stays so to the end of the march:
            # to go back would mean to prove it again.
            if not implicit and h < SHORT * max_step:
                short += stiffness(h, y, trial, k, scale) > STIFF
                implicit = short > most_short
            t, has_jacobian = end, False
            _copy(trial, y)
            if carrying:
                carry[REACHED] = t
            if event < 0:
                _copy(k[6], k[0])
                continue

            # The event changes state or mode, and with them the slopes.
            happened += 1
            if happened > MAX_EVENTS:
                return Outcome(Status.TOO_MANY_EVENTS, steps, rejected, evaluations, happened, logged, work)
            logged = _note(log, logged, t, event, 0.0, y)
            handle_event(p, tables, event, t, y, mode)
            if is_final(p, event, mode):
                return Outcome(Status.STOPPED, steps, rejected, evaluations, happened, logged, work)
            breakpoint = segment_end(p, tables, t, breakpoints[number], mode)
            slopes(p, t, y, mode, k[0])
            zero_crossings(p, t, y, k[0], mode, w)
    if carrying:
        carry[NEXT_STEP], carry[LAST_ERROR], carry[STRETCH_END] = h_next, last_error, breakpoint
        carry[IS_IMPLICIT], carry[SHORT_STEPS] = 1.0 if implicit else 0.0, short
    else:
        logged = _note(log, logged, t, BREAKPOINT, 0.0, y)
    return Outcome(Status.DONE, steps, rejected, evaluations, happened, logged, work)
