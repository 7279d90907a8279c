"""Periodic state of a drivetrain: at an imposed speed, or of a shaft that is free."""

from collections.abc import Sequence
from math import nan
from typing import NamedTuple

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cycle.cylinder_laws import RECEIVER_EXTREMUM, TEMPERATURE_EXTREMUM, TRACE
from apesim.engine.cycle.state import LEDGER, SIZE
from apesim.engine.drivetrain.closure import Closure, closure_of_run
from apesim.engine.drivetrain.preparing import (
    NO_GOAL,
    TRANSIENT_TOLERANCE,
    Course,
    Prepared,
    accuracy_of,
    begin_ledgers,
    machines_of,
    prepare,
    released,
    shift_times,
)
from apesim.engine.drivetrain.rates import OWN_EVENTS, SHAFT_TRACE
from apesim.engine.drivetrain.run import air_of
from apesim.engine.drivetrain.state import (
    ANGLE,
    GAS_WORK,
    MARGIN,
    OWN_MODES,
    PEAK,
    SHAFT_STATES,
    SPEED,
    TURNS,
    Drivetrain,
    block_of,
    cylinder_of,
    ledger_at,
    ledger_place,
    own_extremes,
    own_modes,
    shaft_extremes,
    shaft_ledger,
    shaft_modes,
    shaft_states,
)
from apesim.engine.exergy import RATES
from apesim.engine.machine import Machine
from apesim.engine.steady import SteadyRun, relative_change
from apesim.march.adaptive import (
    BREAKPOINT,
    EVENTS,
    LOG_HEAD,
    LOG_ROWS,
    ZERO_CROSSING,
    Accuracy,
    Status,
)
from apesim.march.periodic import Drive, Orbit, Record, orbit_of

LONGEST_REST = 0.25
"""Time for which a free shaft is held that has no periodic state [s]; chosen, as in a start."""
LONGEST_REVOLUTION = 60.0
"""Time that a free shaft may take for a revolution [s]; chosen."""
SLACK = 1.5
"""Time that is marched at most for a revolution at an imposed speed, over that which it takes; chosen."""
ROOM = 4000
"""Rows of the log of a revolution that is not recorded; the last one tells when it ends."""
ROWS_TO_INVERT = 2881
"""Rows from which the times of a free shaft's angles are found; chosen: cubics between them are exact to 1e-9."""
SHARE_OF_ENERGY = 0.05
"""Share of a heavy shaft's kinetic energy, twice that, which the work of a revolution counts as; chosen."""
REVOLUTION_GOAL = NO_GOAL._replace(max_rest=LONGEST_REST, ends_with_revolution=1)
"""What ends the march of a revolution."""


class Revolutions(Drive):
    """Drivetrain whose cycle is a forward revolution of its shaft, from angle 0 on.

    What a revolution adds to the speed counts `leap` times: a heavy shaft comes to its periodic state, which stays the
    same, as soon as a light one. The pressures that friction follows are no states of the search: each revolution goes
    on from those of the one before.
    """

    def __init__(self, prepared: Prepared, longest: float, accuracy: Accuracy, leap: float = 1.0) -> None:
        super().__init__(prepared.p, prepared.tables, np.array([longest]), accuracy)
        self.leap = leap
        self.phases: Sequence[int] = range(0, OWN_MODES * len(prepared.p.numbers), OWN_MODES)
        self.log = np.empty((ROOM, LOG_HEAD + len(prepared.y)))
        self.peak_places = [own_extremes(prepared.p, i) + PEAK for i in range(len(prepared.p.numbers))]
        self.peaks: np.ndarray | None = None
        self.duration = nan

    def clear_ledger(self, y: np.ndarray) -> None:
        """Let ledgers and extremes begin anew, all but the pressures that friction follows; changes `y`."""
        begin_ledgers(self.p, y)

    def march_once(self, y: np.ndarray, mode: np.ndarray, record: Record) -> int:
        """March a revolution, see `Drive.march_once`; `Status.STOPPED` where the shaft does not finish one forwards."""
        place, turns = shaft_states(self.p) + ANGLE, shaft_modes(self.p) + TURNS
        speed = shaft_states(self.p) + SPEED
        y[place], mode[turns], before = MARGIN, 0.0, y[speed]
        if self.peaks is not None:
            y[self.peak_places] = self.peaks
        status = super().march_once(y, mode, record)
        if status not in (Status.DONE, Status.STOPPED):
            return status

        # Its last row tells when it ended, unless the log was full.
        log = record.log if len(record.log) else self.log
        if self.outcome.logged == len(log):
            return Status.TOO_MANY_EVENTS
        self.duration = float(log[self.outcome.logged - 1, 0])
        if mode[turns] != 1.0:
            return Status.STOPPED
        y[place], y[speed] = MARGIN, before + self.leap * (y[speed] - before)
        shift_times(self.p, mode, self.duration)
        self.peaks = y[self.peak_places]
        return Status.DONE


class Revolution(NamedTuple):
    """Revolution of a drivetrain in its periodic state."""

    machines: Sequence[Machine]
    """Machine of each cylinder, or stage."""
    prepared: Prepared
    """Drivetrain with its state at the start."""
    orbit: Orbit
    """Periodic state, and how it was found."""
    is_free: bool
    """Whether the shaft is free; else its speed is imposed."""
    end: np.ndarray
    """State vector at the end; of a period of some revolutions its ledgers are their mean."""
    log: np.ndarray
    """Breakpoints, events and zero crossings, see `apesim.march.adaptive.march`; the last row ends the revolution."""
    angles: np.ndarray
    """Angles of the shaft in the trace [rad], (t,)."""
    trace: np.ndarray
    """Rows of the trace, see `apesim.engine.drivetrain.rates.observe_drivetrain`, (t, c)."""
    speed: float
    """Mean speed [rad/s]."""
    closure: Closure
    """What it does not account for."""
    work_by_quadrature: float
    """Work of the gas above ambient pressure by quadrature of the power over the dense output [J]."""
    work_change: float
    """Relative change of that work at tenfold tolerance."""
    air_change: float
    """Relative change of the air through all grooves at tenfold tolerance."""
    tolerance: float
    """Relative tolerance of a step."""
    status: int
    """How the march ended, `apesim.march.adaptive.Status`."""
    steps: int
    """Steps of the revolution."""


def settle_at(
    machine: Machine, speed: float, schedules: Sequence[np.ndarray] = (), tolerance: float = TRANSIENT_TOLERANCE
) -> tuple[Prepared, Revolutions, Orbit]:
    """March a drivetrain at a constant speed [rad/s], with its schedules if any, to its periodic state at angle 0."""
    longest = SLACK * TURN / speed
    course = Course(np.array([[0.0, speed], [longest, speed]]), schedules=schedules)
    prepared = prepare(machine, 0.0, course, REVOLUTION_GOAL)
    drive = Revolutions(prepared, longest, accuracy_of(prepared.p, tolerance))
    return prepared, drive, orbit_of(drive, prepared.y, prepared.mode)


def run_revolution(
    machine: Machine,
    speed: float,
    is_free: bool = False,
    tolerance: float = TRANSIENT_TOLERANCE,
    angle_step: float = 0.5 * DEGREE,
    trace_start: float | None = None,
) -> Revolution:
    """March a drivetrain to its periodic state at a speed [rad/s], and through one more revolution that is recorded.

    A free shaft is let go from there, and its own periodic state found. The rows of the trace are `angle_step` [rad] of
    the shaft apart over a turn from `trace_start` [rad] on, by default from the energising.
    """
    prepared, drive, orbit = settle_at(machine, speed, tolerance=tolerance)
    accuracy = drive.accuracy
    if is_free and orbit.status == Status.DONE:
        free = prepare(machine, 0.0, goal=REVOLUTION_GOAL)
        work = abs(gas_work(prepared.p, drive.march(orbit.y, orbit.mode)[0]))
        prepared = released(free, orbit.y, orbit.mode, 0.0)
        leap = max(1.0, SHARE_OF_ENERGY * machine.shaft.inertia * speed**2 / work) if work > 0.0 else 1.0
        drive = Revolutions(prepared, LONGEST_REVOLUTION, accuracy, leap)
        orbit = orbit_of(drive, prepared.y, prepared.mode)
    prepared = prepared._replace(y=orbit.y, mode=orbit.mode)

    # Angles of the trace within the revolution, ascending, and when the shaft comes to them.
    begin = machine.command.energise if trace_start is None else trace_start
    angles = begin + angle_step * np.arange(round(TURN / angle_step))
    order = np.argsort(angles % TURN)
    within = np.maximum(angles[order] % TURN, MARGIN)
    is_found = orbit.status == Status.DONE
    times = _times_of(drive, prepared, within) if is_free and is_found else (within - MARGIN) / speed

    # The revolution that is recorded, followed by zero crossings.
    limit = float(drive.breakpoints[0])
    recorded = Revolutions(prepared._replace(p=prepared.p._replace(is_followed=1)), limit, accuracy)
    columns = len(SHAFT_TRACE) + len(TRACE) * len(prepared.p.numbers)
    record = Record(np.empty((LOG_ROWS, LOG_HEAD + len(orbit.y))), times, np.full((len(times), columns), nan))
    end, mode, status = recorded.march(orbit.y, orbit.mode, record=record)
    outcome = recorded.outcome
    closure = closure_of_run(prepared, end)

    # The others of its period, of whose ledgers the mean is taken; and one at tenfold tolerance, for the error.
    summed = slice(shaft_states(prepared.p) + SHAFT_STATES, shaft_extremes(prepared.p))
    ledgers, y = [end[summed].copy()], end
    for _ in range(orbit.period - 1):
        y, mode, _ = recorded.march(y, mode)
        ledgers.append(y[summed])
    end[summed] = np.mean(ledgers, axis=0)
    coarse, _, _ = Revolutions(prepared, limit, accuracy.tenfold()).march(orbit.y, orbit.mode)
    trace = np.empty_like(record.trace)
    trace[order] = record.trace
    return Revolution(
        machines_of(machine),
        prepared,
        orbit,
        is_free,
        end,
        record.log[: outcome.logged],
        np.append(angles, begin + TURN),
        np.concatenate((trace, trace[:1])),
        TURN / recorded.duration if is_free else speed,
        closure,
        outcome.work,
        relative_change(gas_work(prepared.p, coarse), gas_work(prepared.p, end)),
        relative_change(air_of(prepared.p, coarse)[0].sum(), air_of(prepared.p, end)[0].sum()),
        tolerance,
        int(status if orbit.status == Status.DONE else orbit.status),
        outcome.steps,
    )


def _times_of(drive: Revolutions, prepared: Prepared, angles: np.ndarray) -> np.ndarray:
    """Find when a free shaft comes to angles [rad] of its revolution, by cubics between rows of a trace [s]."""
    from scipy.interpolate import CubicHermiteSpline  # takes long to import, and few need it

    drive = Revolutions(prepared, float(drive.breakpoints[0]), drive.accuracy)
    drive.march(prepared.y, prepared.mode)
    times = np.linspace(0.0, drive.duration, ROWS_TO_INVERT)
    rows = np.full((ROWS_TO_INVERT, len(SHAFT_TRACE) + len(TRACE) * len(prepared.p.numbers)), nan)
    drive.march(prepared.y, prepared.mode, record=Record(np.empty((0, 0)), times, rows))
    degrees, rpm = (rows[:, SHAFT_TRACE.index(name)] for name in ("angle [deg]", "speed [rpm]"))
    known = ~np.isnan(degrees)
    return CubicHermiteSpline(degrees[known] * DEGREE, times[known], 60.0 / TURN / rpm[known])(angles)


def gas_work(p: Drivetrain, y: np.ndarray) -> float:
    """Work of the gas above ambient pressure in a state vector's ledger [J]."""
    return float(y[shaft_ledger(p) + GAS_WORK])


def cylinder_runs(revolution: Revolution) -> list[SteadyRun]:
    """Give the revolution of each cylinder as a cycle of that cylinder alone, counted from its own energising.

    Times are those at which a shaft of constant speed would have the same angles. Closures, exergy and changes at
    tenfold tolerance are of all cylinders together, and NaN here.
    """
    p, y, mode = revolution.prepared.p, revolution.prepared.y, revolution.prepared.mode
    speed, place, log = revolution.speed, shaft_states(p) + ANGLE, revolution.log
    runs = []
    for i in range(len(p.numbers)):
        cycle = cylinder_of(p, y, mode, i)._replace(speed=speed)

        # Rows from the own energising on: those that the shaft passes before it come last.
        since = (log[:, LOG_HEAD + place] - p.phases[i] - cycle.start) % TURN
        first = int(np.argmax(np.diff(since, prepend=since[0]) < -0.5 * TURN))
        block = block_of(np.arange(len(y), dtype=float), i).astype(int)
        rows = np.column_stack((since / speed, _own_codes(log[:, 1], i), log[:, 2], log[:, LOG_HEAD + block]))
        rows = np.roll(rows, -first, axis=0)
        is_extremum = np.isin(rows[:, 1], (ZERO_CROSSING + RECEIVER_EXTREMUM, ZERO_CROSSING + TEMPERATURE_EXTREMUM))

        start, end = np.zeros(SIZE), np.zeros(SIZE)
        start[:LEDGER], end[:LEDGER] = block_of(y, i), block_of(revolution.end, i)
        end[LEDGER:] = ledger_at(revolution.end, ledger_place(p, i))[LEDGER:]
        column = len(SHAFT_TRACE) + len(TRACE) * i
        runs.append(
            SteadyRun(
                cycle,
                revolution.orbit._replace(y=start, mode=own_modes(revolution.orbit.mode, i)),
                start,
                end,
                rows[~is_extremum],
                rows[is_extremum],
                revolution.angles,
                revolution.trace[:, column : column + len(TRACE)],
                nan,
                np.full(SIZE + RATES, nan),
                nan,
                nan,
                revolution.tolerance,
                revolution.status,
                revolution.steps,
            )
        )
    return runs


def _own_codes(codes: np.ndarray, i: int) -> np.ndarray:
    """Codes of a log as a cycle of one cylinder has them; what is not of that cylinder is a breakpoint."""
    is_crossing = codes >= ZERO_CROSSING
    number = codes - ZERO_CROSSING * is_crossing - OWN_EVENTS * i
    is_own = (number >= 0) & (number < EVENTS) & (codes >= 0)
    return np.where(is_own, number + ZERO_CROSSING * is_crossing, BREAKPOINT)
