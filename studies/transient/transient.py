"""An engine over time: a free shaft from rest or from a speed, or an imposed speed, with a row for each revolution."""

import json
import time
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import partial
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from apesim.archive import Archive, find_target, write
from apesim.archive.columns import column, run_axis
from apesim.archive.lock import lock
from apesim.archive.memory import available_memory
from apesim.archive.shards import plan_hash
from apesim.archive.untrusted import SIZE_LIMIT
from apesim.engine.angles import RPM
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cylinder import EPV
from apesim.engine.drivetrain.closure import closure_of_run
from apesim.engine.drivetrain.control import Control, Controller
from apesim.engine.drivetrain.feedback_timing import FeedbackTiming
from apesim.engine.drivetrain.preparing import NO_GOAL, Course, Prepared, prepare, released
from apesim.engine.drivetrain.rates import SHAFT_TRACE
from apesim.engine.drivetrain.run import (
    DrivetrainRun,
    begin_march,
    drawn_air_of,
    march_pieces,
    run_drivetrain,
    run_of,
)
from apesim.engine.drivetrain.state import FRICTION_WORK, GAS_WORK, LOAD_WORK, shaft_extremes, shaft_ledger
from apesim.engine.drivetrain.steady import settle_at
from apesim.engine.machine import Machine
from apesim.kernel import sources_hash
from apesim.march.adaptive import Status
from apesim.quantities import Arguments
from apesim.quantities.arguments import WithUnit
from apesim.results import NotConverged
from apesim.studies.archives.run_result import CONDITIONS, RunResult, columns_of_run
from apesim.studies.drawing.axes import axes_for, check_plotted, in_house_style
from apesim.studies.execution.calls import arguments_of, call_text, name_of_function, public, text_writer
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.execution.progress import Progress, show_progress
from apesim.studies.execution.resuming import keep, make_room, read_own_archive, remove_what_is_done
from apesim.studies.run.compiling import compile_drivetrain
from apesim.studies.run.engine_run import supply_conditions
from apesim.studies.run.march_status import STATUS_MEANINGS
from apesim.studies.run.operating_conditions import SPEED, TIME, require_epv
from apesim.studies.transient.checkpoints import Checkpoints
from apesim.studies.transient.courses import (
    FEEDBACK,
    FIXED,
    IMPOSED_SPEED,
    LOAD_TORQUE,
    MOMENT,
    START_ANGLE,
    read_course,
    read_supply,
    read_timing,
    with_floor,
)
from apesim.studies.transient.march_archive import (
    PREFIX,
    event_variables,
    events_of,
    revolution_variables,
    revolutions_of,
    trace_variables,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

KIND = "engine transient"
"""Kind of the archives."""
ENDED_WELL = Status.DONE, Status.STOPPED
"""How a march ends that has done what was asked."""
ROWS = 5000
"""Rows of a trace where no time between them is given; chosen."""
NUMBERS = {
    "duration_s": ("s", "time marched"),
    "turns": ("1", "turns of the shaft, from angle 0"),
    "gas_work_J": ("J", "work of the gas above ambient pressure"),
    "friction_work_J": ("J", "work against friction"),
    "brake_work_J": ("J", "work of the gas less that against friction"),
    "load_work_J": ("J", "work of the load, where the shaft is free"),
    "engine_air_kg": ("kg", "air from the supply through the grooves"),
    "control_air_kg": ("kg", "control air"),
    "specific_work_J_per_g": ("J/g", "brake work over all air"),
    "lowest_speed_rpm": ("r/min", "lowest speed of a whole revolution"),
    "highest_speed_rpm": ("r/min", "highest speed of a whole revolution"),
    "revolutions": ("1", "whole revolutions"),
    "strokes_cut_short": ("1", "revolutions of a cylinder in which its valve did not reach full lift"),
    "mass_closure": ("1", "air that is not accounted for, over what is turned over"),
    "energy_closure": ("1", "energy of the air that is not accounted for, over what is turned over"),
    "shaft_closure": ("1", "energy of the shaft that is not accounted for, over what is turned over"),
    "steps": ("1", "steps of the march"),
}
PLOTS = {
    "speed": ("revolution_mean_speed_rpm", "mean speed [r/min]"),
    "torque": ("revolution_brake_torque", "brake torque [N m]"),
    "air": ("revolution_engine_air", "engine air [g a turn]"),
    "timing": ("valve_open_deg", "angle after TDC [deg]"),
}
"""What a run draws, over time."""


@dataclass(frozen=True, eq=False, repr=False)
class TransientRun(RunResult):
    """Engine over time; numbers as ``apesim engine transient --json`` has them.

    Attributes
    ----------
    march : DrivetrainRun or None
        March of the drivetrain, for those who look deeper; None where it is read from an archive.
    was_finished : bool
        The archive was there and whole already, and nothing was computed.
    """

    title: ClassVar[str] = "engine over time"
    headline: ClassVar[tuple[str, ...]] = (
        "duration",
        "turns",
        "brake_work",
        "engine_air",
        "control_air",
        "specific_work_J_per_g",
    )

    march: DrivetrainRun | None = field(default=None, kw_only=True)
    was_finished: bool = field(default=False, kw_only=True)

    @classmethod
    def _faults_of(cls, archive: Archive) -> Iterable[str]:
        """Write a line where the march ended early."""
        status = Status(int(archive.variables["status"].values[0]))
        if status not in ENDED_WELL:
            end = archive.variables["duration_s"].values[0]
            yield f"the march ended early, at {end:g} s: {status.remedy}"

    @classmethod
    def _warnings_of(cls, archive: Archive) -> Iterable[str]:
        """Write a line where strokes were cut short."""
        cut_short = archive.variables["strokes_cut_short"].values[0]
        if cut_short:
            share = f"{cut_short} of {archive.variables['full_lift'].values.size} strokes"
            yield f"the valve does not reach full lift in {share}: a longer pulse would, see min_pulse"

    def to_dict(self) -> dict[str, Any]:
        """Convert to a dictionary with the keys of ``apesim engine transient --json``.

        Returns
        -------
        dict
            Numbers, a row for each revolution, events, closures and warnings; NaN where JSON says null.

        Examples
        --------
        >>> import apesim
        >>> run = apesim.run_transient(apesim.Machine(), speed="0 s: 600 rpm, 0.5 s: 900 rpm")
        >>> data = run.to_dict()
        >>> len(data["revolutions"]), sorted(data["closure"])
        (6, ['energy', 'mass', 'shaft'])
        """
        names = ("mass", "energy", "shaft")
        data = {key: self[key] for key in NUMBERS if not key.endswith("_closure") and key != "revolutions"}
        return data | {
            "revolutions": revolutions_of(self),
            "events": events_of(self),
            "closure": {name: self[f"{name}_closure"] for name in names},
            "warnings": [*self.failed, *self.warnings],
            "was_finished": self.was_finished,
        }

    @in_house_style
    def plot(self, ax: "Axes | None" = None, what: str = "speed") -> "Axes":
        """Draw a quantity of each revolution over time.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; those of a new figure if left out.
        what : {"speed", "torque", "air", "timing"}
            Mean speed, mean brake torque, engine air, or the own angles at which the valves open and close.

        Returns
        -------
        matplotlib.axes.Axes
            Axes that were drawn on.

        Raises
        ------
        InputError
            There is no such plot.

        Examples
        --------
        >>> import apesim
        >>> run = apesim.run_transient(apesim.Machine(), speed="0 s: 600 rpm, 0.5 s: 900 rpm")
        >>> run.plot(what="torque").get_ylabel()
        'brake torque [N m]'
        """
        from apesim.studies.drawing.panels import add_legend, add_title
        from apesim.studies.drawing.style import Look, looks_of

        check_plotted(what, PLOTS)
        ax = axes_for(ax)
        name, label = PLOTS[what]
        t = {key: trace.values for key, trace in self.traces.items()}
        middle = t[f"{PREFIX}start"] + 0.5 * np.abs(60.0 / t[f"{PREFIX}mean_speed_rpm"])
        if what == "timing":
            count = len(t["cylinder"])
            for i, look in enumerate(looks_of(count)):
                told = f", cylinder {i + 1}" * (count > 1)
                filled: Look = {"ls": "", "ms": 4} | look
                ax.plot(middle, t["valve_open_deg"][:, i], label=f"opens{told}", **filled)
                ax.plot(middle, t["valve_close_deg"][:, i], mfc="white", label=f"closes{told}", **filled)
            add_legend(ax, ncols=min(count, 3))
        else:
            ax.plot(middle, t[name] * (1e3 if what == "air" else 1.0), "o-", ms=3)
        ax.set(xlabel="time [s]", ylabel=label)
        add_title(ax, self._told_conditions())
        return ax


@public
def run_transient(
    machine: Machine,
    duration: WithUnit | float | None = None,
    angle: WithUnit | None = None,
    from_speed: WithUnit | None = None,
    speed: str | None = None,
    load: str | None = None,
    supply: str | None = None,
    timing: str | PathLike[str] = "fixed",
    min_pulse: WithUnit | float | None = None,
    sample: WithUnit | float | None = None,
    controller: Controller | None = None,
    progress: Progress = False,
    out: str | PathLike[str] | None = None,
    resume: bool = False,
    overwrite: bool = False,
    call: str | None = None,
) -> TransientRun:
    """March an engine over time: its shaft free, from rest or from a speed, or its speed imposed.

    Parameters
    ----------
    machine : Machine
        Machine with its shaft and load.
    duration : str or float, optional
        Time to march, "3 s"; the last instant of an imposed speed if left out.
    angle : str or (float, str), optional
        Angle of the shaft at the start, at rest, "30 deg"; 0 deg of an imposed speed if left out.
    from_speed : str or (float, str), optional
        Speed at whose periodic state the shaft is let free at angle 0, "1000 rpm"; at rest if left out.
    speed : str, optional
        Imposed speed, linear between instants: "0 s: 300 rpm, 1.5 s: 1800 rpm, 3 s: 300 rpm".
    load : str, optional
        Constant part of the load from instants on: "5 s: 10 N m"; the rest of the load stays.
    supply : str, optional
        Pressure of the supply from instants on: "2 s: 0.8 MPa gauge".
    timing : str or path
        "fixed": the machine's command; "feedback": the controller `FeedbackTiming`, which moves the commands until each
        valve opens and closes at its targets; or a CSV with speed, energise and release, such as `correct_timing`
        exports, which each cylinder reads by the instantaneous speed as it passes its own 180 deg.
    min_pulse : str or float, optional
        Shortest pulse that is commanded, "7.8 ms": the release is put off where the timing has a shorter one.
    sample : str or float, optional
        Time between two rows of the traces; a 5000th of the duration if left out.
    controller : function, optional
        Takes the `SensorReadings` of each whole revolution at its end, and returns `EngineCommands`, or None to keep
        what holds; None: there is none. Each cylinder takes its command angles as it passes its own 180 deg. Where
        `timing` is a CSV, that holds until the controller commands.
    progress : bool or function
        True: a bar on standard error; a function is called with the time that is marched and that to march [s].
    out : path, optional
        The archive to write; of a march that takes long, what is done survives a kill, unless it has a controller.
    resume : bool
        Go on with a march that was interrupted; one that is finished is read, and nothing is computed.
    overwrite : bool
        Replace an archive that is there.
    call : str, optional
        What the archive notes as its call; made from the arguments if left out.

    Returns
    -------
    TransientRun
        Totals, a row for each revolution, events, closures and traces.

    Raises
    ------
    InputError
        The machine or an argument is out of range, two arguments do not go together, or the controller returns what
        cannot be.
    NotConverged
        The march ended early; its ``result`` holds what was found, and the archive, too.
    ArchiveError
        The target exists, or another process writes it, or it cannot be written.

    Examples
    --------
    >>> import apesim
    >>> run = apesim.run_transient(apesim.Machine(), speed="0 s: 600 rpm, 0.5 s: 900 rpm")
    >>> round(run["turns"], 3)
    6.25
    """
    call = call_text(run_transient, locals()) if call is None else call
    arguments, machine = arguments_of("run_transient", machine)
    at = arguments.quantity("angle", angle, START_ANGLE)
    omega = arguments.quantity("from_speed", from_speed, SPEED)
    speeds = read_course(arguments, "speed", speed, IMPOSED_SPEED, "300 rpm")
    loads = read_course(arguments, "load", load, LOAD_TORQUE, "10 N m")
    supplies = read_supply(arguments, supply)
    pulse = arguments.quantity("min_pulse", min_pulse, TIME)
    schedules = read_timing(arguments, machine, timing)
    end = arguments.quantity("duration", duration, MOMENT)
    step = arguments.quantity("sample", sample, TIME)

    # Arguments that are right each by itself, but do not go together.
    if resume and (controller is not None or str(timing) == FEEDBACK):
        arguments.fault("resume", "does not go with a controller, of which nothing is kept", "leave it out")
    if str(timing) == FEEDBACK:
        require_epv(arguments, machine)
        if controller is not None:
            arguments.fault("controller", 'does not go with the timing "feedback"', "leave one of them out")
    if speed is not None and omega is not None:
        arguments.fault("from_speed", "does not go with `speed`", "leave one of them out")
    if at is not None and omega is not None:
        arguments.fault("angle", "does not go with `from_speed`, which begins at 0 deg", "leave one of them out")
    if len(speeds) and (len(speeds) < 2 or speeds[0, 0] != 0.0):
        arguments.fault("speed", "does not begin at 0 s, or has one instant only", 'write "0 s: 300 rpm, 3 s: 900 rpm"')
    if end is None and len(speeds) > 1:
        end = float(speeds[-1, 0])
    if not end and not arguments.faults:
        arguments.fault("duration", "is missing", 'give a time above 0, e.g. "3 s"')
    if out is None and resume:
        arguments.fault("out", "is left out, so that nothing is kept", "give the path of an archive")
    if not arguments.faults:
        _refuse_too_many(arguments, machine, end / (step or end / ROWS))
    arguments.refuse()

    # Command angles that change: by a map, for a shortest pulse, or by a controller.
    told = {"shaft": "imposed speed" if len(speeds) else "free"}
    if omega is not None:
        told["from"] = f"{omega / RPM:g} r/min"
    courses = {"load over time": load, "supply over time": supply}
    told |= {name: text for name, text in courses.items() if text} | {"timing": Path(timing).name}
    if pulse is not None:
        told["shortest pulse"] = f"{1e3 * pulse:g} ms"
    if str(timing) == FEEDBACK:
        controller = FeedbackTiming(machine, min_pulse_s=pulse or 0.0)
    elif controller:
        told["controller"] = name_of_function(controller)
    limited: Callable[[np.ndarray], np.ndarray]
    limited = np.asarray if pulse is None else partial(with_floor, min_pulse=pulse)
    control = Control(machine, controller, schedules, limited) if controller else None
    schedules = [] if str(timing) == FIXED and pulse is None and not control else [limited(rows) for rows in schedules]

    # What makes a run this one and no other, so that one that was interrupted goes on.
    course = Course(speeds, loads, supplies, schedules)
    conditions = told | {"cylinders": f"{machine.engine.cylinders:g}"} | supply_conditions(machine)
    provenance = {"kind": KIND, "command": call, "kernels": sources_hash(), CONDITIONS: json.dumps(conditions)}
    times = np.arange(0.0, end * (1.0 + 1e-12), step or end / ROWS)
    with ExitStack() as stack:
        checkpoints, target = None, None if out is None else Path(out)
        if target:
            asked = {"kind": KIND, "kernels": sources_hash(), "end": end, "step": step, "angle": at, "from": omega}
            asked |= {"controller": name_of_function(control.controller)} if control else {}
            asked |= {name: [rows.tolist() for rows in imposed] for name, imposed in course._asdict().items()}
            text = text_writer(machine)()
            provenance["plan_hash"] = plan_hash(text, asked)
            find_target(target)
            stack.enter_context(lock(target))
            own = {"plan_hash": provenance["plan_hash"]}
            begin = time.perf_counter()
            there = read_own_archive(target, own, overwrite=overwrite) if resume else None
            if there:
                notes = remove_what_is_done(target)
                return _ended(TransientRun.of(there, time.perf_counter() - begin, was_finished=True), notes)
            make_room(target, resume=resume, overwrite=overwrite, unfinished="a checkpoint of an unfinished run")
            checkpoints = None if control else Checkpoints(target, text, provenance)

        compile_drivetrain(machine)
        report = stack.enter_context(show_progress(progress, "transient"))
        begin = time.perf_counter()
        start = start_of(machine, at or 0.0, omega, course)
        if control:
            march = _march_controlled(start, end, times, control, report)
        else:
            march = _march(start, end, times, checkpoints, report)
        wall_time = time.perf_counter() - begin

        archive = _archive_of(machine, start, march, provenance)
        notes = checkpoints.notes if checkpoints else []
        if target:
            keep(archive, lambda whole: write(whole, target))
            notes += remove_what_is_done(target)
    return _ended(TransientRun.of(archive, wall_time, march=march), notes)


def _refuse_too_many(arguments: Arguments, machine: Machine, rows: float) -> None:
    """Note a fault where the traces would not be read from an archive, or are more than memory can hold."""
    columns = len(SHAFT_TRACE) + len(TRACE) * machine.engine.cylinders
    size, limit = 8.0 * rows * columns, min(SIZE_LIMIT, available_memory() / 4.0)
    if size > limit:
        wrong = f"makes traces of {size / 1e9:.3g} GB, of at most {limit / 1e9:.2g} GB"
        arguments.fault("sample", wrong, "give a longer time, or leave it out")


def start_of(machine: Machine, angle: float, speed: float | None, course: Course) -> Prepared:
    """Prepare a drivetrain at rest at an angle [rad]; with a speed [rad/s] in its periodic state, after turns at that.

    What settles it is computed again by a run that is resumed: it gives the same bits.
    """
    start = prepare(machine, angle, course, NO_GOAL)
    if speed is None:
        return start
    _, _, orbit = call_in_thread(settle_at, machine, speed, course.schedules).result()
    return released(start, orbit.y, orbit.mode, 0.0)


def _march(
    start: Prepared,
    end: float,
    times: np.ndarray,
    checkpoints: Checkpoints | None,
    report: Callable[[Any, Any], object],
) -> DrivetrainRun:
    """March a drivetrain to the end [s], from a checkpoint where there is one; each piece in a thread of its own."""
    marched = checkpoints.resume(start, times) if checkpoints else begin_march(start, times)
    pieces = march_pieces(start, marched, end)
    while piece := call_in_thread(next, pieces, None).result():
        marched = piece
        report(marched.time, end)
        if checkpoints:
            checkpoints.offer(marched)
    return run_of(marched)


def _march_controlled(
    start: Prepared, end: float, times: np.ndarray, control: Control, report: Callable[[Any, Any], object]
) -> DrivetrainRun:
    """March a drivetrain to the end [s] with a controller, whose state no checkpoint would keep."""
    start = start._replace(p=start.p._replace(goal=start.p.goal._replace(ends_with_revolution=1)))
    return call_in_thread(run_drivetrain, start, end, times, report=lambda now: report(now, end), act=control).result()


def _archive_of(machine: Machine, start: Prepared, march: DrivetrainRun, provenance: dict[str, str]) -> Archive:
    """Lay out a march from its start as an archive."""
    closure, revolutions = closure_of_run(start, march.y), march.revolutions["start"]
    variables = revolution_variables(march, machine.supply.pressure)
    lowest, highest = (variables[f"{PREFIX}{end}_speed_rpm"].values for end in ("lowest", "highest"))
    cut_short = march.cylinders["full_lift"] == 0.0
    values = _totals(start, march) | {
        "lowest_speed_rpm": float(lowest.min()) if lowest.size else np.nan,
        "highest_speed_rpm": float(highest.max()) if highest.size else np.nan,
        "revolutions": len(revolutions),
        "strokes_cut_short": int(cut_short.sum()) if machine.engine.intake == EPV else 0,
        "mass_closure": closure.mass,
        "energy_closure": closure.energy,
        "shaft_closure": closure.shaft,
        "steps": march.steps,
    }
    status = {"status": column([int(march.status)], "1", "how the march ended", STATUS_MEANINGS)}
    own = {"run": run_axis(1)} | columns_of_run(values, NUMBERS) | status
    return Archive(text_writer(machine), provenance, own | trace_variables(march) | variables | event_variables(march))


def _ended(run: TransientRun, notes: list[str]) -> TransientRun:
    """Give a run notes as warnings; raises NotConverged where its march ended early."""
    if notes:
        run = replace(run, warnings=(*run.warnings, *notes))
    if run.failed:
        status = Status(int(run.archive.variables["status"].values[0]))
        raise NotConverged("the transient", "the march ended early", status.remedy, run)
    return run


def _totals(start: Prepared, march: DrivetrainRun) -> dict[str, Any]:
    """Totals of a march by their keys in JSON."""
    counted = shaft_extremes(start.p)
    change = march.y[:counted] - start.y[:counted]
    ledger = change[shaft_ledger(start.p) :]
    engine, control = drawn_air_of(start.p, change)
    gas, friction, load = (float(ledger[which]) for which in (GAS_WORK, FRICTION_WORK, LOAD_WORK))
    air = engine + control
    return {
        "duration_s": march.duration,
        "turns": float(march.turns),
        "gas_work_J": gas,
        "friction_work_J": friction,
        "brake_work_J": gas - friction,
        "load_work_J": load,
        "engine_air_kg": engine,
        "control_air_kg": control,
        "specific_work_J_per_g": 1e-3 * (gas - friction) / air if air else np.nan,
    }
