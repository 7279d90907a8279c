"""The best commands over speed, as an archive."""

from collections.abc import Callable, Mapping, Sequence
from math import nan
from typing import Any

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.columns import NO_YES, column, run_axis
from apesim.engine.angles import DEGREE, RPM
from apesim.engine.indicators import INDICATORS
from apesim.engine.machine import Machine
from apesim.kernel import sources_hash
from apesim.quantities.settings import dumps
from apesim.studies.execution.pool import run_tasks, workers_for
from apesim.studies.optimise.landscape import DURATION, ENERGISE, RECORDED, Goal, Point, merit_of
from apesim.studies.optimise.search import FINE, Optimum, optimise
from apesim.studies.run.operating_conditions import SPEED

SECONDS_A_GOAL, SECONDS_A_FRONT = 1.0, 3.0
NAMES = {Goal.TORQUE: "most_torque", Goal.AIR: "least_air"}
FREE = ("energise", "duration", "supply_pressure")
BOUNDS = {-1: "lowest", 0: "between", 1: "highest"}
CRITERION = (
    "brake torque, and all air over brake work where that is positive, in the coupled periodic state; commands whose "
    "state does not repeat do not count"
)
COLUMNS = {
    "energise_deg": ("deg", "command angle"),
    "release_deg": ("deg", "command angle"),
    "supply_pressure": ("Pa abs", "pressure of the supply"),
    **{name: INDICATORS[name] for name in RECORDED},
}


def row_of(point: Point | None) -> dict[str, float]:
    """Collect the commands and results of a point under the names of `COLUMNS`; NaN where there is no point (None)."""
    if point is None:
        return dict.fromkeys(COLUMNS, nan)
    commands = point.energise / DEGREE, point.release / DEGREE, point.pressure
    return dict(zip(COLUMNS, commands, strict=False)) | point.values


def bounds_of(point: Point | None) -> dict[str, int]:
    """Judge where a point lies in the range of each free variable, by codes of `BOUNDS`; empty for None, no point."""
    return dict(zip(FREE, [int(u >= 1.0 - FINE) - int(u <= FINE) for u in point.place], strict=False)) if point else {}


def optima_over_speed(
    machine: Machine,
    speeds: Sequence[float],
    goals: Sequence[Goal],
    pressures: tuple[float, float] | None = None,
    jobs: int | None = None,
    report: Callable[[int, int], Any] | None = None,
) -> list[Optimum]:
    """Find the best commands at several speeds [rad/s]; each for itself, so the number of processes changes nothing.

    With both goals the Pareto front is searched, too. The supply is free between `pressures` [Pa abs]; it is the
    machine's own if left out. `jobs` is the number of processes, as many as the work is worth if left out; `report` is
    called with the number of speeds that are done and the number of all.
    """
    optima = [Optimum(speed, None, dict.fromkeys(goals), [], 0, 0) for speed in speeds]
    seconds = SECONDS_A_GOAL if len(goals) == 1 else 2.0 * SECONDS_A_GOAL + SECONDS_A_FRONT
    tasks = [(number, machine, speed, goals, pressures) for number, speed in enumerate(speeds)]
    done = run_tasks(_task, tasks, workers_for(seconds * len(speeds), jobs))
    for count, ((number, *_), optimum) in enumerate(done, 1):
        optima[number] = optimum or optima[number]
        if report:
            report(count, len(speeds))
    return optima


def _task(task: tuple[Any, ...]) -> Optimum:
    """Optimum of a numbered task: machine, speed, goals and pressures."""
    _, machine, speed, goals, pressures = task
    return optimise(machine, speed, goals, pressures)


def archive_of(
    machine: Machine,
    optima: Sequence[Optimum],
    goals: Sequence[Goal],
    pressures: tuple[float, float] | None = None,
    command: str = "",
) -> Archive:
    """Store optima as an archive: a run for each speed, and the points of its front along a second axis.

    The text of the machine goes into the archive, and the line of the `command`. The supply was free between
    `pressures` [Pa abs].
    """
    variables = {
        "run": run_axis(len(optima)),
        "speed_rpm": column(
            np.array([speed_rpm(optimum) for optimum in optima]), *INDICATORS["speed_rpm"], coordinate=True
        ),
        **_columns("fixed", [optimum.fixed for optimum in optima]),
    }
    for goal in goals:
        points = [optimum.best[goal] for optimum in optima]
        variables |= _columns(NAMES[goal], points) | _bounds(NAMES[goal], points, 3 if pressures else 2)
    if len(goals) > 1:
        variables |= _fronts([optimum.front for optimum in optima])
    for name, description in (("sketches", "states followed roughly, to 1e-3"), ("runs", "states followed fully")):
        counts = np.array([getattr(optimum, name) for optimum in optima])
        variables[name] = column(counts, "1", f"operating points computed, {description}")
    ranges = [(name, *ends, DEGREE, "deg") for name, ends in zip(FREE, (ENERGISE, DURATION), strict=False)]
    ranges += [(FREE[2], *pressures, 1.0, "Pa abs")] if pressures else []
    searched = {f"searched_{name}": f"{low / by:g} to {high / by:g} {unit}" for name, low, high, by, unit in ranges}
    provenance = {
        "kind": "engine optimise",
        "command": command,
        "kernels": sources_hash(),
        "criterion": CRITERION,
        **searched,
    }
    return Archive(dumps(machine), provenance, variables)


def speed_rpm(optimum: Optimum) -> float:
    """Convert the speed of an optimum to r/min, rounded to 12 digits, without the rounding noise of the conversion."""
    return float(f"{optimum.speed / RPM:.12g}")


def _columns(prefix: str, points: Sequence[Point | None]) -> dict[str, Variable]:
    """Columns of the points of all speeds, their names behind a prefix."""
    title = prefix.replace("_", " ")
    variables = {}
    rows = [row_of(point) for point in points]
    for name, (unit, description) in COLUMNS.items():
        values = np.array([row[name] for row in rows])
        variables[f"{prefix}_{name}"] = column(values, unit, f"{title}: {description}")
    full = np.array([bool(point and point.full_lift) for point in points], dtype=np.int8)
    description = f"{title}: whether the piston is on its open stop at any time"
    return variables | {f"{prefix}_full_lift": column(full, "1", description, NO_YES)}


def _bounds(prefix: str, points: Sequence[Point | None], count: int) -> dict[str, Variable]:
    """Columns of where the points of all speeds lie in the range of each of the first free variables."""
    meanings = ", ".join(f"{code} {text}" for code, text in BOUNDS.items())
    variables = {}
    for name in FREE[:count]:
        codes = np.array([bounds_of(point).get(name, 0) for point in points], dtype=np.int8)
        description = f"{prefix.replace('_', ' ')}: where it lies in the range searched"
        variables[f"{prefix}_bound_{name}"] = column(codes, "1", description, meanings)
    return variables


def _fronts(fronts: Sequence[Sequence[Point]]) -> dict[str, Variable]:
    """Columns of the fronts along an axis of their own, from least air to most torque; NaN behind the last point."""
    longest = max(1, *map(len, fronts))
    rows = [[row_of(point) for point in [*front, *[None] * (longest - len(front))]] for front in fronts]
    variables = {"point": Variable(("point",), np.arange(longest), "1", "number of the point on a Pareto front")}
    for name, (unit, description) in COLUMNS.items():
        values = np.array([[row[name] for row in front] for front in rows])
        variables[f"front_{name}"] = Variable(("run", "point"), values, unit, f"Pareto front: {description}")
    full = np.zeros((len(fronts), longest), dtype=np.int8)
    for run, front in enumerate(fronts):
        full[run, : len(front)] = [point.full_lift for point in front]
    description = "Pareto front: whether the piston is on its open stop at any time"
    return variables | {"front_full_lift": Variable(("run", "point"), full, "1", description, NO_YES)}


def optima_of(archive: Archive) -> tuple[Optimum, ...]:
    """Read the optima, one for each run, of an archive that `archive_of` has written.

    The places of their points are as the archive tells them: 0 and 1 at the ends of a range.

    >>> from apesim.engine.angles import TURN
    >>> point = Point((0.7, 1.0), -1.0, 4.2, 1.1e6, dict.fromkeys(RECORDED, 1.0), (1.0, TURN / 2.0), True)
    >>> optimum = Optimum(RPM * 900.0, point, {Goal.TORQUE: point}, [], 81, 27)
    >>> [again] = optima_of(archive_of(Machine(), [optimum], [Goal.TORQUE]))
    >>> bounds_of(again.best[Goal.TORQUE]), again.best[Goal.TORQUE].merit == point.merit
    ({'energise': 0, 'duration': 1}, True)
    """
    columns = {name: variable.values for name, variable in archive.variables.items()}
    goals = [goal for goal in Goal if f"{NAMES[goal]}_energise_deg" in columns]
    optima = []
    for run in range(len(archive.runs)):
        v = {name: values[run] for name, values in columns.items() if name != "point"}
        length = int(np.isfinite(v.get("front_energise_deg", np.array([]))).sum())
        rows = [{name: values[at] for name, values in v.items() if name.startswith("front_")} for at in range(length)]
        optima.append(
            Optimum(
                SPEED.read(f"{float(v['speed_rpm'])!r} rpm"),
                _point_in(v, "fixed"),
                {goal: _point_in(v, NAMES[goal]) for goal in goals},
                [point for row in rows if (point := _point_in(row, "front"))],
                int(v["sketches"]),
                int(v["runs"]),
            )
        )
    return tuple(optima)


def _point_in(row: Mapping[str, Any], prefix: str) -> Point | None:
    """Point whose commands and results stand in a row under a prefix; None where there is none."""
    said = {name: float(row[f"{prefix}_{name}"]) for name in COLUMNS}
    if np.isnan(said["energise_deg"]):
        return None
    values = {name: said[name] for name in RECORDED}
    codes = [row[f"{prefix}_bound_{name}"] for name in FREE if f"{prefix}_bound_{name}" in row]
    commands = said["energise_deg"] * DEGREE, said["release_deg"] * DEGREE, said["supply_pressure"]
    is_full = row.get(f"{prefix}_full_lift", not np.isnan(values["full_open_deg"]))
    place = tuple({-1: 0.0, 0: 0.5, 1: 1.0}[int(code)] for code in codes)
    return Point(place, *commands, values, merit_of(values), bool(is_full))


def faults_of(optima: Sequence[Optimum]) -> list[str]:
    """Write one line for each speed at which no commands give brake work, which says what to change."""
    lines = []
    for optimum in optima:
        if any(point is None or point.merit[Goal.TORQUE] <= 0.0 for point in optimum.best.values()):
            lines.append(
                f"{speed_rpm(optimum):g} r/min: no commands in the range searched give brake work in a state that "
                "repeats; lower the speed or raise the pressure"
            )
    return lines
