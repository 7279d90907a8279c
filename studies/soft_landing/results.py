"""The archive of a study of soft landing."""

from collections.abc import Mapping, Sequence
from math import isnan, nan

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.columns import NO_YES, column, run_axis
from apesim.engine.machine import Machine
from apesim.kernel import sources_hash
from apesim.quantities.settings import dumps
from apesim.studies.run.operating_conditions import with_supply
from apesim.studies.soft_landing.braking import (
    ADDED,
    APART,
    BRAKE,
    RELEASE,
    RESOLUTION,
    SPACINGS,
    SPEED,
    SWITCHED,
    front_of,
    widest_soft,
)
from apesim.studies.soft_landing.landing import OPENING, SOLENOIDS, STROKES, Landing, Task, apart_of
from apesim.studies.soft_landing.strokes import FACTORS, KINDS, LIMITS, OFFSETS, ChosenBrake, Result
from apesim.valve.solenoid import energised_fraction, solenoid_curves

STEP = 0.02e-3
"""Step of the added time over which the fronts stand [s]."""
SAMPLE = 0.05e-3
"""Time between two rows of the traces [s]."""
NUMBERED = "-1 none, 0 both, 1 A, 2 B"
KEPT = {
    "brake": ("s", "begin of the brake after the command edge"),
    "release": ("s", "end of the brake after the command edge"),
    "added": ("s", "time added to the stroke"),
    "speed": ("m/s", "seating speed"),
    "apart": ("s", "shortest time between two edges of a solenoid"),
    "solenoids": ("1", "solenoids that the brake switches: 0 both, 1 A, 2 B"),
}
"""Columns of the brakes that are kept, from `BRAKE` on: unit and what it is."""


def archive_of(
    machine: Machine,
    results: Sequence[Result],
    spacing: float,
    cost: float,
    command: str = "",
    solenoids: Sequence[str] = SOLENOIDS,
) -> Archive:
    """Store brakes as an archive; a run is a pressure, and NaN stands where there is no brake.

    `results` has opening and closing for each pressure; `spacing` is the shortest time between two edges of a solenoid
    [s], `cost` the longest added time allowed [s], `solenoids` the ways to brake that were tried.
    """
    openings = [result for result in results if result.task.stroke == OPENING]
    controls = [result.task.machine.supply.control() for result in openings]
    pressures = np.array([control.pressure for control in controls])
    temperatures = np.array([control.temperature for control in controls])

    # All fronts stand over one axis of added time, up to the slowest brake of all strokes.
    added = np.arange(0.0, max(STEP, _max_added(results)) + STEP, STEP)
    variables = {
        "run": run_axis(len(openings), "number of the pressure"),
        "supply_pressure": column(pressures, "Pa abs", "pressure of the control air", coordinate=True),
        "supply_temperature": column(temperatures, "K", "temperature of the control air", coordinate=True),
        "added_time": Variable(("added_time",), added, "s", "time added to a stroke by its brake, at most"),
        "spacing": Variable(("spacing",), SPACINGS, "s", "time between two edges of a solenoid, at least"),
        "pressure_factor": Variable(("pressure_factor",), np.array(FACTORS), "1", "of the gauge pressure"),
        "temperature_offset": Variable(("temperature_offset",), np.array(OFFSETS), "K", "of the control air"),
    }

    # The brakes that make up the fronts are kept, so that `strokes_of` finds the results again; then what figures show.
    variables |= _kept(results, spacing, cost)
    for stroke in STROKES:
        of_stroke = [result for result in results if result.task.stroke == stroke]
        variables |= _landings(stroke, of_stroke, cost) | _fronts(stroke, of_stroke, added, spacing)
        for limit in LIMITS:
            for kind in KINDS:
                variables |= _choices(f"{stroke}_{limit}_{kind}", [result.choices[limit, kind] for result in of_stroke])
    variables |= _traces(results)

    # What was asked for, with all digits: whoever reads the archive makes the same results of it.
    provenance = {
        "kind": "valve soft-landing",
        "command": command,
        "kernels": sources_hash(),
        "dwell_s": repr(openings[0].task.dwell),
        "spacing_s": repr(spacing),
        "cost_s": repr(cost),
        "resolution_s": repr(RESOLUTION),
        "solenoids": ", ".join(solenoids),
    }
    return Archive(dumps(machine), provenance, variables)


def _max_added(results: Sequence[Result]) -> float:
    """Longest added time of all brakes [s]; 0 without any."""
    return max((result.brakes[:, ADDED].max() for result in results if len(result.brakes)), default=0.0)


def _landings(stroke: str, results: Sequence[Result], cost: float) -> dict[str, Variable]:
    """Unbraked landings, and the softest brake over the spacing, as variables."""

    def over_spacing(result: Result) -> list[float]:
        fronts = [front_of(result.brakes, apart, cost) for apart in SPACINGS]
        return [front[-1, SPEED] if len(front) else result.unbraked.speed for front in fronts]

    wide = [widest_soft(result.brakes, result.unbraked, cost) for result in results]
    columns = {
        "contact": ([r.unbraked.contact for r in results], "s", "unbraked: command edge to contact"),
        "seating_speed": ([r.unbraked.speed for r in results], "m/s", "unbraked: speed just before contact"),
        "lowest_speed": ([r.lowest for r in results], "m/s", "unbraked: lowest speed between peak and contact"),
        "needed_spacing": (
            [row[0, APART] if len(row) else nan for row in wide],
            "s",
            "farthest apart that edges can be for a brake to halve the seating speed at the stated cost",
        ),
    }
    variables = {f"{stroke}_{name}": column(np.array(v, float), *of) for name, (v, *of) in columns.items()}
    description = "lowest seating speed at the stated cost with edges that far apart; unbraked where none lowers it"
    variables[f"{stroke}_speed_over_spacing"] = Variable(
        ("run", "spacing"), np.array([over_spacing(r) for r in results]), "m/s", description
    )
    return variables


def _fronts(stroke: str, results: Sequence[Result], added: np.ndarray, spacing: float) -> dict[str, Variable]:
    """Fronts as variables: for each added time the softest brake that costs no more; NaN where there is none."""
    variables = {}
    for limit, apart in zip(LIMITS, (spacing, 0.0), strict=True):
        values = np.full((4, len(results), len(added)), nan)
        for run, result in enumerate(results):
            front = front_of(result.brakes, apart)
            last = np.searchsorted(front[:, ADDED], added, side="right") - 1
            for number, place in enumerate((SPEED, BRAKE, RELEASE, SWITCHED)):
                values[number, run, last >= 0] = front[last[last >= 0], place]
        declared = (
            ("speed", "m/s", "front: seating speed", ""),
            ("brake", "s", "front: begin of the brake after the command edge", ""),
            ("release", "s", "front: end of the brake after the command edge", ""),
            ("solenoids", "1", "front: solenoids that the brake switches", NUMBERED),
        )
        columns = (*values[:3], _numbers(values[3]))
        for (name, unit, description, meanings), front in zip(declared, columns, strict=True):
            variable = Variable(("run", "added_time"), front, unit, description, meanings)
            variables[f"{stroke}_{limit}_front_{name}"] = variable
    return variables


def _kept(results: Sequence[Result], spacing: float, cost: float) -> dict[str, Variable]:
    """Brakes on the fronts, and those that show which spacing is needed, as variables; NaN behind the last one."""
    kept = {s: [_kept_brakes(r, spacing, cost) for r in results if r.task.stroke == s] for s in STROKES}
    most = max(1, *(len(rows) for of_stroke in kept.values() for rows in of_stroke))
    variables = {"kept": Variable(("kept",), np.arange(most), "1", "number of a brake that was kept")}
    for stroke, of_stroke in kept.items():
        values = np.full((len(of_stroke), most, len(KEPT)), nan)
        for run, rows in enumerate(of_stroke):
            values[run, : len(rows)] = rows
        for number, (name, (unit, description)) in enumerate(KEPT.items()):
            variables[f"{stroke}_kept_{name}"] = Variable(("run", "kept"), values[..., number], unit, description)
    return variables


def _kept_brakes(result: Result, spacing: float, cost: float) -> np.ndarray:
    """Brakes from which the fronts and the spacing that is needed can be found again, in the order of their trial."""
    fronts = [front_of(result.brakes, apart) for apart in (spacing, 0.0)]
    needed = set(map(tuple, np.concatenate((*fronts, widest_soft(result.brakes, result.unbraked, cost))).tolist()))
    return result.brakes[[tuple(row) in needed for row in result.brakes.tolist()]].reshape(-1, len(KEPT))


def strokes_of(archive: Archive, machine: Machine) -> tuple[Result, ...]:
    """Read the strokes of an archive of `archive_of`: opening and closing for each pressure.

    Of all brakes that were tried they hold those on the fronts; the delay of a landing, which nothing asks for, is NaN.

    >>> from apesim.studies.soft_landing.strokes import soft_landings
    >>> results = soft_landings(Machine(), [0.12e6], 287.0, dwell=50e-3)  # too little pressure to move the piston
    >>> strokes = strokes_of(archive_of(Machine(), results, spacing=4e-3, cost=1e-3), Machine())
    >>> [(result.task.stroke, result.unbraked.stays, result.best) for result in strokes]
    [('opening', False, None), ('closing', False, None)]
    """
    v = {name: variable.values for name, variable in archive.variables.items()}
    dwell = float(archive.provenance["dwell_s"])
    strokes = []
    for run in range(len(archive.runs)):
        air = float(v["supply_pressure"][run]), float(v["supply_temperature"][run])
        supplied = with_supply(machine, *air)
        before = Task(supplied, dwell, STROKES[0]).before
        for stroke in STROKES:
            task = Task(supplied, dwell, stroke, before=before)
            lowest = float(v[f"{stroke}_lowest_speed"][run])
            contact, speed = (float(v[f"{stroke}_{name}"][run]) for name in ("contact", "seating_speed"))
            brakes = np.column_stack([v[f"{stroke}_kept_{name}"][run] for name in KEPT])
            choices = {
                (limit, kind): _choice_in(v, f"{stroke}_{limit}_{kind}", run, task)
                for limit in LIMITS
                for kind in KINDS
            }
            completed = not isnan(lowest)  # only such a stroke has a lowest speed before its contact
            unbraked = Landing(nan, contact, speed, completed)
            strokes.append(Result(task, unbraked, lowest, brakes[~np.isnan(brakes).any(axis=1)], choices))
            best, brake = strokes[-1].braked
            before = best.edges(brake)
    return tuple(strokes)


def _choice_in(v: Mapping[str, np.ndarray], prefix: str, run: int, task: Task) -> ChosenBrake | None:
    """ChosenBrake that stands in the columns with a prefix; None where there is none."""
    names = ("brake", "release", "added", "speed")
    brake, release, added, speed = (float(v[f"{prefix}_{name}"][run]) for name in names)
    if isnan(brake):
        return None
    row = [brake, release, added, speed, apart_of(task, (brake, release)), v[f"{prefix}_solenoids"][run]]
    columns = (v[f"{prefix}_{name}_at"][run].ravel().tolist() for name in ("contact", "speed", "stays"))
    landings = tuple(Landing(nan, at, fast, bool(stays)) for at, fast, stays in zip(*columns, strict=True))
    return ChosenBrake(np.array(row, dtype=float), landings, v[f"{prefix}_added_at"][run].ravel())


def _numbers(solenoids: np.ndarray) -> np.ndarray:
    """Numbers of solenoids as codes; -1 where there are none."""
    return np.nan_to_num(solenoids, nan=-1.0).astype(np.int8)


def _choices(prefix: str, choices: Sequence[ChosenBrake | None]) -> dict[str, Variable]:
    """Kind of choice as variables; NaN where there is none."""
    shape = (len(choices), len(FACTORS), len(OFFSETS))
    rows, speed, added, contact = np.full((len(choices), 6), nan), *(np.full(shape, nan) for _ in range(3))
    stays = np.zeros(shape, dtype=np.int8)
    for run, choice in enumerate(choices):
        if choice:
            rows[run] = choice.row
            speed[run] = np.reshape([landing.speed for landing in choice.landings], shape[1:])
            contact[run] = np.reshape([landing.contact for landing in choice.landings], shape[1:])
            added[run] = choice.added.reshape(shape[1:])
            stays[run] = np.reshape([landing.stays for landing in choice.landings], shape[1:])
    axes = ("run", "pressure_factor", "temperature_offset")
    return {
        f"{prefix}_brake": column(rows[:, BRAKE], "s", "begin of the brake after the command edge"),
        f"{prefix}_release": column(rows[:, RELEASE], "s", "end of the brake after the command edge"),
        f"{prefix}_solenoids": column(_numbers(rows[:, SWITCHED]), "1", "solenoids that it switches", NUMBERED),
        f"{prefix}_added": column(rows[:, ADDED], "s", "time added to the stroke"),
        f"{prefix}_speed": column(rows[:, SPEED], "m/s", "seating speed"),
        f"{prefix}_speed_at": Variable(axes, speed, "m/s", "seating speed under other conditions"),
        f"{prefix}_contact_at": Variable(axes, contact, "s", "command edge to contact under other conditions"),
        f"{prefix}_added_at": Variable(axes, added, "s", "time added to the unbraked stroke of the same condition"),
        f"{prefix}_stays_at": Variable(axes, stays, "1", "whether the piston stays at its stop", NO_YES),
    }


def _traces(results: Sequence[Result]) -> dict[str, Variable]:
    """Lift, velocity and energised fractions over both strokes, unbraked and with the best brakes, as variables."""
    openings, closings = results[::2], results[1::2]
    task = results[0].task
    times = task.run(sample=SAMPLE).times
    variables = {"time": Variable(("time",), times, "s", "time after the solenoids are energised")}
    curves = solenoid_curves(task.machine.valve.solenoid)
    braked = [result.braked for result in closings]
    for name, runs in (("unbraked", [(result.task, ()) for result in openings]), ("braked", braked)):
        traces = np.array([task.run(brake, sample=SAMPLE).trace for task, brake in runs])
        variables[f"{name}_lift"] = Variable(("run", "time"), traces[..., 0], "m", "lift")
        variables[f"{name}_velocity"] = Variable(
            ("run", "time"), traces[..., 1], "m/s", "velocity of the lift, positive as it opens"
        )
        for number, solenoid in enumerate("ab"):
            commands = [np.array(sorted((0.0, task.dwell, *task.edges(brake)[number]))) for task, brake in runs]
            energised = [[energised_fraction(edges, np.inf, curves, t) for t in times] for edges in commands]
            variables[f"{name}_energised_{solenoid}"] = Variable(
                ("run", "time"), np.array(energised), "1", f"energised fraction of solenoid {solenoid.upper()}"
            )
    return variables
