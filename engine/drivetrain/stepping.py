"""A drivetrain in steps: commands, supply, and the speed or the load of its shaft changed in between."""

from collections.abc import Sequence
from math import nan
from typing import NamedTuple

import numpy as np

from apesim.air import GasState
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.drivetrain.checkpoint import checkpoint_of, resume_march
from apesim.engine.drivetrain.closure import closure_of_run
from apesim.engine.drivetrain.control import EngineCommands, SensorReadings, commanded, readings_of
from apesim.engine.drivetrain.preparing import TRANSIENT_TOLERANCE, Prepared, accuracy_of, supply_row
from apesim.engine.drivetrain.rates import SHAFT_TRACE
from apesim.engine.drivetrain.run import March, air_of, begin_march, draws_from_supply, longest_piece
from apesim.engine.drivetrain.state import GAS_WORK, LOAD_WORK, SPEED, Drivetrain, shaft_ledger, shaft_states
from apesim.engine.machine import Machine
from apesim.march.adaptive import MAX_EVENTS, Outcome, Status
from apesim.march.stepping import Stepping, Steps
from apesim.packed import numbers_in
from apesim.valve.edges import FAR

SHORT = 2e-3
"""Time up to which a step is marched at once whatever the speed [s]: far below the shortest piece."""
NO_TIMES = np.empty(0)


class DrivetrainSteps(NamedTuple):
    """State of a drivetrain between two steps, see `apesim.march.stepping.Steps`."""

    steps: Steps
    """State of the march."""
    inputs: tuple[np.ndarray, ...]
    """What acts on it: arrays of `DrivetrainStepping.inputs`."""
    books: dict[str, np.ndarray]
    """What was read off its events so far, see `apesim.engine.drivetrain.checkpoint`."""
    readings: SensorReadings | None
    """What sensors tell of the last whole revolution."""
    is_imposed: bool
    """Whether the speed of the shaft is imposed."""


class DrivetrainStepping(Stepping):
    """March of a machine's drivetrain in steps, from where it was prepared, with a schedule for each cylinder or none.

    Inputs stand in arrays of its own, which are changed in place. The tolerance is the relative error of a step of the
    march. `readings` are those of the last whole revolution, None before the first one.

    >>> from apesim.engine.drivetrain.preparing import Course, prepare
    >>> machine = Machine()
    >>> stepping = DrivetrainStepping(machine, prepare(machine, 0.5), [])
    >>> outcome = stepping.march_to(1e-3)
    >>> round(float(stepping.row[0]), 2)  # the angle [deg]
    28.65
    """

    def __init__(
        self,
        machine: Machine,
        prepared: Prepared,
        schedules: Sequence[np.ndarray],
        tolerance: float = TRANSIENT_TOLERANCE,
    ) -> None:
        p, tables, y, mode, _ = prepared
        p = p._replace(numbers=p.numbers.copy())
        columns = len(SHAFT_TRACE) + len(TRACE) * len(p.numbers)
        rows = MAX_EVENTS + 100
        super().__init__(
            p, tables, y.copy(), mode.copy(), np.array([FAR]), accuracy_of(p, tolerance), columns, log_rows=rows
        )
        self.machine, self.prepared, self.schedules = machine, prepared, list(schedules)
        self.books = begin_march(prepared).books
        self.readings: SensorReadings | None = None
        self.inputs = p.schedules, p.numbers, tables.speeds, tables.loads, tables.supplies
        self._temperatures = _temperature_columns(p)
        self._ledger = shaft_ledger(p)

        # Places in the state vector are found by reading one that counts itself.
        groove, control = air_of(p, np.arange(len(y)))
        self._air = groove[draws_from_supply(p)], control

    @property
    def is_imposed(self) -> bool:
        """Whether the speed of the shaft is imposed."""
        return self.p.is_imposed == 1

    def command(self, commands: EngineCommands) -> None:
        """Change the command angles, which each cylinder reads as it next passes its own 180 deg, and the supply."""
        self.schedules = commanded(self.schedules, commands)
        for i, changed in enumerate(self.schedules):
            self.p.schedules[i] = changed
        self.feed(commands.supply_pressure_Pa)

    def feed(self, pressure: float | None = None, temperature: float | None = None) -> None:
        """Change pressure [Pa abs] and temperature [K] of the supply; what is None stays.

        The control air follows, unless the machine states its own pressure.
        """
        if pressure is not None and pressure != self.tables.supplies[0, 1]:
            self.tables.supplies[0, 1:] = supply_row(self.machine, 0.0, float(pressure))[1:]
            self.begin_stretch()
        if temperature is not None and temperature != self.p.numbers[0, self._temperatures[0]]:
            self.p.numbers[:, self._temperatures] = temperature
            self.begin_stretch()

    def impose(self, speed: float) -> None:
        """Change the imposed speed [rad/s]."""
        if speed != self.tables.speeds[0, 1]:
            self.tables.speeds[:, 1] = speed
            self.begin_stretch()

    def load(self, torque: float) -> None:
        """Change the constant part of the load [N m]."""
        if torque != self.tables.loads[0, 1]:
            self.tables.loads[:, 1] = torque
            self.begin_stretch()

    def march_to(self, t: float) -> Outcome:
        """March on to a time [s], in pieces that have room for their events, and read off what ended in it."""
        while True:
            end = t
            if t - self.time > SHORT:
                end = min(t, self.time + longest_piece(self.p, self.y[shaft_states(self.p) + SPEED]))
            outcome = super().march_to(end)
            if outcome.logged:
                self._read_off(outcome.logged)
            if end == t or outcome.status != Status.DONE:
                return outcome

    def _read_off(self, logged: int) -> None:
        """Take the events of a step; of the revolutions the last one is kept."""
        books = self.books
        before = books.began
        books.take(self.log[:logged])
        books.events.clear()
        del books.rows[:-1], books.own_rows[:-1]
        if books.began and books.began is not before and books.rows:
            self.readings = readings_of(self.p, books.last_revolution(books.began[1], self.mode))

    @property
    def air(self) -> tuple[float, float]:
        """Air through the grooves from the supply, and control air, since the start [kg]."""
        groove, control = (self.y[places] - self.start[places] for places in self._air)
        return float(groove.sum()), float(control.sum())

    @property
    def works(self) -> list[float]:
        """Work of the gas above ambient pressure, against friction and of the load since the start [J]."""
        places = slice(self._ledger + GAS_WORK, self._ledger + LOAD_WORK + 1)
        works: list[float] = (self.y[places] - self.start[places]).tolist()
        return works

    def closure(self) -> dict[str, float]:
        """Return the mass, energy and, of a free shaft, work that are not accounted for since the start."""
        told = closure_of_run(self.prepared._replace(y=self.start), self.y)._asdict()
        return {name: float(value) for name, value in told.items() if not np.isnan(value)}

    def copy_all(self) -> DrivetrainSteps:
        """Copy the state between two steps."""
        steps = self.steps()
        marched = March(steps.time, steps.y, steps.mode, Status.DONE, 0, self.books, NO_TIMES, self._rows[:0])
        inputs = tuple(array.copy() for array in self.inputs)
        return DrivetrainSteps(steps, inputs, checkpoint_of(marched), self.readings, self.is_imposed)

    def restore(self, kept: DrivetrainSteps) -> None:
        """Go back to a state that was copied."""
        self.put_back(kept.steps)
        for array, copied in zip(self.inputs, kept.inputs, strict=True):
            array[:] = copied
        self.schedules = [rows.copy() for rows in self.p.schedules[: len(self.schedules)]]
        self.books, self.readings = resume_march(self.prepared, NO_TIMES, kept.books).books, kept.readings


def _temperature_columns(p: Drivetrain) -> np.ndarray:
    """Columns of a drivetrain's numbers that hold the temperatures of the supply and of the control air."""
    unknown = GasState(0.0, nan)
    template = p.template._replace(supply=unknown, control=unknown)
    known = list(numbers_in(p.template))
    return np.array([i for i, (a, b) in enumerate(zip(numbers_in(template), known, strict=True)) if a != a and b == b])
