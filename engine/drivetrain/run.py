"""Runs of a drivetrain over time: in pieces, with a row for each revolution, events and traces."""

from collections.abc import Callable, Iterator
from enum import Enum
from math import pi
from typing import NamedTuple

import numpy as np

from apesim.engine.angles import TURN
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cycle.state import control_ledger, engine_ledger
from apesim.engine.drivetrain.preparing import TRANSIENT_TOLERANCE, Prepared, accuracy_of
from apesim.engine.drivetrain.rates import (
    BROKE_AWAY,
    HALTED,
    HELD_LONG,
    OWN_EVENTS,
    REACHED_ANGLE,
    REACHED_SPEED,
    REVOLVED,
    SHAFT_TRACE,
)
from apesim.engine.drivetrain.state import (
    ANGLE,
    DIRECTION,
    EXCHANGED_HEAT,
    FRICTION_WORK,
    GAS_WORK,
    LOAD_WORK,
    MAX_PRESSURE,
    MAX_RECEIVER,
    MAX_SPEED,
    MAX_TORQUE,
    MIN_RECEIVER,
    MIN_SPEED,
    MIN_TORQUE,
    SPEED,
    WALL_HEAT,
    Drivetrain,
    DrivetrainTables,
    block_of,
    cylinder_of,
    ledger_at,
    ledger_place,
    own_extremes,
    shaft_extremes,
    shaft_ledger,
    shaft_modes,
    shaft_states,
)
from apesim.march.adaptive import LOG_HEAD, MAX_EVENTS, NO_CARRY, Status, march
from apesim.valve.ledger import valve_states
from apesim.valve.motion import CORNER, MET_OPEN

LONGEST_PIECE = 0.25
"""Longest time that is marched at once [s]; chosen."""
EVENTS_A_REVOLUTION = 60
"""Events of a cylinder in a revolution, at most as many as are usual; a piece has room for `MAX_EVENTS` with twice that
speed."""
SLOWEST = 5.0
"""Speed below which a piece is no longer [rad/s]; chosen."""
BEFORE_TARGET = 0.5 * pi
"""How long before its target an opening is seen as early, and not as late by most of a turn [rad]; chosen."""
AT_LAP = 1e-6
"""Distance from the lap at which a corner of the groove's table is the lap [m]; chosen, far above rounding."""


class EventKind(Enum):
    """What happens to a shaft, with its number among the events of the shaft."""

    FIRST_MOTION = "first motion"
    HALT = "speed zero"
    REST = "at rest"
    ANGLE_REACHED = "angle reached"
    SPEED_REACHED = "speed reached"
    HELD = "held"


KINDS = {
    BROKE_AWAY: EventKind.FIRST_MOTION,
    HALTED: EventKind.HALT,
    REACHED_ANGLE: EventKind.ANGLE_REACHED,
    REACHED_SPEED: EventKind.SPEED_REACHED,
    HELD_LONG: EventKind.HELD,
}
"""Kind of each event of the shaft that is told."""


class ShaftEvent(NamedTuple):
    """Event of the shaft."""

    kind: EventKind
    """What happened."""
    time: float
    """When [s]."""
    angle: float
    """Angle of the shaft from where its angles are counted [rad]."""
    speed: float
    """Its speed [rad/s]."""
    engine_air: float
    """Air from the supply through the grooves since the start [kg]."""
    control_air: float
    """Control air since the start [kg]."""


REVOLUTION = (
    *("start", "duration", "gas_work", "friction_work", "load_work", "engine_air", "control_air", "exchanged_heat"),
    *("min_speed", "max_speed", "min_torque", "max_torque", "wall_heat"),
)
"""Quantities of a revolution: times [s], works [J], masses [kg], heats [J], extremes of speed [rad/s] and torque [N m].
"""
OWN_REVOLUTION = (
    *("gas_work", "engine_air", "control_air", "max_pressure", "min_receiver", "max_receiver"),
    *("open", "close", "full_lift"),
)
"""Quantities of each cylinder in a revolution: work above ambient pressure [J], masses [kg], pressures [Pa abs]; of the
valve's stroke that ended in it the own angles at which it opened and closed [rad], 1 where it met its open stop; NaN
where none ended.
"""


class RevolutionEnd(NamedTuple):
    """End of a whole revolution in a march that stops there."""

    time: float
    """When it is [s]."""
    turns: int
    """Whole turns of the shaft until then."""
    revolution: dict[str, float]
    """`REVOLUTION` of it."""
    cylinders: dict[str, np.ndarray]
    """`OWN_REVOLUTION` of it, (n,) each."""
    y: np.ndarray
    """State vector from which the march goes on."""
    mode: np.ndarray
    """Modes from which it goes on."""


Act = Callable[[Drivetrain, DrivetrainTables, RevolutionEnd], tuple[Drivetrain, DrivetrainTables]]
"""Function that changes what is imposed on a drivetrain at the end of a revolution."""


class DrivetrainRun(NamedTuple):
    """March of a drivetrain over time."""

    revolutions: dict[str, np.ndarray]
    """`REVOLUTION` of each whole revolution, (r,) each; the duration of a backward one is negative."""
    cylinders: dict[str, np.ndarray]
    """`OWN_REVOLUTION` of each cylinder in each of them, (r, n) each."""
    events: tuple[ShaftEvent, ...]
    """Events of the shaft."""
    times: np.ndarray
    """Times of the trace [s], (t,)."""
    trace: np.ndarray
    """Rows of the trace, see `apesim.engine.drivetrain.rates.observe_drivetrain`, (t, c)."""
    duration: float
    """Time marched [s]."""
    turns: float
    """Turns of the shaft from where its angles are counted."""
    y: np.ndarray
    """State vector at the end."""
    mode: np.ndarray
    """Modes at the end."""
    status: Status
    """How the march ended."""
    steps: int
    """Steps in all."""


class Books:
    """What is read off the logs of the pieces of a march."""

    def __init__(self, prepared: Prepared) -> None:
        self.p = prepared.p
        self.count = len(self.p.numbers)
        self.turns = 0
        self.rows: list[list[float]] = []
        self.own_rows: list[np.ndarray] = []
        self.events: list[ShaftEvent] = []
        self.opened, self.is_full = np.full(self.count, np.nan), [False] * self.count
        self.strokes = np.full((3, self.count), np.nan)
        self.laps = [cylinder_of(self.p, prepared.y, prepared.mode, i) for i in range(self.count)]
        self.began: tuple[float, np.ndarray] | None = None
        self.sense = 1
        if prepared.y[shaft_states(self.p) + ANGLE] == 0.0:
            self.began = 0.0, prepared.y.copy()

    def take(self, log: np.ndarray) -> None:
        """Take the log of a piece."""
        first = OWN_EVENTS * self.count
        for row in log:
            code = int(row[1])
            if code < 0:
                continue
            y = row[LOG_HEAD:]
            if code < first:
                i, own_event = divmod(code, OWN_EVENTS)
                if own_event == CORNER:
                    self._note_lap(i, y)
                self.is_full[i] = self.is_full[i] or own_event == MET_OPEN
                continue
            if code - first == REVOLVED:
                self._end_revolution(row[0], y)
            elif (kind := KINDS.get(code - first)) is not None:
                self.events.append(self._event(kind, row[0], y))

    def _event(self, kind: EventKind, time: float, y: np.ndarray) -> ShaftEvent:
        """An event of the shaft at a state."""
        shaft = shaft_states(self.p)
        angle, speed = TURN * self.turns + y[shaft + ANGLE], y[shaft + SPEED]
        engine, control = drawn_air_of(self.p, y)
        return ShaftEvent(kind, time, float(angle), float(speed), engine, control)

    def _note_lap(self, i: int, y: np.ndarray) -> None:
        """Note the own angle at which the valve of a cylinder crosses its lap; a stroke counts where it closes."""
        valve, states = self.laps[i].actuator.valve, valve_states(block_of(y, i))
        if abs(valve.stroke - states.position - self.laps[i].lap) < AT_LAP:
            angle = y[shaft_states(self.p) + ANGLE] - self.p.phases[i]
            start = self.laps[i].open_target - BEFORE_TARGET
            angle = start + (angle - start) % TURN
            if states.speed < 0.0:
                self.opened[i], self.is_full[i] = angle, False
            else:
                self.strokes[:, i] = self.opened[i], angle, self.is_full[i]

    def _end_revolution(self, time: float, y: np.ndarray) -> None:
        """End a revolution; one that the shaft does not finish the way it began is none."""
        turn = 1 if y[shaft_states(self.p) + ANGLE] > pi else -1
        if self.began and turn == self.sense:
            before_time, before = self.began
            ledger, extremes = shaft_ledger(self.p), shaft_extremes(self.p)
            change = y[:extremes] - before[:extremes]
            (engine, control), gas = air_of(self.p, change), gas_work_of(self.p, change)
            self.rows.append(
                [
                    before_time,
                    turn * (time - before_time),
                    change[ledger + GAS_WORK],
                    change[ledger + FRICTION_WORK],
                    change[ledger + LOAD_WORK],
                    *drawn_air_of(self.p, change),
                    change[ledger + EXCHANGED_HEAT],
                    *y[[extremes + MIN_SPEED, extremes + MAX_SPEED, extremes + MIN_TORQUE, extremes + MAX_TORQUE]],
                    change[ledger + WALL_HEAT],
                ]
            )
            own = [own_extremes(self.p, i) for i in range(self.count)]
            pressures = [y[[place + which for place in own]] for which in (MAX_PRESSURE, MIN_RECEIVER, MAX_RECEIVER)]
            self.own_rows.append(np.array([gas, engine, control, *pressures, *self.strokes]))
        self.turns += turn
        self.began, self.sense = (time, y.copy()), turn
        self.strokes = np.full((3, self.count), np.nan)

    def last_revolution(self, y: np.ndarray, mode: np.ndarray) -> RevolutionEnd:
        """Last whole revolution, with the state from which the march goes on."""
        revolution = dict(zip(REVOLUTION, self.rows[-1], strict=True))
        cylinders = dict(zip(OWN_REVOLUTION, self.own_rows[-1], strict=True))
        return RevolutionEnd(self.began[0], self.turns, revolution, cylinders, y, mode)  # type: ignore[index]


def air_of(p: Drivetrain, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Read the air through the grooves and the control air of all cylinders [kg], (n,) each, from a state vector."""
    ledgers = [ledger_at(y, ledger_place(p, i)) for i in range(len(p.numbers))]
    grooves = [engine_ledger(ledger).groove.mass for ledger in ledgers]
    return np.array(grooves), np.array([control_ledger(ledger).line_fed.mass for ledger in ledgers])


def draws_from_supply(p: Drivetrain) -> np.ndarray:
    """Which cylinders draw from the receiver behind the supply, (n,): a second stage draws what the first has used."""
    return p.sources == 0


def drawn_air_of(p: Drivetrain, y: np.ndarray) -> tuple[float, float]:
    """Read the engine air and the control air that the supply has given [kg], from a state vector."""
    engine, control = air_of(p, y)
    return float(engine[draws_from_supply(p)].sum()), float(control.sum())


def gas_work_of(p: Drivetrain, change: np.ndarray) -> np.ndarray:
    """Work of the gas in each cylinder over whole revolutions [J], (n,), from the change of a state vector."""
    return np.array([engine_ledger(ledger_at(change, ledger_place(p, i))).work for i in range(len(p.numbers))])


class March(NamedTuple):
    """March of a drivetrain so far, from which it goes on; `apesim.engine.drivetrain.checkpoint` keeps one."""

    time: float
    """Time that is reached [s]."""
    y: np.ndarray
    """State vector there."""
    mode: np.ndarray
    """Modes there."""
    status: Status
    """How the last piece ended."""
    steps: int
    """Steps so far."""
    books: Books
    """What was read off the logs so far."""
    times: np.ndarray
    """Times of the trace [s], (t,), those to come among them."""
    trace: np.ndarray
    """Rows of the trace, (t, c); NaN where it has not come to."""


def begin_march(prepared: Prepared, times: np.ndarray | None = None) -> March:
    """Begin a march, of which nothing is done; `times` (t,) [s] are those of the trace, ascending."""
    times = np.empty(0) if times is None else times
    trace = np.full((len(times), len(SHAFT_TRACE) + len(prepared.p.numbers) * len(TRACE)), np.nan)
    return March(0.0, prepared.y.copy(), prepared.mode.copy(), Status.DONE, 0, Books(prepared), times, trace)


def longest_piece(p: Drivetrain, speed: float) -> float:
    """Return the longest time that is marched at once at a speed [rad/s], so that there is room for its events [s]."""
    events = 2.0 * EVENTS_A_REVOLUTION * len(p.numbers)
    return min(LONGEST_PIECE, MAX_EVENTS / events * TURN / max(abs(speed), SLOWEST))


def march_pieces(
    prepared: Prepared,
    begin: March,
    duration: float,
    tolerance: float = TRANSIENT_TOLERANCE,
    act: Act | None = None,
) -> Iterator[March]:
    """March a drivetrain on from where a march has come to, and yield the march after each piece.

    The pieces depend on nothing but the state, so that one that goes on makes those of one that was never left.
    The arrays of what is yielded are those of `begin`: the next piece changes them. `act` is called at the end of each
    whole revolution, either way, of a drivetrain whose goal ends a march there; what it changes is kept nowhere else.
    """
    p, tables, _, _, breakpoints = prepared
    t, y, mode, status, steps, books, times, trace = begin
    count = len(p.numbers)
    log = np.empty((MAX_EVENTS + 100 + 2 * len(breakpoints), LOG_HEAD + len(y)))
    accuracy = accuracy_of(p, tolerance)
    while t < duration and status == Status.DONE:
        end = min(duration, t + longest_piece(p, y[shaft_states(p) + SPEED]))
        stops = np.append(breakpoints[(breakpoints > t) & (breakpoints < end)], end)
        first = np.searchsorted(times, t, side="left" if t == 0.0 else "right")
        stop = np.searchsorted(times, end, side="right")
        outcome = march(p, tables, t, y, mode, stops, accuracy, log, times[first:stop], trace[first:stop], NO_CARRY)
        known = len(books.rows)
        books.take(log[: outcome.logged])
        t, steps, status = float(log[outcome.logged - 1, 0]), steps + outcome.steps, Status(outcome.status)
        if act and status == Status.STOPPED and int(log[outcome.logged - 1, 1]) == OWN_EVENTS * count + REVOLVED:
            status = Status.DONE
            if len(books.rows) > known:
                p, tables = act(p, tables, books.last_revolution(y, mode))
        yield March(t, y, mode, status, steps, books, times, trace)


def run_drivetrain(
    prepared: Prepared,
    duration: float,
    times: np.ndarray | None = None,
    tolerance: float = TRANSIENT_TOLERANCE,
    report: Callable[[float], object] | None = None,
    act: Act | None = None,
) -> DrivetrainRun:
    """March a drivetrain for a time [s], or until it has reached what it waits for.

    `times` (t,) [s] are those of the trace, ascending. `report` is told the time reached after each piece; `act`
    as for `march_pieces`.
    """
    marched = begin_march(prepared, times)
    for piece in march_pieces(prepared, marched, duration, tolerance, act):
        marched = piece
        if report:
            report(marched.time)
    return run_of(marched)


def run_of(marched: March) -> DrivetrainRun:
    """Make the run of a march that has ended."""
    t, y, mode, status, steps, books, times, trace = marched
    p = books.p
    rows = np.array(books.rows).reshape(-1, len(REVOLUTION))
    own = np.array(books.own_rows).reshape(-1, len(OWN_REVOLUTION), books.count)
    reached = times <= t
    return DrivetrainRun(
        dict(zip(REVOLUTION, rows.T, strict=True)),
        {name: own[:, i] for i, name in enumerate(OWN_REVOLUTION)},
        tuple(_told(books.events, mode[shaft_modes(p) + DIRECTION] == 0.0)),
        times[reached],
        trace[reached],
        t,
        books.turns + y[shaft_states(p) + ANGLE] / TURN,
        y,
        mode,
        status,
        steps,
    )


def _told(events: list[ShaftEvent], is_held: bool) -> Iterator[ShaftEvent]:
    """Events as they are told: a halt that the shaft does not leave is where it is at rest."""
    for i, event in enumerate(events):
        leaves = any(later.kind is EventKind.HALT for later in events[i + 1 :])
        if event.kind is EventKind.HALT and is_held and not leaves:
            yield event._replace(kind=EventKind.REST)
        else:
            yield event
