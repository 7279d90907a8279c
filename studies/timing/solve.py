"""Command angles of one operating point, solved on the coupled model in its periodic state."""

from enum import IntEnum
from math import inf, nan
from typing import NamedTuple

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cycle.rates import TRACE
from apesim.engine.cylinder import EPV
from apesim.engine.indicators import valve_angles
from apesim.engine.machine import Machine
from apesim.engine.steady import SteadyRun, run_steady
from apesim.march.adaptive import LOG_HEAD, Status
from apesim.march.periodic import PERIODIC_TOLERANCE
from apesim.studies.timing.open_loop import lap_of_machine, open_loop_delays
from apesim.valve.motion import CORNER
from apesim.valve.solenoid import opening_curve

TOLERANCE = 5e-4 * DEGREE
"""To which the targets are met, where they can be [rad]."""
REACHED_WITHIN = 0.05 * DEGREE
"""Angles nearer to their targets than this are reached [rad]."""
SKETCH = 1e-3
"""Change of a state over a cycle that counts as periodic far from the solution."""
NEAR = 0.03 * DEGREE
"""Nearer than this to the targets, states are brought to their full periodic state [rad]."""
LIFT = TRACE.index("lift [m]")
ANGLE_STEP, SKETCH_ANGLE_STEP = 0.5 * DEGREE, 5.0 * DEGREE
MAX_STEP = 40.0 * DEGREE
TRIES = 12
MIN_PULSE = 0.1 * DEGREE
WIDTHS = (3.0 * DEGREE, 0.3 * DEGREE, 0.01 * DEGREE)
"""Widths of the bracket of the pulse, each tried where a wider one has not led to the solution [rad]."""
USUAL_SLOPE = 1.5
"""Slope of the true opening duration over the pulse, before it is known: 1 where the valve rests on its open stop in
between, near 2 where it turns back before."""


class Reason(IntEnum):
    """Why the targets are not reached."""

    REACHED = 0
    NEVER_OPENS = 1
    NEVER_CLOSES = 2
    NO_PULSE = 3
    OPEN_TOO_LONG = 4
    OPEN_TOO_SHORT = 5
    CROSSES_AGAIN = 6
    NOT_PERIODIC = 7
    MISSED = 8
    FAILED = 9

    @property
    def words(self):
        """In short, e.g. "never opens"."""
        return self.name.lower().replace("_", " ")

    @property
    def remedy(self):
        """What is the matter, and what to change."""
        return REMEDIES[self]


REMEDIES = {
    Reason.REACHED: "reached",
    Reason.NEVER_OPENS: "even the longest pulse does not lift the valve through the lap; raise the pressure or lower "
    "the speed",
    Reason.NEVER_CLOSES: "even after the shortest pulse the lift stays above the lap; raise the pressure or lower the "
    "speed",
    Reason.NO_PULSE: "shorter pulses do not open the valve and longer ones do not let it close within the turn; raise "
    "the pressure or lower the speed",
    Reason.OPEN_TOO_LONG: "the shortest pulse that opens the valve holds it open longer than from target to target; "
    "lower the speed or part the targets",
    Reason.OPEN_TOO_SHORT: "the longest pulse that lets the valve close holds it open more briefly than from target to "
    "target; lower the speed or bring the targets together",
    Reason.CROSSES_AGAIN: "the lift crosses the lap more than once a cycle; lower the pressure or damp the valve",
    Reason.NOT_PERIODIC: "at the commands that come nearest the cycles do not repeat one by one; lower the speed",
    Reason.MISSED: "no commands were found that meet both angles within 0.05 deg: opening or closing jumps over its "
    "target; move the targets",
    Reason.FAILED: "a march ended early; run `apesim engine run` at this point to see why",
}


class Timing(NamedTuple):
    """Commands of an operating point, and what the valve does with them."""

    machine: Machine
    """With the commands found; where the targets are out of reach, as it was given."""
    run: SteadyRun | None
    """The periodic state with these commands; None out of reach."""
    angles: dict
    """See `apesim.engine.indicators.valve_angles`; empty out of reach."""
    advance: float
    """Target less command of the opening [rad]; NaN out of reach. Of the turns that it could be, the first that leaves
    the solenoids their dead time."""
    release_advance: float
    """Target less command of the closing [rad]; NaN out of reach."""
    open_error: float
    """True less target angle [rad]; NaN out of reach."""
    close_error: float
    reason: Reason
    marches: int
    """Periodic states computed."""

    @property
    def reachable(self):
        """Whether the targets are reached."""
        return self.reason == Reason.REACHED


class Look(NamedTuple):
    """The valve's answer to a command."""

    machine: Machine
    run: SteadyRun
    angles: dict
    misses: np.ndarray
    """True less target of the opening, and of the duration from opening to closing [rad]. The duration is infinitely
    short where the valve never opens, infinitely long where it never closes; NaN where the march failed."""


def wrapped(angle):
    """An angle within half a turn of zero [rad]."""
    return (angle + 0.5 * TURN) % TURN - 0.5 * TURN


def commanded(machine, energise, release):
    """A machine with other command angles [rad], a turn later where they would come too early for a machine file."""
    later = TURN if energise < -TURN else 0.0
    command = machine.command._replace(energise=float(energise + later), release=float(release + later))
    return machine._replace(command=command)


def look(machine, speed, energise, pulse, periodic_tolerance=PERIODIC_TOLERANCE):
    """March to the periodic state and see where the valve opens and closes.

    Parameters
    ----------
    machine : Machine
        Its targets are what counts as a miss.
    speed : float
        [rad/s]
    energise, pulse : float
        Command angle, and how long it holds [rad].
    periodic_tolerance : float
        See `apesim.engine.steady.run_steady`.

    Returns
    -------
    Look
    """
    machine = commanded(machine, energise, energise + pulse)
    angle_step = SKETCH_ANGLE_STEP if periodic_tolerance == SKETCH else ANGLE_STEP
    run = run_steady(machine, speed, periodic_tolerance=periodic_tolerance, angle_step=angle_step)
    if run.status != Status.DONE:
        return Look(machine, run, {}, np.full(2, nan))
    angles = valve_angles(machine, run)
    opens, closes = angles["valve_open_deg"] * DEGREE, angles["valve_close_deg"] * DEGREE
    if np.isnan(opens + closes):
        stays_open = run.trace[:, LIFT].min() > lap_of_machine(machine)
        return Look(machine, run, angles, np.array([0.0, inf if stays_open else -inf]))
    wanted = machine.command
    duration_miss = closes - opens - (wanted.close_target - wanted.open_target)
    return Look(machine, run, angles, np.array([wrapped(opens - wanted.open_target), duration_miss]))


def openings(machine, run):
    """How often the lift rises through the lap in a cycle."""
    position, velocity = run.log[:, LOG_HEAD], run.log[:, LOG_HEAD + 1]
    above_lap = machine.valve.stroke - position - lap_of_machine(machine)
    at_lap = (run.log[:, 1] == CORNER) & (np.abs(above_lap) < 1e-6 * machine.valve.stroke)
    return int(np.sum(at_lap & (velocity < 0.0)))


def corrected(machine, speed, start=None, periodic_tolerance=PERIODIC_TOLERANCE):
    """Commands with which the valve opens and closes at its targets, in the periodic state.

    Broyden's method in energise and pulse, from a start or the delays of the bench; where that fails, the pulse is
    bracketed (the valve is open longer after a longer pulse) and the method starts anew from the bracket.

    Parameters
    ----------
    machine : Machine
        With an electro-pneumatic intake; its targets are ``command.open_target`` and ``command.close_target``.
    speed : float
        [rad/s]
    start : tuple of float, optional
        Energise and pulse to start from [rad].
    periodic_tolerance : float
        See `apesim.engine.steady.run_steady`; with `SKETCH` the targets are met within `NEAR`, at a third of the time.

    Returns
    -------
    Timing

    Raises
    ------
    ValueError
        The intake is another, which has no commands.
    """
    if machine.engine.intake != EPV:
        raise ValueError("only an electro-pneumatic intake has commands to correct")
    marches = 0

    def look_at(x, periodic_tolerance):
        nonlocal marches
        marches += 1
        return look(machine, speed, *x, periodic_tolerance)

    found = _approach(look_at, start or _open_loop(machine, speed), USUAL_SLOPE, periodic_tolerance)
    reason = reason_of(found)
    if reason not in (Reason.REACHED, Reason.CROSSES_AGAIN, Reason.FAILED):
        reason, found = _bracketed(look_at, machine, periodic_tolerance)
    if reason != Reason.REACHED:
        return Timing(machine, None, {}, nan, nan, nan, nan, reason, marches)
    target, command = machine.command, found.machine.command
    advance = target.open_target - command.energise
    soonest = speed * opening_curve(machine.valve.solenoid)[0, 0]
    advance = soonest + (advance - soonest) % TURN
    wanted, pulse = target.close_target - target.open_target, command.release - command.energise
    return Timing(
        found.machine,
        found.run,
        found.angles,
        advance,
        advance + wanted - pulse,
        float(found.misses[0]),
        float(found.misses.sum()),
        reason,
        marches,
    )


def start_after(machine, speed, before):
    """Find a start from what other speeds needed: times on a line through the last two.

    Parameters
    ----------
    machine : Machine
        With the targets.
    speed : float
        [rad/s]
    before : sequence of tuple
        Other speeds [rad/s], each with its `Timing`, reached.

    Returns
    -------
    tuple of float or None
        Energise and pulse [rad]; None without any.
    """
    if not before:
        return None
    speeds, timings = zip(*before[-2:], strict=True)
    times = np.array([(timing.advance, timing.release_advance) for timing in timings]) / np.array(speeds)[:, None]
    late = times[-1]
    if len(speeds) > 1 and speeds[1] != speeds[0]:
        late = late + (speed - speeds[1]) / (speeds[1] - speeds[0]) * (times[1] - times[0])
    advance, release_advance = (float(angle) for angle in speed * late)
    command = machine.command
    return command.open_target - advance, command.close_target - command.open_target + advance - release_advance


def reason_of(found):
    """Whether a look reaches the targets in a state that repeats every cycle, and if not, why."""
    opening, duration = found.misses
    if np.isnan(duration):
        return Reason.FAILED
    if max(abs(opening), abs(opening + duration)) > REACHED_WITHIN:
        return Reason.MISSED
    if not found.run.orbit.converged or found.run.orbit.period != 1:
        return Reason.NOT_PERIODIC
    if openings(found.machine, found.run) > 1:
        return Reason.CROSSES_AGAIN
    return Reason.REACHED


def _open_loop(machine, speed):
    """Energise and pulse by the delays of the bench [rad]."""
    delays = open_loop_delays(machine)
    opening, closing = speed * np.nan_to_num(delays.opening), speed * np.nan_to_num(delays.closing)
    command = machine.command
    return command.open_target - opening, command.close_target - closing - (command.open_target - opening)


def _approach(look_at, start, slope, last):
    """Broyden's method from a start to the targets, first by sketches; the last look."""
    x = np.array(start)
    x[1] = np.clip(x[1], MIN_PULSE, TURN - MIN_PULSE)
    slopes = np.diag((1.0, slope))
    periodic_tolerance = SKETCH
    here = look_at(x, periodic_tolerance)
    for _ in range(TRIES):
        if not np.isfinite(here.misses).all():
            break
        miss = np.abs(here.misses).max()
        if periodic_tolerance != last and miss < NEAR:
            periodic_tolerance = last
            here = look_at(x, periodic_tolerance)
            continue
        if miss < (NEAR if last == SKETCH else TOLERANCE):
            break
        step = -np.linalg.lstsq(slopes, here.misses)[0]
        step *= min(1.0, MAX_STEP / np.abs(step).max())
        step[1] = np.clip(x[1] + step[1], MIN_PULSE, TURN - MIN_PULSE) - x[1]
        there = look_at(x + step, periodic_tolerance)
        if np.isfinite(there.misses).all() and step @ step > 0.0:
            slopes += np.outer(there.misses - here.misses - slopes @ step, step) / (step @ step)
        x, here = x + step, there
    return here


def _bracketed(look_at, machine, last):
    """Search with the pulse bracketed between one that opens too short and one that opens too long.

    Returns
    -------
    Reason
    Look or None
        The one that reaches the targets.
    """
    energise = machine.command.open_target
    low, high = MIN_PULSE, TURN - MIN_PULSE
    short, long = (look_at((energise, pulse), SKETCH).misses[1] for pulse in (low, high))
    reason = Reason.MISSED
    for width in WIDTHS:
        if not short < 0.0 < long:
            break
        while high - low > width:
            middle = 0.5 * (low + high)
            opening, duration = look_at((energise, middle), SKETCH).misses
            if np.isnan(duration):
                return Reason.FAILED, None
            energise -= opening
            if duration < 0.0:
                low, short = middle, duration
            else:
                high, long = middle, duration
        if np.isfinite((short, long)).all():
            share = short / (short - long)
            found = _approach(look_at, (energise, low + share * (high - low)), (long - short) / (high - low), last)
            reason = reason_of(found)
            if reason in (Reason.REACHED, Reason.CROSSES_AGAIN):
                return reason, found
    return _out_of_reach(short, long, reason), None


def _out_of_reach(short, long, otherwise):
    """Why no pulse opens the valve for the right time, from the misses at both ends of the bracket."""
    if np.isnan(short) or np.isnan(long):
        return Reason.FAILED
    if short >= 0.0:
        return Reason.NEVER_CLOSES if short == inf else Reason.OPEN_TOO_LONG
    if long <= 0.0:
        return Reason.NEVER_OPENS if long == -inf else Reason.OPEN_TOO_SHORT
    if short == -inf:
        return Reason.NO_PULSE if long == inf else Reason.OPEN_TOO_LONG
    return Reason.OPEN_TOO_SHORT if long == inf else otherwise
