"""The best commands over speed, as an archive."""

from math import nan

import numpy as np

from apesim.archive import Archive, Variable
from apesim.archive.columns import NO_YES, column, run_axis
from apesim.engine.angles import DEGREE, TURN
from apesim.engine.indicators import INDICATORS
from apesim.kernel import sources_hash
from apesim.quantities.settings import dumps
from apesim.studies.execution.pool import run_tasks, workers_for
from apesim.studies.optimise.landscape import DURATION, ENERGISE, RECORDED, Goal
from apesim.studies.optimise.search import FINE, Optimum, optimise

RPM = TURN / 60.0
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


def row_of(point):
    """What is told of a point, by the names of `COLUMNS`; NaN where there is none."""
    if point is None:
        return dict.fromkeys(COLUMNS, nan)
    commands = point.energise / DEGREE, point.release / DEGREE, point.pressure
    return dict(zip(COLUMNS, commands, strict=False)) | point.values


def bounds_of(point):
    """Return where a point lies in the range of each free variable, a code of `BOUNDS`."""
    return dict(zip(FREE, [int(u >= 1.0 - FINE) - int(u <= FINE) for u in point.place], strict=False)) if point else {}


def optima_over_speed(machine, speeds, goals, pressures=None, jobs=None, report=None):
    """The best commands at several speeds; each for itself, so the number of processes changes nothing.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
        With an electro-pneumatic intake.
    speeds : sequence of float
        [rad/s]
    goals : sequence of Goal
    pressures : pair of float, optional
        Between which the supply pressure is free [Pa abs].
    jobs : int, optional
        Processes; as many as the work is worth if left out.
    report : function, optional
        Called with the numbers of speeds done and in all.

    Returns
    -------
    list of Optimum
    """
    found = [Optimum(speed, None, dict.fromkeys(goals), [], 0, 0) for speed in speeds]
    seconds = SECONDS_A_GOAL if len(goals) == 1 else 2.0 * SECONDS_A_GOAL + SECONDS_A_FRONT
    tasks = [(number, machine, speed, goals, pressures) for number, speed in enumerate(speeds)]
    done = run_tasks(_task, tasks, workers_for(seconds * len(speeds), jobs))
    for count, ((number, *_), optimum) in enumerate(done, 1):
        found[number] = optimum or found[number]
        if report:
            report(count, len(speeds))
    return found


def _task(item):
    return optimise(*item[1:])


def archive_of(machine, optima, goals, pressures=None, command=""):
    """Optima as an archive: a run for each speed, and the points of its front along a second axis.

    Parameters
    ----------
    machine : apesim.engine.machine.Machine
    optima : list of Optimum
    goals : sequence of Goal
    pressures : pair of float or None
    command : str
        The command line, for the archive.

    Returns
    -------
    Archive
    """
    variables = {
        "run": run_axis(len(optima)),
        "speed_rpm": column(np.array([speed_rpm(one) for one in optima]), *INDICATORS["speed_rpm"], coordinate=True),
        **_columns("uncorrected", [one.own for one in optima]),
    }
    for goal in goals:
        points = [one.best[goal] for one in optima]
        variables |= _columns(NAMES[goal], points) | _bounds(NAMES[goal], points, 3 if pressures else 2)
    if len(goals) > 1:
        variables |= _fronts([one.front for one in optima])
    for name, description in (("sketches", "states followed roughly, to 1e-3"), ("runs", "states followed fully")):
        counts = np.array([getattr(one, name) for one in optima])
        variables[name] = column(counts, "1", f"operating points computed, {description}")
    ranges = [(name, *ends, DEGREE, "deg") for name, ends in zip(FREE, (ENERGISE, DURATION), strict=False)]
    ranges += [(FREE[2], *pressures, 1.0, "Pa abs")] if pressures else []
    searched = {f"searched_{name}": f"{low / by:g} to {high / by:g} {unit}" for name, low, high, by, unit in ranges}
    provenance = {"command": command, "kernels": sources_hash(), "criterion": CRITERION} | searched
    return Archive(dumps(machine), provenance, variables)


def speed_rpm(optimum):
    """Speed of an optimum [r/min], as it was written."""
    return float(f"{optimum.speed / RPM:.12g}")


def _columns(prefix, points):
    told = prefix.replace("_", " ")
    variables = {}
    rows = [row_of(point) for point in points]
    for name, (unit, description) in COLUMNS.items():
        values = np.array([row[name] for row in rows])
        variables[f"{prefix}_{name}"] = column(values, unit, f"{told}: {description}")
    full = np.array([bool(point and point.full_lift) for point in points], dtype=np.int8)
    description = f"{told}: whether the piston is on its open stop at any time"
    return variables | {f"{prefix}_full_lift": column(full, "1", description, NO_YES)}


def _bounds(prefix, points, count):
    meanings = ", ".join(f"{code} {text}" for code, text in BOUNDS.items())
    variables = {}
    for name in FREE[:count]:
        codes = np.array([bounds_of(point).get(name, 0) for point in points], dtype=np.int8)
        description = f"{prefix.replace('_', ' ')}: where it lies in the range searched"
        variables[f"{prefix}_bound_{name}"] = column(codes, "1", description, meanings)
    return variables


def _fronts(fronts):
    """Points of the fronts along an axis of their own, from least air to most torque; NaN behind the last."""
    longest = max(1, *map(len, fronts))
    rows = [[row_of(point) for point in [*front, *[None] * (longest - len(front))]] for front in fronts]
    variables = {"point": Variable(("point",), np.arange(longest), "1", "number of the point on a Pareto front")}
    for name, (unit, description) in COLUMNS.items():
        values = np.array([[row[name] for row in front] for front in rows])
        variables[f"front_{name}"] = Variable(("run", "point"), values, unit, f"Pareto front: {description}")
    return variables


def faults_of(optima):
    """One line for each speed at which no commands give brake work.

    Parameters
    ----------
    optima : list of Optimum

    Returns
    -------
    list of str
    """
    lines = []
    for one in optima:
        if any(point is None or point.merit[Goal.TORQUE] <= 0.0 for point in one.best.values()):
            lines.append(
                f"{speed_rpm(one):g} r/min: no commands in the range searched give brake work in a state that repeats; "
                "lower the speed or raise the pressure"
            )
    return lines
