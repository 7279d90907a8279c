"""Does an engine start: from one angle of its crank, or from which of all."""

import time
from dataclasses import dataclass, field
from math import nan
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.drivetrain.preparing import NO_COURSE, Course
from apesim.engine.drivetrain.rates import SHAFT_TRACE
from apesim.engine.drivetrain.run import EventKind
from apesim.engine.drivetrain.start import MAX_REST, MAX_TIME, Start, find_intervals, run_start
from apesim.engine.machine import Machine
from apesim.quantities.arguments import WithUnit
from apesim.results import Result, scalars_of
from apesim.studies.execution.calls import arguments_of, public, text_writer
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.run.compiling import compile_drivetrain
from apesim.studies.run.engine_run import supply_conditions
from apesim.studies.run.operating_conditions import ANGLE, SPEED
from apesim.studies.transient.courses import START_ANGLE, commands_of, refuse_own_commands
from apesim.studies.transient.transient import traces_over_time

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SAMPLE = 0.5e-3
"""Time between two rows of a trace [s]."""
TRACED = 5.0
"""Time up to which a start is traced [s]."""
NUMBERS = {
    "starts": ("", "whether the shaft turns thrice"),
    "time_s": ("s", "time until the target speed, or without one until three turns"),
    "turns": ("", "turns until then"),
    "engine_air_kg": ("kg", "air from the supply through the grooves until then"),
    "control_air_kg": ("kg", "control air until then"),
    "first_motion_s": ("s", "when the shaft begins to move"),
    "lowest_speed_rpm": ("r/min", "lowest speed after the first motion; below zero it kicks back"),
    "highest_speed_rpm": ("r/min", "highest speed of the march"),
    "starting_share": ("", "share of all angles from which it starts; of one angle 1 or 0"),
    "wall_time_s": ("s", "computing time of the call"),
}


@dataclass(frozen=True, eq=False, repr=False)
class StartRun(Result):
    """Start from rest; numbers as ``apesim engine start --json`` has them.

    Attributes
    ----------
    intervals_deg : tuple of (float, float)
        Angles of the shaft from which the engine starts, where all were asked for: ends of each interval [deg], the
        upper one above 360 where it passes zero.
    march : Start or None
        March of the start from one angle, for those who look deeper.
    """

    title: ClassVar[str] = "start from rest"
    headline: ClassVar[tuple[str, ...]] = ("starts", "time", "turns", "engine_air", "control_air", "starting_share")

    intervals_deg: tuple[tuple[float, float], ...] = field(default=(), kw_only=True)
    march: Start | None = field(default=None, kw_only=True)

    def to_dict(self) -> dict[str, Any]:
        """Convert to a dictionary with the keys of ``apesim engine start --json``.

        Returns
        -------
        dict
            Numbers, intervals of angles [deg], events and warnings; NaN where JSON says null.

        Examples
        --------
        >>> import apesim
        >>> data = apesim.start_engine(apesim.Machine(), angle="30 deg", until="600 rpm").to_dict()
        >>> data["starts"], round(data["turns"], 2)
        (True, 0.15)
        """
        run = self.march.run if self.march else None
        events = [
            {"kind": event.kind.value, "time_s": event.time, "angle_deg": event.angle / DEGREE}
            for event in (run.events if run else ())
        ]
        return {key: self[key] for key in NUMBERS} | {
            "intervals_deg": [list(interval) for interval in self.intervals_deg],
            "events": events,
            "warnings": list(self.warnings),
        }

    def plot(self, ax: "Axes | None" = None, what: str = "speed") -> "Axes":
        """Draw the start: speed over time of one, or the angles around the circle of all.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on, polar ones for the angles; those of a new figure if left out.
        what : {"speed", "angles"}
            Speed over time, or angles of the shaft from which the engine starts.

        Returns
        -------
        matplotlib.axes.Axes
            Axes that were drawn on.

        Raises
        ------
        InputError
            There is no such plot of this result.

        Examples
        --------
        >>> import apesim
        >>> start = apesim.start_engine(apesim.Machine(), angle="30 deg", until="600 rpm")
        >>> start.plot().get_ylabel()
        'speed [r/min]'
        """
        from apesim.studies.drawing.axes import axes_for, check_plotted

        check_plotted(what, ("speed",) if self.march else ("angles",))
        if what == "speed":
            ax = axes_for(ax)
            ax.plot(self.traces["time"].values, self.traces["speed_rpm"].values)
            ax.set(xlabel="time [s]", ylabel="speed [r/min]", title=self._told_conditions())
            return ax
        if ax is None:
            import matplotlib.pyplot as plt

            _, ax = plt.subplots(subplot_kw={"projection": "polar"}, layout="constrained")
        draw_circle(ax, [self.intervals_deg], [f"it starts from\n{self['starting_share']:.0%} of all angles"])
        ax.set_title(self._told_conditions())
        return ax


def draw_circle(ax: "Axes", rings: list[tuple[tuple[float, float], ...]], names: list[str]) -> None:
    """Draw intervals of angles [deg] as a ring for each of several engines, from the inside out, on polar axes.

    The names stand in the middle.
    """
    polar: Any = ax
    polar.set_theta_zero_location("N")
    polar.set_theta_direction(-1)
    for i, intervals in enumerate(rings):
        polar.bar(0.0, 0.8, 2.0 * np.pi, bottom=1.0 + i, color="0.9", edgecolor="none", align="edge")
        for low, high in intervals:
            width = (high - low) * DEGREE
            polar.bar(low * DEGREE, 0.8, width, bottom=1.0 + i, color="C0", edgecolor="none", align="edge")
    polar.text(0.0, 0.0, "\n".join(reversed(names)), ha="center", va="center")
    polar.set_ylim(0.0, 1.0 + len(rings))
    polar.set_yticks([])
    polar.grid(visible=False)
    polar.set_xlabel("angle of the shaft at rest; blue: the engine starts")


@public
def start_engine(
    machine: Machine,
    angle: WithUnit = "30 deg",
    until: WithUnit | None = None,
    cranking_release: WithUnit | None = None,
) -> StartRun:
    """March a start from rest: does the engine start, how fast, with how much air, and from which angles.

    It starts if its shaft turns thrice forwards; it does not if the crank is held for 0.25 s before that, or 60 s pass.

    Parameters
    ----------
    machine : Machine
        Machine to start, with its shaft and load.
    angle : str or (float, str)
        Angle of the shaft at rest, "30 deg"; "all": from which angles it starts, each end to 0.01 deg.
    until : str or (float, str), optional
        Speed at which time, turns and air are read, "900 rpm"; three turns if left out.
    cranking_release : str or (float, str), optional
        Release while cranking, "130 deg": until each cylinder first passes its own 180 deg forwards; then that of the
        command.

    Returns
    -------
    StartRun
        Whether it starts, with time, turns and air; of one angle also events and traces.

    Raises
    ------
    InputError
        The machine or an argument is out of range.

    Examples
    --------
    >>> import apesim
    >>> start = apesim.start_engine(apesim.Machine(), angle="30 deg", until="600 rpm")
    >>> start["starts"], start["time"] < 0.1
    (True, True)
    """
    arguments, machine = arguments_of("start_engine", machine)
    is_all = str(angle) == "all"
    at = 0.0 if is_all else arguments.quantity("angle", angle, START_ANGLE)
    target = arguments.quantity("until", until, SPEED)
    release = arguments.quantity("cranking_release", cranking_release, ANGLE)
    if is_all and until is not None:
        arguments.fault("until", 'does not go with `angle` "all"', "leave it out, or give one angle")
    if release is not None:
        refuse_own_commands(arguments, "cranking_release", machine)
    if release is not None and not 0.0 < release - machine.command.energise < TURN:
        right = f"an angle up to 360 deg after energise, {machine.command.energise / DEGREE:g} deg"
        arguments.fault("cranking_release", "is not behind the energising", right)
    arguments.refuse()

    # While cranking the command is another: each cylinder reads the usual one as it first passes its own 180 deg.
    course, cranked = NO_COURSE, machine
    if release is not None:
        command = machine.command
        course = Course(schedules=commands_of(machine))
        cranked = machine._replace(command=command._replace(release=release))
    compile_drivetrain(machine)
    begin = time.perf_counter()
    conditions = {"cylinders": f"{machine.engine.cylinders:g}"} | supply_conditions(machine)
    if release is not None:
        conditions["release while cranking"] = f"{release / DEGREE:g} deg"
    if is_all:
        found = call_in_thread(find_intervals, cranked, course).result()
        intervals = tuple((low / DEGREE, high / DEGREE) for low, high in found)
        share = sum(high - low for low, high in intervals) / 360.0
        values = dict.fromkeys(NUMBERS, nan) | {"starts": share > 0.0, "starting_share": share}
        values["wall_time_s"] = time.perf_counter() - begin
        return StartRun(
            scalars_of(values, NUMBERS), {}, conditions, machine=text_writer(machine), intervals_deg=intervals
        )
    times = np.arange(0.0, TRACED, SAMPLE)
    start = call_in_thread(run_start, cranked, at, nan if target is None else target, course, times).result()
    values = _values(start) | {"wall_time_s": time.perf_counter() - begin}
    warnings = []
    if not start.starts:
        warnings.append(f"the engine does not start: {_why(start)}")
    elif not start.is_target_met:
        warnings.append(f"it turns, but does not reach {until} within {MAX_TIME:g} s")
    return StartRun(
        scalars_of(values, NUMBERS),
        traces_over_time(start.run),
        {"angle": f"{at / DEGREE:g} deg"} | conditions,
        warnings,
        machine=text_writer(machine),
        march=start,
    )


def _why(start: Start) -> str:
    """Why a start failed, in words."""
    events = start.run.events
    if events and events[-1].kind is EventKind.HELD:
        moved = any(event.kind is EventKind.FIRST_MOTION for event in events)
        rest = f"the crank is held at {events[-1].angle / DEGREE % 360.0:.4g} deg"
        return f"{rest} {'after it has moved' if moved else 'from the start'}, for {MAX_REST:g} s"
    return f"no three turns within {MAX_TIME:g} s"


def _values(start: Start) -> dict[str, Any]:
    """Numbers of a start by their keys in JSON."""
    speeds = start.run.trace[:, SHAFT_TRACE.index("speed [rpm]")]
    first = [event.time for event in start.run.events if event.kind is EventKind.FIRST_MOTION]
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
