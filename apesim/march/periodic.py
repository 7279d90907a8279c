"""Periodic state of a machine that is driven in cycles."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from apesim.march.acceleration import Secants, way_left
from apesim.march.adaptive import LOG_HEAD, MAX_EVALUATIONS_TO_PERIODIC, NO_CARRY, Accuracy, Outcome, Status, march

PERIODIC_TOLERANCE = 1e-8
"""Default largest change of a state over a cycle that counts as periodic, relative."""
MAX_CYCLES = 2500
"""Largest number of cycles; chosen: stores that fill slowly need up to some 2000, which are cheap in most of them."""
NOISE = 100.0
"""Tolerances of a step below which two cycles differ by the solver's error."""
SAME = 10.0
"""Tolerances of a step below which a change is no more than the solver's error, where the state is known to be near."""
PATIENCE = 60
"""Cycles after which a change of `SAME` is good enough."""
BURST = 15
"""Plain cycles before the march is helped by Newton's method, and between two such helps."""
REST_CYCLES = 10
"""Last of those cycles, over which a state that only the solver's error moves is no farther than in one of them."""
NEARER = 0.9
"""Share of a change that is clearly less."""
MAX_DISTANCE = 10.0
"""Estimated distance from the periodic state, over the tolerance, up to which plain cycles alone are believed."""
SWINGING = -0.5
"""Factor by which a deviation falls from cycle to cycle, below which a machine near by may settle otherwise."""
MAX_CORRECTIONS = 12
"""Largest number of cycles from a known state, before it counts as too far away."""
LOOSE = 1e-9
"""A state whose map differs from the identity by less is held, as a piston on its stop."""
FREE = 1.0
"""Largest size of the first mode of what is not held."""
CLIP = 0.3
"""Longest step of Newton's method in any state, relative."""
MAX_NEAR_CYCLES = 100
"""Cycles after which a state counts as far away, and implicit steps of many cycles lead there."""
FIRST_LEAP, MAX_LEAP = 4.0, 1e8
"""Cycles of the first such step, before it grows, and of the longest, which is a step of Newton's method."""
MAX_PERIOD = 24
"""Cycles after which a state may repeat; chosen."""
MAX_PERIODS = 5
"""Such periods, of the longest, that are waited for."""
FAINT = 0.5
"""Change over a period, over that of a cycle or two, below which more cycles may show that the state repeats."""
MAX_SETTLING_CYCLES = 1e6
"""Cycles of a short step from which on no slower state is waited for."""
FINE, FINE_NUDGE = 1e-1, 1e-6
"""Tolerance of the slopes for such steps, over the usual one, and relative change of a state: states that settle in ten
thousand cycles are to be told from those that never do, and flows between nearly equal pressures are to stay such."""
MAX_VAIN_STEPS = 12.0
"""Such steps in a row that do not halve what a cycle gains, at most; Newton's method may do better."""
LONG_STEP, VAIN_IF_LONG = 0.1, 0.2
"""Length of a step that leads far, relative, and for how much it counts among those: a gain may hardly fall there."""
BACK = 0.5
"""Share of the step before, above which one that turns back leads past where both should lead."""
FORETOLD = 0.3
"""Error of the foretold gain, over the gain, up to which slopes of a state near by are kept, and long steps follow."""
MAX_SHORT_STEPS = 5
"""Short steps behind a long one, at most."""
ROUGH_LEAP = 1e3
"""Cycles up to which the usual slopes will do, of such a step or in which all that is not held settles."""
GROWTH = 4.0
"""Factor by which such a step may grow from one to the next."""
NUDGE = 1e-3
"""Relative change of a state for a difference of the cycle's map."""
ENOUGH = 24
"""Accelerated cycles at most; where they do not do, the search begins anew."""
VAIN = 6
"""Such cycles in a row that do not halve a gain within the solver's error, at most; the search goes on from there."""
REPELLING = 1.001
"""Modulus of a multiplier from which on accelerated cycles may have come to a state that repels."""


class Known(NamedTuple):
    """Periodic state from which those of machines that differ a little are near."""

    y: np.ndarray
    """State at the start of the cycle."""
    mode: np.ndarray
    """Modes at the start of the cycle."""
    correction: np.ndarray
    """Matrix (n, n): times what a state gains over a cycle, it is the way to the periodic state; both relative."""
    rough: bool = False
    """Whether the correction is of a machine that differs by more than a little, and has to learn on the way."""


class Record(NamedTuple):
    """Arrays that a march through a cycle writes, see `apesim.march.adaptive.march`."""

    log: np.ndarray
    """Rows for breakpoints, events and zero crossings."""
    times: np.ndarray
    """When to take rows of the trace [s]."""
    trace: np.ndarray
    """Rows of the trace."""


class Recorded(NamedTuple):
    """A cycle that was marched, with what was written of it."""

    log: np.ndarray
    """Rows for breakpoints, events and zero crossings, as many as there were."""
    trace: np.ndarray
    """Rows of the trace."""
    end: np.ndarray
    """State at the end of the cycle."""
    outcome: Outcome
    """Outcome of the march."""


NO_RECORD = Record(np.empty((0, 0)), np.empty(0), np.empty((0, 0)))
"""Arrays of no rows, for a march of which nothing is written."""
NOT_MARCHED = Outcome(Status.DONE, 0, 0, 0, 0, 0, 0.0)
"""Outcome before the first cycle."""


class Orbit(NamedTuple):
    """State that a machine settles to."""

    y: np.ndarray
    """State at the start of the cycle; the ledger behind it is zero."""
    mode: np.ndarray
    """Modes at the start of the cycle."""
    converged: bool
    """Whether the state was seen to repeat."""
    period: int
    """Cycles after which the state repeats, up to `MAX_PERIOD`; 0 where it was not seen to repeat."""
    cycles: int
    """Number of cycles marched in all."""
    change: float
    """Largest change of a state over the last cycle, relative to scale + abs(state)."""
    change_of_two: float
    """Largest change of a state over the last two cycles, relative to scale + abs(state)."""
    status: int
    """Status of the last march, `apesim.march.adaptive.Status`."""
    known: Known | None = None
    """Start for the next machine, where accelerated cycles showed the way here, or this one was reached from a known
    state; None: it cannot be one."""
    recorded: Recorded | None = None
    """Cycle from the periodic state; None: it was not recorded on the way."""


def distance(a: np.ndarray, b: np.ndarray, scale: np.ndarray) -> float:
    """Return the largest difference of two states (m,), relative to scale + abs(state), the larger of the two.

    `scale` (n,) holds the scale of the error of each integrated state; only the first n elements count.
    """
    n = len(scale)
    sizes = scale + np.maximum(np.abs(a[:n]), np.abs(b[:n]))
    return float(np.max(np.abs(a[:n] - b[:n]) / sizes))


class Drive:
    """Machine with the cycle that it is driven in; counts what is marched."""

    phases: Sequence[int] = (0,)
    """Elements of the modes that are phases of pistons: held where their size is above `FREE`."""

    def __init__(self, p: Any, tables: Any, breakpoints: np.ndarray, accuracy: Accuracy) -> None:
        self.p, self.tables, self.breakpoints, self.accuracy = p, tables, breakpoints, accuracy
        self.log = np.empty((0, LOG_HEAD + len(accuracy.scale)))
        self.cycles = self.evaluations = 0
        self.outcome = NOT_MARCHED

    def clear_ledger(self, y: np.ndarray) -> None:
        """Let what is summed up behind the states begin anew, as at the start of a cycle; changes `y` (m,)."""
        y[len(self.accuracy.scale) :] = 0.0

    def march(
        self, y: np.ndarray, mode: np.ndarray, count: int = 1, record: Record = NO_RECORD
    ) -> tuple[np.ndarray, np.ndarray, int]:
        """March some cycles; return state (m,) and modes (k,) at the end, and the last `apesim.march.adaptive.Status`.

        `y` and `mode` stay as they are, the arrays of `record` are written; the ledger in the returned state is that of
        the last cycles.
        """
        y, mode = y.copy(), mode.copy()
        self.clear_ledger(y)
        status: int = Status.DONE
        while count and status == Status.DONE:
            count -= 1
            status = self.march_once(y, mode, record)
            self.cycles += 1
            self.evaluations += self.outcome.evaluations
            if self.evaluations > MAX_EVALUATIONS_TO_PERIODIC:
                status = Status.TOO_MANY_EVALUATIONS
        return y, mode, status

    def march_once(self, y: np.ndarray, mode: np.ndarray, record: Record) -> int:
        """March one cycle, whose state (m,) and modes (k,) are changed; return its `apesim.march.adaptive.Status`."""
        log = record.log if len(record.log) else self.log
        self.outcome = march(
            self.p,
            self.tables,
            0.0,
            y,
            mode,
            self.breakpoints,
            self.accuracy,
            log,
            record.times,
            record.trace,
            NO_CARRY,
        )
        return self.outcome.status

    @contextmanager
    def finer_steps(self) -> Iterator[None]:
        """Hold the steps of cycles to the share `FINE` of their tolerance, as long as the context lasts.

        >>> drive = Drive(None, None, np.array([1.0]), Accuracy(1e-7, 0.1, np.ones(1)))
        >>> with drive.finer_steps():
        ...     print(f"{drive.accuracy.tolerance:.0e}")
        1e-08
        >>> drive.accuracy.tolerance
        1e-07
        """
        usual = self.accuracy
        self.accuracy = usual._replace(tolerance=FINE * usual.tolerance)
        try:
            yield
        finally:
            self.accuracy = usual


class Settling(NamedTuple):
    """Result of some plain cycles."""

    y: np.ndarray
    """State at the end."""
    mode: np.ndarray
    """Modes at the end."""
    status: int
    """Status of the last march."""
    change: float
    """Largest change of a state over the last cycle, relative."""
    change_of_two: float
    """Largest change of a state over the last two cycles, relative."""
    period: int
    """Cycles after which the state repeats, else 0."""
    correction: np.ndarray | None = None
    """Correction of a state, see `Known`; None: not known."""
    recorded: Recorded | None = None
    """Cycle from `y`; None: it was not recorded."""


def _plain_cycles(
    drive: Drive, y: np.ndarray, mode: np.ndarray, tolerance: float, max_cycles: int, sure: bool
) -> Settling:
    """March plain cycles until two in a row repeat the state, or four in a row that of two cycles before, or the most.

    Where `sure`, a small change is enough; else what is still to go has to be small, too.
    """
    noise = NOISE * drive.accuracy.tolerance
    before = before_that = first = None
    change = change_of_two = np.inf
    largest = 0.0
    repeats = repeats_of_two = period = 0
    for i in range(max_cycles):
        before_that, before = before, (y, mode)
        first = before if i == BURST - REST_CYCLES else first
        earlier, earlier_of_two = change, change_of_two
        y, mode, status = drive.march(y, mode)
        if status != Status.DONE:
            return Settling(y, mode, status, change, change_of_two, 0)
        change = _change(drive, before, y, mode)
        change_of_two = _change(drive, before_that, y, mode)
        largest = max(largest, change) if first else 0.0
        repeats = repeats + 1 if _is_small(change, earlier, tolerance, sure) else 0
        repeats_of_two = repeats_of_two + 1 if _is_small(change_of_two, earlier_of_two, tolerance, sure) else 0
        if repeats >= 2 or repeats_of_two >= 4:
            # What stays within the solver's error is no difference.
            period = 1 if repeats >= 2 or change <= noise else 2
            break
    if not period and i == BURST - 1 and drive.cycles >= PATIENCE and largest <= SAME * drive.accuracy.tolerance:
        # A drift adds up over the cycles, the solver's error does not.
        period = 1 if _change(drive, first, y, mode) <= largest else 0
    return Settling(y, mode, status, change, change_of_two, period)


def _is_other_phase(drive: Drive, before: np.ndarray, after: np.ndarray) -> bool:
    """Whether what was held is free, or the reverse; what is free may hover, and move either way."""
    return any((abs(before[i]) > FREE) != (abs(after[i]) > FREE) for i in drive.phases)


def _is_held_elsewhere(drive: Drive, before: np.ndarray, after: np.ndarray) -> bool:
    """Whether a piston that is held is held on the other side."""
    return any(before[i] != after[i] and min(abs(before[i]), abs(after[i])) > FREE for i in drive.phases)


def _change(drive: Drive, earlier: tuple[np.ndarray, np.ndarray] | None, y: np.ndarray, mode: np.ndarray) -> float:
    """Distance from an earlier state and mode; infinite where the phase differs or there was none."""
    if earlier is None or _is_other_phase(drive, earlier[1], mode):
        return np.inf
    return distance(earlier[0], y, drive.accuracy.scale)


def _is_small(change: float, earlier: float, tolerance: float, sure: bool) -> bool:
    """Whether a change is, and, if that is not enough, what is to go where changes fall by one factor for ever."""
    if change > tolerance or change == 0.0:
        return change == 0.0
    return sure or way_left(change, earlier) <= MAX_DISTANCE * tolerance


def _newton(drive: Drive, y: np.ndarray, mode: np.ndarray, count: int) -> np.ndarray | None:
    """Take one Newton step towards the fixed point of the map of some cycles; None where there is none to take.

    That is so where the cycles change the mode or fail, so that the map has no slope; or where the slope repels, so
    that the fixed point is none that a machine settles to.
    """
    found = _linear_map(drive, y, mode, count)
    if found is None or _swings(drive, found) or found.repelled > _error(drive):
        return None
    return _after(found.y, _correction(found.slopes) @ found.gain, found.sizes)


@dataclass(frozen=True, eq=False)
class Linear:
    """The map of some cycles near a state, as slopes and what the state gains there."""

    y: np.ndarray
    """State that it is taken at."""
    sizes: np.ndarray
    """What changes of the state are related to."""
    slopes: np.ndarray
    """Slopes of the map, relative, (n, n)."""
    gain: np.ndarray
    """What the state gains, relative."""

    @cached_property
    def multipliers(self) -> np.ndarray:
        """Eigenvalues of the slopes."""
        return np.linalg.eigvals(self.slopes)

    @property
    def repelled(self) -> float:
        """Largest real part of a multiplier, less 1: above 0 a state is repelled."""
        return float(self.multipliers.real.max()) - 1.0

    @property
    def settles_in(self) -> float:
        """Cycles in which the slowest state that is not held comes nearer to where it settles by a factor of e."""
        left = np.abs(self.multipliers - 1.0)
        return 1.0 / min(left[left > LOOSE], default=np.inf)


def _error(drive: Drive) -> float:
    """Error of a multiplier by the usual differences."""
    return drive.accuracy.tolerance / NUDGE


def _swings(drive: Drive, found: Linear) -> bool:
    """Whether a deviation changes its sign and grows, or turns and grows: no step of many cycles follows that."""
    return np.abs(found.multipliers).max() > 1.0 + max(found.repelled, _error(drive))


def _after(y: np.ndarray, step: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """State after a relative step, each of whose elements is clipped."""
    y = y.copy()
    y[: len(step)] += np.clip(step, -CLIP, CLIP) * sizes
    return y


def _image(drive: Drive, y: np.ndarray, mode: np.ndarray, count: int = 1) -> np.ndarray | None:
    """State after some cycles; None where they fail or change the phase."""
    image, mode_image, status = drive.march(y, mode, count)
    return None if status != Status.DONE or _is_other_phase(drive, mode, mode_image) else image


def _linear_map(
    drive: Drive, y: np.ndarray, mode: np.ndarray, count: int = 1, nudge: float = NUDGE, image: np.ndarray | None = None
) -> Linear | None:
    """Return the map of some cycles near a state, by differences; None where it has no slopes.

    `image` is the image of the state, where it is known.
    """
    n, sizes = len(drive.accuracy.scale), _sizes(drive, y)
    image = _image(drive, y, mode, count) if image is None else image
    if image is None:
        return None
    slopes = np.zeros((n, n))
    for i in range(n):
        nudged = y.copy()
        nudged[i] -= nudge * sizes[i]
        other = _image(drive, nudged, mode, count)
        if other is None:
            return None
        slopes[:, i] = (image[:n] - other[:n]) / sizes / nudge
    return Linear(y, sizes, slopes, (image[:n] - y[:n]) / sizes)


def _linear(
    drive: Drive, y: np.ndarray, mode: np.ndarray, is_fine: bool, known: Linear | None, error: float
) -> Linear | None:
    """Return the map of a cycle near the image of a state, by differences, fine or usual; None where it has no slopes.

    In the image those states have settled that do so at once: what a long step leaves of them would hide the slow ones.
    Fine means steps held to the share `FINE` of their tolerance, and a nudge to `FINE_NUDGE`. Slopes of `known`, the
    map of a state near by, are kept where the gain that it foretells is off by at most the share `error`. Fine ones
    that swing may be taken across the edge of a law: then they are taken to the other side.
    """
    with drive.finer_steps() if is_fine else nullcontext():
        settled = _image(drive, y, mode)
        image = None if settled is None else _image(drive, settled, mode)
        if settled is None or image is None:
            return None
        found = None if known is None else _foretold(known, settled, image, _sizes(drive, settled), error)
        found = found or _linear_map(drive, settled, mode, 1, FINE_NUDGE if is_fine else NUDGE, image)
        if is_fine and (found is None or _swings(drive, found)):
            found = _linear_map(drive, settled, mode, 1, -FINE_NUDGE, image) or found
        return found


def _foretold(known: Linear, y: np.ndarray, image: np.ndarray, sizes: np.ndarray, error: float) -> Linear | None:
    """The map near a state by that of a known one, corrected by Broyden's first rule; None where its gain is off."""
    n = len(known.gain)
    moved, gain = (y[:n] - known.y[:n]) / known.sizes, (image[:n] - y[:n]) / known.sizes
    if not moved.any():
        return known
    wrong = gain - known.gain - known.slopes @ moved + moved
    if not np.abs(wrong).max() <= error * np.abs(known.gain).max():
        return None
    change = known.sizes / sizes
    slopes = (known.slopes + np.outer(wrong, moved) / (moved @ moved)) * change[:, None] / change
    return Linear(y, sizes, slopes, gain * change)


def _many_cycles(
    drive: Drive, y: np.ndarray, mode: np.ndarray, tolerance: float, max_cycles: int
) -> tuple[np.ndarray, bool]:
    """Implicit steps of many cycles each, along the way that plain cycles take, until they lead no farther.

    It is pseudo-transient continuation [1]_: a step over d cycles solves ``(1/d + 1 - S) step = gain``, with the slopes
    S of a cycle's map and what a cycle gains. States that settle at once are brought to where they settle, and those
    that take thousands of cycles go as far as d cycles take them. d grows as long as no state changes by more than
    `CLIP`, and no state is repelled. What a step leaves of states that settle sooner, as a pressure beside a
    temperature, may hide what the slow ones gain: short steps follow it. Steps that turn back become shorter, as about
    a balance of two stores, where a flow is the root of a difference and the slopes have no bound.

    Returns
    -------
    y : (m,) float array
        State that the steps have led to.
    has_arrived : bool
        Whether the last step was shorter than the tolerance, and over as many cycles as the slowest state takes, or
        over `MAX_SETTLING_CYCLES`.

    References
    ----------
    .. [1] C. T. Kelley and D. E. Keyes, "Convergence Analysis of Pseudo-Transient Continuation", SIAM J. Numer. Anal.
       35, 1998, pp. 508-523, doi 10.1137/S0036142996304796.
    """
    count, known, least, vain = FIRST_LEAP, None, np.inf, 0.0
    reach, last, leap = CLIP, np.zeros(len(drive.accuracy.scale)), None
    is_fine = was_fine = False
    while drive.cycles < max_cycles and vain < MAX_VAIN_STEPS:
        # The map near the state. Slopes of the one before are kept while they foretell the gain, or while short steps
        # halve it. Where the usual differences show none, or a swing, fine ones decide.
        error = np.inf if leap and leap.comes_down else FORETOLD
        found = _linear(drive, y, mode, is_fine, known if was_fine == is_fine else None, error)
        was_fine = is_fine
        if not is_fine and (found is None or _swings(drive, found)):
            is_fine = True
            continue
        if found is not None:
            known = found
        elif known is None or count < FIRST_LEAP:
            return (y if known is None else known.y), False
        else:  # back, and less far
            count, leap = count / GROWTH**3, None
        if _swings(drive, known):
            return known.y, False

        # Short steps behind a long one: what it left of faster states may hide what the slow ones gain.
        step = leap.short_step(known, FINE * drive.accuracy.tolerance, reach) if leap else None
        if step is not None:
            y = _after(known.y, step, known.sizes)
            continue

        # The long step, over more cycles than the one before, but not so many that what is repelled turns it round.
        repelled, gained = known.repelled, np.abs(known.gain).max()
        count = min(GROWTH * count, MAX_LEAP, 0.5 / max(repelled, 0.5 / MAX_LEAP))
        step = _implicit_step(known.slopes, known.gain, count)

        # One that turns back has led past the balance: steps become shorter until one leads on.
        if step @ last < 0.0 and np.abs(step).max() > BACK * np.abs(last).max():
            reach = 0.5 * min(reach, np.abs(step).max())
        else:
            reach = min(CLIP, 2.0 * reach)
        while np.abs(step).max() > reach and count > 1.0:
            count *= 0.5
            step = _implicit_step(known.slopes, known.gain, count)
        last = step

        # What the next step goes by: fine slopes after a step of many cycles, or where a state is repelled.
        is_fine = is_fine or repelled > drive.accuracy.tolerance or min(count, known.settles_in) > ROUGH_LEAP
        vain = 0.0 if gained < 0.5 * least else vain + (VAIN_IF_LONG if np.abs(step).max() > LONG_STEP else 1.0)
        least = min(least, gained)
        leap = _Leap(known.y, count)
        y = _after(known.y, step, known.sizes)
        if np.abs(step).max() <= tolerance and count >= min(known.settles_in, MAX_SETTLING_CYCLES):
            return y, True
    return y, False


@dataclass(eq=False)
class _Leap:
    """A step over many cycles, and the short ones behind it, in which what it left of faster states settles."""

    y: np.ndarray
    """State at its start."""
    count: float
    """Cycles that it goes over."""
    gain: np.ndarray | None = None
    """What the state gained before the last short step, relative; None before the first."""
    short_steps: int = 0
    """How many there were."""
    comes_down: bool = True
    """Whether the gain was halved, or no short step tells yet: then the slopes are good enough."""

    def short_step(self, found: Linear, noise: float, reach: float) -> np.ndarray | None:
        """Short step from a map behind the leap; None where the gain is as foretold, or noise, or falls no more.

        Nor is there one that is longer than `reach`.
        """
        if self.count <= MAX_NEAR_CYCLES or self.short_steps == MAX_SHORT_STEPS:
            return None
        foretold, gained, before = self.gain, np.abs(found.gain).max(), np.inf
        if foretold is None:
            n = len(found.gain)
            foretold = (found.y[:n] - self.y[:n]) / found.sizes / self.count
        else:
            before = np.abs(foretold).max()
        if gained > NEARER * before or np.abs(found.gain - foretold).max() <= max(FORETOLD * gained, noise):
            return None
        step = _implicit_step(found.slopes, found.gain, np.sqrt(FIRST_LEAP * self.count))
        if np.abs(step).max() > reach:
            return None
        self.gain, self.short_steps, self.comes_down = found.gain, self.short_steps + 1, gained < 0.5 * before
        return step


def _implicit_step(slopes: np.ndarray, gain: np.ndarray, count: float) -> np.ndarray:
    """Implicit step over some cycles, relative."""
    return np.linalg.solve((1.0 / count + 1.0) * np.eye(len(gain)) - slopes, gain)


def _sizes(drive: Drive, y: np.ndarray) -> np.ndarray:
    """What changes of a state are related to."""
    scale = drive.accuracy.scale
    return scale + np.abs(y[: len(scale)])


def _correction(slopes: np.ndarray) -> np.ndarray:
    """See `Known`: the inverse of one less the slopes; states that are held stay."""
    gap = np.eye(len(slopes)) - slopes
    free = np.flatnonzero(np.abs(gap).max(axis=1) > LOOSE)
    correction = np.zeros_like(gap)
    correction[np.ix_(free, free)] = np.linalg.pinv(gap[np.ix_(free, free)], rcond=1e-9)
    return correction


def known_orbit(p: Any, tables: Any, orbit: Orbit, breakpoints: np.ndarray, accuracy: Accuracy) -> Known | None:
    """Return a periodic state as a start for others, see `periodic_orbit`.

    Its correction is the inverse of one less the slopes of the cycle's map, which has the Floquet multipliers for
    eigenvalues [1]_.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.
    tables : NamedTuple
        Arrays of the machine.
    orbit : Orbit
        Periodic state of the machine.
    breakpoints : (j,) float array
        Breakpoints of a cycle from 0; the last is its period [s].
    accuracy : Accuracy
        Tolerance, longest step and scales.

    Returns
    -------
    Known or None
        None where it has not converged to a period of one cycle, or its map has no slope, or nearly swings.

    References
    ----------
    .. [1] R. Seydel, "Practical Bifurcation and Stability Analysis", 3rd ed., Springer, 2010,
       doi 10.1007/978-1-4419-1740-9, chapter 7.

    Examples
    --------
    A decay at 2 per second gains exp(-2) - 1 of its distance from 0 in a cycle of 1 s, so that 1/(1 - exp(-2)) = 1.1565
    times a gain leads there:

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
    >>> cycle = np.array([1.0]), Accuracy(1e-9, 0.1, np.ones(1))
    >>> orbit = periodic_orbit(p, None, y, mode, *cycle)
    >>> round(float(known_orbit(p, None, orbit, *cycle).correction[0, 0]), 4)
    1.1565
    """
    if not orbit.converged or orbit.period != 1:
        return None
    found = _linear_map(Drive(p, tables, breakpoints, accuracy), orbit.y, orbit.mode)
    if found is None or found.multipliers.real.min() < SWINGING:
        return None
    return Known(orbit.y, orbit.mode, _correction(found.slopes))


def _from_known(drive: Drive, known: Known, tolerance: float, record: Record) -> Settling | None:
    """Settle by Broyden's method from a known state that is near; None where that does not succeed at once.

    None, too, where a cycle moves what the known cycle held, as a piston in its friction, or ends in another phase: the
    correction knows nothing of that. The tolerance is that of the way left to the periodic state; each cycle writes the
    arrays of `record` anew.
    """
    n, y, mode, correction = len(drive.accuracy.scale), known.y, known.mode, known.correction
    if len(correction) != n:
        return None

    # Of states that the known cycle held, the correction knows nothing: none of them may move.
    held = ~correction.any(axis=1)
    before = gain_before = step = None
    largest_before = np.inf
    for _ in range(MAX_CORRECTIONS):
        # From the first state the way is hardly ever short enough: what it does need not be recorded.
        image, mode_image, status = drive.march(y, mode, 1, NO_RECORD if before is None else record)
        if status != Status.DONE or any(mode_image[i] != mode[i] for i in drive.phases):
            return None
        sizes = _sizes(drive, y)
        gain = (image[:n] - y[:n]) / sizes
        if np.abs(gain[held]).max(initial=0.0) > tolerance:
            return None

        # The correction learns from what the last step has changed, by Broyden's first rule.
        if step is not None:
            moved = correction @ (gain_before - gain)
            if abs(weight := step @ moved) > 0.0:
                correction = correction + np.outer(step - moved, step @ correction) / weight
        step = correction @ gain

        # A way left that is long or grows means too far away, unless a rough correction still brings the gain down.
        left, largest_gain = np.abs(step).max(), np.abs(gain).max()
        learning = known.rough and largest_gain <= largest_before
        if left > CLIP or (before is not None and left > before and not learning):
            return None

        # The cycle from this very state is in the record: where the state is near enough, it is the periodic one.
        if before is not None and len(record.log) and left <= tolerance:
            recorded = Recorded(record.log[: drive.outcome.logged], record.trace, image, drive.outcome)
            return Settling(y, mode, Status.DONE, largest_gain, np.inf, 1, correction, recorded)

        # The step. Where the way left falls fast enough, the state behind it is taken without one more cycle.
        y, nearer = y.copy(), left / before if before else 1.0
        y[:n] += step * sizes
        if left * nearer <= tolerance:  # the next step falls by as much at least
            return Settling(y, mode, Status.DONE, largest_gain, np.inf, 1, correction)
        before, gain_before, largest_before = left, gain, largest_gain
    return None


def _accelerated(drive: Drive, y: np.ndarray, mode: np.ndarray, tolerance: float) -> Settling:
    """Cycles between which Anderson's method leads on; of the period 0 where the search has to go on from their end.

    Where a deviation changes its sign from cycle to cycle, or grows, they may have come to a state that no machine
    settles to, as the one between the two states of a period of two: then the search begins anew, from the start. So
    it does where they lead nowhere.
    """
    n = len(drive.accuracy.scale)
    anew = Settling(y, mode, Status.DONE, np.inf, np.inf, 0)
    # The first cycle fills an empty cylinder: no secant from there shows a slope.
    y, mode, status = drive.march(y, mode)
    gains: list[float] = []
    secants, repeats = Secants(), 0
    while status == Status.DONE and drive.cycles < ENOUGH:
        image, mode_image, status = drive.march(y, mode)
        if status == Status.TOO_MANY_EVALUATIONS:
            return Settling(image, mode_image, status, np.inf, np.inf, 0)
        if _is_other_phase(drive, mode, mode_image) or _is_held_elsewhere(drive, mode, mode_image):
            secants.forget()
            y, mode = image, mode_image
            continue

        # Whether the state repeats: nothing may be far that the secants show, nor what they do not.
        sizes = _sizes(drive, y)
        gain = (image[:n] - y[:n]) / sizes
        secants.add(y[:n], image[:n], sizes)
        step, left = secants.step(gain, sizes)
        change = float(np.abs(gain).max())
        repeats = repeats + 1 if change <= tolerance and left <= MAX_DISTANCE * tolerance else 0
        if repeats == 2 or (repeats and (secants.are_shown or change == 0.0)):
            multipliers = secants.multipliers()
            repels = multipliers.real.min(initial=0.0) < SWINGING or np.abs(multipliers).max(initial=0.0) > REPELLING
            if repels:
                return anew
            return Settling(image, mode_image, Status.DONE, change, np.inf, 1, secants.correction(sizes))

        # Where only the solver's error moves the state, plain cycles tell sooner.
        gains.append(change)
        lately, before = min(gains[-VAIN:]), min(gains[:-VAIN], default=np.inf)
        if 0.5 * before < lately < NOISE * drive.accuracy.tolerance:
            return Settling(image, mode_image, Status.DONE, change, np.inf, 0)
        y, mode = _after(y, step, sizes), mode_image
    return anew


def _settled(drive: Drive, y: np.ndarray, mode: np.ndarray, tolerance: float, max_cycles: int) -> Settling:
    """Plain cycles, and help between them; see `periodic_orbit`."""
    kept: Settling | None
    kept, fine, has_leapt, has_arrived, looks_at = None, 0, False, False, MAX_NEAR_CYCLES
    while True:
        # Plain cycles. A small change alone is believed where two full Newton steps, or implicit ones, have led near,
        # or after `PATIENCE` cycles where no step goes before.
        sure = fine >= 2 or (kept is None and drive.cycles >= PATIENCE)
        enough = max(tolerance, SAME * drive.accuracy.tolerance) if has_arrived else tolerance
        found = _plain_cycles(drive, y, mode, enough, max(1, min(BURST, max_cycles - drive.cycles)), sure)

        # A step that led astray is taken back: the search goes on from the state before it.
        leads_on = kept is None or (found.status == Status.DONE and (has_leapt or _nearer(found, kept)))
        astray = not (leads_on or found.period)
        if astray and kept is not None:
            found = kept
        if found.status != Status.DONE or found.period or drive.cycles >= max_cycles:
            return found

        # Far on, it may be that only the solver's error moves the state, or that it repeats after several cycles: to
        # see that takes many more, so that it is looked for at twice the cycles each time.
        if drive.cycles > MAX_NEAR_CYCLES and _only_errors_move(drive, found, tolerance):
            return found._replace(period=1)
        if drive.cycles > looks_at:
            found, looks_at = _subharmonic(drive, found, max_cycles), 2 * drive.cycles
            if found.status != Status.DONE or found.period:
                return found

        # Help for the next cycles: implicit steps over many in turns with Newton's method, and near the end that alone.
        is_near = kept is not None and not astray and _least(found) <= MAX_DISTANCE * tolerance
        y, mode, kept, has_arrived = found.y, found.mode, None, False
        has_leapt = (
            not (has_leapt or is_near) and drive.cycles > MAX_NEAR_CYCLES and found.change_of_two >= 0.5 * found.change
        )
        if has_leapt:
            y, has_arrived = _many_cycles(drive, y, mode, MAX_DISTANCE * tolerance, max_cycles)
            kept, fine = found, 2 if has_arrived else 0
        elif not astray:
            better = _newton(drive, y, mode, 2 if found.change_of_two < 0.5 * found.change else 1)
            if better is not None:
                clipped = distance(y, better, drive.accuracy.scale) >= CLIP / (1.0 + CLIP)
                y, kept, fine = better, found, 0 if clipped else fine + 1


def _subharmonic(drive: Drive, found: Settling, max_cycles: int) -> Settling:
    """March plain cycles until the state repeats after some of them, as in a driven oscillator, or no sign of it shows.

    It repeats where its change over a period is no more than the solver's error through two periods, and does not add
    up: a drift does. What changes by no more than that error from cycle to cycle has no such period.
    """
    tolerance = drive.accuracy.tolerance
    passed: list[tuple[np.ndarray, np.ndarray]] = [(found.y, found.mode)]
    apart: list[list[float]] = []
    while len(apart) < MAX_PERIODS * MAX_PERIOD and drive.cycles < max_cycles:
        if _least(found) <= NOISE * tolerance:
            break
        y, mode, status = drive.march(*passed[-1])
        if status != Status.DONE:
            return Settling(y, mode, status, np.inf, np.inf, 0)
        changes = [_change(drive, earlier, y, mode) for earlier in passed[: -MAX_PERIOD - 1 : -1]]
        passed.append((y, mode))
        apart.append(changes)
        found = Settling(y, mode, status, changes[0], min(changes[1:2], default=np.inf), 0)
        for period in range(3, min(MAX_PERIOD, len(apart) // 3) + 1):
            largest = max(at[period - 1] for at in apart[-2 * period :])
            if largest <= SAME * tolerance and _change(drive, passed[-1 - 2 * period], y, mode) <= largest:
                return found._replace(period=period)
        if len(apart) >= 2 * MAX_PERIOD and min(changes[2:]) > FAINT * min(changes[:2]):
            break
    return found


def _only_errors_move(drive: Drive, found: Settling, tolerance: float) -> bool:
    """Whether what moves the state is the solver's error, which falls with the tolerance of a step; a drift stays.

    A cycle goes before: what it forgets begins with the error of the steps that it takes.
    """
    if found.change > SAME * drive.accuracy.tolerance:
        return False
    usual = _moved(drive, found)
    with drive.finer_steps():
        finer = None if usual is None else _moved(drive, found)
    if usual is None or finer is None:
        return False
    return bool(np.abs(finer - FINE * usual).max() / (1.0 - FINE) <= REST_CYCLES * tolerance)


def _moved(drive: Drive, found: Settling) -> np.ndarray | None:
    """What some cycles behind the next one move a state by, relative; None where they fail or change the phase."""
    start = _image(drive, found.y, found.mode)
    image = None if start is None else _image(drive, start, found.mode, REST_CYCLES)
    if start is None or image is None:
        return None
    n = len(drive.accuracy.scale)
    return (image[:n] - start[:n]) / _sizes(drive, start)


def periodic_orbit(
    p: Any,
    tables: Any,
    y: np.ndarray,
    mode: np.ndarray,
    breakpoints: np.ndarray,
    accuracy: Accuracy,
    tolerance: float = PERIODIC_TOLERANCE,
    max_cycles: int = MAX_CYCLES,
    known: Known | None = None,
    record: Record = NO_RECORD,
) -> Orbit:
    """March to the periodic state, by cycles between which Anderson's method leads on.

    They end where the state repeats, and nothing shows that it repels [3]_. Elsewhere plain cycles follow, helped by
    Newton's method where they converge slowly. A Newton step is kept only where the plain cycles after it come nearer
    to a period than those before it. Where the state swings from cycle to cycle, the step is one of the map of two
    cycles.

    After `MAX_NEAR_CYCLES` cycles the way of plain cycles is followed in implicit steps over many of them, in turns
    with Newton's method.

    The periodic state is a fixed point of the map of a cycle [1]_; its slopes are taken by differences. From a known
    state the inverse of one less those slopes is kept up by Broyden's first rule [2]_.

    Parameters
    ----------
    p : NamedTuple
        Parameters of the machine.
    tables : NamedTuple
        Arrays of the machine.
    y : (n,) float array
        State at the start.
    mode : (m,) float array
        Modes at the start.
    breakpoints : (j,) float array
        Breakpoints of a cycle from 0; the last is its period [s].
    accuracy : Accuracy
        Tolerance, longest step and scales.
    tolerance : float
        Largest change of any state over a cycle, relative.
    max_cycles : int
        Largest number of cycles; up to `MAX_NEAR_CYCLES` of them are plain ones from the first.
    known : Known, optional
        Periodic state of a machine that differs a little: where that is near, and has the same states, it takes few
        cycles; else the march is the one without it.
    record : Record
        Arrays for a cycle. Where a known state is near, cycles are recorded on the way, and the one from the periodic
        state need not be marched once more.

    Returns
    -------
    Orbit
        Periodic state, or the last state where none was found.

    References
    ----------
    .. [1] R. Seydel, "Practical Bifurcation and Stability Analysis", 3rd ed., Springer, 2010,
       doi 10.1007/978-1-4419-1740-9, chapter 7.
    .. [2] C. G. Broyden, "A class of methods for solving nonlinear simultaneous equations", Math. Comp. 19, 1965,
       pp. 577-593, doi 10.1090/S0025-5718-1965-0198670-6.
    .. [3] H. F. Walker and P. Ni, "Anderson acceleration for fixed-point iterations", SIAM J. Numer. Anal. 49, 2011,
       pp. 1715-1735, doi 10.1137/10078356X.

    Examples
    --------
    A decay settles to 0:

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
    >>> orbit = periodic_orbit(p, None, y, mode, np.array([1.0]), Accuracy(1e-9, 0.1, np.ones(1)))
    >>> orbit.converged, orbit.period, round(float(orbit.y[0]), 7)
    (True, 1, 0.0)
    """
    drive = Drive(p, tables, breakpoints, accuracy)
    orbit = orbit_of(drive, y, mode, tolerance, max_cycles, known, record)
    if known and not orbit.known:
        return orbit._replace(known=known_orbit(p, tables, orbit, breakpoints, accuracy))
    return orbit


def orbit_of(
    drive: Drive,
    y: np.ndarray,
    mode: np.ndarray,
    tolerance: float = PERIODIC_TOLERANCE,
    max_cycles: int = MAX_CYCLES,
    known: Known | None = None,
    record: Record = NO_RECORD,
) -> Orbit:
    """March a drive to its periodic state, see `periodic_orbit`."""
    found = _from_known(drive, known, tolerance, record) if known else None
    spent = 0
    if found is None and max_cycles > MAX_NEAR_CYCLES:  # whoever allows a few wants to see where plain cycles lead
        found = _accelerated(drive, y, mode, tolerance)
        y, mode = found.y, found.mode
        if found.status == Status.DONE and not found.period:  # the search goes on, with its own count
            found, spent, drive.cycles = None, drive.cycles, 0
    found = found or _settled(drive, y, mode, tolerance, max_cycles - spent)
    y = found.y.copy()
    drive.clear_ledger(y)
    return Orbit(
        y,
        found.mode,
        bool(found.period),
        found.period,
        spent + drive.cycles,
        found.change,
        found.change_of_two,
        found.status,
        None if found.correction is None else Known(y, found.mode, found.correction),
        found.recorded,
    )


def _nearer(found: Settling, kept: Settling) -> bool:
    """Whether cycles come clearly nearer to a period than others; a step that was clipped cannot do more."""
    return _least(found) < NEARER * _least(kept)


def _least(found: Settling) -> float:
    """Change over the last cycle, or over the last two where that is smaller."""
    return min(found.change, found.change_of_two)
