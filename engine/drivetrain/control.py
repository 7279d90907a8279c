"""Control of a drivetrain: what sensors tell after a revolution, what a controller commands, and how that is taken."""

from collections.abc import Callable, Iterator, Sequence
from numbers import Real
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.angles import DEGREE, RPM
from apesim.engine.command import window_fault
from apesim.engine.cycle.state import receiver_gas
from apesim.engine.cylinder import EPV
from apesim.engine.drivetrain.preparing import stack_schedules, supply_row
from apesim.engine.drivetrain.run import RevolutionEnd
from apesim.engine.drivetrain.state import (
    ENERGISE,
    RELEASE,
    SPEED,
    SUPPLY,
    Drivetrain,
    DrivetrainTables,
    block_of,
    own_modes,
    shaft_modes,
    shaft_states,
)
from apesim.engine.machine import Machine
from apesim.quantities import Fault, InputError, quoted
from apesim.quantities.trees import leaves_of
from apesim.valve.chamber import chamber_state

KEYS = leaves_of(Machine)
"""Keys of a machine file, whose ranges hold for commands, too."""
ANGLES = {
    f"{name}_deg": (float(declared.low), float(declared.high))
    for name in ("energise", "release")
    for declared in (KEYS[f"command.{name}"].declaration,)
}
"""Command angles and their ranges [deg]."""
PRESSURES = tuple(KEYS["supply.pressure"].declaration.ends)
"""Range of the supply's pressure [Pa abs]."""


class SensorReadings(NamedTuple):
    """Readings of an engine's sensors at the end of a revolution of its shaft, for a controller.

    What belongs to each cylinder is a tuple with a number for each of them.

    Examples
    --------
    >>> import apesim
    >>> seen = []
    >>> run = apesim.run_transient(apesim.Machine(), speed="0 s: 600 rpm, 0.2 s: 600 rpm", controller=seen.append)
    >>> type(seen[0]).__name__, round(seen[0].time_s, 3), round(seen[0].mean_speed_rpm)
    ('SensorReadings', 0.1, 600)
    """

    time_s: float
    """Time since the start [s]."""
    turns: int
    """Whole turns of the shaft from where its angles are counted; backward ones count as less."""
    mean_speed_rpm: float
    """Mean speed of the revolution [r/min]; below zero it was backwards."""
    lowest_speed_rpm: float
    """Lowest speed in the revolution [r/min]."""
    highest_speed_rpm: float
    """Highest speed in the revolution [r/min]."""
    end_speed_rpm: float
    """Speed at its end [r/min]."""
    valve_open_deg: tuple[float, ...]
    """Own angle at which each valve opened in the stroke that ended in the revolution [deg]; NaN: none ended."""
    valve_close_deg: tuple[float, ...]
    """Own angle at which it closed [deg]; NaN: none ended."""
    full_lift: tuple[float, ...]
    """1 where it met its open stop in that stroke, 0 where it did not; NaN: none ended."""
    energise_deg: tuple[float, ...]
    """Command that each cylinder follows, read when it last passed its own 180 deg: when it is energised [deg]."""
    release_deg: tuple[float, ...]
    """Command that each cylinder follows: when it is released [deg]."""
    supply_pressure_Pa: float
    """Pressure of the supply [Pa abs]."""
    receiver_pressure_Pa: float
    """Pressure in the receiver [Pa abs], that of the supply where the receiver is infinite."""
    lowest_receiver_pressure_Pa: float
    """Lowest pressure in the receiver in the revolution [Pa abs]."""
    engine_air_kg: float
    """Air through the grooves of all cylinders in the revolution [kg]."""
    control_air_kg: float
    """Control air of all cylinders in the revolution [kg]."""


class EngineCommands(NamedTuple):
    """Commands of a controller to an engine; what is None stays as it is.

    Examples
    --------
    >>> import apesim
    >>> apesim.EngineCommands(release_deg=60.0)
    EngineCommands(energise_deg=None, release_deg=60.0, supply_pressure_Pa=None)
    """

    energise_deg: float | Sequence[float] | None = None
    """Own angle at which each cylinder is energised [deg], or one for all, from -360 to 360."""
    release_deg: float | Sequence[float] | None = None
    """Own angle at which it is released [deg], more than 0 and less than 360 deg after that."""
    supply_pressure_Pa: float | None = None
    """Pressure of the supply from now on [Pa abs]; the control air follows unless the machine states its own."""


Controller = Callable[[SensorReadings], EngineCommands | None]
"""Function that is called at the end of each whole revolution, forwards or backwards; None: all stays as it is."""


class Control:
    """Controller between the pieces of a march: it reads the sensors, asks the controller, and sets what it commands.

    `schedules` are the command angles of each cylinder over speed, (k, 3) [rad/s], [rad], before `limited` changes
    them. Each cylinder reads them at its own 180 deg; where that falls on the end of a revolution, rounding decides
    whether it reads what is commanded there at once, or a turn later.
    """

    def __init__(
        self,
        machine: Machine,
        controller: Controller,
        schedules: Sequence[np.ndarray],
        limited: Callable[[np.ndarray], np.ndarray] = np.asarray,
    ) -> None:
        self.machine, self.controller, self.limited = machine, controller, limited
        self.schedules = list(schedules)

    def __call__(
        self, p: Drivetrain, tables: DrivetrainTables, end: RevolutionEnd
    ) -> tuple[Drivetrain, DrivetrainTables]:
        """Ask the controller at the end of a revolution, and return the drivetrain with what it commands.

        Raises `InputError` where it commands what cannot be.
        """
        commands = self.controller(readings_of(p, end))
        if commands is None:
            return p, tables
        if fault := next(command_faults(self.machine, self.schedules, commands), None):
            wrong, right = fault
            raise InputError([Fault("run_transient()", "controller", f"returned {wrong}", right)])
        self.schedules = commanded(self.schedules, commands)
        limited = [self.limited(rows) for rows in self.schedules]
        p = p._replace(schedules=stack_schedules(limited, len(limited)))

        # The pressure holds until the next one that is imposed; rows of the past are of no use.
        if commands.supply_pressure_Pa is not None:
            row = supply_row(self.machine, end.time, commands.supply_pressure_Pa)
            later = tables.supplies[tables.supplies[:, 0] > end.time]
            tables = tables._replace(supplies=np.vstack(([row], later)))
        return p, tables


def commanded(schedules: Sequence[np.ndarray], commands: EngineCommands) -> list[np.ndarray]:
    """Put the command angles of a controller into schedules (k, 3); those that are None stay.

    A schedule keeps its speeds: where a map holds, a command replaces the angles of all of them.
    """
    changed = [rows.copy() for rows in schedules]
    for column, angles in enumerate((commands.energise_deg, commands.release_deg), 1):
        if angles is not None:
            for rows, angle in zip(changed, _each(angles, len(changed)), strict=True):
                rows[:, column] = angle * DEGREE
    return changed


def _each(angles: Any, count: int) -> list[Any]:
    """Command angles of each cylinder, from those or from one for all [deg]; none where it is neither."""
    if isinstance(angles, list | tuple | np.ndarray):
        return list(angles) if len(angles) == count else []
    return [angles] * count


def command_faults(machine: Machine, schedules: Sequence[np.ndarray], commands: Any) -> Iterator[tuple[str, str]]:
    """Find what is wrong with the commands of a controller to the cylinders of these schedules: wrong, right."""
    if not isinstance(commands, EngineCommands):
        yield quoted(commands), "return an apesim.EngineCommands, or None to keep what holds"
        return
    faults = list(_range_faults(machine, len(schedules), commands))
    yield from faults
    if faults:
        return
    for i, rows in enumerate(commanded(schedules, commands)):
        durations = rows[:, 2] - rows[:, 1]
        row = rows[durations.argmin() if durations.min() <= 0.0 else durations.argmax()]
        if wrong := window_fault("energise_deg", "release_deg", (row[1], row[2])):
            yield f"for cylinder {i + 1}: {wrong[0]}", wrong[1]


def _range_faults(machine: Machine, count: int, commands: EngineCommands) -> Iterator[tuple[str, str]]:
    """What of the commands is no number in its range, for an intake that has none, or for other cylinders."""
    for name, (low, high) in ANGLES.items():
        angles = getattr(commands, name)
        if angles is None:
            continue
        right = f"give a number from {low:g} to {high:g}, or {count} of them"
        if machine.engine.intake != EPV:
            yield f"{name}, and the intake has no commands", f"leave {name} out"
        elif not (each := _each(angles, count)):
            yield f"{name} = {quoted(angles)} for {count} cylinders", right
        elif not all(isinstance(angle, Real) and low <= angle <= high for angle in each):  # type: ignore[operator]
            yield f"{name} = {quoted(angles)}", right
    pressure, (low, high) = commands.supply_pressure_Pa, PRESSURES
    if pressure is not None and not (isinstance(pressure, Real) and low <= pressure <= high):
        yield f"supply_pressure_Pa = {quoted(pressure)}", f"give an absolute pressure from {low:g} to {high:g} Pa"


def readings_of(p: Drivetrain, end: RevolutionEnd) -> SensorReadings:
    """Read what sensors would tell at the end of a revolution."""
    own = [own_modes(end.mode, i) for i in range(len(p.numbers))]
    revolution, cylinders = end.revolution, end.cylinders
    supply = float(end.mode[shaft_modes(p) + SUPPLY])
    first = p.template
    receiver = supply
    if first.receiver_volume > 0.0:
        content = receiver_gas(block_of(end.y, 0))
        receiver = float(chamber_state(first.actuator.gas, content, first.receiver_volume).pressure)
    return SensorReadings(
        time_s=float(end.time),
        turns=end.turns,
        mean_speed_rpm=float(60.0 / revolution["duration"]),
        lowest_speed_rpm=float(revolution["min_speed"] / RPM),
        highest_speed_rpm=float(revolution["max_speed"] / RPM),
        end_speed_rpm=float(end.y[shaft_states(p) + SPEED] / RPM),
        valve_open_deg=tuple((cylinders["open"] / DEGREE).tolist()),
        valve_close_deg=tuple((cylinders["close"] / DEGREE).tolist()),
        full_lift=tuple(cylinders["full_lift"].tolist()),
        energise_deg=tuple(float(modes[ENERGISE] / DEGREE) for modes in own),
        release_deg=tuple(float(modes[RELEASE] / DEGREE) for modes in own),
        supply_pressure_Pa=supply,
        receiver_pressure_Pa=receiver,
        lowest_receiver_pressure_Pa=float(cylinders["min_receiver"][0]),
        engine_air_kg=float(revolution["engine_air"]),
        control_air_kg=float(revolution["control_air"]),
    )
