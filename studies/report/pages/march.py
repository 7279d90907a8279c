"""The page of a start, or of an engine over time: revolution by revolution, then single turns."""

from collections.abc import Mapping, Sequence

import numpy as np

from apesim.archive import Archive
from apesim.results import Result
from apesim.studies.archives.archive_result import ArchiveResult
from apesim.studies.drawing.spread import spread_out
from apesim.studies.report.figures.curves import Curves, Line
from apesim.studies.report.figures.labels import Axis, Frames, find_shown_unit, format_number
from apesim.studies.report.figures.moving import Moving
from apesim.studies.report.figures.rings import Rings
from apesim.studies.report.machine import read_machine
from apesim.studies.report.pages.cycle import CycleLine, draw_cycle
from apesim.studies.report.sections import Content, Fact, Section, Table
from apesim.studies.transient.march_archive import events_of
from apesim.studies.transient.start_archive import intervals_of

TRACES = (
    *("cylinder_pressure", "cylinder_temperature", "cylinder_volume", "lift", "pressure_a", "pressure_b"),
    *("groove_flow", "torque", "receiver_pressure"),
)
"""Traces of a cylinder that the page shows."""
SHAFT = "gas_torque", "friction_torque", "load_torque"
"""Torques of the shaft, in one figure."""
REVOLUTIONS = (
    ("speed", ("revolution_mean_speed_rpm", "revolution_lowest_speed_rpm", "revolution_highest_speed_rpm")),
    ("torque", ("revolution_gas_torque_Nm", "revolution_brake_torque_Nm", "revolution_load_torque_Nm")),
    ("engine air", ("revolution_engine_air_kg",)),
    ("control air", ("revolution_control_air_kg",)),
    ("opening of the valve", ("valve_open_deg",)),
    ("closing of the valve", ("valve_close_deg",)),
)
"""What is drawn over the revolutions: label, and variables of the archive."""
WORDS = {"revolution_": "", "_rpm": "", "_Nm": "", "_kg": "", "_speed": "", "_torque": "", "_": " "}
"""What becomes short in the names of a revolution's quantities."""
MAX_TURNS = 6
"""Turns that are shown one by one."""
MAX_OF_TURN = 400
"""Samples of a turn that a figure shows."""
MAX_SAMPLES = 1200
"""Samples over the whole time that a figure shows."""
TURN = 360.0
"""Angle of a turn [deg]."""


def write_transient(result: ArchiveResult) -> Content:
    """Say what the engine did over time."""
    archive = result.archive
    sections = [
        _draw_revolutions(archive),
        _draw_turns(archive, start=-1),
        _draw_shaft(archive),
        _list_events(result),
    ]
    facts = list_facts(
        result,
        (
            "duration",
            "lowest_speed_rpm",
            "highest_speed_rpm",
            "brake_work",
            "engine_air",
            "control_air",
            "specific_work_J_per_g",
        ),
    )
    return Content("The engine over time", _summarise(result), facts, [each for each in sections if each])


def write_start(result: ArchiveResult) -> Content:
    """Say whether and how the engine starts."""
    archive = result.archive
    title = "A start from rest"
    intervals = intervals_of(archive)
    if "angle_deg" not in archive.variables:
        note = "Angle of the shaft at rest, 0 at top dead centre of the first cylinder"
        share = f"{100.0 * result['starting_share']:.0f} % of all angles"
        rows = [(f"{low:.2f}", f"{high:.2f}") for low, high in intervals]
        table = Table("", ("from [deg]", "to [deg]"), rows)
        section = Section(
            "Angles from which it starts", [Rings("Starting angles", [(share, intervals)], note)], tables=[table]
        )
        summary = f"The engine starts from {share} of its crank. {_say_conditions(result.conditions)}"
        return Content(title, summary, list_facts(result, ("starting_share",)), [section])
    sections = [_draw_turns(archive, start=0), _draw_shaft(archive), _list_events(result)]
    facts = list_facts(result, ("time", "turns", "engine_air", "control_air", "first_motion", "highest_speed_rpm"))
    return Content(title, _summarise_start(result), facts, [each for each in sections if each])


def list_facts(result: Result, names: Sequence[str]) -> list[Fact]:
    """Take headline numbers from a result, in the units that pages show."""
    facts = []
    for name in names:
        scalar = result.scalars.get(name)
        if scalar is None or isinstance(scalar.value, str):
            continue
        factor, unit = find_shown_unit(scalar.unit, np.array([float(scalar.value)]))
        value = (
            "yes" if scalar.value is True else "no" if scalar.value is False else format_number(scalar.value * factor)
        )
        facts.append(Fact(value, unit, scalar.long_name))
    return facts


def _summarise(result: ArchiveResult) -> str:
    """Say in a sentence or two what happened."""
    said = result.conditions
    shaft = {"free": "A free shaft", "imposed": "A shaft at imposed speed"}.get(said.get("shaft", ""), "A shaft")
    duration, turns, work = (format_number(result[name]) for name in ("duration", "turns", "brake_work"))
    low, high = (format_number(result[f"{end}_speed_rpm"]) for end in ("lowest", "highest"))
    return (
        f"{shaft} over {duration} s and {turns} turns: from {low} to {high} r/min in whole revolutions, with "
        f"{_sum_air(result)} g of air for {work} J of brake work. {_say_conditions(said)}"
    )


def _summarise_start(result: ArchiveResult) -> str:
    """Say in a sentence or two how the start went."""
    if not result["starts"]:
        return f"The engine does not start: its shaft does not turn thrice. {_say_conditions(result.conditions)}"
    time, turns = format_number(result["time"]), format_number(result["turns"])
    return (
        f"The engine starts: it reaches its goal after {time} s and {turns} turns, with {_sum_air(result)} g of air. "
        f"{_say_conditions(result.conditions)}"
    )


def _sum_air(result: ArchiveResult) -> str:
    """Air of engine and control in words [g]."""
    return format_number(1e3 * (result["engine_air"] + result["control_air"]))


def _say_conditions(conditions: Mapping[str, str]) -> str:
    """Conditions of a march as a sentence."""
    return "Conditions: " + "; ".join(f"{name.replace('_', ' ')} {text}" for name, text in conditions.items()) + "."


def _draw_revolutions(archive: Archive) -> Section | None:
    """Draw the means of the revolutions over time."""
    if "revolution_start_s" not in archive.variables or archive.variables["revolution_start_s"].values.size < 2:
        return None
    start = archive.variables["revolution_start_s"].values[0]
    figures = []
    for label, names in REVOLUTIONS:
        lines: list[Line] = []
        for name in names:
            variable = archive.variables[name]
            factor, unit = find_shown_unit(variable.unit)
            columns = variable.values[0].reshape(len(start), -1).T * factor
            for number, column in enumerate(columns, 1):
                own = _shorten(name) if len(names) > 1 else label
                lines.append(Line(own if len(columns) == 1 else f"cylinder {number}", [column], look=len(lines)))
        if any(np.isfinite(line.values[0]).any() for line in lines):
            title = f"{label[:1].upper()}{label[1:]}"
            figures.append(
                Curves(
                    title, Axis("start of the revolution", "s"), Axis(label, unit), lines, [start], sync="revolution"
                )
            )
    return Section("Revolution by revolution", figures, "A point for each whole revolution of the shaft.")


def _shorten(name: str) -> str:
    """Short words for a quantity of a revolution: "revolution_gas_torque_Nm" is "gas"."""
    for long, short in WORDS.items():
        name = name.replace(long, short)
    return name.strip()


def _draw_turns(archive: Archive, *, start: int) -> Section | None:
    """Draw single turns of the shaft over its angle, those of the first cylinder; `start` is shown first."""
    angle, time = archive.variables["angle_deg"].values[0], archive.variables["time"].values
    last = int(np.floor(angle[-1] / TURN)) if angle.size else 0
    if last < 1:
        return None
    turns = [int(k) for k in spread_out(last, MAX_TURNS)]
    parts = [np.flatnonzero((angle >= k * TURN) & (angle <= (k + 1) * TURN)) for k in turns]
    # At rest it stays where it is; a turn in which it goes back is no turn.
    parts = [part[np.diff(angle[part], prepend=-1.0) > 0.0] for part in parts if (np.diff(angle[part]) >= 0.0).all()]
    longest = max((part.size for part in parts), default=0)
    step = max(1, -(-longest // MAX_OF_TURN))
    parts = [part[::step] for part in parts if part.size > 2 * step]
    if not parts:
        return None
    names = [name for name in TRACES if name in archive.variables]
    traces = [
        {name: archive.variables[name].values[0].reshape(len(time), -1)[part, 0] for name in names} for part in parts
    ]
    xs = [angle[part] - TURN * np.floor(angle[part[0]] / TURN + 1e-9) for part in parts]
    axis = Axis("crank angle", "deg", (0.0, TURN))
    texts = tuple(f"{int(angle[part[0]] // TURN) + 1}, from {format_number(float(time[part[0]]))} s" for part in parts)
    line = CycleLine("cylinder 1", 0, traces)
    machine, frames = read_machine(archive), Frames("turn", texts, start if start >= 0 else len(parts) + start)
    figures = draw_cycle(archive, machine, axis, xs, [line], frames)
    title = "Engine and valve to scale"
    moving = Moving(title, machine, Axis("crank angle", "deg"), xs, traces, frames=frames)
    several = len(archive.variables["cylinder"].values) > 1
    said = [f"{len(parts)} of {last} turns"] + ["the first cylinder"] * several
    said += [f"every {step}th sample"] * (step > 1)
    return Section("Turn by turn", [moving, *figures], f"{', '.join(said)}; the archive holds all.")


def _draw_shaft(archive: Archive) -> Section:
    """Draw speed and torques of the shaft over the whole time."""
    time = archive.variables["time"].values
    step = max(1, -(-len(time) // MAX_SAMPLES))
    x, xs = Axis("time", "s"), [time[::step]]
    speed = archive.variables["speed_rpm"].values[0][::step]
    figures = [Curves("Speed of the shaft", x, Axis("speed", "r/min"), [Line("speed", [speed])], xs, sync="time")]
    torques = [
        Line(name.split("_")[0], [archive.variables[name].values[0][::step]], look=number)
        for number, name in enumerate(SHAFT)
        if name in archive.variables and np.any(archive.variables[name].values)
    ]
    figures.append(Curves("Torques on the shaft", x, Axis("torque", "N·m"), torques, xs, sync="time"))
    note = f"Every {step}th of {len(time)} samples." if step > 1 else ""
    return Section("The shaft over the whole time", figures, note)


def _list_events(result: ArchiveResult) -> Section | None:
    """List the events of the shaft."""
    rows = [
        (row["kind"].replace("_", " "), format_number(row["time_s"]), format_number(row["angle_deg"]))
        for row in events_of(result)
    ]
    table = Table("", ("event", "time [s]", "angle [deg]"), rows)
    return Section("Events of the shaft", tables=[table]) if rows else None
