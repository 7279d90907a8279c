"""Marches of a drivetrain as variables of an archive: traces over time, a row for each revolution, events."""

from typing import Any

import numpy as np

from apesim.archive import Variable
from apesim.archive.columns import meanings_of
from apesim.archive.grid import words_of
from apesim.engine.angles import DEGREE, RPM, TURN
from apesim.engine.cycle.cylinder_laws import TRACE
from apesim.engine.drivetrain.rates import SHAFT_TRACE
from apesim.engine.drivetrain.run import DrivetrainRun, EventKind
from apesim.quantities import split_header
from apesim.results import Result, name_of
from apesim.studies.archives.archive_result import ArchiveResult
from apesim.studies.archives.run_result import axis_of, over_run
from apesim.studies.run.engine_run import TRACE_NAMES

SHAFT_NAMES = {
    "angle": "angle of the shaft",
    "speed": "speed of the shaft",
    "gas_torque": "torque of the gas",
    "friction_torque": "torque of friction",
    "load_torque": "torque of the load",
}
"""What each trace of the shaft is."""
REVOLUTION = {
    "start_s": ("s", "start of the revolution"),
    "mean_speed_rpm": ("r/min", "mean speed of the revolution"),
    "lowest_speed_rpm": ("r/min", "lowest speed of the revolution"),
    "highest_speed_rpm": ("r/min", "highest speed of the revolution"),
    "gas_torque_Nm": ("N m", "mean torque of the gas in the revolution"),
    "brake_torque_Nm": ("N m", "mean torque of the gas less friction in the revolution"),
    "load_torque_Nm": ("N m", "mean torque of the load in the revolution"),
    "lowest_torque_Nm": ("N m", "lowest torque of the gas in the revolution"),
    "highest_torque_Nm": ("N m", "highest torque of the gas in the revolution"),
    "engine_air_kg": ("kg", "air from the supply through the grooves in the revolution"),
    "control_air_kg": ("kg", "control air in the revolution"),
    "receiver_dip_Pa": ("Pa", "supply pressure of the machine less the lowest in the receiver in the revolution"),
}
"""Quantities of a revolution; in archives and traces their names begin with `PREFIX`."""
PREFIX = "revolution_"
OWN = {
    "valve_open_deg": ("deg", "own angle at which the lift rises through the lap"),
    "valve_close_deg": ("deg", "own angle at which the lift falls through the lap"),
    "full_lift": ("1", "1 where the valve reached its open stop, 0 where it did not"),
}
"""Quantities of a cylinder in a revolution; NaN where no stroke of its valve ended."""
EVENT = {
    "event_time_s": ("s", "time of the event"),
    "event_angle_deg": ("deg", "angle of the shaft at the event, from where its angles are counted"),
    "event_speed_rpm": ("r/min", "speed of the shaft at the event"),
    "event_engine_air_kg": ("kg", "air from the supply through the grooves until the event"),
    "event_control_air_kg": ("kg", "control air until the event"),
}
"""Quantities of an event of the shaft, beside its kind."""
SI = {"deg": DEGREE, "r/min": RPM}
"""Units of archives that are not SI, in SI."""


def trace_variables(march: DrivetrainRun) -> dict[str, Variable]:
    """Lay out the traces of a march over time, those of the cylinders with a second axis."""
    count = (march.trace.shape[1] - len(SHAFT_TRACE)) // len(TRACE)
    own = march.trace[:, len(SHAFT_TRACE) :].reshape(-1, count, len(TRACE))
    variables = axis_of("time", march.times, "s", "time")
    variables |= axis_of("cylinder", np.arange(1, count + 1), "1", "cylinder")
    for column, (name, unit) in enumerate(_columns(SHAFT_TRACE)):
        variables[name_of(name, unit)] = over_run(("time",), march.trace[:, column], unit, SHAFT_NAMES[name])
    for column, (name, unit) in enumerate(_columns(TRACE)):
        variables[name] = over_run(("time", "cylinder"), own[:, :, column], unit, TRACE_NAMES[name])
    return variables


def _columns(headers: tuple[str, ...]) -> list[tuple[str, str]]:
    """Split the headers of columns into names and units, these by their names in archives."""
    split = [split_header(header) for header in headers]
    return [(name, "r/min" if unit == "rpm" else unit or "1") for name, unit in split]


def revolution_variables(march: DrivetrainRun, supply_pressure: float) -> dict[str, Variable]:
    """Lay out `REVOLUTION` and `OWN` of each revolution of a march; the dip is below a pressure [Pa abs]."""
    r, c = march.revolutions, march.cylinders
    angle = np.sign(r["duration"]) * TURN
    columns = {
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
        "receiver_dip_Pa": supply_pressure - c["min_receiver"][:, 0],  # behind the supply
    }
    own = {"valve_open_deg": c["open"] / DEGREE, "valve_close_deg": c["close"] / DEGREE, "full_lift": c["full_lift"]}
    variables = axis_of("revolution", np.arange(len(r["start"])), "1", "whole revolution")
    variables |= {PREFIX + key: over_run(("revolution",), columns[key], *REVOLUTION[key]) for key in REVOLUTION}
    return variables | {key: over_run(("revolution", "cylinder"), own[key], *OWN[key]) for key in OWN}


def event_variables(march: DrivetrainRun) -> dict[str, Variable]:
    """Lay out the events of the shaft of a march."""
    kinds = list(EventKind)
    codes = np.array([kinds.index(event.kind) for event in march.events], dtype=np.int8)
    numbers = np.array([event[1:] for event in march.events], dtype=float).reshape(-1, len(EVENT))
    variables = axis_of("event", np.arange(1, len(codes) + 1), "1", "event of the shaft")
    variables["event_kind"] = over_run(
        ("event",), codes, "1", "what happens", meanings_of(kind.value for kind in kinds)
    )
    for column, (key, (unit, text)) in enumerate(EVENT.items()):
        variables[key] = over_run(("event",), numbers[:, column] / SI.get(unit, 1.0), unit, text)
    return variables


def revolutions_of(result: ArchiveResult) -> list[dict[str, Any]]:
    """Write the revolutions of a result as rows, by the keys of JSON."""
    v = {name: variable.values[0] for name, variable in result.archive.variables.items() if len(variable.dims) > 1}
    count = len(result.archive.variables["cylinder"].values)
    return [
        {key: float(v[PREFIX + key][k]) for key in REVOLUTION}
        | {"cylinders": [{key: float(v[key][k, i]) for key in OWN} for i in range(count)]}
        for k in range(len(v[PREFIX + "start_s"]))
    ]


def events_of(result: ArchiveResult) -> list[dict[str, Any]]:
    """Write the events of a result by the keys of JSON; none where it has none."""
    v = result.archive.variables
    if "event_kind" not in v:
        return []
    rows = words_of(v["event_kind"])[0], v["event_time_s"].values[0], v["event_angle_deg"].values[0]
    return [
        {"kind": str(kind), "time_s": float(time), "angle_deg": float(angle)}
        for kind, time, angle in zip(*rows, strict=True)
    ]


def trace_table(result: Result) -> tuple[list[str], np.ndarray]:
    """Header with units and rows of the traces over time, the columns of each cylinder with its number."""
    count = len(result.traces["cylinder"])
    names = [name_of(name, unit) for name, unit in (*_columns(SHAFT_TRACE), *_columns(TRACE))]
    shaft, own = names[: len(SHAFT_TRACE)], names[len(SHAFT_TRACE) :]
    header = ["time [s]", *SHAFT_TRACE]
    columns = [result.traces[name].values for name in ("time", *shaft)]
    for i in range(count):
        for name, column in zip(own, TRACE, strict=True):
            bare, unit = split_header(column)
            header.append(column if count == 1 else f"{bare}_{i + 1} [{unit}]")
            columns.append(result.traces[name].values[:, i])
    return header, np.column_stack(columns)
