"""Soft landing, the next step that the paper names (doi 10.1631/jzus.A0820373): how far braking re-switches go."""

from collections.abc import Callable, Sequence
from itertools import product
from math import nan
from typing import Any, NamedTuple

import numpy as np

from apesim.engine.machine import Machine
from apesim.march.adaptive import LOG_HEAD, ZERO_CROSSING
from apesim.studies.execution.pool import Team, workers_for
from apesim.studies.run.operating_conditions import with_control_air
from apesim.studies.soft_landing.braking import (
    APART,
    SWITCHED,
    front_of,
    search,
    sturdiest,
    widest_soft,
)
from apesim.studies.soft_landing.landing import (
    BOTH,
    ONLY_A,
    ONLY_B,
    SOLENOIDS,
    STROKES,
    Edges,
    Landing,
    Task,
    apart_of,
    land,
)
from apesim.valve.motion import MET_CLOSED, MET_OPEN, SPEED_EXTREMUM

PRESSURES = "0.4:1.6:0.6 MPa gauge"
SPACING = 1.0 / (2.0 * 120.0)
"""Shortest time between two edges of a solenoid that follows 120 Hz, the paper's [s]."""
FACTORS = (0.95, 1.0, 1.05)
"""Factors on the gauge pressure for which a brake is tried."""
OFFSETS = (-10.0, 0.0, 10.0)
"""Offsets of the temperature for which a brake is tried [K]."""
SECONDS_A_STROKE = 4.0
"""Estimated computing time of a stroke [s]."""
LIMITS = ("within_spacing", "any_spacing")
"""Whether the edges keep the solenoids' least time."""
KINDS = ("softest", "sturdy")
"""The lowest seating speed as it should be; the lowest at the worst of the conditions."""


class ChosenBrake(NamedTuple):
    """A brake, and what becomes of it under other conditions."""

    row: np.ndarray
    """Brake with the columns from `apesim.studies.soft_landing.braking.BRAKE` on, (6,)."""
    landings: tuple[Landing, ...]
    """A `Landing` for each pressure factor and temperature offset, row by row."""
    added: np.ndarray
    """Time added to the unbraked stroke of the same condition [s], in the same order."""

    @property
    def solenoids(self) -> str:
        """Solenoids that the brake switches, one of `apesim.studies.soft_landing.landing.SOLENOIDS`."""
        return SOLENOIDS[int(self.row[SWITCHED])]


class Result(NamedTuple):
    """Brakes of a stroke at one pressure."""

    task: Task
    """Stroke without a brake."""
    unbraked: Landing
    """Landing without a brake."""
    lowest: float
    """Lowest speed of the unbraked piston between its peak and contact [m/s]: the most that the fluctuation alone could
    give, if the stop stood there."""
    brakes: np.ndarray
    """Brakes of all solenoids tried, see `apesim.studies.soft_landing.braking.search`."""
    choices: dict[tuple[str, str], ChosenBrake | None]
    """Chosen brakes by limit and kind; None where there is none."""

    @property
    def gauge(self) -> float:
        """Gauge pressure of the control air [Pa]."""
        return self.task.machine.supply.control().pressure - self.task.machine.ambient.pressure

    @property
    def best(self) -> ChosenBrake | None:
        """Softest brake within the spacing; without one, the softest of any spacing; else None."""
        return next((c for limit in LIMITS if (c := self.choices[limit, "softest"])), None)

    @property
    def braked(self) -> tuple[Task, tuple[float, ...]]:
        """Task with the solenoids of its best brake, and the edges of that; none if there is no brake."""
        best = self.best
        return (self.task._replace(solenoids=best.solenoids), tuple(best.row[:2])) if best else (self.task, ())


def _lowest_speed(log: np.ndarray, command: float, contact: float) -> float:
    """Find the lowest speed after the peak of a stroke, up to its contact [m/s], in the log of a bench run."""
    is_event = np.isin(log[:, 1], (MET_CLOSED, MET_OPEN, ZERO_CROSSING + SPEED_EXTREMUM))
    speeds = np.abs(log[is_event & (log[:, 0] >= command) & (log[:, 0] <= contact), LOG_HEAD + 1])
    return float(speeds[speeds.argmax() :].min()) if len(speeds) else nan


def conditions_of(task: Task) -> list[tuple[Task, Landing]]:
    """Set a task to every pressure factor and temperature offset, and land it there without a brake.

    The result is row by row: a row for each of `FACTORS`, a column for each of `OFFSETS`.
    """
    pressure, temperature = task.machine.supply.control()
    ambient = task.machine.ambient.pressure
    tasks = [
        task._replace(
            machine=with_control_air(task.machine, ambient + factor * (pressure - ambient), temperature + offset)
        )
        for factor in FACTORS
        for offset in OFFSETS
    ]
    return [(other, land(other)) for other in tasks]


def _of(number: int, conditions: Sequence[tuple[Task, Landing]]) -> list[tuple[Task, Landing]]:
    """Conditions whose brake switches the solenoids of that number."""
    return [(task._replace(solenoids=SOLENOIDS[number]), unbraked) for task, unbraked in conditions]


def _choice(
    task: Task,
    unbraked: Landing,
    brake: Edges,
    number: int,
    conditions: Sequence[tuple[Task, Landing]],
) -> ChosenBrake:
    """Run a brake of numbered solenoids as it should be and under all conditions."""
    [(task, _)], conditions = _of(number, [(task, unbraked)]), _of(number, conditions)
    landings = tuple(land(other, brake) for other, _ in conditions)
    added = np.array([braked.contact - base.contact for braked, (_, base) in zip(landings, conditions, strict=True)])
    landing = land(task, brake)
    apart = apart_of(task, brake)
    return ChosenBrake(
        np.array([*brake, landing.contact - unbraked.contact, landing.speed, apart, number]), landings, added
    )


class _Stroke:
    """A stroke whose brakes are sought, with what is known of it so far."""

    def __init__(self, task: Task) -> None:
        self.task, self.unbraked, self.lowest, self.brakes = task, land(task), nan, np.empty((0, 6))
        self.conditions: list[tuple[Task, Landing]] = []
        if self.unbraked.stays:
            plain = task.run(sample=task.dwell)
            self.lowest = _lowest_speed(plain.log, task.command, task.command + self.unbraked.contact)
            self.conditions = conditions_of(task)


def _soften(
    team: Team, tasks: Sequence[Task], spacing: float, cost: float, solenoids: Sequence[str], tell: Callable[[], object]
) -> list[Result]:
    """Find the brakes of strokes that depend on none of each other; none where the unbraked one is not completed."""

    def mapped(function: Callable[..., Any], calls: dict[Any, tuple]) -> dict[Any, Any]:
        return dict(zip(calls, team.map(function, calls.values(), lambda *_: tell()), strict=True))

    strokes = [_Stroke(task) for task in tasks]
    completed = [(n, stroke) for n, stroke in enumerate(strokes) if stroke.unbraked.stays]

    # Brakes of each way to switch, of all strokes at once.
    searches = {
        (n, way): (stroke.task._replace(solenoids=way), stroke.unbraked, spacing, cost)
        for n, stroke in completed
        for way in solenoids
    }
    brakes = mapped(search, searches)
    for n, stroke in completed:
        stroke.brakes = np.concatenate([brakes[n, way] for way in solenoids])

    # The softest of these are known; the sturdiest of each way are sought where there is a softest one.
    softest, sturdy = {}, {}
    for (n, stroke), (limit, apart) in product(completed, zip(LIMITS, (spacing, 0.0), strict=True)):
        for row in front_of(stroke.brakes, apart, cost)[-1:]:
            softest[n, limit] = (float(row[0]), float(row[1])), int(row[SWITCHED])
            for number in np.unique(stroke.brakes[:, SWITCHED]).astype(int).tolist():
                own = stroke.brakes[stroke.brakes[:, SWITCHED] == number]
                sturdy[n, limit, number] = _of(number, stroke.conditions), own, apart, cost
    chosen = {(n, limit, KINDS[0]): brake for (n, limit), brake in softest.items()}
    best: dict[tuple[int, str], list[tuple[float, tuple[float, float], int]]] = {}
    for (n, limit, number), (brake, worst) in mapped(sturdiest, sturdy).items():
        best.setdefault((n, limit), []).extend([(worst, brake, number)] if brake else [])
    for (n, limit), candidates in best.items():
        for _, brake, number in sorted(candidates)[:1]:
            chosen[n, limit, KINDS[1]] = brake, number

    # What becomes of the chosen ones where pressure and temperature stray.
    runs = {
        key: (strokes[key[0]].task, strokes[key[0]].unbraked, *brake, strokes[key[0]].conditions)
        for key, brake in chosen.items()
    }
    choices = mapped(_choice, runs)
    return [
        Result(
            stroke.task,
            stroke.unbraked,
            stroke.lowest,
            stroke.brakes,
            {(limit, kind): choices.get((n, limit, kind)) for limit in LIMITS for kind in KINDS},
        )
        for n, stroke in enumerate(strokes)
    ]


def soft_landings(
    machine: Machine,
    pressures: Sequence[float],
    temperature: float,
    dwell: float,
    spacing: float = SPACING,
    cost: float = 1e-3,
    report: Callable[[int, int], Any] | None = None,
    solenoids: Sequence[str] = SOLENOIDS,
    jobs: int | None = 1,
) -> list[Result]:
    """Find brakes of both strokes over pressure: opening and closing for each of `pressures` [Pa abs].

    The closing follows an opening with its best brake. `temperature` of the control air [K], `dwell` from each command
    edge to the next [s], shortest `spacing` between two edges of a solenoid [s], `cost` that a brake may add from
    command to contact [s]; `report` gets the searches done and in all; `jobs` is the number of processes (None: as many
    as the work is worth) and does not change the results.
    """
    machines = [with_control_air(machine, pressure, temperature) for pressure in pressures]
    before = [Task(machine, dwell, STROKES[0]).before for machine in machines]
    results: list[list[Result]] = []
    # A stroke has a search for each way to brake, and then a choice of each kind for each limit, if all goes well.
    total = len(STROKES) * len(machines) * (len(solenoids) * (1 + len(LIMITS)) + len(LIMITS) * len(KINDS))
    done = 0

    def tell() -> None:
        nonlocal done
        done += 1
        if report:
            report(done, total)

    with Team(workers_for(SECONDS_A_STROKE * len(STROKES) * len(machines), jobs)) as team:
        for stroke in STROKES:  # a closing follows the best opening
            tasks = [Task(each, dwell, stroke, before=edges) for each, edges in zip(machines, before, strict=True)]
            results.append(_soften(team, tasks, spacing, cost, solenoids, tell))
            before = [task.edges(brake) for task, brake in (result.braked for result in results[-1])]
    if report:
        report(total, total)
    return [result for at_pressure in zip(*results, strict=True) for result in at_pressure]


def faults_of(
    results: Sequence[Result], spacing: float, cost: float, solenoids: Sequence[str] = SOLENOIDS
) -> list[str]:
    """Write a line for each stroke that is not completed, or that no brake softens within the spacing at that cost.

    `spacing` is the shortest time between two edges of a solenoid [s], `cost` the longest added time allowed [s].
    """
    names = {BOTH: "both solenoids at once", ONLY_A: "solenoid A alone", ONLY_B: "solenoid B alone"}
    which = "" if len(solenoids) == len(SOLENOIDS) else " of " + " or ".join(names[name] for name in solenoids)
    lines = []
    for result in results:
        where = f"{result.gauge / 1e6:.3g} MPa gauge, {result.task.stroke}"
        if not result.unbraked.stays:
            lines.append(f"{where}: not completed even without a brake; try more pressure or a longer pulse")
        elif not result.choices["within_spacing", "softest"]:
            tried = f"with edges {1e3 * spacing:.3g} ms apart lowers the seating speed at a cost of {1e3 * cost:.3g} ms"
            lines.append(f"{where}: out of reach: no brake{which} {tried}{_what_would(result, cost)}")
    return lines


def _what_would(result: Result, cost: float) -> str:
    """Say which spacing would do, in words."""
    wide = widest_soft(result.brakes, result.unbraked, cost)
    return f"; {1e3 * wide[0, APART]:.2f} ms apart, one halves it" if len(wide) else ""
