"""What is imposed on an engine over time, read from text: speeds, loads, pressures and timings."""

from itertools import pairwise
from os import PathLike
from pathlib import Path

import numpy as np

from apesim.engine.angles import DEGREE, RPM
from apesim.engine.drivetrain.feedback_timing import MAX_WINDOW_DEG
from apesim.engine.drivetrain.preparing import machines_of
from apesim.engine.machine import Machine
from apesim.quantities import Arguments, Pressure, Quantity, quoted
from apesim.quantities.files import csv_columns
from apesim.quantities.input_errors import InvalidValue
from apesim.studies.run.operating_conditions import PRESSURE

MOMENT = Quantity("s", 0, 1e5, "command line", typical="1.5 s")
IMPOSED_SPEED = Quantity("rpm", -30000, 30000, "command line", typical="1000 rpm")
START_ANGLE = Quantity("deg", -360, 360, "command line", typical="30 deg")
LOAD_TORQUE = Quantity("N m", -1e6, 1e6, "command line", typical="10 N m")
COLUMNS = {"speed": "rpm", "energise": "deg", "release": "deg"}
"""Columns of a file with command angles over speed, and their units."""
FLOOR_UP_TO, FLOOR_STEP = 3000.0 * RPM, 10.0 * RPM
"""Speeds up to which, and at which, a shortest pulse is laid into a schedule [rad/s]; chosen, linear in between."""
FIXED, FEEDBACK = "fixed", "feedback"
"""Timings that are no file."""
RIGHT_FORM = 'write instants and values, e.g. "0 s: {0}, 1.5 s: {0}"'


def read_course(
    arguments: Arguments, name: str, given: str | None, declaration: Quantity | Pressure, typical: str
) -> np.ndarray:
    """Read values over time such as "0 s: 300 rpm, 1.5 s: 1800 rpm" as rows (n, 2), in SI; faults are noted.

    >>> arguments = Arguments("run_transient")
    >>> rows = read_course(arguments, "load", "0 s: 5 N m, 2 s: 10 N m", LOAD_TORQUE, "10 N m")
    >>> rows.tolist()
    [[0.0, 5.0], [2.0, 10.0]]
    """
    if given is None:
        return np.empty((0, 2))
    rows: list[tuple[float, float]] = []
    right = RIGHT_FORM.format(typical)
    for part in str(given).split(", "):
        instant, found, value = part.partition(":")
        if not found:
            arguments.fault(name, f"{quoted(part)} has no instant", right)
            continue
        time = arguments.quantity(name, instant.strip(), MOMENT)
        number = arguments.quantity(name, value.strip(), declaration)
        if time is not None and number is not None:
            rows.append((time, number))
    times = [time for time, _ in rows]
    if any(later <= earlier for earlier, later in pairwise(times)):
        arguments.fault(name, "the instants do not rise", right)
    return np.array(rows).reshape(-1, 2)


def read_timing(arguments: Arguments, machine: Machine, timing: str | PathLike[str]) -> list[np.ndarray]:
    """Read the command angles of each cylinder over speed, rows (k, 3) of speed [rad/s], energise and release [rad].

    `timing` is "fixed" or "feedback": the machine's commands hold, to begin with. Or it is a CSV with the columns
    speed, energise and release, such as ``apesim engine timing`` writes: its points are interpolated at the machine's
    supply, and those out of reach left out. A second stage keeps its own command; a cylinder that has one of its own is
    a fault, as such a file is of one valve. Faults are noted.
    """
    schedules = commands_of(machine)
    if str(timing) in (FIXED, FEEDBACK):
        return schedules
    refuse_own_commands(arguments, "timing", machine)
    try:
        rows = _schedule_of(csv_columns(Path(timing)), machine)
    except (InvalidValue, ValueError) as wrong:
        right = "give a CSV with the columns " + ", ".join(f"{name} [{unit}]" for name, unit in COLUMNS.items())
        arguments.fault("timing", str(wrong), right)
        return schedules
    return [rows, *schedules[1:]] if machine.stage_2.is_on else [rows] * len(schedules)


def commands_of(machine: Machine) -> list[np.ndarray]:
    """Return the command of each cylinder, or of each stage, as a schedule that is the same at all speeds, (1, 3)."""
    commands = [each.command for each in machines_of(machine)]
    return [np.array([[0.0, command.energise, command.release]]) for command in commands]


def refuse_own_commands(arguments: Arguments, name: str, machine: Machine) -> None:
    """Note a fault of an argument that replaces commands, where a cylinder has one of its own."""
    for index, own in enumerate(machine.cylinder):
        if any(key.startswith("command.") for key, _ in own):
            wrong = f"would replace the command that cylinder[{index + 1}] has of its own"
            arguments.fault(name, wrong, "leave it out, or the keys of command in [[cylinder]]")


def with_floor(rows: np.ndarray, min_pulse: float) -> np.ndarray:
    """Put the release of a schedule (k, 3) off where a pulse is shorter than the shortest one [s], within a turn."""
    fastest = max(float(rows[-1, 0]), FLOOR_UP_TO)
    speeds = np.unique(np.append(rows[:, 0], np.arange(0.0, fastest + FLOOR_STEP, FLOOR_STEP)))
    energise, release = (np.interp(speeds, rows[:, 0], rows[:, column]) for column in (1, 2))
    floor = np.minimum(min_pulse * speeds, MAX_WINDOW_DEG * DEGREE)
    return np.column_stack((speeds, energise, np.maximum(release, energise + floor)))


def _schedule_of(columns: dict[tuple[str, str | None], tuple[str, ...]], machine: Machine) -> np.ndarray:
    """Rows of a schedule from the columns of a CSV, at the supply of a machine."""
    units = {"speed": RPM, "energise": DEGREE, "release": DEGREE}
    found = {name.removesuffix("_rpm").removesuffix("_deg"): np.array(texts) for (name, _), texts in columns.items()}
    if missing := [name for name in units if name not in found]:
        raise ValueError(f"has no column {missing[0]}")
    used = np.ones(len(found["speed"]), dtype=bool)
    if "reachable" in found:
        used = found["reachable"].astype(float) > 0.0
    values = {name: found[name][used].astype(float) * unit for name, unit in units.items()}
    at = {
        "supply_pressure": machine.supply.pressure,
        "supply_temperature": machine.supply.temperature,
    }
    axes = [found[name][used].astype(float) for name in at if name in found]
    rows = []
    for speed in np.unique(values["speed"]):
        here = values["speed"] == speed
        place = [(axis[here], value) for axis, value in zip(axes, at.values(), strict=False)]
        rows.append([speed, *(_between(place, values[name][here]) for name in ("energise", "release"))])
    rows = [row for row in rows if not np.isnan(row).any()]
    if not rows:
        raise ValueError("has no point in reach at the machine's supply")
    return np.array(rows)


def _between(place: list[tuple[np.ndarray, float]], values: np.ndarray) -> float:
    """Interpolate values on a grid of some axes at a place, linear and constant beyond; NaN where the grid has gaps."""
    if not place:
        return float(values[0])
    (axis, at), *others = place
    knots = np.unique(axis)
    along = [
        _between([(other[axis == knot], value) for other, value in others], values[axis == knot]) for knot in knots
    ]
    return float(np.interp(at, knots, along))


def read_supply(arguments: Arguments, given: str | None) -> np.ndarray:
    """Read pressures of the supply over time, as rows of time [s] and pressure [Pa abs]."""
    return read_course(arguments, "supply", given, PRESSURE, "0.8 MPa gauge")
