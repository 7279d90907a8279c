"""An engine over time: a free shaft from rest or from a speed, or an imposed speed, with a row for each revolution."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from apesim.engine.angles import DEGREE, TURN
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.cylinder import EPV
from apesim.engine.drivetrain.closure import closure_of_run
from apesim.engine.drivetrain.preparing import NO_GOAL, Course, Prepared, prepare, released
from apesim.engine.drivetrain.rates import SHAFT_TRACE
from apesim.engine.drivetrain.run import DrivetrainRun, drawn_air_of, draws_from_supply, run_drivetrain
from apesim.engine.drivetrain.state import FRICTION_WORK, GAS_WORK, LOAD_WORK, shaft_extremes, shaft_ledger
from apesim.engine.machine import Machine
from apesim.march.adaptive import Status
from apesim.quantities import split_header
from apesim.quantities.arguments import WithUnit
from apesim.results import NotConverged, Result, Trace, name_of, scalars_of
from apesim.studies.execution.calls import arguments_of, public, text_writer
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.run.compiling import compile_drivetrain
from apesim.studies.run.engine_run import TRACE_NAMES, supply_conditions
from apesim.studies.run.operating_conditions import SPEED, TIME
from apesim.studies.transient.courses import (
    IMPOSED_SPEED,
    LOAD_TORQUE,
    MOMENT,
    RPM,
    START_ANGLE,
    read_course,
    read_supply,
    read_timing,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ROWS = 5000
"""Rows of a trace where no time between them is given; chosen."""
SETTLING = 100
"""Revolutions at a constant speed before a shaft is let free from there; chosen: states repeat within 1e-8 by then."""
NUMBERS = {
    "duration_s": ("s", "time marched"),
    "turns": ("", "turns of the shaft, from angle 0"),
    "gas_work_J": ("J", "work of the gas above ambient pressure"),
    "friction_work_J": ("J", "work against friction"),
    "brake_work_J": ("J", "work of the gas less that against friction"),
    "load_work_J": ("J", "work of the load, where the shaft is free"),
    "engine_air_kg": ("kg", "air from the supply through the grooves"),
    "control_air_kg": ("kg", "control air"),
    "specific_work_J_per_g": ("J g-1", "brake work over all air"),
    "lowest_speed_rpm": ("r/min", "lowest speed of a whole revolution"),
    "highest_speed_rpm": ("r/min", "highest speed of a whole revolution"),
    "revolutions": ("", "whole revolutions"),
    "strokes_cut_short": ("", "revolutions of a cylinder in which its valve did not reach full lift"),
    "mass_closure": ("", "air that is not accounted for, over what is turned over"),
    "energy_closure": ("", "energy of the air that is not accounted for, over what is turned over"),
    "shaft_closure": ("", "energy of the shaft that is not accounted for, over what is turned over"),
    "wall_time_s": ("s", "computing time of the call"),
}
REVOLUTION = {
    "start_s": ("s", "start of the revolution"),
    "mean_speed_rpm": ("r/min", "mean speed of the revolution"),
    "lowest_speed_rpm": ("r/min", "lowest speed of the revolution"),
    "highest_speed_rpm": ("r/min", "highest speed of the revolution"),
    "gas_torque_Nm": ("N m", "mean torque of the gas"),
    "brake_torque_Nm": ("N m", "mean torque of the gas less friction"),
    "load_torque_Nm": ("N m", "mean torque of the load"),
    "lowest_torque_Nm": ("N m", "lowest torque of the gas"),
    "highest_torque_Nm": ("N m", "highest torque of the gas"),
    "engine_air_kg": ("kg", "air from the supply through the grooves"),
    "control_air_kg": ("kg", "control air"),
    "receiver_dip_Pa": ("Pa", "supply pressure of the machine less the lowest in the receiver"),
}
"""Quantities of a revolution."""
OWN = {
    "valve_open_deg": ("deg", "own angle at which the lift rises through the lap"),
    "valve_close_deg": ("deg", "own angle at which the lift falls through the lap"),
    "full_lift": ("", "whether the valve reached its open stop"),
}
"""Quantities of a cylinder in a revolution."""
PLOTS = {
    "speed": ("mean_speed", "mean speed [r/min]"),
    "torque": ("brake_torque", "brake torque [N m]"),
    "air": ("engine_air", "engine air [g a turn]"),
    "timing": ("valve_open_deg", "angle after TDC [deg]"),
}
"""What a run draws, over time."""


@dataclass(frozen=True, eq=False, repr=False)
class TransientRun(Result):
    """Engine over time; numbers as ``apesim engine transient --json`` has them.

    Attributes
    ----------
    march : DrivetrainRun
        March of the drivetrain, for those who look deeper.
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

    march: DrivetrainRun = field(kw_only=True)

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
        columns, own = revolution_columns(self.march), own_columns(self.march)
        revolutions = []
        for k in range(len(self.march.revolutions["start"])):
            row: dict[str, Any] = {name: float(values[k]) for name, values in columns.items()}
            count = self.march.cylinders["open"].shape[1]
            row["receiver_dip_Pa"] = self._dip(k)
            row["cylinders"] = [{name: float(values[k, i]) for name, values in own.items()} for i in range(count)]
            revolutions.append(row)
        events = [
            {"kind": event.kind.value, "time_s": event.time, "angle_deg": event.angle / DEGREE}
            for event in self.march.events
        ]
        names = ("mass", "energy", "shaft")
        data = {key: self[key] for key in NUMBERS if not key.endswith("_closure") and key != "revolutions"}
        return data | {
            "revolutions": revolutions,
            "events": events,
            "closure": {name: self[f"{name}_closure"] for name in names},
            "warnings": list(self.warnings),
        }

    def _dip(self, k: int) -> float:
        """Supply pressure less the lowest one in the receiver in a revolution [Pa]."""
        return float(self.traces["receiver_dip"].values[k])

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
        from apesim.studies.drawing.axes import axes_for, check_plotted

        check_plotted(what, PLOTS)
        ax = axes_for(ax)
        name, label = PLOTS[what]
        r = self.march.revolutions
        middle = r["start"] + 0.5 * np.abs(r["duration"])
        if what == "timing":
            own = own_columns(self.march)
            for i in range(own["valve_open_deg"].shape[1]):
                told = f" of cylinder {i + 1}" * (own["valve_open_deg"].shape[1] > 1)
                ax.plot(middle, own["valve_open_deg"][:, i], "o", ms=3, label=f"opens{told}")
                ax.plot(middle, own["valve_close_deg"][:, i], "s", ms=3, label=f"closes{told}")
            ax.legend()
        else:
            factor = 1e3 if what == "air" else 1.0
            key = next(key for key, (unit, _) in REVOLUTION.items() if name_of(key, unit).startswith(name))
            ax.plot(middle, revolution_columns(self.march)[key] * factor, "o-", ms=3)
        ax.set(xlabel="time [s]", ylabel=label, title=self._told_conditions())
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
    progress: Callable[..., object] | None = None,
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
        "fixed": the machine's command; or a CSV with speed, energise and release, such as `correct_timing` exports,
        which each cylinder reads by the instantaneous speed as it passes its own 180 deg.
    min_pulse : str or float, optional
        Shortest pulse that is commanded, "7.8 ms": the release is put off where the timing has a shorter one.
    sample : str or float, optional
        Time between two rows of the traces; a 5000th of the duration if left out.
    progress : function, optional
        Is told the time that is marched and the time to march [s], from time to time.

    Returns
    -------
    TransientRun
        Totals, a row for each revolution, events, closures and traces.

    Raises
    ------
    InputError
        The machine or an argument is out of range, or two arguments do not go together.
    NotConverged
        The march ended early; its ``result`` holds what was found.

    Examples
    --------
    >>> import apesim
    >>> run = apesim.run_transient(apesim.Machine(), speed="0 s: 600 rpm, 0.5 s: 900 rpm")
    >>> round(run["turns"], 3)
    6.25
    """
    arguments, machine = arguments_of("run_transient", machine)
    at = arguments.quantity("angle", angle, START_ANGLE)
    omega = arguments.quantity("from_speed", from_speed, SPEED)
    speeds = read_course(arguments, "speed", speed, IMPOSED_SPEED, "300 rpm")
    loads = read_course(arguments, "load", load, LOAD_TORQUE, "10 N m")
    supplies = read_supply(arguments, supply)
    pulse = arguments.quantity("min_pulse", min_pulse, TIME)
    schedules = read_timing(arguments, machine, timing, pulse)
    end = arguments.quantity("duration", duration, MOMENT)
    step = arguments.quantity("sample", sample, TIME)

    # Arguments that are right each by itself, but do not go together.
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
    arguments.refuse()

    # From rest at an angle; from the periodic state at a speed, after turns at that; or with the imposed speed.
    compile_drivetrain(machine)
    begin = time.perf_counter()
    course = Course(speeds, loads, supplies, schedules)
    start = prepare(machine, 0.0 if at is None else at, course, NO_GOAL)
    if omega is not None:
        settling = SETTLING * TURN / omega
        steady = Course(np.array([[0.0, omega], [2.0 * settling, omega]]), schedules=schedules)
        settled = call_in_thread(run_drivetrain, prepare(machine, 0.0, steady, NO_GOAL), settling).result()
        start = released(start, settled.y, settled.mode, settling)
    times = np.arange(0.0, end * (1.0 + 1e-12), step or end / ROWS)
    told = (lambda now: progress(now, end)) if progress else None
    march = call_in_thread(run_drivetrain, start, end, times, report=told).result()
    wall_time = time.perf_counter() - begin

    closure = closure_of_run(start, march.y)
    columns, full = revolution_columns(march), march.cylinders["full_lift"]
    receivers = march.cylinders["min_receiver"][:, draws_from_supply(start.p)]
    dip = machine.supply.pressure - receivers.min(axis=1, initial=np.inf)
    values = _totals(start, march) | {
        "strokes_cut_short": int((full == 0.0).sum()),
        "mass_closure": closure.mass,
        "energy_closure": closure.energy,
        "shaft_closure": closure.shaft,
        "wall_time_s": wall_time,
    }
    speeds_met = columns["lowest_speed_rpm"], columns["highest_speed_rpm"]
    values |= {"lowest_speed_rpm": float(speeds_met[0].min(initial=np.inf))}
    values |= {"highest_speed_rpm": float(speeds_met[1].max(initial=-np.inf)), "revolutions": len(dip)}
    warnings = []
    if march.status not in (Status.DONE, Status.STOPPED):
        warnings.append(f"the march ended early, at {march.duration:g} s: {march.status.remedy}")
    if machine.engine.intake == EPV and values["strokes_cut_short"]:
        share = f"{values['strokes_cut_short']} of {full.size} strokes"
        warnings.append(f"the valve does not reach full lift in {share}: a longer pulse would, see min_pulse")
    traces = traces_over_time(march) | _traces_of_revolutions(columns, own_columns(march), dip)
    conditions = {"shaft": "imposed speed" if len(speeds) else "free", "timing": str(timing)}
    run = TransientRun(
        scalars_of(values, NUMBERS),
        traces,
        conditions | {"cylinders": f"{machine.engine.cylinders:g}"} | supply_conditions(machine),
        warnings,
        machine=text_writer(machine),
        march=march,
    )
    if march.status not in (Status.DONE, Status.STOPPED):
        raise NotConverged("the transient", "the march ended early", march.status.remedy, run)
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


def revolution_columns(march: DrivetrainRun) -> dict[str, np.ndarray]:
    """Compute `REVOLUTION` of each revolution (r,), in the units there, without the receiver's dip."""
    r = march.revolutions
    angle = np.sign(r["duration"]) * TURN
    return {
        "start_s": r["start"],
        "mean_speed_rpm": 60.0 / r["duration"],
        "lowest_speed_rpm": r["min_speed"] / RPM,
        "highest_speed_rpm": r["max_speed"] / RPM,
        "gas_torque_Nm": r["gas_work"] / angle,
        "brake_torque_Nm": (r["gas_work"] - r["friction_work"]) / angle,
        "load_torque_Nm": r["load_work"] / angle,
        "lowest_torque_Nm": r["min_torque"],
        "highest_torque_Nm": r["max_torque"],
        "engine_air_kg": r["engine_air"],
        "control_air_kg": r["control_air"],
    }


def own_columns(march: DrivetrainRun) -> dict[str, np.ndarray]:
    """Compute `OWN` of each cylinder in each revolution (r, n), in the units there."""
    c = march.cylinders
    return {"valve_open_deg": c["open"] / DEGREE, "valve_close_deg": c["close"] / DEGREE, "full_lift": c["full_lift"]}


def _traces_of_revolutions(
    columns: dict[str, np.ndarray], own: dict[str, np.ndarray], dip: np.ndarray
) -> dict[str, Trace]:
    """Quantities of the revolutions as traces, by their names in Python; no trace over time has the name of one."""
    traces = {"revolution": Trace(("revolution",), np.arange(len(dip)), "", "whole revolution")}
    for key, (unit, text) in REVOLUTION.items():
        values = dip if key == "receiver_dip_Pa" else columns[key]
        name = name_of(key, unit)
        prefix = "revolution_" if key == "start_s" else "mean_" if text.startswith("mean torque") else ""
        traces[prefix + name] = Trace(("revolution",), values, unit, text)
    for key, (unit, text) in OWN.items():
        traces[name_of(key, unit)] = Trace(("revolution", "cylinder"), own[key], unit, text)
    count = own["full_lift"].shape[1]
    return traces | {"cylinder": Trace(("cylinder",), np.arange(1, count + 1), "", "cylinder")}


def traces_over_time(march: DrivetrainRun) -> dict[str, Trace]:
    """Traces of a march over time, those of the cylinders with a second axis, by their names in Python."""
    dims, shaft = ("time",), len(SHAFT_TRACE)
    traces = {"time": Trace(dims, march.times, "s", "time")}
    names = {"angle": "angle of the shaft", "speed": "speed of the shaft", "gas_torque": "torque of the gas"}
    names |= {"friction_torque": "torque of friction", "load_torque": "torque of the load"}
    for column, header in enumerate(SHAFT_TRACE):
        name, unit = split_header(header)
        unit = "r/min" if unit == "rpm" else unit or ""
        key = f"{name}_deg" if unit == "deg" else f"{name}_rpm" if unit == "r/min" else name
        traces[key] = Trace(dims, march.trace[:, column], unit, names[name])
    count = (march.trace.shape[1] - shaft) // len(TRACE)
    own = march.trace[:, shaft:].reshape(-1, count, len(TRACE))
    traces["cylinder"] = Trace(("cylinder",), np.arange(1, count + 1), "", "cylinder")
    for column, header in enumerate(TRACE):
        name, unit = split_header(header)
        traces[name_of(name, unit or "1")] = Trace(
            ("time", "cylinder"), own[:, :, column], unit or "1", TRACE_NAMES[name]
        )
    return traces


def trace_table(march: DrivetrainRun) -> tuple[list[str], np.ndarray]:
    """Header with units and rows of the traces over time, the columns of each cylinder with its number."""
    count = (march.trace.shape[1] - len(SHAFT_TRACE)) // len(TRACE)
    header = ["time [s]", *SHAFT_TRACE]
    for i in range(count):
        for column in TRACE:
            name, unit = split_header(column)
            header.append(column if count == 1 else f"{name}_{i + 1} [{unit}]")
    return header, np.column_stack((march.times, march.trace))
