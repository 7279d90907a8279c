"""Starts from rest as variables of an archive: numbers, and the intervals of angles from which an engine starts."""

from collections.abc import Iterable, Sequence
from math import nan
from typing import Any, NamedTuple

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.grid import axes_of, places_of
from apesim.engine.angles import DEGREE
from apesim.engine.drivetrain.preparing import NO_COURSE, Course
from apesim.engine.drivetrain.rates import SHAFT_TRACE
from apesim.engine.drivetrain.run import EventKind
from apesim.engine.drivetrain.start import Start, find_intervals, run_start
from apesim.engine.machine import Machine
from apesim.studies.archives.run_result import axis_of
from apesim.studies.transient.courses import commands_of

NUMBERS = {
    "starts": ("1", "whether the shaft turns thrice; where all angles are asked for, from any of them"),
    "time_s": ("s", "time until the target speed, or without one until three turns"),
    "turns": ("1", "turns until then"),
    "engine_air_kg": ("kg", "air from the supply through the grooves until then"),
    "control_air_kg": ("kg", "control air until then"),
    "first_motion_s": ("s", "when the shaft begins to move"),
    "lowest_speed_rpm": ("r/min", "lowest speed after the first motion; below zero it kicks back"),
    "highest_speed_rpm": ("r/min", "highest speed of the march"),
    "starting_share": ("1", "share of all angles from which it starts; of one angle 1 or 0"),
}
"""Numbers of a start; where all angles are asked for, only the first and the last are known."""
INTERVAL_ENDS = {
    "interval_low_deg": "lower end of an interval of angles from which the engine starts",
    "interval_high_deg": "upper end of it, above 360 where the interval passes zero",
}
Intervals = tuple[tuple[float, float], ...]
"""Ends of intervals of the shaft's angle [deg]."""
SAMPLE, TRACED = 0.5e-3, 5.0
"""Time between two rows of the trace of a start, of which extreme speeds are told, too; up to when it is traced [s]."""


class Starting(NamedTuple):
    """How starts are asked for."""

    angle: float | None
    """Angle of the shaft at rest [rad]; None: all angles."""
    target: float
    """Speed at which time, turns and air are read [rad/s]; NaN: after three turns."""
    release: float | None
    """Release while cranking [rad]; None: that of the command."""

    def cranking_of(self, machine: Machine) -> tuple[Machine, Course]:
        """Make the machine that cranks, and its course.

        While it cranks the command is another: each cylinder reads the usual one as it first passes its own 180 deg.
        """
        if self.release is None:
            return machine, NO_COURSE
        command = machine.command
        course = Course(schedules=commands_of(machine))
        return machine._replace(command=command._replace(release=self.release)), course


class Started(NamedTuple):
    """What was asked for of one machine."""

    values: dict[str, Any]
    """`NUMBERS` of it."""
    intervals: Intervals
    """Angles from which it starts; none where one angle was asked for."""
    start: Start | None
    """March from that angle; None where all were asked for."""


def start_machine(machine: Machine, starting: Starting) -> Started:
    """Start a machine from one angle, or find the angles from which it starts."""
    cranked, course = starting.cranking_of(machine)
    if starting.angle is None:
        intervals = tuple((low / DEGREE, high / DEGREE) for low, high in find_intervals(cranked, course))
        return Started(values_of_all(intervals), intervals, None)
    start = run_start(cranked, starting.angle, starting.target, course, np.arange(0.0, TRACED, SAMPLE))
    return Started(values_of(start), (), start)


def values_of(start: Start) -> dict[str, Any]:
    """Numbers of a start from one angle, by their keys in JSON."""
    speeds = start.run.trace[:, SHAFT_TRACE.index("speed [rpm]")]
    first = [event.time for event in start.run.events if event.kind is EventKind.FIRST_MOTION]
    if not first and speeds.any():  # nothing held it at the start
        first = [0.0]
    return {
        "starts": start.starts,
        "time_s": start.time,
        "turns": start.turns,
        "engine_air_kg": start.engine_air,
        "control_air_kg": start.control_air,
        "first_motion_s": first[0] if first else nan,
        "lowest_speed_rpm": float(speeds.min(initial=0.0)),
        "highest_speed_rpm": float(speeds.max(initial=0.0)),
        "starting_share": float(start.starts),
    }


def values_of_all(intervals: Intervals) -> dict[str, Any]:
    """Numbers of the starts from all angles, by their keys in JSON; most are NaN."""
    share = sum(high - low for low, high in intervals) / 360.0
    return dict.fromkeys(NUMBERS, nan) | {"starts": share > 0.0, "starting_share": share}


def interval_variables(intervals: Sequence[Intervals]) -> dict[str, Variable]:
    """Lay out the intervals of each run; NaN behind the last of those that have fewer."""
    count = max(map(len, intervals), default=0)
    ends = np.full((len(INTERVAL_ENDS), len(intervals), count), nan)
    for run, each in enumerate(intervals):
        ends[:, run, : len(each)] = np.reshape(each, (-1, 2)).T
    variables = axis_of("interval", np.arange(1, count + 1), "1", "interval of angles, ascending")
    for (name, text), values in zip(INTERVAL_ENDS.items(), ends, strict=True):
        variables[name] = Variable(("run", "interval"), values, "deg", text)
    return variables


def intervals_of(archive: Archive, run: int = 0) -> Intervals:
    """Read the intervals of a run back; none where it was of one angle."""
    if "interval" not in archive.variables:
        return ()
    ends = [archive.variables[name].values[run] for name in INTERVAL_ENDS]
    pairs = zip(*(values.tolist() for values in ends), strict=True)
    return tuple((low, high) for low, high in pairs if low == low)


def names_of(archive: Archive, chosen: np.ndarray | None = None) -> Iterable[str]:
    """Name the machines of an archive by what was varied, "3 cylinders"; only the `chosen` ones, (n,) bool."""
    axes = axes_of(archive)
    for run, where in enumerate(zip(*places_of(archive), strict=True)):
        if chosen is None or chosen[run]:
            yield ", ".join(named(name, texts[place]) for (name, texts), place in zip(axes.items(), where, strict=True))


def named(axis: str, text: str) -> str:
    """Name a value of an axis: "3 cylinders", "load constant 5 N m"."""
    if axis == "engine_cylinders":
        return f"{text} cylinder{'s' * (text != '1')}"
    return f"{axis.replace('_', ' ')} {text}"
