"""Command angles of one operating point, solved on the coupled model in its periodic state."""

from collections.abc import Callable, Sequence
from enum import IntEnum
from math import inf, nan
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cylinder import EPV
from apesim.engine.drivetrain.preparing import machines_of
from apesim.engine.drivetrain.steady import Revolution, cylinder_runs, run_revolution
from apesim.engine.indicators import valve_angles
from apesim.engine.machine import Machine
from apesim.engine.second_stage import SecondStage
from apesim.engine.steady import SteadyRun, is_of_one_cylinder, run_steady
from apesim.march.adaptive import LOG_HEAD, Status
from apesim.march.periodic import PERIODIC_TOLERANCE, Known
from apesim.quantities.lists import NO_LIST
from apesim.studies.timing.open_loop import lap_of_machine, open_loop_delays
from apesim.valve.motion import CORNER
from apesim.valve.solenoid import opening_curve

TOLERANCE = 5e-4 * DEGREE
"""Largest miss of the targets at which the search ends [rad]."""
REACHED_WITHIN = 0.05 * DEGREE
"""Largest miss of a target that counts as reached [rad]."""
SKETCH = 1e-3
"""Change of a state over a cycle that counts as periodic far from the solution."""
NEAR = 0.03 * DEGREE
"""Nearer than this to the targets, states are brought to their full periodic state [rad]."""
LIFT = TRACE.index("lift [m]")
ANGLE_STEP, SKETCH_ANGLE_STEP = 0.5 * DEGREE, 5.0 * DEGREE
"""Crank angle between two rows of a trace, in a full periodic state and in a sketch of one [rad]."""
MAX_STEP = 40.0 * DEGREE
"""Largest change of a command in one step of the search [rad]."""
TRIES = 12
"""Most steps of the search from one start."""
MIN_PULSE = 0.1 * DEGREE
"""Shortest pulse that is tried; the longest is shorter than a turn by this [rad]."""
WIDTHS = (3.0 * DEGREE, 0.3 * DEGREE, 0.01 * DEGREE)
"""Widths of the bracket of the pulse, each tried where a wider one has not led to the solution [rad]."""
USUAL_SLOPE = 1.5
"""Slope of the true opening duration over the pulse, before it is known: 1 where the valve rests on its open stop in
between, near 2 where it turns back before."""


class Reason(IntEnum):
    """Reason why the targets of an operating point are not reached, or `REACHED`."""

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
    def words(self) -> str:
        """Name of the reason in words, e.g. "never opens"."""
        return self.name.lower().replace("_", " ")

    @property
    def remedy(self) -> str:
        """What is the matter, and what to change, in words."""
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
    """Commands of an operating point that meet its targets, and what the valve does with them."""

    machine: Machine
    """Machine with these commands; where the targets are out of reach, the machine that was given."""
    run: SteadyRun | Revolution | None
    """The periodic state with these commands; None out of reach, or in a sketch of several cylinders."""
    angles: dict[str, float]
    """Angles of the valve, see `apesim.engine.indicators.valve_angles`; empty out of reach. Of several cylinders those
    of the first, NaN where another one does not come to it."""
    advance: float
    """Target of the opening less its command angle [rad]; NaN out of reach. It is no shorter than the dead time of the
    solenoids, and less than a turn longer."""
    release_advance: float
    """Target of the closing less its command angle [rad]; NaN out of reach."""
    open_error: float
    """True less target angle of the opening [rad]; NaN out of reach."""
    close_error: float
    """True less target angle of the closing [rad]; NaN out of reach."""
    reason: Reason
    """Why the targets are not reached, or `Reason.REACHED`."""
    marches: int
    """Number of periodic states that were computed."""

    @property
    def reachable(self) -> bool:
        """Whether the targets are reached."""
        return self.reason == Reason.REACHED


class Look(NamedTuple):
    """What the valve does with a command in the periodic state, and by how much it misses its targets."""

    machine: Machine
    """Machine with the command."""
    run: SteadyRun
    """The periodic state with the command."""
    angles: dict[str, float]
    """Angles of the valve, see `apesim.engine.indicators.valve_angles`; empty where the march failed."""
    misses: np.ndarray
    """True less target of the opening, and of the duration from opening to closing, (2,) [rad]. The duration is
    infinitely short where the valve never opens, infinitely long where it never closes; NaN where the march failed."""


def wrapped(angle: float) -> float:
    """Wrap an angle [rad] to within half a turn of zero.

    >>> wrapped(1.25 * TURN) / TURN
    0.25
    """
    return (angle + 0.5 * TURN) % TURN - 0.5 * TURN


def _commanded(machine: Machine, energise: float, release: float) -> Machine:
    """Give a machine other command angles [rad], both a turn later where a machine file could not hold them."""
    later = TURN if energise < -TURN else 0.0
    command = machine.command._replace(energise=float(energise + later), release=float(release + later))
    return machine._replace(command=command)


def look(
    machine: Machine,
    speed: float,
    energise: float,
    pulse: float,
    periodic_tolerance: float = PERIODIC_TOLERANCE,
    start: Known | None = None,
) -> Look:
    """March to the periodic state and see where the valve opens and closes, and how far it misses the targets.

    `speed` [rad/s], `energise` command angle [rad], `pulse` for which the solenoids stay energised [rad];
    `periodic_tolerance` and `start`, a periodic state with commands near by, as for `apesim.engine.steady.run_steady`.
    With the tolerance `SKETCH` no errors are estimated.
    """
    machine = _commanded(machine, energise, energise + pulse)
    angle_step = SKETCH_ANGLE_STEP if periodic_tolerance == SKETCH else ANGLE_STEP
    run = run_steady(
        machine,
        speed,
        periodic_tolerance=periodic_tolerance,
        angle_step=angle_step,
        start=start,
        estimate_error=periodic_tolerance != SKETCH,
    )
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


def _openings(machine: Machine, run: SteadyRun) -> int:
    """Count how often the lift rises through the lap in the logged cycle of a periodic state."""
    position, velocity = run.log[:, LOG_HEAD], run.log[:, LOG_HEAD + 1]
    above_lap = machine.valve.stroke - position - lap_of_machine(machine)
    at_lap = (run.log[:, 1] == CORNER) & (np.abs(above_lap) < 1e-6 * machine.valve.stroke)
    return int(np.sum(at_lap & (velocity < 0.0)))


def corrected(
    machine: Machine,
    speed: float,
    start: tuple[float, float] | None = None,
    periodic_tolerance: float = PERIODIC_TOLERANCE,
) -> Timing:
    """Find the commands with which the valve opens and closes at its targets, in the periodic state.

    Broyden's method (Broyden 1965, doi 10.1090/S0025-5718-1965-0198670-6) finds command angle and pulse from `start`
    [rad], or from the delays of the bench; where it fails, the pulse is bracketed (the valve is open longer after a
    longer pulse), and the method starts anew. `speed` [rad/s]; with the `periodic_tolerance` `SKETCH` the targets are
    met within `NEAR`, at a third of the time. Out of reach, the result holds the reason; raises ValueError where the
    intake is no electro-pneumatic valve.

    >>> timing = corrected(Machine(), 94.0)
    >>> round(timing.advance / DEGREE), round(timing.release_advance / DEGREE), timing.reason.name
    (36, 52, 'REACHED')
    >>> abs(timing.open_error) < TOLERANCE
    True
    """
    if machine.engine.intake != EPV:
        raise ValueError("only an electro-pneumatic intake has commands to correct")
    if not is_of_one_cylinder(machine):
        return _corrected_together(machine, speed, start, periodic_tolerance)

    # Each state starts from the last one of the same tolerance, as commands change little from one try to the next.
    marches = 0
    before: dict[float, Known | None] = {}  # the first full state starts at rest, as whoever runs the engine starts

    def look_at(x: Sequence[float], periodic_tolerance: float) -> Look:
        nonlocal marches
        marches += 1
        here = look(machine, speed, x[0], x[1], periodic_tolerance, before.get(periodic_tolerance))
        before[periodic_tolerance] = here.run.orbit.known
        return here

    # Broyden's method first. What meets the targets is final, even where the lift crosses the lap again, and so is
    # a march that failed; in all other cases the pulse is bracketed.
    result = _approach(look_at, start or _open_loop(machine, speed), USUAL_SLOPE, periodic_tolerance)
    reason = reason_of(result)
    if reason not in (Reason.REACHED, Reason.CROSSES_AGAIN, Reason.FAILED):
        reason, result = _bracketed(look_at, machine, periodic_tolerance)
    if reason != Reason.REACHED:
        return Timing(machine, None, {}, nan, nan, nan, nan, reason, marches)

    # The search may end a turn away: the advance is brought to between the dead time of the solenoids and a turn more.
    target, command = machine.command, result.machine.command
    advance = target.open_target - command.energise
    soonest = speed * opening_curve(machine.valve.solenoid)[0, 0]
    advance = soonest + (advance - soonest) % TURN
    wanted, pulse = target.close_target - target.open_target, command.release - command.energise
    return Timing(
        result.machine,
        result.run,
        result.angles,
        advance,
        advance + wanted - pulse,
        float(result.misses[0]),
        float(result.misses.sum()),
        reason,
        marches,
    )


def _corrected_together(
    machine: Machine, speed: float, start: tuple[float, float] | None, periodic_tolerance: float
) -> Timing:
    """Find the commands of several cylinders, or of two stages: of each alone, then by what they miss together.

    Cylinders that are alike have one command, by their mean miss; the time of a valve hardly depends on its commands.
    A sketch is that of each alone.
    """
    cylinders, own = machines_of(machine), any(machine.cylinder) or machine.stage_2.is_on
    timings = [
        corrected(alone(each), speed, None if own else start, periodic_tolerance)
        for each in (cylinders if own else cylinders[:1])
    ]
    marches = sum(timing.marches for timing in timings)
    for timing in timings:
        if not timing.reachable:
            return timing._replace(machine=machine, marches=marches)
    commands = [(timing.machine.command.energise, timing.machine.command.release) for timing in timings]
    commanded = _with_commands(machine, commands)
    if periodic_tolerance == SKETCH:
        return timings[0]._replace(machine=commanded, run=None, marches=marches)

    # Together they share receiver and shaft: each command is moved by what its valve misses, until all meet.
    reason = Reason.MISSED
    for _ in range(TRIES):
        revolution, marches = run_revolution(commanded, speed), marches + 1
        if revolution.status != Status.DONE:
            return Timing(machine, None, {}, nan, nan, nan, nan, Reason.FAILED, marches)
        runs = cylinder_runs(revolution)
        angles = [valve_angles(each, run) for each, run in zip(cylinders, runs, strict=True)]
        misses = np.array([_misses_of(each, found) for each, found in zip(cylinders, angles, strict=True)])
        moves = misses if own else misses.mean(axis=0, keepdims=True)
        reason = _reason_of_all(misses, revolution)
        if reason == Reason.FAILED or np.abs(moves).max() < TOLERANCE:
            break
        commands = [(command[0] - move[0], command[1] - move[1]) for command, move in zip(commands, moves, strict=True)]
        commanded = _with_commands(machine, commands)
    if reason != Reason.REACHED:
        return Timing(machine, None, {}, nan, nan, nan, nan, reason, marches)

    # What is told of one is told of the first, unless another one does not come to it.
    told = {name: value + 0.0 * sum(each[name] for each in angles) for name, value in angles[0].items()}
    target, command = machine.command, commanded.command
    open_miss, close_miss = misses[np.abs(misses).max(axis=1).argmax()].tolist()
    advance = timings[0].advance + wrapped(target.open_target - command.energise - timings[0].advance)
    release_advance = advance + (target.close_target - target.open_target) - (command.release - command.energise)
    return Timing(commanded, revolution, told, advance, release_advance, open_miss, close_miss, reason, marches)


def _misses_of(machine: Machine, angles: dict[str, float]) -> list[float]:
    """True less target angle of opening and closing [rad] of a cylinder's valve."""
    ends = ("open", machine.command.open_target), ("close", machine.command.close_target)
    return [wrapped(angles[f"valve_{end}_deg"] * DEGREE - target) for end, target in ends]


def alone(machine: Machine) -> Machine:
    """The machine of a cylinder as an engine of that cylinder alone."""
    engine = machine.engine._replace(cylinders=1.0, phases=NO_LIST)
    return machine._replace(engine=engine, stage_2=SecondStage(), cylinder=())


def _with_commands(machine: Machine, commands: Sequence[tuple[float, float]]) -> Machine:
    """Give a machine the command angles [rad] of each stage, of each cylinder, or one pair for all of them."""
    if machine.stage_2.is_on:
        second = _commanded(machine._replace(command=machine.stage_2.command), *commands[1]).command
        return _commanded(machine, *commands[0])._replace(stage_2=machine.stage_2._replace(command=second))
    if len(commands) == 1:
        return _commanded(machine, *commands[0])
    tables = []
    for i, angles in enumerate(commands):
        command = _commanded(machine, *angles).command
        own = dict(machine.cylinder[i]) if i < len(machine.cylinder) else {}
        own |= {"command.energise": command.energise, "command.release": command.release}
        tables.append(tuple(own.items()))
    return _commanded(machine, *commands[0])._replace(cylinder=tuple(tables))


def _reason_of_all(misses: np.ndarray, revolution: Revolution) -> Reason:
    """Judge whether all cylinders meet their targets (n, 2) [rad], in a state that repeats, and if not, why."""
    if np.isnan(misses).any():
        return Reason.FAILED
    if np.abs(misses).max() > REACHED_WITHIN:
        return Reason.MISSED
    return Reason.REACHED if revolution.orbit.converged and revolution.orbit.period == 1 else Reason.NOT_PERIODIC


def start_after(machine: Machine, speed: float, before: Sequence[tuple[float, Timing]]) -> tuple[float, float] | None:
    """Find a start for the search from the times that other speeds needed, on a line through the last two.

    `speed` and the speeds of `before` [rad/s], whose timings are all reached; returns command angle and pulse [rad], or
    None where there are no other speeds.

    >>> timing = Timing(Machine(), None, {}, 0.6, 0.9, 0.0, 0.0, Reason.REACHED, 6)
    >>> energise, pulse = start_after(Machine(), 110.0, [(100.0, timing)])  # the same times at a higher speed
    >>> round(Machine().command.open_target - energise, 3)
    0.66
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


def reason_of(result: Look) -> Reason:
    """Judge whether a command reaches the targets, in a state that repeats every cycle, and if not, why.

    One of REACHED, FAILED, MISSED, NOT_PERIODIC and CROSSES_AGAIN.
    """
    opening, duration = result.misses
    if np.isnan(duration):
        return Reason.FAILED
    if max(abs(opening), abs(opening + duration)) > REACHED_WITHIN:
        return Reason.MISSED
    if not result.run.orbit.converged or result.run.orbit.period != 1:
        return Reason.NOT_PERIODIC
    if _openings(result.machine, result.run) > 1:
        return Reason.CROSSES_AGAIN
    return Reason.REACHED


def _open_loop(machine: Machine, speed: float) -> tuple[float, float]:
    """Find the command angle and the pulse by the delays of the bench [rad]."""
    delays = open_loop_delays(machine)
    opening, closing = speed * np.nan_to_num(delays.opening), speed * np.nan_to_num(delays.closing)
    command = machine.command
    return command.open_target - opening, command.close_target - closing - (command.open_target - opening)


def _approach(look_at: Callable[..., Look], start: Sequence[float], slope: float, last: float) -> Look:
    """Approach the targets from a start by Broyden's method, first by sketches; returns the last look."""
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


def _bracketed(look_at: Callable[..., Look], machine: Machine, last: float) -> tuple[Reason, Any]:
    """Search with the pulse bracketed between one that opens too short and one that opens too long.

    Returns why the targets are not reached, or `REACHED`, and the `Look` that reaches them, perhaps crossing the lap
    again; None if there is none.
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
            result = _approach(look_at, (energise, low + share * (high - low)), (long - short) / (high - low), last)
            reason = reason_of(result)
            if reason in (Reason.REACHED, Reason.CROSSES_AGAIN):
                return reason, result
    return _out_of_reach(short, long, reason), None


def _out_of_reach(short: float, long: float, otherwise: Reason) -> Reason:
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
