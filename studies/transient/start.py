"""Does an engine start: from one angle of its crank, or from which of all."""

import json
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from math import nan
from os import PathLike
from typing import TYPE_CHECKING, Any, ClassVar, overload

import numpy as np

from apesim.archive import Archive
from apesim.archive.columns import run_axis
from apesim.archive.grid import words_of
from apesim.engine.angles import DEGREE, RPM, TURN
from apesim.engine.drivetrain.run import EventKind
from apesim.engine.drivetrain.start import MAX_REST, MAX_TIME, Start
from apesim.engine.machine import Machine
from apesim.kernel import sources_hash
from apesim.quantities import Arguments
from apesim.quantities.arguments import WithUnit
from apesim.studies.archives.run_result import CONDITIONS, RunResult, columns_of_run
from apesim.studies.drawing.axes import axes_for, check_plotted, in_house_style
from apesim.studies.execution.calls import arguments_of, call_text, public, text_writer
from apesim.studies.execution.output import publish, refuse_to_replace
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.execution.progress import Progress, show_progress
from apesim.studies.run.compiling import compile_drivetrain
from apesim.studies.run.engine_run import supply_conditions
from apesim.studies.run.operating_conditions import ANGLE, JOBS, SPEED
from apesim.studies.sweep.variation import Vary, read_variation
from apesim.studies.transient.courses import START_ANGLE, refuse_own_commands
from apesim.studies.transient.march_archive import event_variables, events_of, trace_variables
from apesim.studies.transient.start_archive import (
    NUMBERS,
    Intervals,
    Starting,
    interval_variables,
    intervals_of,
    start_machine,
)
from apesim.studies.transient.start_map import StartMap, map_starts

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class StartRun(RunResult):
    """Start from rest; numbers as ``apesim engine start --json`` has them.

    Attributes
    ----------
    intervals_deg : tuple of (float, float)
        Angles of the shaft from which the engine starts, where all were asked for: ends of each interval [deg], the
        upper one above 360 where it passes zero.
    march : Start or None
        March of the start from one angle, for those who look deeper; None where it is read from an archive.
    """

    title: ClassVar[str] = "start from rest"
    headline: ClassVar[tuple[str, ...]] = ("starts", "time", "turns", "engine_air", "control_air", "starting_share")

    intervals_deg: Intervals = field(default=(), kw_only=True)
    march: Start | None = field(default=None, kw_only=True)

    @classmethod
    def _recorded(cls, archive: Archive) -> dict[str, Any]:
        """Find the intervals of angles in the archive."""
        return {"intervals_deg": intervals_of(archive)}

    @classmethod
    def _warnings_of(cls, archive: Archive) -> Iterable[str]:
        """Write a line where it does not start, or does not reach its target."""
        v, until = archive.variables, cls._conditions_of(archive).get("until")
        if "time" not in v:
            return
        if not v["starts"].values[0]:
            yield f"the engine does not start: {_why(archive)}"
        elif until and np.isnan(v["time_s"].values[0]):
            yield f"it turns, but does not reach {until} within {MAX_TIME:g} s"

    @property
    def is_of_all_angles(self) -> bool:
        """Whether it says from which angles the engine starts, and not how it does from one."""
        return "interval" in self.traces

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
        return {key: self[key] for key in NUMBERS} | {
            "intervals_deg": [list(interval) for interval in self.intervals_deg],
            "events": events_of(self),
            "warnings": list(self.warnings),
        }

    @in_house_style
    def plot(self, ax: "Axes | None" = None, what: str | None = None) -> "Axes":
        """Draw the start: speed over time of one, or the angles around the circle of all.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on, polar ones for the angles; those of a new figure if left out.
        what : {"speed", "angles"}, optional
            Speed over time, or angles of the shaft from which the engine starts; what there is if left out.

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
        from apesim.studies.drawing.panels import add_title
        from apesim.studies.transient.circle import draw_circle, open_circle

        plots = ("angles",) if self.is_of_all_angles else ("speed",)
        what = what or plots[0]
        check_plotted(what, plots)
        if what == "speed":
            ax = axes_for(ax)
            ax.plot(self.traces["time"].values, self.traces["speed_rpm"].values)
            ax.set(xlabel="time [s]", ylabel="speed [r/min]")
            add_title(ax, self._told_conditions())
            return ax
        names = [f"it starts from\n{100.0 * self['starting_share']:.0f} % of all angles"]
        ax = ax or open_circle(names)
        draw_circle(ax, [self.intervals_deg], names)
        add_title(ax, self._told_conditions())
        return ax


@overload
def start_engine(
    machine: Machine,
    angle: WithUnit = ...,
    until: WithUnit | None = ...,
    cranking_release: WithUnit | None = ...,
    *,
    vary: None = ...,
    out: str | PathLike[str] | None = ...,
    jobs: int | None = ...,
    overwrite: bool = ...,
    progress: Progress = ...,
    call: str | None = ...,
) -> StartRun: ...


@overload
def start_engine(
    machine: Machine,
    angle: WithUnit = ...,
    until: WithUnit | None = ...,
    cranking_release: WithUnit | None = ...,
    *,
    vary: Vary,
    out: str | PathLike[str] | None = ...,
    jobs: int | None = ...,
    overwrite: bool = ...,
    progress: Progress = ...,
    call: str | None = ...,
) -> StartMap: ...


@public
def start_engine(
    machine: Machine,
    angle: WithUnit = "30 deg",
    until: WithUnit | None = None,
    cranking_release: WithUnit | None = None,
    *,
    vary: Vary | None = None,
    out: str | PathLike[str] | None = None,
    jobs: int | None = 1,
    overwrite: bool = False,
    progress: Progress = False,
    call: str | None = None,
) -> StartRun | StartMap:
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
    vary : mapping of str, or sequence of str, optional
        Ranges by keys of the machine, e.g. ``{"engine.cylinders": "1:6:1"}``, or ``KEY=RANGE``: each is started.
    out : path, optional
        The archive to write.
    jobs : int or None
        Processes for the machines of `vary`; None: as many as the work is worth. A script that asks for more than one
        does so below ``if __name__ == "__main__":``, as each process imports it.
    overwrite : bool
        Replace an archive that is there.
    progress : bool or function
        True: a bar on standard error; a function is called with the numbers of machines done and in all.
    call : str, optional
        What the archive notes as its call; made from the arguments if left out.

    Returns
    -------
    StartRun or StartMap
        Whether it starts, with time, turns and air; of one angle also events and traces. With `vary` all of it but
        these, over the keys.

    Raises
    ------
    InputError
        The machine or an argument is out of range.
    ArchiveError
        The target exists, or cannot be written.

    Examples
    --------
    >>> import apesim
    >>> start = apesim.start_engine(apesim.Machine(), angle="30 deg", until="600 rpm")
    >>> start["starts"], start["time"] < 0.1
    (True, True)
    >>> apesim.start_engine(apesim.Machine(), vary={"engine.cylinders": "1, 2"})["starting_machines"]
    2
    """
    call = call_text(start_engine, locals()) if call is None else call
    arguments, machine = arguments_of("start_engine", machine)
    is_all = str(angle) == "all"
    at = 0.0 if is_all else arguments.quantity("angle", angle, START_ANGLE)
    target = arguments.quantity("until", until, SPEED)
    release = arguments.quantity("cranking_release", cranking_release, ANGLE)
    if is_all and until is not None:
        arguments.fault("until", 'does not go with `angle` "all"', "leave it out, or give one angle")
    if release is not None:
        refuse_own_commands(arguments, "cranking_release", machine)
    variation = read_variation(arguments, machine, vary, has_intakes=False)
    if variation and not variation.axes:
        arguments.fault("vary", "varies nothing", 'write KEY=RANGE, e.g. "engine.cylinders=1:6:1"')
    arguments.quantity("jobs", jobs, JOBS)
    for each in variation.machines if variation else (machine,):
        _check_release(arguments, each, release)
    arguments.refuse()
    if out is not None:
        refuse_to_replace(out, overwrite=overwrite)

    # What holds whatever is varied.
    conditions = {} if is_all else {"angle": f"{at / DEGREE:g} deg"}
    if target is not None:
        conditions["until"] = f"{target / RPM:g} r/min"
    if release is not None:
        conditions["release while cranking"] = f"{release / DEGREE:g} deg"
    starting = Starting(None if is_all else at, nan if target is None else target, release)
    provenance = {"command": call, "kernels": sources_hash()}

    if variation:
        with show_progress(progress, "start") as report:
            return map_starts(
                machine,
                variation,
                starting,
                conditions,
                provenance,
                jobs=jobs,
                out=out,
                overwrite=overwrite,
                report=report,
            )

    # One machine, whose traces and events are kept.
    compile_drivetrain(machine)
    begin = time.perf_counter()
    values, intervals, start = call_in_thread(start_machine, machine, starting).result()
    wall_time = time.perf_counter() - begin
    if start is None:
        more = interval_variables([intervals])
    else:
        more = trace_variables(start.run) | event_variables(start.run)
    conditions |= {"cylinders": f"{machine.engine.cylinders:g}"} | supply_conditions(machine)
    provenance |= {"kind": "engine start", CONDITIONS: json.dumps(conditions)}
    variables = {"run": run_axis(1)} | columns_of_run(values, NUMBERS) | more
    archive = Archive(text_writer(machine), provenance, variables)
    if out is not None:
        publish(archive, out, overwrite)
    return StartRun.of(archive, wall_time, march=start, **StartRun._recorded(archive))


def _check_release(arguments: Arguments, machine: Machine, release: float | None) -> None:
    """Note a fault where the release while cranking [rad] is not within a turn behind the energising of a machine."""
    energise = machine.command.energise
    noted = any(fault.key == "cranking_release" for fault in arguments.faults)
    if release is not None and not noted and not 0.0 < release - energise < TURN:
        right = f"an angle up to 360 deg after energise, {energise / DEGREE:g} deg"
        arguments.fault("cranking_release", "is not behind the energising", right)


def _why(archive: Archive) -> str:
    """Why a start failed, in words."""
    v = archive.variables
    kinds = [str(kind) for kind in words_of(v["event_kind"])[0]]
    if kinds and kinds[-1] == EventKind.HELD.value:
        rest = f"the crank is held at {v['event_angle_deg'].values[0, -1] % 360.0:.4g} deg"
        how = "after it has moved" if EventKind.FIRST_MOTION.value in kinds else "from the start"
        return f"{rest} {how}, for {MAX_REST:g} s"
    return f"no three turns within {MAX_TIME:g} s"
